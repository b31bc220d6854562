// The progress of a campaign, and its results so far.

import { $, element, notice } from './dom.js';
import { Link } from './link.js';

const link = new Link(take);

function take(frame) {
  if (frame.greeting) {
    document.title = `${frame.greeting.title} · live`;
    $('title').textContent = frame.greeting.title;
  }
  if ('done' in frame) show(frame);
  if (frame.over) {
    link.end();
    $('pace').textContent = '';
    const { value, max } = $('bar');
    notice(value < max ? 'The command was interrupted before all runs were done.' : 'All runs are done.', true);
  }
}

function show({ done, all, before, elapsed_s, unexpected, named, tallies }) {
  $('bar').max = all;
  $('bar').value = done;
  $('done').textContent = `${done} of ${all} runs`;
  const rate = (done - before) / elapsed_s;
  $('pace').textContent = rate > 0 ? `${rate.toFixed(1)} runs per second, ${words((all - done) / rate)} to go` : '';
  document.querySelector('table').hidden = !tallies.length;
  $('tallies').replaceChildren(...tallies.map(({ name, happened, of, interval }) => element('tr', {},
    element('th', { scope: 'row', textContent: name }),
    ...[happened, of, ...between(interval)].map(text => element('td', { textContent: text })))));
  $('probability').hidden = !tallies.some(({ interval }) => interval);
  const runs = unexpected === 1 ? 'run' : 'runs';
  $('unexpected').textContent = unexpected ? `${unexpected} ${runs} since the command started; the latest:` : 'none';
  $('named').replaceChildren(...named.toReversed().map(text => element('li', { textContent: text })));
}

function between(interval) {
  return interval ? [interval.map(end => end.toFixed(4)).join(' to ')] : [];
}

function words(seconds) {
  const minutes = Math.floor(seconds / 60);
  if (minutes >= 60) return `${Math.floor(minutes / 60)} h ${minutes % 60} min`;
  return minutes ? `${minutes} min ${Math.floor(seconds % 60)} s` : `${Math.ceil(seconds)} s`;
}
