// The machines of skills and components as diagrams, with their active states.

import { $, drawn, element } from './dom.js';
import { parts } from './parts.js';

export class Machines {
  // `ask` shows details.
  constructor(ask) {
    [this.ask, this.choice, this.place, this.table] = [ask, $('machine'), $('machines'), $('states')];
    this.choice.onchange = () => this.choose();
  }

  greet({ machines, processes }) {
    this.processes = processes;
    this.locations = {};
    this.all = new Map(machines.map(machine => [machine.process, { ...machine, ...this.figure(machine) }]));
    const option = (value, textContent) => element('option', { value, textContent });
    const names = [...this.all.keys()].map(name => option(name, name));
    this.choice.replaceChildren(option('', 'the active ones'), ...names);
    this.choice.closest('label').hidden = !machines.length;
    $('processes').hidden = !processes.length;
    this.place.replaceChildren(...[...this.all.values()].map(({ figure }) => figure));
  }

  figure({ process, svg }) {
    const name = `Machine of ${process}: the arrow keys explain its states`;
    const picture = element('div', { className: 'swipe', tabIndex: 0, role: 'group', ariaLabel: name });
    drawn(picture, svg);
    parts(picture, 'data-state', state => this.ask(this.about(this.all.get(process), state)));
    const state = element('span', { className: 'quiet' });
    const caption = element('figcaption', {}, element('b', { textContent: process }), ' ', state);
    return { picture, state, figure: element('figure', { hidden: true }, caption, picture) };
  }

  show({ locations, running }) {
    if (!locations) return;
    this.running = running;
    for (const [name, location] of Object.entries(locations)) {
      if (location !== this.locations[name] && this.all.has(name)) this.light(this.all.get(name), location);
    }
    this.locations = locations;
    this.table.replaceChildren(...Object.entries(locations).map(([name, location]) => this.row(name, location)));
    this.choose();
  }

  row(name, location) {
    const now = element('td', { textContent: location ?? '–' });
    if (!this.all.has(name)) return element('tr', {}, element('th', { scope: 'row', textContent: name }), now);
    const button = element('button', { type: 'button', textContent: name, title: 'Show its machine' });
    button.onclick = () => {
      this.choice.value = name;
      this.choose();
      this.choice.focus();
    };
    return element('tr', {}, element('th', { scope: 'row' }, button), now);
  }

  // Highlights the active states of a machine and the states around them.
  light({ states, picture, state }, location) {
    const active = activeIn(states, location);
    for (const part of picture.querySelectorAll('[data-state]')) {
      part.classList.toggle('active', active.has(Number(part.dataset.state)));
    }
    state.textContent = location ? `is in the state ${location}` : '';
  }

  // Shows the chosen machine, or the machines of the running leaves.
  choose() {
    const chosen = this.choice.value;
    for (const [name, { figure }] of this.all) figure.hidden = chosen ? name !== chosen : !this.running?.includes(name);
  }

  about({ process, states }, place) {
    return () => {
      const { name, parent, transitions } = states[place];
      const around = index => index == null ? [] : [states[index].name, ...around(states[index].parent)];
      return [name, [
        ['kind', place ? 'a state of a machine' : 'a machine'],
        ['now', activeIn(states, this.locations[process]).has(place) ? 'active' : 'not active'],
        ['inside of', around(parent).join(' in ')],
        ['transitions', transitions.map(words => words.replaceAll('->', '→')).join('; ')],
        ['process', `${process}, in ${this.locations[process] ?? '–'}`],
      ]];
    };
  }
}

// The indices of a machine's active states and of the states around them.
function activeIn(states, location) {
  const [names, active] = [(location ?? '').split(', '), new Set()];
  states.forEach(({ name }, place) => {
    if (!place || !names.includes(name)) return;
    for (let at = place; at != null; at = states[at].parent) active.add(at);
  });
  return active;
}
