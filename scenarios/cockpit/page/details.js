// What was clicked: its name and what is known about it, updated while it is shown.

import { $, element } from './dom.js';

export class Details {
  constructor() {
    this.place = $('details');
    const close = element('button', { type: 'button', textContent: '×', ariaLabel: 'Close the details' });
    close.onclick = () => this.close();
    this.title = element('h2', { ariaLive: 'polite' });
    this.rows = element('dl');
    this.place.replaceChildren(element('header', {}, this.title, close), this.rows);
    addEventListener('keydown', ({ key }) => { if (key === 'Escape') this.close(); });
  }

  // `describe` returns a title and rows of a label and a value. It is called again with every frame; null closes the panel.
  open(describe) {
    this.describe = describe;
    this.shown = '';
    this.refresh();
  }

  close() {
    this.describe = null;
    this.place.hidden = true;
  }

  refresh() {
    if (!this.describe) return;
    const described = this.describe();
    if (!described) return this.close();
    const text = JSON.stringify(described);
    if (text === this.shown) return;
    this.shown = text;
    const [title, rows] = described;
    this.title.textContent = title;
    this.rows.replaceChildren(...rows.filter(([, value]) => value != null && value !== '').map(([word, value]) =>
      element('div', {}, element('dt', { textContent: word }), element('dd', { textContent: value }))));
    this.place.hidden = false;
  }
}

export const meters = number => `${number.toFixed(2)} m`;
export const degrees = radians => `${Math.round(((radians * 180 / Math.PI) % 360 + 360) % 360)}°`;
export const point = ([x, y]) => `(${x.toFixed(2)}, ${y.toFixed(2)}) m`;
