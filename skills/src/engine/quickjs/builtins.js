// Limits on the engine's own objects: nothing may depend on the machine, and everything must be counted.
//
// The engine counts calls and loop iterations, and is stopped when there are too many. Its built-in functions count
// only part of their work, so it is counted here before they do it; where it cannot be known beforehand, the function
// is written here, in code that the engine counts. `Proxy`, `BigInt` and typed arrays are left out, because their sizes
// could not be known or their work not counted. `now` is in milliseconds, `allowance` roughly in nanoseconds.
(function (now, allowance) {
  'use strict';
  const root = globalThis;
  const { apply, construct, ownKeys, defineProperty, getOwnPropertyDescriptor, getPrototypeOf } = Reflect;
  const { isArray } = Array;
  const { freeze } = Object;
  const { hasOwnProperty, isPrototypeOf } = Object.prototype;
  const { min, max, trunc } = Math;
  // (A template would call `concat`, which is one of the functions below.)
  const text = String;

  for (const name of ['eval', 'globalThis', 'BigInt', 'WeakRef', 'FinalizationRegistry', 'Atomics', 'SharedArrayBuffer']) {
    delete root[name];
  }
  Error.stackTraceLimit = 0;

  // Replaces a function by what `make` makes of it.
  const replace = (object, name, make) => {
    const native = object[name];
    if (native !== undefined) object[name] = make(native);
  };

  let spent = 0;
  const spend = (work) => {
    if (!(spent + work <= allowance)) throw new RangeError('a built-in function has too much to do');
    spent += work;
  };
  const counted = (object, names, work) => {
    for (const name of names) {
      replace(object, name, (native) => ({
        built_in(...given) {
          spend(work(this, given));
          return apply(native, this, given);
        },
      }).built_in);
    }
  };

  // Text cannot become code.
  const refuse = function Function() { throw new EvalError('text cannot be run as code'); };
  refuse.prototype = Function.prototype;
  for (const code of [function () {}, async function () {}, function* () {}, async function* () {}]) {
    defineProperty(getPrototypeOf(code), 'constructor', { value: refuse });
  }
  defineProperty(root, 'Function', { value: refuse });

  // The engine's own `bind` crashes if memory runs out in it.
  replace(Function.prototype, 'bind', () => ({
    built_in(self, ...first) {
      const target = this;
      if (typeof target !== 'function') throw new TypeError('not a function');
      return function built_in(...rest) {
        const given = [];
        for (let index = 0; index < first.length; index++) given[index] = first[index];
        for (let index = 0; index < rest.length; index++) given[given.length] = rest[index];
        if (new.target === undefined) return apply(target, self, given);
        return construct(target, given, new.target === built_in ? target : new.target);
      };
    },
  }).built_in);

  // --- Time: that of the run. There is no time zone: local time is UTC.
  {
    const Native = Date;
    const { getTime, toUTCString } = Native.prototype;
    const { test } = RegExp.prototype;
    const { split } = String.prototype;
    const { UTC, parse: read } = Native;
    const withoutZone = /T\d\d:\d\d(?::\d\d(?:[.,]\d+)?)?$/;
    const complete = /^[+-]?\d{4,6}(?:-\d\d){0,2}$|(?:Z|UTC?|GMT|[ECMP][SD]T|[+-]\d\d:?\d\d)(?: *\(.*\))? *$/i;
    const parse = (written) => {
      spend(written.length);
      if (apply(test, withoutZone, [written])) return read(written + 'Z');
      return read(apply(test, complete, [written]) ? written : written + ' GMT');
    };
    const value = (given) => {
      if (typeof given === 'object' && given !== null) {
        try {
          return apply(getTime, given, []);
        } catch {
          const plain = given.valueOf();
          given = typeof plain === 'object' ? text(given) : plain;
        }
      }
      return typeof given === 'string' ? parse(given) : +given;
    };
    const words = (date) => apply(split, apply(toUTCString, date, []), [' ']);
    const shown = (date, show) => (apply(getTime, date, []) === apply(getTime, date, []) ? show(words(date)) : 'Invalid Date');
    const day = ([weekday, date, month, year]) => `${weekday[0]}${weekday[1]}${weekday[2]} ${month} ${date} ${year}`;
    const clock = ([, , , , time]) => `${time} GMT+0000 (UTC)`;
    const Clock = function Date(...given) {
      if (new.target === undefined) return new Clock().toString();
      const count = given.length;
      const time = count === 0 ? now : count === 1 ? value(given[0]) : apply(UTC, Native, given);
      return construct(Native, [time], new.target);
    };
    const own = Native.prototype;
    Clock.prototype = own;
    const define = (object, members) => {
      for (const name of ownKeys(members)) {
        defineProperty(object, name, { value: members[name], writable: true, enumerable: false, configurable: true });
      }
    };
    define(Clock, { now: () => now, parse: (written) => parse(text(written)), UTC });
    const whole = { toString() { return shown(this, (words) => `${day(words)} ${clock(words)}`); } }.toString;
    const dated = { toDateString() { return shown(this, day); } }.toDateString;
    const timed = { toTimeString() { return shown(this, clock); } }.toTimeString;
    define(own, {
      constructor: Clock,
      getTimezoneOffset() { return 0 * apply(getTime, this, []); },
      toString: whole, toLocaleString: whole,
      toDateString: dated, toLocaleDateString: dated,
      toTimeString: timed, toLocaleTimeString: timed,
    });
    for (const unit of ['FullYear', 'Month', 'Date', 'Day', 'Hours', 'Minutes', 'Seconds', 'Milliseconds']) {
      own[`get${unit}`] = own[`getUTC${unit}`];
      if (unit !== 'Day') own[`set${unit}`] = own[`setUTC${unit}`];
    }
    delete own.getYear;
    delete own.setYear;
    defineProperty(root, 'Date', { value: Clock });
  }

  // --- Arrays
  // The number of items of the object on which an array's method is called; a getter may not provide it.
  const extent = (list) => {
    if (isArray(list) || typeof list === 'string') return list.length;
    if (list === null || list === undefined) return 0;
    const object = Object(list);
    const own = getOwnPropertyDescriptor(object, 'length');
    if (own === undefined ? 'length' in object : typeof own.value !== 'number') {
      throw new TypeError('an array is needed, or an object whose length is a number');
    }
    return own !== undefined && own.value > 0 ? own.value : 0;
  };
  const isObject = (value) => typeof value === 'object' && value !== null;
  {
    const own = Array.prototype;
    // More items than fit into memory must be holes, and each hole takes longer.
    const shifted = (list) => {
      const count = extent(list);
      return count > 1e6 ? count * 32 : count;
    };
    counted(own, ['shift', 'slice'], shifted);
    counted(own, ['unshift', 'splice', 'reverse', 'copyWithin', 'fill', 'with', 'toReversed', 'toSpliced', 'join',
      'toLocaleString', 'keys', 'values', 'entries'], (list) => extent(list) * 32);
    defineProperty(own, Symbol.iterator, { value: own.values });
    counted(own, ['indexOf', 'lastIndexOf', 'includes'], (list, given) =>
      typeof given[0] === 'string' && isArray(list) ? list.length * given[0].length / 16 : 0);
    const byText = (one, other) => {
      const a = text(one);
      const b = text(other);
      spend(min(a.length, b.length) / 16);
      return a < b ? -1 : a > b ? 1 : 0;
    };
    for (const name of ['sort', 'toSorted']) {
      replace(own, name, (native) => ({
        built_in(compare) {
          spend(extent(this) * 32);
          return apply(native, this, [compare === undefined ? byText : compare]);
        },
      }).built_in);
    }
    const append = (result, list, levels) => {
      const count = list.length;
      for (let index = 0; index < count; index++) {
        if (!(index in list)) continue;
        const item = list[index];
        if (levels >= 1 && isArray(item)) append(result, item, levels - 1);
        else result[result.length] = item;
      }
      return result;
    };
    replace(own, 'flat', () => ({
      built_in(depth) { return append([], Object(this), depth === undefined ? 1 : +depth); },
    }).built_in);
    replace(own, 'flatMap', () => ({
      built_in(change, self) {
        const result = [];
        const list = Object(this);
        const count = list.length;
        for (let index = 0; index < count; index++) {
          if (!(index in list)) continue;
          const item = apply(change, self, [list[index], index, list]);
          if (isArray(item)) append(result, item, 0);
          else result[result.length] = item;
        }
        return result;
      },
    }).built_in);
    const spreads = Symbol.isConcatSpreadable;
    replace(own, 'concat', () => ({
      built_in(...given) {
        const result = [];
        let next = 0;
        const add = (item) => {
          const asked = isObject(item) ? item[spreads] : false;
          if (asked === undefined ? isArray(item) : asked) {
            const count = item.length;
            for (let index = 0; index < count; index++) if (index in item) result[next + index] = item[index];
            next += count;
          } else {
            result[next++] = item;
          }
        };
        add(Object(this));
        for (let index = 0; index < given.length; index++) add(given[index]);
        result.length = next;
        return result;
      },
    }).built_in);
    replace(getPrototypeOf(getPrototypeOf([].values())), 'drop', (native) => ({
      built_in(count) {
        spend(max(0, +count) * 32);
        return apply(native, this, [count]);
      },
    }).built_in);
  }

  // --- Strings
  {
    const own = String.prototype;
    const onText = (names, work) => {
      for (const name of names) {
        replace(own, name, (native) => ({
          built_in(...given) {
            if (this === null || this === undefined) return apply(native, this, given);
            const written = text(this);
            spend(work(written, given));
            return apply(native, written, given);
          },
        }).built_in);
      }
    };
    const expression = RegExp.prototype;
    // A text to search for; a regular expression is counted elsewhere.
    const sought = (given) => {
      if (isObject(given[0]) && apply(isPrototypeOf, expression, [given[0]])) return 0;
      given[0] = given.length === 0 ? 'undefined' : text(given[0]);
      return given[0].length + 1;
    };
    onText(['indexOf', 'lastIndexOf', 'includes', 'startsWith', 'endsWith', 'split', 'replace', 'replaceAll'],
      (written, given) => written.length * sought(given) / 4);
    onText(['match', 'matchAll', 'search'], (written, given) => written.length + sought(given) ** 2);
    onText(['toLowerCase', 'toUpperCase', 'toLocaleLowerCase', 'toLocaleUpperCase', 'isWellFormed', 'toWellFormed',
      'trim', 'trimStart', 'trimEnd'], (written) => written.length * 16);
    onText(['slice', 'substring', 'substr', 'concat'], (written) => written.length / 16);
    onText([Symbol.iterator], (written) => written.length * 32);
    const sized = (written, given) => {
      given[0] = trunc(+given[0]) || 0;
      return given[0];
    };
    onText(['repeat'], (written, given) => max(0, sized(written, given)) * (written.length + 1) / 8);
    onText(['padStart', 'padEnd'], (written, given) => max(0, sized(written, given)));
    onText(['normalize'], (written) => written.length ** 2);
    onText(['localeCompare'], (written, given) => {
      given[0] = text(given[0]);
      return (written.length + given[0].length) ** 2;
    });
    replace(String, 'raw', () => ({
      built_in(template, ...values) {
        const { raw } = template;
        const count = raw.length;
        let result = '';
        for (let index = 0; index < count; index++) {
          result += text(raw[index]);
          if (index + 1 < count && index < values.length) result += text(values[index]);
        }
        return result;
      },
    }).built_in);
    for (const name of ['encodeURI', 'encodeURIComponent', 'decodeURI', 'decodeURIComponent', 'escape', 'unescape',
      'parseInt', 'parseFloat']) {
      replace(root, name, (native) => ({
        built_in(written, radix) {
          const given = text(written);
          spend(given.length * 16);
          return native(given, radix);
        },
      }).built_in);
    }
    Number.parseInt = root.parseInt;
    Number.parseFloat = root.parseFloat;
  }

  // --- Regular expressions: each search is a call that the engine counts, and it counts the steps of long ones itself.
  {
    const Native = RegExp;
    const own = Native.prototype;
    const source = getOwnPropertyDescriptor(own, 'source').get;
    const { exec } = own;
    const count = /\{(\d+)(?:,(\d*))?\}/g;
    // Repetitions in braces are assumed to be nested.
    let known = '';
    const checked = (source) => {
      if (source === known) return;
      let product = 1;
      count.lastIndex = 0;
      for (let found = apply(exec, count, [source]); found !== null; found = apply(exec, count, [source])) {
        product *= max(1, +found[1], +(found[2] || 0));
      }
      if (product > 10000) throw new RangeError('a regular expression repeats too much');
      known = source;
    };
    // The engine counts the steps of long searches, not those of short ones.
    replace(own, 'exec', () => ({
      built_in(written) {
        const given = text(written);
        checked(apply(source, this, []));
        spend(5000 + given.length);
        return apply(exec, this, [given]);
      },
    }).built_in);
    delete own.compile;
    const Counted = function RegExp(...given) {
      const pattern = given[0];
      const source = isObject(pattern) && apply(isPrototypeOf, own, [pattern]) ? pattern.source : given.length === 0 || pattern === undefined ? '' : (given[0] = text(pattern));
      spend(source.length ** 2);
      return new.target === undefined ? apply(Native, undefined, given) : construct(Native, given, new.target);
    };
    for (const key of ownKeys(Native)) {
      if (!apply(hasOwnProperty, Counted, [key])) defineProperty(Counted, key, getOwnPropertyDescriptor(Native, key));
    }
    Counted.prototype = own;
    defineProperty(own, 'constructor', { value: Counted });
    defineProperty(root, 'RegExp', { value: Counted });
  }

  // --- Objects, maps, JSON
  {
    const keyed = (object) => {
      if (object === null || object === undefined) return 0;
      return typeof object === 'string' ? object.length : ownKeys(Object(object)).length;
    };
    counted(Object, ['keys', 'values', 'entries', 'assign', 'getOwnPropertyNames', 'getOwnPropertySymbols',
      'getOwnPropertyDescriptors', 'freeze', 'isFrozen', 'seal', 'isSealed', 'defineProperties'], (_, given) => {
      let count = 0;
      for (let index = 0; index < given.length; index++) count += keyed(given[index]);
      return count * 512;
    });
    replace(Reflect, 'ownKeys', (native) => ({
      built_in(object) {
        const keys = native(object);
        spend(keys.length * 512);
        return keys;
      },
    }).built_in);
    for (const own of [Map.prototype, Set.prototype]) {
      const size = getOwnPropertyDescriptor(own, 'size').get;
      counted(own, ['get', 'set', 'has', 'add', 'delete'], (_, given) => (typeof given[0] === 'string' ? given[0].length : 0));
      counted(own, ['union', 'intersection', 'difference', 'symmetricDifference', 'isSubsetOf', 'isSupersetOf',
        'isDisjointFrom'], (set, given) => {
        const others = isObject(given[0]) ? +given[0].size : 0;
        return 64 * (apply(size, set, []) + (others >= 0 && others < 1e6 ? others : 0));
      });
    }
    replace(JSON, 'parse', (native) => ({
      built_in(written, revive) {
        const given = text(written);
        spend(given.length * 16);
        return native(given, revive);
      },
    }).built_in);
    // If there is a function to call for every part, the engine counts the parts.
    replace(JSON, 'stringify', (native) => ({
      built_in(value, change, indent) {
        let ask = change;
        if (isArray(change)) {
          const names = [];
          for (let index = 0; index < change.length; index++) names[index] = text(change[index]);
          ask = (_, part) => {
            if (!isObject(part) || isArray(part)) return part;
            const chosen = {};
            for (let index = 0; index < names.length; index++) {
              if (apply(hasOwnProperty, part, [names[index]])) chosen[names[index]] = part[names[index]];
            }
            return chosen;
          };
        } else if (typeof change !== 'function') {
          ask = (_, part) => part;
        }
        return native(value, ask, indent);
      },
    }).built_in);
  }

  // What the host asks about values; it works whatever the program has done to the engine's objects.
  const { toString: written } = refuse.prototype;
  const { toWellFormed, startsWith } = String.prototype;
  const classes = [Error, Date, Map, Set, WeakMap, WeakSet, RegExp, Promise, Number, String, Boolean, Symbol,
    { prototype: getPrototypeOf(getPrototypeOf([].values())) }];
  const prototypes = classes.map((known) => known.prototype);
  return {
    freeze,
    // 0 an object, 1 a function, 2 an array, 3 XML, 4 an error, 5 a date, 6 what cannot be kept
    kind: (value) => {
      if (typeof value === 'function') return 1;
      if (isArray(value)) return 2;
      if (typeof value.outerXML === 'string') return 3;
      for (let index = 0; index < prototypes.length; index++) {
        if (apply(isPrototypeOf, prototypes[index], [value])) return index === 0 ? 4 : index === 1 ? 5 : 6;
      }
      return 0;
    },
    source: (code) => {
      const source = apply(written, code, []);
      const begins = (start) => apply(startsWith, source, [start]);
      return begins('built_in(') || begins('function built_in(') || code === root.Date || code === root.RegExp || code === refuse ? '' : source;
    },
    text: (value) => text(value),
    wellFormed: (value) => apply(toWellFormed, value, []),
  };
})
