// What the signs on the map mean: only those that are visible.

import { element, shape } from './dom.js';

const circle = (cx, r) => shape('circle', { cx, cy: 9, r });
const box = (x, kind) => shape('rect', { x, y: 4, width: 12, height: 10, class: kind });
const stroke = () => shape('polyline', { points: '2,9 26,9' });
const dots = d => shape('path', { d });
const robot = kind => shape('g', { class: kind }, circle(14, 7), shape('line', { x1: 14, y1: 9, x2: 21, y2: 9 }));
const holds = (layer, what) => floor => floor.layers[layer].querySelector(what);

// The layer of the sign, what it means, how it is drawn, and whether it is on a map.
const SIGNS = [
  ['robot', 'robot and its heading', () => [robot('true')], floor => floor.pose],
  ['robot', 'where it believes it is', () => [robot('estimate')], floor => floor.estimate],
  ['particles', 'where it may be', () => [dots('M8,6h0M15,12h0M20,7h0')], holds('particles', '[d*=M]')],
  ['hits', 'what the lasers see', () => [dots('M6,9h0M14,9h0M22,9h0')], holds('hits', '[d*=M]')],
  ['path', 'planned path', () => [stroke()], holds('path', '[points*=","]')],
  ['trail', 'path so far', () => [stroke()], floor => floor.trail.length > 1],
  ['bodies', 'person (round), box or door', () => [circle(7, 5), box(15)], floor => floor.bodies.length],
  ['bodies', 'can be dragged', () => [box(8, 'held')], holds('bodies', '.held')],
  ['marks', 'fault or violation', () => [dots('M14,2l7,12h-14z')], holds('marks', 'path')],
];

export class Legend {
  constructor(place) {
    this.place = place;
  }

  show(floor) {
    const there = SIGNS.filter(([, , , isThere]) => isThere(floor));
    const names = there.map(([, words]) => words).join();
    if (names === this.shown) return;
    this.shown = names;
    this.place.replaceChildren(...there.map(([layer, words, draw]) => {
      const sign = shape('g', { class: layer }, ...draw());
      const attributes = { viewBox: '0 0 28 18', width: 28, height: 18, class: 'moving', 'aria-hidden': 'true' };
      return element('li', {}, shape('svg', attributes, sign), words);
    }));
  }
}
