// The map: what stands on it comes with the greeting, what moves with every frame. Drag moves it, the wheel zooms.

import { $, drawn, shape } from './dom.js';

const ZOOM = 1.2;

export class Floor {
  // `clicked` gets a point in metres and whether the robot was dragged there.
  constructor(clicked) {
    this.clicked = clicked;
    this.follows = false;
    this.trail = [];
  }

  greet({ floor, robot_radius_m }) {
    this.there = Boolean(floor);
    $('map').hidden = !this.there;
    if (!this.there) return;
    drawn($('floor'), floor.svg);
    this.svg = $('floor').querySelector('svg');
    this.size = floor.size;
    [this.x0, this.y0, this.scale] = floor.origin;
    this.radius = robot_radius_m * this.scale;
    this.box = [0, 0, ...this.size];
    this.moving = shape('g', { class: 'moving' });
    this.svg.append(this.moving);
    this.parts = Object.fromEntries(['trail', 'path', 'particles', 'hits', 'bodies', 'robot', 'marks'].map(name => {
      const part = shape('g', { class: name });
      this.moving.append(part);
      return [name, part];
    }));
    this.listen();
  }

  spot([x, y]) {
    return [this.x0 + x * this.scale, this.y0 - y * this.scale];
  }

  // The point of the map under the pointer, in metres.
  point({ clientX, clientY }) {
    const at = new DOMPoint(clientX, clientY).matrixTransform(this.svg.getScreenCTM().inverse());
    return [(at.x - this.x0) / this.scale, (this.y0 - at.y) / this.scale].map(m => Math.round(m * 100) / 100);
  }

  show({ pose, estimate, scene }) {
    if (!this.there || !scene) return;
    const { trail, path, particles, hits, bodies, robot } = this.parts;
    if (pose) this.remember(pose);
    trail.replaceChildren(line(this.trail));
    path.replaceChildren(line(this.pairs(scene.path)));
    particles.replaceChildren(dots(this.pairs(scene.particles)));
    hits.replaceChildren(dots(this.pairs(scene.hits)));
    bodies.replaceChildren(...scene.bodies.flatMap(body => this.body(body)));
    robot.replaceChildren(...(estimate ? [this.robot(estimate, 'estimate')] : []), ...(pose ? [this.robot(pose, 'true')] : []));
    if (pose) scene.speeches.forEach((words, row) => robot.append(this.speech(pose, words, row)));
    if (pose && this.follows && !this.drag) this.center(this.spot(pose));
    this.pose = pose;
  }

  // The way so far, before this page was opened.
  way(flat) {
    if (this.there) this.trail = this.pairs(flat);
  }

  remember(pose) {
    const spot = this.spot(pose);
    const last = this.trail.at(-1);
    if (!last || Math.hypot(spot[0] - last[0], spot[1] - last[1]) > 3) this.trail.push(spot);
  }

  // Marks the place where something has happened.
  mark(words, pose) {
    if (!this.there || !pose) return;
    const [x, y] = this.spot(pose);
    this.parts.marks.append(shape('circle', { cx: x, cy: y, r: 5 }, shape('title', {}, words)));
  }

  pairs(flat) {
    return Array.from({ length: flat.length / 2 }, (_, i) => this.spot([flat[2 * i], flat[2 * i + 1]]));
  }

  robot(pose, kind) {
    const [x, y] = this.spot(pose);
    const [dx, dy] = [Math.cos(pose[2]) * this.radius, -Math.sin(pose[2]) * this.radius];
    return shape('g', { class: kind },
      shape('circle', { cx: x, cy: y, r: this.radius }), shape('line', { x1: x, y1: y, x2: x + dx, y2: y + dy }));
  }

  speech(pose, words, row) {
    const [x, y] = this.spot(pose);
    return shape('text', { x, y: y - this.radius - 10 - 18 * row, class: 'speech' }, `“${words}”`);
  }

  body({ name, at, radius_m, size_m }) {
    const [x, y] = this.spot(at);
    const title = shape('title', {}, name);
    if (radius_m) return [shape('circle', { cx: x, cy: y, r: radius_m * this.scale }, title)];
    const [w, h] = size_m.map(m => m * this.scale);
    const turn = `rotate(${-at[2] * 180 / Math.PI} ${x} ${y})`;
    return [shape('rect', { x: x - w / 2, y: y - h / 2, width: w, height: h, transform: turn }, title)];
  }

  listen() {
    this.svg.addEventListener('pointerdown', event => this.press(event));
    this.svg.addEventListener('pointermove', event => this.pull(event));
    this.svg.addEventListener('pointerup', event => this.drop(event));
    this.svg.addEventListener('wheel', event => {
      event.preventDefault();
      this.zoom(event.deltaY < 0 ? 1 / ZOOM : ZOOM, event);
    }, { passive: false });
    $('floor').addEventListener('keydown', event => {
      const act = { '+': () => this.zoom(1 / ZOOM), '-': () => this.zoom(ZOOM), 0: () => this.all(), f: () => this.follow() }[event.key];
      if (act) { event.preventDefault(); act(); }
    });
  }

  press(event) {
    this.svg.setPointerCapture(event.pointerId);
    const at = this.point(event);
    const onRobot = this.pose && Math.hypot(at[0] - this.pose[0], at[1] - this.pose[1]) * this.scale <= this.radius * 1.3;
    this.drag = { from: [event.clientX, event.clientY], box: [...this.box], onRobot, moved: false };
  }

  pull(event) {
    if (!this.drag) return;
    const [dx, dy] = [event.clientX - this.drag.from[0], event.clientY - this.drag.from[1]];
    this.drag.moved ||= Math.hypot(dx, dy) > 4;
    if (!this.drag.moved) return;
    if (this.drag.onRobot) {
      this.parts.robot.replaceChildren(this.robot([...this.point(event), this.pose[2]], 'dragged'));
    } else {
      const scale = this.box[2] / this.svg.clientWidth;
      this.look([this.drag.box[0] - dx * scale, this.drag.box[1] - dy * scale, this.box[2], this.box[3]]);
    }
  }

  drop(event) {
    const drag = this.drag;
    this.drag = null;
    if (drag && (!drag.moved || drag.onRobot)) this.clicked(this.point(event), drag.moved && drag.onRobot, this.pose);
  }

  zoom(by, event) {
    const box = this.svg.getBoundingClientRect();
    const [px, py] = event ? [(event.clientX - box.x) / box.width, (event.clientY - box.y) / box.height] : [0.5, 0.5];
    const width = Math.min(Math.max(this.box[2] * by, 60), this.size[0] * 1.5);
    const height = width * this.box[3] / this.box[2];
    this.look([this.box[0] + (this.box[2] - width) * px, this.box[1] + (this.box[3] - height) * py, width, height]);
  }

  center([x, y]) {
    this.look([x - this.box[2] / 2, y - this.box[3] / 2, this.box[2], this.box[3]]);
  }

  all() {
    this.follows = false;
    this.look([0, 0, ...this.size]);
  }

  follow() {
    this.follows = !this.follows;
    return this.follows;
  }

  look(box) {
    this.box = box;
    this.svg.setAttribute('viewBox', box.join(' '));
  }
}

function line(spots) {
  return shape('polyline', { points: spots.map(spot => spot.join(',')).join(' ') });
}

// Many points as one path of short strokes.
function dots(spots) {
  return shape('path', { d: spots.map(([x, y]) => `M${x},${y}h0`).join('') });
}
