// What a person does to the run: battery, clicks on the map, any fault.

import { $, element } from './dom.js';

// What a click on the map does.
const TOOLS = [
  ['look', 'Look', 'Drag moves the map; the robot can be dragged elsewhere'],
  ['box', 'Box', 'A click puts a box on the floor'],
  ['person', 'Person', 'Two clicks let a person walk between them'],
];

export class Hand {
  constructor(link) {
    this.link = link;
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
      clearTimeout(waiting);
      waiting = setTimeout(() => this.link.act('battery_level', { level_pct: Number(slider.value) }), 100);
      this.sliding = Date.now();
    });
  }

  // A click on the map, or the robot dragged to a point.
  clicked(point, isRobot, pose) {
    if (this.picking) {
      this.picking(point);
    } else if (isRobot) {
      this.link.act('kidnap', { to: [...point, Math.round(pose[2] * 180 / Math.PI)] });
    } else if (this.tool === 'box') {
      this.link.act('obstacle_appears', { at: [...point, 0] }, this.name('box'));
    } else if (this.tool === 'person') {
      if (this.first) this.link.act('people', { at: this.first, route: [point], count: 1, gives_way: true }, this.name('person'));
      this.first = this.first ? null : point;
    }
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
    if (parameter.takes === 'flag') input.checked = value ?? false;
    else if (parameter.takes !== 'choice') input.value = Array.isArray(value) ? JSON.stringify(value) : value ?? '';
    if (parameter.takes === 'number') input.step = 'any';
    if (Array.isArray(parameter.range) && parameter.takes !== 'choice') [input.min, input.max] = parameter.range;
    const label = element('label', { title: parameter.about }, parameter.name, input);
    if (['point', 'pose'].includes(parameter.takes)) {
      const pick = element('button', { type: 'button', textContent: 'Pick on the map' });
      pick.onclick = () => {
        this.picking = point => {
          input.value = JSON.stringify(parameter.takes === 'pose' ? [...point, 0] : point);
          this.picking = null;
        };
      };
      label.append(pick);
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

  show({ battery, lasting }) {
    $('hand').querySelector('.slider').hidden = !battery;
    if (battery && Date.now() - (this.sliding ?? 0) > 1000) {
      $('charge').value = battery.pct;
      $('level').textContent = `${battery.pct.toFixed(1)} %`;
    }
    const text = JSON.stringify(lasting);
    if (lasting && text !== this.shown) {
      this.shown = text;
      $('lasting').replaceChildren(...lasting.filter(({ name }) => name !== 'joypad').map(({ name, words }) => {
        const button = element('button', { type: 'button', textContent: 'End', ariaLabel: `End: ${words}` });
        button.onclick = () => this.link.ask('release', { name });
        return element('li', {}, words, ' ', button);
      }));
    }
  }
}
