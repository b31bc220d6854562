// The map: what is fixed comes with the greeting, what moves with every frame.

import { $, drawn, shape } from './dom.js';
import { gestures } from './gestures.js';
import { Legend } from './legend.js';

const LAYERS = ['trail', 'path', 'particles', 'hits', 'bodies', 'robot', 'marks', 'draft'];
const CLOSEST = 60;

export class Floor {
  // `hand` decides what a press on the map does.
  constructor(hand) {
    this.hand = hand;
    this.follows = false;
    this.trail = [];
    this.legend = new Legend($('legend'));
    $('nearer').onclick = () => this.zoom(1 / 1.4);
    $('farther').onclick = () => this.zoom(1.4);
    $('whole').onclick = () => this.all();
    $('follow').onclick = () => this.follow();
  }

  greet({ floor, robot_radius_m, places }) {
    this.there = Boolean(floor);
    $('map').hidden = !this.there;
    this.trail = [];
    if (!this.there) return;
    $('floor').replaceChildren();
    drawn($('floor'), floor.svg);
    this.svg = $('floor').querySelector('svg');
    this.size = floor.size;
    this.places = places;
    [this.x0, this.y0, this.scale] = floor.origin;
    // A robot whose size is unknown is drawn as a sign.
    this.radius_m = robot_radius_m || 0.2;
    this.moving = shape('g', { class: 'moving' });
    this.svg.append(this.moving);
    this.layers = Object.fromEntries(LAYERS.map(name => [name, shape('g', { class: name })]));
    this.moving.append(...Object.values(this.layers));
    this.all();
    gestures(this, $('floor'));
  }

  spot([x, y]) {
    return [this.x0 + x * this.scale, this.y0 - y * this.scale];
  }

  // The point of the map under the pointer, in meters.
  point({ clientX, clientY }) {
    const at = new DOMPoint(clientX, clientY).matrixTransform(this.svg.getScreenCTM().inverse());
    return [(at.x - this.x0) / this.scale, (this.y0 - at.y) / this.scale].map(m => Math.round(m * 100) / 100);
  }

  show({ pose, estimate, scene }) {
    if (!this.there || !scene) return;
    const { trail, path, particles, hits, bodies, robot } = this.layers;
    if (pose) this.remember(pose);
    trail.replaceChildren(line(this.trail));
    path.replaceChildren(line(this.pairs(scene.path)));
    particles.replaceChildren(dots(this.pairs(scene.particles)));
    hits.replaceChildren(dots(this.pairs(scene.hits)));
    bodies.replaceChildren(...scene.bodies.map(body => this.body(body)));
    robot.replaceChildren();
    if (estimate) robot.append(this.robot(estimate, 'estimate'));
    if (pose) robot.append(this.robot(pose, 'true'));
    if (pose && scene.speeches.length) robot.append(this.speech(pose, scene.speeches.map(words => `“${words}”`).join(' ')));
    [this.pose, this.estimate, this.bodies] = [pose, estimate, scene.bodies];
    if (pose && this.follows) this.center(this.spot(pose));
    this.legend.show(this);
  }

  // The robot's path up to the moment shown.
  way(flat) {
    if (!this.there) return;
    this.trail = this.pairs(flat);
    this.layers.trail.replaceChildren(line(this.trail));
  }

  remember(pose) {
    const spot = this.spot(pose);
    const last = this.trail.at(-1);
    if (!last || Math.hypot(spot[0] - last[0], spot[1] - last[1]) > 3) this.trail.push(spot);
  }

  // Marks the place where something happened.
  mark(words, pose) {
    if (!this.there || !pose) return;
    const [x, y] = this.spot(pose);
    this.layers.marks.append(shape('path', { d: `M${x},${y - 7}l7,12h-14z` }, shape('title', {}, words)));
  }

  // What is at a point: the robot, a body, a place, or the floor.
  thing(point) {
    if (this.pose && distance(point, this.pose) <= this.radius_m * 1.3) return { is: 'robot', at: this.pose };
    const body = this.bodies?.findLast(body => reaches(body, point));
    if (body) return { is: 'body', ...body };
    const place = this.places.filter(place => covers(place.corners, point)).sort((a, b) => extent(a) - extent(b))[0];
    return place ? { is: 'place', ...place } : { is: 'floor', at: point };
  }

  // Draws a thing where it would be dropped.
  draft(thing, point) {
    const at = [...point, thing.at[2]];
    this.layers.draft.replaceChildren(thing.is === 'robot' ? this.robot(at, 'true') : this.body({ ...thing, at }));
  }

  aim(from, to) {
    const [[x, y], tip] = [this.spot(from), this.spot(to)];
    const angle = Math.atan2(tip[1] - y, tip[0] - x);
    const wing = turn => [tip[0] - 12 * Math.cos(angle + turn), tip[1] - 12 * Math.sin(angle + turn)].join(',');
    this.layers.draft.replaceChildren(shape('circle', { cx: x, cy: y, r: 6 }),
      shape('path', { d: `M${x},${y}L${tip.join(',')}M${wing(0.5)}L${tip.join(',')}L${wing(-0.5)}` }));
  }

