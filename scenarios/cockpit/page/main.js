// The cockpit: shows what the run tells, and asks it for what the pilot does.

import { $, drawn, element, notice } from './dom.js';
import { Details } from './details.js';
import { Floor } from './floor.js';
import { Hand } from './hand.js';
import { Joypad } from './keys.js';
import { Link } from './link.js';
import { Machines } from './machines.js';
import { Messages } from './messages.js';
import { about } from './things.js';
import { Tree } from './tree.js';

const link = new Link(take);
const hand = new Hand(link, () => steers, thing => details.open(about(thing, floor, hand, () => latest)));
const floor = new Floor(hand);
const details = new Details();
const ask = tell => details.open(tell);
const messages = new Messages(ask);
const machines = new Machines(ask);
const tree = new Tree(ask);
let steers = false;
let paused = false;
let latest = {};

new Joypad({ ask: (...request) => steers ? link.ask(...request) : Promise.resolve(null),
             act: (...request) => steers ? link.act(...request) : Promise.resolve(null) });

function take(frame) {
  if (frame.greeting) return greet(frame.greeting);
  if ('pilot' in frame) {
    steers = frame.pilot;
    document.body.classList.toggle('viewer', !steers);
    return;
  }
  if (frame.failed) notice(`The run cannot go on: ${frame.failed}`, true);
  if ('time' in frame) state(frame);
  if ('verdicts' in frame) parts(frame);
}

function greet(greeting) {
  document.title = `${greeting.scenario} · live`;
  $('scenario').textContent = greeting.scenario;
  $('scenario').title = greeting.about;
  floor.greet(greeting);
  for (const part of [hand, machines, tree]) part.greet(greeting);
}

function state(frame) {
  latest = { ...latest, ...frame };
  paused = frame.paused;
  $('clock').textContent = `${frame.time.toFixed(2)} s · tick ${Math.max(0, frame.ticks - 1)}`;
  const { battery, end } = frame;
  $('battery').textContent = battery ? `battery ${battery.pct.toFixed(1)} %${battery.charging ? ', charging' : ''}` : '';
  $('go').textContent = paused ? 'Go' : 'Pause';
  $('speed').value = frame.speed ?? '';
  for (const button of ['go', 'step', 'tick', 'end']) $(button).disabled = Boolean(end);
  if (end) notice(`The run has ended: ${end.words}. Its trace hash is ${end.trace_hash.slice(0, 16)}….`, true);
  if ('doing' in frame) {
    $('doing').textContent = [frame.doing, frame.navigation && `navigation: ${frame.navigation}`].filter(Boolean).join(' · ');
  }
  floor.show(frame);
  for (const part of [hand, messages, machines, tree]) part.show(frame);
  happenings(frame);
  details.refresh();
}

function happenings({ happenings, anew, pose }) {
  if (anew) $('happenings').replaceChildren();
  for (const { at, kind, words } of happenings ?? []) {
    $('happenings').append(element('li', { className: kind, textContent: `${at.toFixed(2)} s  ${words}` }));
    if (!anew && (kind === 'fault' || kind === 'violated')) floor.mark(words, pose);
  }
  if (happenings?.length) $('happenings').scrollTop = $('happenings').scrollHeight;
}

function parts(frame) {
  floor.way(frame.trail);
  for (const part of ['verdicts', 'stories', 'course']) drawn($(part), frame[part]);
}

$('go').onclick = () => link.ask(paused ? 'resume' : 'pause');
$('step').onclick = () => link.ask('step');
$('tick').onclick = () => link.ask('tick');
$('end').onclick = () => link.ask('end');
$('speed').onchange = () => link.ask('speed', { times: $('speed').value ? Number($('speed').value) : null });
$('save').onclick = async () => {
  const answer = await link.ask('save');
  if (!answer) return;
  const file = URL.createObjectURL(new Blob([answer.scenario], { type: 'application/toml' }));
  element('a', { href: file, download: `${$('scenario').textContent.replaceAll('/', '-')}-session.toml` }).click();
  URL.revokeObjectURL(file);
};

addEventListener('keydown', event => {
  if (event.target.closest('input, select, textarea, button, summary') || event.ctrlKey || event.metaKey || !steers) return;
  const key = { ' ': 'go', '.': 'step', t: 'tick' }[event.key];
  if (key) { event.preventDefault(); $(key).click(); }
});
