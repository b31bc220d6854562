// What the page looks like for pilot and viewer, in three sizes, light and dark, and what axe-core says about it.

import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { createRequire } from 'node:module';
import path from 'node:path';
import { Cockpit, Live } from './cockpit.mjs';

const axe = await readFile(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
const SIZES = [[390, 844], [768, 1024], [1366, 768], [1920, 1080]];
const SCHEMES = ['light', 'dark'];

// What axe-core calls serious or critical, with the elements.
export async function serious({ page }) {
  await page.evaluate(axe);
  const { violations } = await page.evaluate(() => window.axe.run());
  return violations.filter(({ impact }) => ['serious', 'critical'].includes(impact))
    .flatMap(({ id, nodes }) => nodes.map(({ target, any }) => `${id}: ${target}: ${any.map(why => why.message)}`));
}

// Somebody walks, a fault lasts, phi1 is violated: the page shows something of everything.
async function busy(live, browser) {
  const cockpit = await Cockpit.open(browser, live.address);
  const { page } = cockpit;
  await page.getByText('Faults', { exact: true }).click();
  await page.locator('#kind').selectOption('laser_noise');
  await cockpit.ask(() => cockpit.button('Do it now').click());
  await cockpit.speed('10×');
  await cockpit.until(run => run.time > 8);
  await cockpit.charge(10);
  await cockpit.until(run => run.time > 16);
  await cockpit.speed('1×');
  return cockpit;
}

// Details open from the keyboard, and those arrow keys do not drive.
async function explains({ page }) {
  for (const place of ['#tree', '#chart']) {
    await page.locator(place).press('ArrowUp');
    await page.locator('#details').waitFor();
    await page.keyboard.press('Escape');
    await page.locator('#details').waitFor({ state: 'hidden' });
  }
  await page.evaluate(() => scrollTo(0, 0));
  assert.ok(!(await page.locator('#happenings').textContent()).includes('joypad'));
}

// On a small laptop, everything is on the first screen. A line moves, a panel goes away, and the browser keeps both.
async function docks({ page }) {
  await page.setViewportSize({ width: 1366, height: 768 });
  const box = panel => page.locator(panel).boundingBox();
  for (const panel of ['#map', '#verdicts', '#behavior', '#past', '#hand']) {
    const { x, y, width, height } = await box(panel);
    assert.ok(x >= 0 && y >= 0 && x + width <= 1366 && y + height <= 768 && width > 200 && height > 150, panel);
  }
  const before = await box('#map');
  const line = page.getByRole('separator').first();
  await line.press('ArrowLeft');
  const { x, y, height } = await line.boundingBox();
  await page.mouse.move(x + 2, y + height / 2);
  await page.mouse.down();
  await page.mouse.move(x - 58, y + height / 2);
  await page.mouse.up();
  const moved = await box('#map');
  assert.ok(Math.abs(moved.width - before.width + 84) < 4, `${before.width} → ${moved.width}`);
  await page.locator('#panels summary').click();
  await page.getByRole('checkbox', { name: 'Messages' }).uncheck();
  await page.reload();
  await page.locator('#floor svg').waitFor();
  assert.ok(Math.abs((await box('#map')).width - moved.width) < 2);
  assert.ok(!await page.locator('#traffic').isVisible());
  await page.locator('#panels summary').click();
  await page.getByRole('button', { name: 'As at first' }).click();
  assert.ok(await page.locator('#traffic').isVisible());
  assert.ok(Math.abs((await box('#map')).width - before.width) < 2);
  await page.locator('#panels summary').click();
}

export async function looks(steward, browser, { pictures }) {
  const live = await Live.start(steward, 'populated');
  const pilot = await busy(live, browser);
  const viewer = await Cockpit.open(browser, live.viewers);
  // Pictures and axe-core see the whole page, not only what is in sight.
  for (const { page } of [pilot, viewer]) {
    await page.addStyleTag({ content: 'main *{content-visibility:visible!important}' });
  }
  const found = new Set();
  for (const state of ['running', 'ended']) {
    for (const [who, cockpit] of Object.entries({ pilot, viewer })) {
      const { page } = cockpit;
      for (const colorScheme of SCHEMES) {
        await page.emulateMedia({ colorScheme });
        for (const [width, height] of SIZES) {
          await page.setViewportSize({ width, height });
          const at = `${who}-${state}-${width}-${colorScheme}`;
          if (pictures) await page.screenshot({ path: path.join(pictures, `${at}.png`), fullPage: true });
          const sticksOut = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
          if (sticksOut > 0) found.add(`${at}: ${sticksOut} px stick out`);
        }
        (await serious(cockpit)).forEach(words => found.add(`${who}, ${state}, ${colorScheme}: ${words}`));
      }
    }
    await explains(pilot);
    await docks(pilot);
    if (state === 'running') await pilot.ask(() => pilot.button('End').click());
  }
  assert.deepEqual([...found, ...pilot.problems, ...viewer.problems], []);
  await pilot.close();
  await viewer.close();
  live.stop();
}
