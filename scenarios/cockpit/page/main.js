// The cockpit: shows the run, and sends it what the pilot does. The reports' script explores the timeline.

/* global explore */

import { $, drawn, element, notice } from './dom.js';
import { beside, Comparison } from './beside.js';
import { Details } from './details.js';
import { arrange, dock } from './dock.js';
import { Floor } from './floor.js';
import { Hand } from './hand.js';
import { Joypad } from './keys.js';
import { Link } from './link.js';
import { Machines } from './machines.js';
import { Messages } from './messages.js';
import { about } from './things.js';
import { Transport } from './transport.js';
import { Tree } from './tree.js';

const link = new Link(take);
const transport = new Transport(link);
// Whether the user can act on the run: only the pilot can, and only in the present.
const acts = () => transport.steers && !recorded && !past;
const hand = new Hand(link, acts, thing => details.open(about(thing, floor, hand, () => latest)));
const floor = new Floor(hand);
const details = new Details();
const ask = describe => details.open(describe);
const comparison = new Comparison(link, transport);
const messages = new Messages(ask);
const machines = new Machines(ask);
const tree = new Tree(ask, unfold);
let recorded = true;
let past = false;
let ended = false;
// Whether the run knows its ticks: a log does not.
let ticks = true;
// Shows other data on the timeline.
let course;
let latest = {};
const late = [];
let waits = false;

new Joypad({ ask: (...request) => transport.steers && !recorded ? link.ask(...request) : Promise.resolve(null),
             act: (...request) => acts() ? link.act(...request) : Promise.resolve(null) });

// A run beside others uses the slider of the outer page, and is as high as what it shows.
const isSide = new URLSearchParams(location.search).has('side');
document.body.classList.add(isSide ? 'side' : 'docked');
dock();

function take(frame) {
  if (frame.greeting) return greet(frame.greeting);
  if ('pilot' in frame) {
    transport.allow(frame.pilot);
    document.body.classList.toggle('viewer', !frame.pilot);
    return arrange();
  }
  if (frame.failed) notice(`The run cannot continue: ${frame.failed}`, true);
  if ('at' in frame) transport.show(frame);
  if (frame.beside) comparison.show(frame.beside);
  // The path comes first: what is shown is not a continuation of the path up to another moment.
  if ('trail' in frame) floor.way(frame.trail);
  if ('scene' in frame) floor.show(frame);
  later(frame);
}

// The map is drawn at once, since whoever steers looks there; the rest when that is on the screen. In a hidden page it
// never is, so frames do not wait for it without end.
function later(frame) {
  late.push(frame);
  if (late.length > 25) rest();
  if (waits) return;
  waits = true;
  requestAnimationFrame(() => setTimeout(() => { waits = false; rest(); }));
}

function rest() {
  for (const frame of late.splice(0)) {
    if ('verdicts' in frame) parts(frame);
    if ('scene' in frame) state(frame);
  }
}

function greet(greeting) {
  recorded = !('scenario' in greeting) || greeting.file !== null;
  document.body.classList.toggle('recorded', recorded);
  if (greeting.sides) {
    transport.greet(greeting);
    return beside(greeting.sides);
  }
  details.close();
  const name = recorded ? `${greeting.scenario} · ${greeting.file}` : greeting.scenario;
  document.title = `${name} · live`;
  $('scenario').textContent = name;
  ticks = greeting.ticks;
  $('scenario').title = `${greeting.about}${ticks ? ` Seed ${greeting.seed}.` : ''}`;
  floor.greet(greeting);
  for (const part of [transport, hand, messages, machines, tree]) part.greet(greeting);
  arrange();
}

function state(frame) {
  latest = { ...latest, ...frame };
  past = frame.past && !recorded;
  for (const place of ['hand', 'tools']) $(place).inert = past || Boolean(frame.end);
  $('clock').textContent = `${frame.time.toFixed(2)} s${ticks ? ` · tick ${Math.max(0, frame.ticks - 1)}` : ''}`;
  const { battery, end } = frame;
  $('battery').textContent = battery ? `battery ${battery.pct.toFixed(1)} %${battery.charging ? ', charging' : ''}` : '';
  $('end').disabled = Boolean(end) || past;
  $('report').hidden = !end;
  if (end) notice(`The run has ended: ${end.words}. Its trace hash is ${end.trace_hash.slice(0, 16)}….`, true);
  else if (ended) notice('');
  ended = Boolean(end);
  if ('doing' in frame) {
    $('doing').textContent = [frame.doing, frame.navigation && `navigation: ${frame.navigation}`].filter(Boolean).join(' · ');
  }
  for (const part of [hand, messages, machines, tree]) part.show(frame);
  if ('entries' in frame) blackboard(Object.entries(frame.entries));
  happenings(frame);
  details.refresh();
}

function blackboard(entries) {
  const row = ([name, value]) =>
    element('tr', {}, element('th', { scope: 'row', textContent: name }), element('td', { textContent: value }));
  $('entries').replaceChildren(...entries.map(row));
  if ($('blackboard').hidden === Boolean(entries.length)) {
    $('blackboard').hidden = !entries.length;
    arrange();
  }
}

function happenings({ happenings, anew }) {
  if (anew) { $('happenings').replaceChildren(); floor.unmark(); }
  for (const { at, kind, words, place } of happenings ?? []) {
    $('happenings').append(element('li', { className: kind, textContent: `${at.toFixed(2)} s  ${words}` }));
    if (kind === 'fault' || kind === 'violated') floor.mark(words, place);
  }
  if (happenings?.length) $('happenings').scrollTop = $('happenings').scrollHeight;
}

function parts(frame) {
  const opened = [...$('verdicts').querySelectorAll('[open]')].map(line => line.dataset.name);
  for (const part of ['verdicts', 'stories']) drawn($(part), frame[part]);
  if ($('verdicts').hidden !== !frame.verdicts) {
    $('verdicts').hidden = !frame.verdicts;
    arrange();
  }
  if (course) course(frame.course);
  else course = explore($('course'), frame.course, time => transport.go(time));
  for (const line of $('verdicts').children) line.open = opened.includes(line.dataset.name);
}

// A run beside others leaves the choice of the moment and of the open nodes to the outer page, which shows all alike.
addEventListener('go', ({ detail }) => transport.go(detail));
addEventListener('unfold', event => {
  if (!unfold(event.detail.node, event.detail.open, event.detail.side)) event.preventDefault();
});

function unfold(node, open, side = Number(new URLSearchParams(location.search).get('side'))) {
  if (transport.steers) link.ask('unfold', { node, open, side });
  else if (isSide) return parent.dispatchEvent(new CustomEvent('unfold', { detail: { node, open, side }, cancelable: true }));
  return transport.steers;
}

$('end').onclick = () => link.ask('end');
$('restart').onclick = () => link.ask('restart');
$('save').onclick = () => download('save', 'scenario', 'application/toml', 'session.toml');
$('report').onclick = () => download('report', 'page', 'text/html', 'report.html');

// Asks for a file, and downloads it.
async function download(what, key, type, name) {
  const answer = await link.ask(what);
  if (!answer) return;
  if (answer.note) notice(answer.note);
  const href = URL.createObjectURL(new Blob([answer[key]], { type }));
  element('a', { href, download: `${$('scenario').textContent.replaceAll('/', '-')}-${name}` }).click();
  URL.revokeObjectURL(href);
}
