(function () {
  'use strict';
  const root = globalThis;
  for (const name of ['WeakRef', 'FinalizationRegistry', 'Atomics', 'SharedArrayBuffer', 'eval', 'globalThis']) {
    delete root[name];
  }
  // A member of a frozen prototype hides nothing from whoever inherits it.
  const open = (prototype) => {
    for (const key of Reflect.ownKeys(prototype)) {
      const own = Reflect.getOwnPropertyDescriptor(prototype, key);
      if (!own.configurable || !('value' in own)) continue;
      const value = own.value;
      Reflect.defineProperty(prototype, key, {
        get() { return value; },
        set(next) {
          if (this === prototype) throw new TypeError('the engine\'s own objects cannot be changed');
          Reflect.defineProperty(this, key, { value: next, writable: true, enumerable: true, configurable: true });
        },
        enumerable: own.enumerable,
        configurable: false,
      });
    }
  };
  [Object.prototype, Error.prototype, Function.prototype].forEach(open);
  const frozen = new Set();
  const freeze = (value) => {
    if (value === null || typeof value !== 'object' && typeof value !== 'function' || frozen.has(value)) return;
    frozen.add(value);
    if (value !== root) Object.freeze(value);
    freeze(Reflect.getPrototypeOf(value));
    for (const key of Reflect.ownKeys(value)) {
      const own = Reflect.getOwnPropertyDescriptor(value, key);
      freeze(own.value);
      freeze(own.get);
      freeze(own.set);
    }
  };
  freeze(root);
  // What syntax reaches and no name does.
  for (const hidden of [function* () {}, async function () {}, async function* () {}, [][Symbol.iterator](),
    ''[Symbol.iterator](), new Map()[Symbol.iterator](), new Set()[Symbol.iterator](), /./[Symbol.matchAll]('')]) {
    freeze(Reflect.getPrototypeOf(hidden));
  }
  for (const key of Reflect.ownKeys(root)) {
    const own = Reflect.getOwnPropertyDescriptor(root, key);
    if (own.configurable) {
      Reflect.defineProperty(root, key, 'value' in own ? { writable: false, configurable: false } : { configurable: false });
    }
  }
})();
