// The latest messages as a sequence chart: a column for each process that takes part, time downwards.

import { $, element, shape } from './dom.js';

const SHOWN = 40;
const KEPT = 400;
const ROW = 22;
const HEAD = 26;

export class Messages {
  constructor() {
    this.all = [];
    $('filter').addEventListener('input', () => this.draw());
  }

  show({ messages, anew }) {
    if (!messages?.length && !anew) return;
    if (anew) this.all = [];
    this.all.push(...messages);
    this.all.splice(0, this.all.length - KEPT);
    this.draw();
  }

  draw() {
    const wanted = $('filter').value.trim().toLowerCase();
    const fits = message => !wanted || message.slice(2).join(' ').toLowerCase().includes(wanted);
    const messages = this.all.filter(fits).slice(-SHOWN);
    const names = [...new Set(messages.flatMap(([, , from, to]) => [from, to]))];
    if (!names.length) return $('chart').replaceChildren(element('p', { className: 'quiet', textContent: 'no message yet' }));
    const gap = Math.max(96, Math.min(170, ($('chart').clientWidth - 60) / names.length));
    const x = name => 56 + gap * (names.indexOf(name) + 0.5);
    const [width, height] = [56 + gap * names.length, ROW * messages.length + 8];
    const head = shape('svg', { class: 'head', width, height: HEAD, 'aria-hidden': true });
    const svg = shape('svg', { width, height, role: 'img', 'aria-label': 'The latest messages' });
    for (const name of names) {
      const text = shape('text', { x: x(name), y: 16, class: 'name' }, short(name, gap));
      text.append(shape('title', {}, name));
      head.append(text);
      svg.append(shape('line', { x1: x(name), x2: x(name), y1: 0, y2: height, class: 'life' }));
    }
    let tick = null;
    messages.forEach(([, at, from, to, text], row) => {
      const y = ROW * (row + 0.7);
      if (at !== tick) svg.append(shape('text', { x: 2, y: y + 4, class: 'tick' }, `tick ${at}`));
      tick = at;
      const [a, b] = [x(from), x(to)];
      const words = shape('text', { x: (a + b) / 2, y: y - 4, class: 'message' }, short(text, Math.abs(b - a)));
      words.append(shape('title', {}, `${from} → ${to} ${text}`));
      const tip = b - 6 * Math.sign(b - a);
      svg.append(words, shape('path', { d: `M${a},${y}H${b}M${tip},${y - 4}L${b},${y}L${tip},${y + 4}`, class: 'arrow' }));
    });
    $('chart').replaceChildren(head, svg);
    $('chart').scrollTop = $('chart').scrollHeight;
  }
}

// As much of a text as fits.
function short(text, room) {
  const letters = Math.max(6, Math.floor(room / 7));
  return text.length > letters ? `${text.slice(0, letters - 1)}…` : text;
}
