// The latest messages as a sequence chart: one column per process, with time running down.

import { $, element, shape } from './dom.js';
import { parts } from './parts.js';

const SHOWN = 40;
const KEPT = 400;
const ROW = 22;
const HEAD = 24;

export class Messages {
  // `ask` shows details.
  constructor(ask) {
    [this.ask, this.filter, this.between, this.chart] = [ask, $('filter'), $('between'), $('chart')];
    this.all = [];
    this.count = 0;
    this.names = new Set();
    this.filter.addEventListener('input', () => this.draw());
    this.between.addEventListener('change', () => this.draw());
    this.parts = parts(this.chart, 'data-message', number => this.ask(this.about(this.all.find(message => message.at(-1) === number))));
    this.chart.addEventListener('click', ({ clientX, clientY }) => {
      const name = document.elementFromPoint(clientX, clientY)?.closest('[data-process]');
      if (name) this.only(name.dataset.process);
    });
  }

  // `ticks` says whether the run knows its ticks.
  greet({ ticks }) {
    this.ticks = ticks;
  }

  show({ messages, anew }) {
    if (!messages?.length && !anew) return;
    if (anew) this.all = [];
    this.all.push(...messages.map(message => [...message, this.count++]));
    this.all.splice(0, this.all.length - KEPT);
    this.offer(messages);
    this.draw();
  }

  // Adds new processes and channels to the filter.
  offer(messages) {
    const before = this.names.size;
    for (const [, , from, to] of messages) for (const name of [from, to, `${from} → ${to}`]) this.names.add(name);
    if (this.names.size === before) return;
    const chosen = this.between.value;
    const option = name => element('option', { value: name, textContent: name });
    const group = (label, areChannels) => {
      const names = [...this.names].filter(name => name.includes(' → ') === areChannels).sort();
      return element('optgroup', { label }, ...names.map(option));
    };
    const all = element('option', { value: '', textContent: 'all processes' });
    this.between.replaceChildren(all, group('Processes', false), group('Channels', true));
    this.between.value = chosen;
  }

  // Shows only the messages of one process, or all of them again.
  only(name) {
    this.between.value = this.between.value === name ? '' : name;
    this.draw();
  }

  fits([, , from, to, text]) {
    const [words, chosen] = [this.filter.value.trim().toLowerCase(), this.between.value];
    const concerns = !chosen || [from, to, `${from} → ${to}`].includes(chosen);
    return concerns && (!words || `${from} ${to} ${text}`.toLowerCase().includes(words));
  }

  draw() {
    const messages = this.all.filter(message => this.fits(message)).slice(-SHOWN);
    const names = [...new Set(messages.flatMap(([, , from, to]) => [from, to]))];
    if (!names.length) {
      const textContent = this.all.length ? 'no such message' : 'no message yet';
      return this.chart.replaceChildren(element('p', { className: 'quiet', textContent }));
    }
    const gap = Math.max(96, Math.min(170, (this.chart.clientWidth - 60) / names.length));
    const x = name => 56 + gap * (names.indexOf(name) + 0.5);
    const [width, height] = [56 + gap * names.length, ROW * messages.length + 8];
    const head = shape('svg', { width, height: HEAD, class: 'head', 'aria-hidden': 'true' });
    const svg = shape('svg', { width, height, role: 'img', 'aria-label': 'The latest messages' });
    for (const name of names) {
      const title = shape('title', {}, `${name}: click to show only its messages`);
      const text = shape('text', { x: x(name), y: 16, class: 'name', 'data-process': name }, short(name, gap - 14), title);
      head.append(text);
      svg.append(shape('line', { x1: x(name), x2: x(name), y1: 0, y2: height, class: 'life' }));
    }
    let tick = null;
    messages.forEach(([, at, from, to, text, number], row) => {
      const y = ROW * (row + 0.8);
      if (this.ticks && at !== tick) svg.append(shape('text', { x: 2, y: y + 4, class: 'tick' }, `tick ${at}`));
      tick = at;
      const [a, b] = [x(from), x(to)];
      const words = shape('text', { x: (a + b) / 2, y: y - 4, class: 'message' }, short(text, Math.abs(b - a)));
      const tip = b - 6 * Math.sign(b - a);
      svg.append(shape('g', { 'data-message': number }, shape('title', {}, `${from} → ${to} ${text}`),
        shape('rect', { x: Math.min(a, b), y: y - 15, width: Math.abs(b - a), height: ROW, class: 'hit' }), words,
        shape('path', { d: `M${a},${y}H${b}M${tip},${y - 4}L${b},${y}L${tip},${y + 4}`, class: 'arrow' })));
    });
    this.chart.replaceChildren(head, svg);
    this.parts.mark();
    this.chart.scrollTop = this.chart.scrollHeight;
  }

  about([step, tick, from, to, text]) {
    const when = [['tick', this.ticks ? tick : null], ['communication', step]];
    const rows = [['message', text], ['sender', from], ['receiver', to], ...when];
    return () => [`${from} → ${to}`, rows];
  }
}

// A text, shortened to the room; names that begin alike stay different.
function short(text, room) {
  const letters = Math.max(6, Math.floor(room / 7)), end = Math.floor((letters - 1) / 2);
  return text.length > letters ? `${text.slice(0, letters - 1 - end)}…${text.slice(-end)}` : text;
}
