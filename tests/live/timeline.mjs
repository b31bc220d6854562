// The timeline of a report, opened as a file: it zooms, says what is under the pointer, folds and follows links.

import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { readFile, writeFile } from 'node:fs/promises';
import path from 'node:path';
import { promisify } from 'node:util';
import { folder } from './cockpit.mjs';
import { serious } from './looks.mjs';

// The report of the paper's first experiment.
export async function report(steward) {
  const out = path.join(folder, 'report');
  await promisify(execFile)(steward, ['run', 'battery_fault', '--no-snapshots', '--out', out]);
  return path.join(out, 'report.html');
}

class Explored {
  static async open(browser, file, options = {}) {
    const explored = new Explored();
    const context = await browser.newContext({ viewport: { width: 1366, height: 768 }, ...options });
    explored.page = await context.newPage();
    explored.problems = [];
    explored.page.on('pageerror', error => explored.problems.push(error.message));
    explored.page.on('console', message => explored.problems.push(message.text()));
    await explored.page.goto(`file://${file}`);
    explored.canvas = explored.page.locator('.explore canvas');
    return explored;
  }

  output() {
    return this.page.locator('.explore output').textContent();
  }

  // The page's script draws in the next frame.
  frame() {
    return this.page.evaluate(() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done))));
  }

  async pixels() {
    await this.frame();
    return this.canvas.evaluate(canvas => canvas.toDataURL());
  }

  // Each row from the top until the pointer is in one of which this is said.
  async point(x, words) {
    const { height } = await this.canvas.boundingBox();
    for (let y = 20; y < height; y += 12) {
      await this.canvas.hover({ position: { x, y } });
      if (words.test(await this.output())) return y;
    }
    throw new Error(`nothing at ${x} says ${words}`);
  }
}

export async function timeline(steward, browser) {
  const file = await report(steward);
  const explored = await Explored.open(browser, file);
  const { page, canvas } = explored;
  assert.ok(!await page.locator('.whole').isVisible());
  const { width } = await canvas.boundingBox();
  await explored.point(width - 60, /phi1: ✗ violated, from 21\.02 s to/);
  const level = await explored.point(width - 60, /BatteryLevel: ✗ failure, from 21\.02 s to/);
  assert.match(await explored.output(), /Battery, in percent: 8\.\d/);

  // A page scrolls over the timeline until one has turned to it.
  await page.mouse.move(0, 0);
  const whole = await explored.pixels();
  await canvas.hover({ position: { x: width / 2, y: level } });
  const before = await explored.pixels();
  await page.mouse.wheel(0, 100);
  assert.ok(await explored.pixels() === before);
  await canvas.click({ position: { x: width / 2, y: level } });
  await page.mouse.wheel(0, -400);
  const near = await explored.pixels();
  assert.ok(near !== before);
  await page.keyboard.press('0');
  await page.mouse.move(0, 0);
  assert.ok(await explored.pixels() === whole);

  // From event to event, and from a violation's time to the timeline.
  await canvas.press('.');
  assert.match(await explored.output(), /^20\.50 s .*battery level set to 10 %/);
  await canvas.press('.');
  assert.match(await explored.output(), /^21\.02 s .*phi1 violated/);
  await page.locator('a[data-at]').first().click();
  assert.match(page.url(), /#timeline$/);
  assert.match(await explored.output(), /^21\.02 s .*phi1 violated/);


  // A click on a heading folds its lanes.
  const { height } = await canvas.boundingBox();
  await canvas.click({ position: { x: 40, y: level - 24 } });
  await explored.frame();
  assert.ok((await canvas.boundingBox()).height < height - 100);
  assert.deepEqual(explored.problems, []);
  assert.deepEqual(await serious(explored), []);

  // A script of somebody else does not run, and on paper and without scripts there is the drawing: on sheets, or whole.
  const stranger = file.replace('report.html', 'stranger.html');
  await writeFile(stranger, (await readFile(file, 'utf8')).replace('</main>', '<script>window.stranger = 1</script></main>'));
  const foreign = await Explored.open(browser, stranger);
  assert.equal(await foreign.page.evaluate(() => window.stranger), undefined);
  assert.match(foreign.problems.join(), /Content Security Policy/);
  await page.emulateMedia({ media: 'print' });
  const shown = async () => [await page.locator('.sheet').first().isVisible(), await page.locator('.whole').isVisible(), await canvas.isVisible()];
  assert.deepEqual(await shown(), [true, false, false]);
  const silent = await Explored.open(browser, file, { javaScriptEnabled: false });
  assert.ok(await silent.page.locator('.whole > svg').isVisible());
}
