// A running `steward live`, its page in a browser, and the runs that it saves.

import { spawn, execFile } from 'node:child_process';
import { mkdtemp, readFile } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { createInterface } from 'node:readline';
import { promisify } from 'node:util';
import { chromium } from 'playwright-core';

// Nothing here takes this long, even on a busy machine.
export const PATIENCE_MS = 120_000;

export const folder = await mkdtemp(path.join(tmpdir(), 'steward-live-'));

// Debian's Chromium, or the one that CHROMIUM names. It resolves names that end in `.example` to this computer, and
// leaves it to the server to refuse other sites.
export function browser() {
  return chromium.launch({
    executablePath: process.env.CHROMIUM || '/usr/bin/chromium',
    args: [
      '--no-sandbox',
      '--host-resolver-rules=MAP *.example 127.0.0.1',
      '--disable-features=LocalNetworkAccessChecks',
    ],
    timeout: PATIENCE_MS,
  });
}

export class Live {
  static async start(steward, scenario, ...args) {
    const live = new Live();
    live.steward = steward;
    live.process = spawn(steward, ['live', scenario, '--no-open', ...args], { stdio: ['ignore', 'pipe', 'inherit'] });
    live.end = () => live.process.kill();
    process.once('exit', live.end);
    const lines = [];
    for await (const line of createInterface({ input: live.process.stdout })) {
      if (lines.push(line) === 2) break;
    }
    [live.address, live.viewers] = lines.map(line => line.slice(line.indexOf('http://')));
    if (!live.viewers) throw new Error(`steward live ${scenario} prints nothing`);
    const { host, port, searchParams } = new URL(live.address);
    Object.assign(live, { host, port: Number(port), token: searchParams.get('token') });
    return live;
  }

  get pid() {
    return this.process.pid;
  }

  stop() {
    process.off('exit', this.end);
    this.end();
  }
}

// The page of a run, with the latest state that it has received.
export class Cockpit {
  static async open(browser, address) {
    const context = await browser.newContext({ viewport: { width: 1400, height: 900 } });
    const cockpit = new Cockpit();
    cockpit.page = await context.newPage();
    cockpit.page.setDefaultTimeout(PATIENCE_MS);
    cockpit.problems = [];
    cockpit.run = {};
    cockpit.answers = 0;
    cockpit.waiting = new Set();
    cockpit.observe();
    await cockpit.page.goto(address);
    await cockpit.until(run => 'pilot' in run && 'time' in run);
    return cockpit;
  }

  observe() {
    const { page, problems } = this;
    page.on('console', message => { if (message.type() === 'error') problems.push(message.text()); });
    page.on('pageerror', error => problems.push(String(error)));
    page.on('dialog', dialog => { problems.push(`dialog: ${dialog.message()}`); dialog.dismiss(); });
    page.on('websocket', socket => socket.on('framereceived', ({ payload }) => {
      const frame = JSON.parse(payload);
      if ('answer' in frame || 'refused' in frame) this.answers += 1;
      Object.assign(this.run, frame);
      this.waiting.forEach(look => look());
    }));
  }

  // Waits until this holds for the run.
  until(holds) {
    return new Promise((done, fail) => {
      const timer = setTimeout(() => {
        fail(new Error(`timed out waiting for ${holds} at ${this.run.time} s; ${this.problems}`));
      }, PATIENCE_MS);
      const look = () => {
        if (!holds(this.run)) return;
        clearTimeout(timer);
        this.waiting.delete(look);
        done(this.run);
      };
      this.waiting.add(look);
      look();
    });
  }

  // Does something that makes the page send a request, and waits for the answer.
  async ask(act) {
    const { answers } = this;
    await act();
    await this.until(() => this.answers > answers);
  }

  button(name) {
    return this.page.getByRole('button', { name, exact: true });
  }

  async speed(label) {
    await this.page.locator('#speed').selectOption({ label });
  }

  // Pauses, and goes on tick by tick: on a busy computer, a click may come much later than it was meant.
  async pauseAt(time) {
    if (!this.run.paused) await this.button('Pause').click();
    await this.until(run => run.paused);
    while (this.run.time < time) {
      const { ticks } = this.run;
      await this.button('Tick').click();
      await this.until(run => run.paused && run.ticks > ticks);
    }
  }

  // Sets the battery level with the slider.
  async charge(pct) {
    await this.ask(() => this.page.getByRole('slider', { name: 'Battery' }).fill(String(pct)));
  }

  // The position of a point of the map on the page.
  async spot([x, y]) {
    await this.page.locator('#floor svg').scrollIntoViewIfNeeded();
    return this.page.evaluate(([x, y, [x0, y0, scale]]) => {
      const matrix = document.querySelector('#floor svg').getScreenCTM();
      const at = new DOMPoint(x0 + x * scale, y0 - y * scale).matrixTransform(matrix);
      return [at.x, at.y];
    }, [x, y, this.run.greeting.floor.origin]);
  }

  // The verdicts of the properties.
  async verdicts() {
    const lines = this.page.locator('#verdicts [data-name]');
    return Object.fromEntries(await lines.evaluateAll(lines =>
      lines.map(line => [line.dataset.name, line.querySelector('.pill').textContent.trim()])));
  }

  // Ends the run and saves it; returns the file, and the trace hash that the page received.
  async save() {
    const over = this.until(run => run.end);
    // It may also end by itself, and the button is disabled then.
    await Promise.any([over, this.button('End').click()]);
    const { end } = await over;
    const download = this.page.waitForEvent('download');
    await this.button('Save as scenario').click();
    const file = path.join(folder, `session-${Math.random().toString(36).slice(2)}.toml`);
    await (await download).saveAs(file);
    return { file, hash: end.trace_hash };
  }

  async close() {
    await this.page.context().close();
  }
}

// Runs a scenario without a page; returns its report.
export async function report(steward, scenario) {
  const out = path.join(folder, `out-${Math.random().toString(36).slice(2)}`);
  const run = promisify(execFile)(steward, ['run', scenario, '--no-snapshots', '--out', out]);
  const { code = 0, stdout } = await run.catch(error => error);
  const text = await readFile(path.join(out, 'report.json'), 'utf8').catch(() => '{}');
  return { code, stdout, ...JSON.parse(text) };
}
