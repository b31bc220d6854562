// Velocities from the joypad on the page, the arrow keys and gamepads. A new command replaces the previous one.

import { $ } from './dom.js';

const FASTEST_MPS = 0.4;
const FASTEST_RADPS = 1.0;
const NAME = 'joypad';

export class Joypad {
  constructor(link) {
    this.link = link;
    this.held = new Set();
    this.stick = [0, 0];
    this.sent = '0 0';
    this.listen();
    setInterval(() => this.gamepad(), 50);
  }

  listen() {
    const arrows = { ArrowUp: [1, 0], ArrowDown: [-1, 0], ArrowLeft: [0, 1], ArrowRight: [0, -1] };
    const typing = target => target.closest('input, select, textarea, [tabindex]');
    addEventListener('keydown', event => {
      if (event.defaultPrevented || !(event.key in arrows) || typing(event.target)) return;
      event.preventDefault();
      this.held.add(event.key);
      this.update();
    });
    addEventListener('keyup', event => { if (this.held.delete(event.key)) this.update(); });
    addEventListener('blur', () => { this.held.clear(); this.stick = [0, 0]; this.update(); });
    this.arrows = arrows;
    const pad = $('pad');
    const follow = event => {
      const { x, y, width, height } = pad.getBoundingClientRect();
      const limit = number => Math.max(-1, Math.min(1, number));
      this.stick = [-limit((event.clientY - y) / height * 2 - 1), -limit((event.clientX - x) / width * 2 - 1)];
      this.update();
    };
    pad.addEventListener('pointerdown', event => { pad.setPointerCapture(event.pointerId); follow(event); });
    pad.addEventListener('pointermove', event => { if (pad.hasPointerCapture(event.pointerId)) follow(event); });
    pad.addEventListener('lostpointercapture', () => { this.stick = [0, 0]; this.update(); });
  }

  gamepad() {
    const pad = navigator.getGamepads().find(Boolean);
    if (!pad) return;
    const dead = axis => Math.abs(axis) < 0.15 ? 0 : axis;
    const stick = [-dead(pad.axes[1]), -dead(pad.axes[0])];
    if (this.padded || stick.some(Boolean)) { this.stick = stick; this.update(); }
    this.padded = stick.some(Boolean);
  }

  // Forward and left, each from −1 to 1.
  wanted() {
    const keys = [...this.held].map(key => this.arrows[key]);
    const sum = axis => keys.reduce((all, key) => all + key[axis], this.stick[axis]);
    return [0, 1].map(axis => Math.max(-1, Math.min(1, Math.round(sum(axis) * 10) / 10)));
  }

  async update() {
    const [forward, left] = this.wanted();
    $('knob').style.translate = `${-left * 36}px ${-forward * 36}px`;
    const wanted = `${forward} ${left}`;
    if (wanted === this.sent || this.busy) return;
    this.busy = true;
    this.sent = wanted;
    const velocity = { linear_mps: forward * FASTEST_MPS, angular_radps: left * FASTEST_RADPS };
    if (forward || left) await this.link.act('joypad', velocity, NAME);
    else await this.link.ask('release', { name: NAME });
    this.busy = false;
    this.update();
  }
}
