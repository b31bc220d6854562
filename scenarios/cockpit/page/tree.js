// The behavior tree, each node with its last outcome. Of a large one, the server draws what is going on, and what the
// user has opened.

import { $, drawn, shape } from './dom.js';
import { parts } from './parts.js';

export class Tree {
  // `ask` shows details; `unfold` has all children of a node drawn, or no longer, and tells whether the user may do so.
  constructor(ask, unfold) {
    [this.place, this.overview, this.find] = [$('tree'), $('overview'), $('find')];
    this.unfold = unfold;
    this.parts = parts(this.place, 'data-node', node => ask(this.about(node)));
    this.place.addEventListener('click', ({ clientX, clientY }) => {
      if (document.elementFromPoint(clientX, clientY)?.closest('[data-node]')) this.toggle();
    });
    this.place.addEventListener('keydown', ({ key }) => { if (key === 'Enter') this.toggle(); });
    this.find.addEventListener('keydown', ({ key }) => { if (key === 'Enter') this.seek(); });
    this.place.addEventListener('scroll', () => this.look());
    new ResizeObserver(() => this.look()).observe(this.place);
    const go = ({ buttons, offsetX, offsetY }) => {
      if (!buttons) return;
      const { scrollWidth, scrollHeight, clientWidth, clientHeight } = this.place;
      const scale = scrollWidth / this.overview.clientWidth;
      this.place.scrollTo(offsetX * scale - clientWidth / 2, offsetY * scale - clientHeight / 2);
    };
    for (const event of ['pointerdown', 'pointermove']) this.overview.addEventListener(event, go);
  }

  greet({ nodes }) {
    this.nodes = nodes;
    [this.opened, this.last, this.seen] = [new Set(), null, null];
    this.find.closest('label').hidden = nodes.length < 20;
    $('behavior').hidden = !nodes.length;
  }

  show({ tree, outcomes, locations, differing }) {
    if (tree === undefined) return;
    [this.outcomes, this.locations, this.differing] = [outcomes, locations, differing];
    drawn(this.place, tree);
    const picture = this.place.querySelector('svg');
    picture.id = 'whole-tree';
    for (const side of ['width', 'height']) picture.style.setProperty(`--${side}`, `${picture.getAttribute(side)}px`);
    this.parts.mark();
    for (const part of this.place.querySelectorAll('[data-node]')) {
      part.classList.toggle('differing', Number(part.dataset.node) === differing);
    }
    if (this.sought == null) this.follow();
    else if (this.place.querySelector(`[data-node="${this.sought}"]`)) {
      this.parts.choose(this.sought);
      this.sought = null;
    }
    this.look();
  }

  // Moves to the leaf that is running, when it is another one than before, unless somebody is looking elsewhere.
  follow() {
    const running = this.outcomes.lastIndexOf('running');
    const part = this.place.querySelector(`[data-node="${running}"]`);
    if (!part || running === this.followed || this.place.matches(':hover, :focus-within')) return;
    this.followed = running;
    const [there, here] = [part, this.place].map(place => place.getBoundingClientRect());
    this.place.scrollBy(there.x + there.width / 2 - here.x - here.width / 2, there.y + there.height / 2 - here.y - here.height / 2);
  }

  toggle() {
    const node = this.parts.chosen();
    if (node == null || !this.nodes.some(({ parent }) => parent === node)) return;
    const open = !this.opened.has(node);
    if (!this.unfold(node, open)) return;
    if (open) this.opened.add(node);
    else this.opened.delete(node);
    this.sought = node;
  }

  // Shows the next node with this text in its name; to those who may not unfold it, the one that it is folded into.
  seek() {
    const text = this.find.value.toLowerCase();
    const has = node => text && this.nodes[node].name.toLowerCase().includes(text);
    const matches = [...this.nodes.keys()].filter(has);
    const from = this.parts.chosen() === this.seen ? this.last : this.parts.chosen();
    const next = matches.find(node => node > (from ?? -1)) ?? matches[0];
    this.find.setAttribute('aria-invalid', Boolean(text) && next === undefined);
    if (next === undefined) return;
    if (this.last != null && !this.opened.has(this.last)) this.unfold(this.last, false);
    [this.last, this.seen] = [next, next];
    if (this.unfold(next, true)) this.sought = next;
    else {
      while (!this.place.querySelector(`[data-node="${this.seen}"]`)) this.seen = this.nodes[this.seen].parent;
      this.parts.choose(this.seen);
    }
  }

  // A small picture of the whole where it does not fit, with a frame around what is seen.
  look() {
    const { scrollWidth, scrollHeight, clientWidth, clientHeight, scrollLeft, scrollTop } = this.place;
    const fits = scrollWidth <= clientWidth + 1 && scrollHeight <= clientHeight + 1;
    this.overview.toggleAttribute('hidden', fits || !clientHeight);
    if (fits) return;
    const picture = this.place.querySelector('svg');
    const scale = picture.getAttribute('width') / scrollWidth;
    this.overview.setAttribute('viewBox', `0 0 ${picture.getAttribute('width')} ${picture.getAttribute('height')}`);
    this.overview.replaceChildren(shape('use', { href: '#whole-tree' }), shape('rect', {
      x: scrollLeft * scale, y: scrollTop * scale, width: clientWidth * scale, height: clientHeight * scale,
    }));
  }

  about(number) {
    const { name, kind, parent } = this.nodes[number];
    const children = this.nodes.filter(node => node.parent === number).map(node => node.name);
    return () => [name, [
      ['kind', kind === 'leaf' ? 'a leaf' : kind],
      ['last answer', this.outcomes[number]],
      ['skill is in', this.locations[name]],
      ['parent', parent == null ? 'none: this is the root' : this.nodes[parent].name],
      ['children', children.join(', ')],
      ['beside', number === this.differing ? 'the first result that differs from that of another run' : null],
      ['kept open', this.opened.has(number) ? 'a click, or Enter, lets it be folded again' : null],
    ]];
  }
}