  clearDraft() {
    this.layers.draft.replaceChildren();
  }

  unmark() {
    if (this.there) this.layers.marks.replaceChildren();
  }

  pairs(flat) {
    return Array.from({ length: flat.length / 2 }, (_, i) => this.spot([flat[2 * i], flat[2 * i + 1]]));
  }

  robot(pose, kind) {
    const [x, y] = this.spot(pose);
    const radius = this.radius_m * this.scale;
    const [dx, dy] = [Math.cos(pose[2]) * radius, -Math.sin(pose[2]) * radius];
    return shape('g', { class: kind },
      shape('circle', { cx: x, cy: y, r: radius }), shape('line', { x1: x, y1: y, x2: x + dx, y2: y + dy }));
  }

  // In lines above the robot, the last one nearest, not beyond the edges of the map.
  speech(pose, text) {
    const [x, y] = this.spot(pose);
    const lines = wrapped(text, 32);
    const half = 4 * Math.max(...lines.map(line => line.length));
    const middle = Math.max(half, Math.min(x, this.size[0] - half));
    const top = Math.max(18, y - this.radius_m * this.scale - 10 - 18 * (lines.length - 1));
    const parts = lines.map((line, row) => shape('tspan', { x: middle, y: top + 18 * row }, line));
    return shape('text', { class: 'speech' }, ...parts);
  }

  body(body) {
    const { name, at, radius_m, size_m } = body;
    const [x, y] = this.spot(at);
    const title = shape('title', {}, name);
    const kind = this.hand.holds({ is: 'body', ...body }) ? 'held' : '';
    if (radius_m) return shape('circle', { cx: x, cy: y, r: radius_m * this.scale, class: kind }, title);
    const [w, h] = size_m.map(m => m * this.scale);
    const turn = `rotate(${-at[2] * 180 / Math.PI} ${x} ${y})`;
    return shape('rect', { x: x - w / 2, y: y - h / 2, width: w, height: h, transform: turn, class: kind }, title);
  }

  // Zooms around a point in the picture, given as fractions of its width and height.
  zoom(by, [px, py] = [0.5, 0.5]) {
    const width = Math.min(Math.max(this.box[2] * by, CLOSEST), this.size[0] * 1.5);
    const height = width * this.box[3] / this.box[2];
    this.look([this.box[0] + (this.box[2] - width) * px, this.box[1] + (this.box[3] - height) * py, width, height]);
  }

  // Moves the picture by fractions of its width and height.
  pan(dx, dy) {
    this.follow(false);
    this.look([this.box[0] + dx * this.box[2], this.box[1] + dy * this.box[3], this.box[2], this.box[3]]);
  }

  center([x, y]) {
    this.look([x - this.box[2] / 2, y - this.box[3] / 2, this.box[2], this.box[3]]);
  }

  all() {
    this.follow(false);
    this.look([0, 0, ...this.size]);
  }

  follow(does = !this.follows) {
    this.follows = does;
    $('follow').ariaPressed = String(does);
    if (does && this.pose) this.center(this.spot(this.pose));
  }

  look(box) {
    this.box = box;
    this.svg.setAttribute('viewBox', box.join(' '));
  }
}

function line(spots) {
  return shape('polyline', { points: spots.map(spot => spot.join(',')).join(' ') });
}

// Many points as one path of zero-length strokes.
function dots(spots) {
  return shape('path', { d: spots.map(([x, y]) => `M${x},${y}h0`).join('') });
}

export function distance(a, b) {
  return Math.hypot(a[0] - b[0], a[1] - b[1]);
}

// Whether a body is at a point, or near enough for a touch.
function reaches({ at, radius_m, size_m }, point) {
  const near = 0.1;
  if (radius_m) return distance(at, point) <= radius_m + near;
  const [dx, dy] = [point[0] - at[0], point[1] - at[1]];
  const [cos, sin] = [Math.cos(at[2]), Math.sin(at[2])];
  return Math.abs(dx * cos + dy * sin) <= size_m[0] / 2 + near && Math.abs(dy * cos - dx * sin) <= size_m[1] / 2 + near;
}

// Whether a place covers a point. A place without an area counts as a disc with a radius of 0.4 m.
function covers(corners, point) {
  if (corners.length < 3) return distance(corners[0], point) <= 0.4;
  return corners.filter(([x, y], i) => {
    const [px, py] = corners.at(i - 1);
    return (y > point[1]) !== (py > point[1]) && point[0] < x + (px - x) * (point[1] - y) / (py - y);
  }).length % 2 === 1;
}

export function extent({ corners }) {
  return Math.abs(corners.reduce((sum, [x, y], i) => sum + corners.at(i - 1)[0] * y - x * corners.at(i - 1)[1], 0)) / 2;
}

// A text in lines of at most that many characters, if its words are short enough.
function wrapped(text, most) {
  const lines = [''];
  for (const word of text.split(' ')) {
    if (lines.at(-1) && lines.at(-1).length + word.length >= most) lines.push('');
    lines.push(`${lines.pop()} ${word}`.trim());
  }
  return lines;
}
