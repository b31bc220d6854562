// Controls playback: pause, resume, step, speed, and the slider over what was recorded.

import { $ } from './dom.js';

export class Transport {
  constructor(link) {
    this.link = link;
    this.steers = false;
    $('go').onclick = () => link.ask(this.paused ? 'resume' : 'pause');
    $('step').onclick = () => link.ask('step');
    $('tick').onclick = () => link.ask('tick');
    $('now').onclick = () => link.ask('now');
    $('speed').onchange = () => link.ask('speed', { times: $('speed').value ? Number($('speed').value) : null });
    $('when').oninput = () => this.seek();
    addEventListener('keydown', event => this.key(event));
  }

  // `paced` says whether others set the pace of the run, `ticks` whether it knows its ticks.
  greet({ paced, ticks }) {
    this.paced = paced;
    $('tick').hidden = !ticks;
  }

  // `at` is the moment shown, `past` whether it is before the newest, `grows` whether there will be more, `waits` whether
  // the run waits for others, `delay` how long after the others a run beside them begins.
  show({ at, to, paused, past, grows, speed, waits, end, delay = 0 }) {
    this.delay = delay;
    this.paused = paused;
    $('go').textContent = paused ? 'Go' : 'Pause';
    $('speed').value = speed ?? '';
    const isPaced = Boolean(this.paced) && !past;
    $('speed').parentElement.style.display = isPaced ? 'none' : '';
    $('pace').hidden = !isPaced;
    $('pace').textContent = waits ? 'waiting for others' : 'at the pace of others';
    for (const button of ['go', 'step', 'tick']) $(button).disabled = Boolean(end) && grows && !past;
    const slider = $('when');
    slider.max = Math.ceil(to * 50) / 50;
    if (!this.sought) slider.value = past ? at : slider.max;
    slider.ariaValueText = `${Number(slider.value).toFixed(2)} of ${to.toFixed(2)} seconds`;
    $('until').textContent = `${to.toFixed(1)} s`;
    $('now').hidden = !grows;
    document.body.classList.toggle('past', past);
    this.past = past;
    this.allow(this.steers);
  }

  // Whether the user may choose the moment.
  allow(steers) {
    this.steers = steers;
    $('when').disabled = !steers;
    $('now').disabled = !this.past || !steers;
  }

  // Shows another moment, unless only another person may.
  go(time) {
    if (!this.steers && parent !== window) parent.dispatchEvent(new CustomEvent('go', { detail: time + this.delay }));
    if (!this.steers) return;
    $('when').value = time;
    this.seek();
  }

  // Sends one request at a time; only the slider's latest position counts.
  async seek() {
    const busy = this.sought;
    this.sought = true;
    if (busy) return;
    let asked;
    while (asked !== $('when').value) {
      asked = $('when').value;
      await this.link.ask('seek', { time: Number(asked) });
    }
    this.sought = false;
  }

  key(event) {
    if (!this.steers || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.target.closest('input:not([type=range]), select, textarea, button, summary')) return;
    const key = { ' ': 'go', '.': 'step', t: 'tick', n: 'now' }[event.key];
    if (key && !$(key).hidden) { event.preventDefault(); $(key).click(); }
  }
}
