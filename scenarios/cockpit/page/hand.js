// What a person can do to the run: set the battery, click on the map, inject any fault.

import { $, element, notice } from './dom.js';

// What a click on the map does.
const TOOLS = [
  ['look', 'Look', 'Click to see what something is. Drag to move the map, the robot, or what you put on the floor'],
  ['goal', 'Goal', 'Click to send Navigation there; drag to set the final heading'],
  ['box', 'Box', 'Click to put a box on the floor'],
  ['person', 'Person', 'Click twice to let a person walk between the two points'],
];

export class Hand {
  // `acts` says whether the user can act now; `ask` shows what a thing on the map is.
  constructor(link, acts, ask) {
    Object.assign(this, { link, acts, ask });
    this.lasting = [];
    this.tool = 'look';
    this.count = 0;
    this.tools();
    this.charge();
  }

  greet({ kinds }) {
    this.kinds = new Map(kinds.map(kind => [kind.name, kind]));
    const places = Map.groupBy(kinds, kind => kind.place);
    const options = [...places].map(([place, kinds]) =>
      element('optgroup', { label: place }, ...kinds.map(kind => element('option', { value: kind.name, textContent: kind.name }))));
    $('kind').replaceChildren(...options);
    $('kind').onchange = () => this.form();
    $('do').onclick = () => this.act();
    this.form();
  }

  tools() {
    const buttons = TOOLS.map(([tool, words, title]) => {
      const button = element('button', { type: 'button', textContent: words, title, ariaPressed: String(tool === this.tool) });
      button.onclick = () => {
        this.tool = tool;
        this.first = null;
        buttons.forEach(other => { other.ariaPressed = String(other === button); });
      };
      return button;
    });
    $('tools').append(...buttons);
  }

  charge() {
    const slider = $('charge');
    let waiting;
    slider.addEventListener('input', () => {
      $('level').textContent = `${slider.value} %`;
      this.slides = true;
      clearTimeout(waiting);
      const act = waiting = setTimeout(async () => {
        const done = await this.link.act('battery_level', { level_pct: Number(slider.value) });
        if (act !== waiting) return;
        // The battery has this level from the next step on.
        this.slides = false;
        this.slid = done && this.time;
      }, 100);
    });
    // The arrow keys drive the robot again.
    slider.addEventListener('pointerup', () => slider.blur());
  }

  // Whether a press on the map sets a point, and dragging then sets a heading.
  aims() {
    return this.acts() && (this.picking ? this.picking.takes === 'pose' : this.tool === 'goal');
  }

  // Whether a thing on the map can be dragged.
  holds(thing) {
    if (!this.acts() || this.picking) return false;
    return thing.is === 'robot' || thing.is === 'body' && Boolean(this.placed(thing.name));
  }

  // The lasting act that put this body on the floor.
  placed(body) {
    return this.lasting.find(({ name, fault, bodies }) => name && fault.at && bodies.includes(body));
  }

  // Sends the robot to a point. There it faces `to`, if given; otherwise it faces away from where it is now.
  goal(at, to, pose) {
    const looks = to ? [at, to] : [pose ?? at, at];
    const [dx, dy] = [0, 1].map(axis => looks[1][axis] - looks[0][axis]);
    const heading = Math.round(Math.atan2(dy, dx) * 180 / Math.PI);
    if (this.picking) this.pick([...at, heading]);
    else this.link.act('operator_goal', { to: [...at, heading] });
  }

  // Called when a thing is dragged to a point.
  moved(thing, to) {
    if (thing.is === 'robot') {
      return this.link.act('kidnap', { to: [...to, Math.round(thing.at[2] * 180 / Math.PI)] });
    }
    const { name, fault: { kind, ...parameters } } = this.placed(thing.name);
    const by = [0, 1].map(axis => to[axis] - parameters.at[axis]);
    const round = m => Math.round(m * 100) / 100;
    const along = ([x, y, ...heading]) => [x + by[0], y + by[1], ...heading].map(round);
    parameters.at = along(parameters.at);
    if (parameters.route) parameters.route = parameters.route.map(along);
    return this.link.act(kind, parameters, name);
  }

