// The behavior tree, each node with its last outcome.

import { $, drawn } from './dom.js';
import { parts } from './parts.js';

export class Tree {
  // `ask` shows details.
  constructor(ask) {
    this.place = $('tree');
    this.mark = parts(this.place, 'data-node', node => ask(this.about(node)));
  }

  greet({ nodes }) {
    this.nodes = nodes;
  }

  show({ tree, outcomes, locations }) {
    if (tree === undefined) return;
    [this.outcomes, this.locations] = [outcomes, locations];
    drawn(this.place, tree);
    this.mark();
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
    ]];
  }
}