  // Called when a thing on the map is clicked.
  clicked(point, thing) {
    if (!this.acts()) return this.ask(thing);
    if (this.picking) return this.pick(point);
    if (this.tool === 'box') return this.link.act('obstacle_appears', { at: [...point, 0] }, this.name('box'));
    if (this.tool !== 'person') return this.ask(thing);
    const route = { at: this.first, route: [point], count: 1, gives_way: true };
    if (this.first) this.link.act('people', route, this.name('person'));
    this.first = this.first ? null : point;
    notice(this.first ? 'Now click the other end of the walk.' : '');
  }

  // Writes a point on the map into the form.
  pick(value) {
    const { input, button, takes } = this.picking;
    const before = takes === 'points' ? JSON.parse(input.value || '[]') : [];
    input.value = JSON.stringify(takes === 'points' ? [...before, value] : value);
    button.ariaPressed = 'false';
    this.picking = null;
  }

  name(kind) {
    this.count += 1;
    return `${kind} ${Date.now()} ${this.count}`;
  }

  form() {
    const kind = this.kinds.get($('kind').value);
    $('about').textContent = kind.about;
    $('parameters').replaceChildren(...kind.parameters.map(parameter => this.field(parameter, kind.example[parameter.name])));
  }

  field(parameter, example) {
    const value = example ?? parameter.default;
    const input = parameter.takes === 'choice'
      ? element('select', {}, ...parameter.range.map(name => element('option', { textContent: name, selected: name === value })))
      : element('input', { type: { number: 'number', whole: 'number', flag: 'checkbox' }[parameter.takes] ?? 'text' });
    input.name = parameter.name;
    const list = element('datalist', { id: `names-of-${parameter.name}` }, ...parameter.names.map(value => element('option', { value })),
      ...parameter.places.map(([label, value]) => element('option', { value, label })));
    if (list.children.length) input.setAttribute('list', list.id);
    if (parameter.takes === 'flag') input.checked = value ?? false;
    else if (parameter.takes !== 'choice') input.value = Array.isArray(value) ? JSON.stringify(value) : value ?? '';
    if (parameter.takes === 'number') input.step = 'any';
    if (Array.isArray(parameter.range) && parameter.takes !== 'choice') [input.min, input.max] = parameter.range;
    const label = element('label', { title: parameter.about }, parameter.name, input, list);
    if (['point', 'pose', 'points'].includes(parameter.takes)) {
      const words = parameter.takes === 'points' ? 'Add from the map' : 'Pick on the map';
      const button = element('button', { type: 'button', textContent: words, ariaPressed: 'false' });
      button.onclick = () => {
        if (this.picking) this.picking.button.ariaPressed = 'false';
        this.picking = { input, button, takes: parameter.takes };
        button.ariaPressed = 'true';
        $('floor').scrollIntoView({ block: 'nearest' });
      };
      label.append(button);
    }
    return label;
  }

  act() {
    const kind = this.kinds.get($('kind').value);
    const given = kind.parameters.map(({ name, takes }) => [name, takes, $('parameters').elements[name]]);
    const parameters = {};
    for (const [name, takes, { value, checked }] of given) {
      if (takes === 'flag') parameters[name] = checked;
      else if (value === '') continue;
      else if (takes === 'text' || takes === 'choice') parameters[name] = value;
      else try { parameters[name] = JSON.parse(value); } catch { parameters[name] = value; }
    }
    this.link.act(kind.name, parameters, kind.momentary ? '' : this.name(kind.name));
  }

  show({ time, battery, lasting }) {
    $('hand').querySelector('.slider').hidden = !battery;
    if (time !== this.slid) this.slid = null;
    this.time = time;
    if (battery && !this.slides && this.slid === null) {
      $('charge').value = battery.pct;
      $('level').textContent = `${battery.pct.toFixed(1)} %`;
    }
    const text = JSON.stringify(lasting);
    if (lasting && text !== this.shown) {
      [this.shown, this.lasting] = [text, lasting];
      $('lasting').replaceChildren(...lasting.filter(({ name }) => name !== 'joypad').map(({ name, words }) => {
        const button = element('button', { type: 'button', textContent: 'End', ariaLabel: `End: ${words}` });
        button.onclick = () => this.link.ask('release', { name });
        return element('li', {}, words, ' ', button);
      }));
    }
  }
}
