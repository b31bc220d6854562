// Random sessions: each saved scenario replays to the session's trace hash.

import assert from 'node:assert/strict';
import { copyFile, readFile } from 'node:fs/promises';
import { Cockpit, Live, report } from './cockpit.mjs';

const SCENARIOS = ['nominal', 'errand', 'populated', 'joypad', 'guide', 'parcel', 'pick'];
const ARROWS = ['ArrowUp', 'ArrowDown', 'ArrowLeft', 'ArrowRight'];

// Mulberry32: the same numbers for the same seed.
function dice(seed) {
  const next = () => {
    seed = seed + 0x6d2b79f5 | 0;
    let t = Math.imul(seed ^ seed >>> 15, 1 | seed);
    t = t + Math.imul(t ^ t >>> 7, 61 | t) ^ t;
    return ((t ^ t >>> 14) >>> 0) / 2 ** 32;
  };
  const between = (least, most) => least + next() * (most - least);
  return { between, pick: list => list[Math.floor(next() * list.length)] };
}

// What a person might do. Some of it is refused, as for a person.
const ACTS = {
  wait: async ({ page }, { between }) => page.waitForTimeout(between(50, 400)),
  speed: async ({ page }, { pick }) => page.locator('#speed').selectOption(pick(['0.5', '1', '5', '10', ''])),
  pause: async ({ page }) => page.locator('#go').click(),
  step: async ({ page }) => page.locator('#step').click(),
  tick: async ({ page }) => page.keyboard.press('t'),
  scrub: async (cockpit, { between }) => {
    const { page, run } = cockpit;
    if (!(run.to > 1)) return;
    await page.locator('#when').fill(String(Math.floor(between(0, run.to - 0.5) * 50) / 50));
    await cockpit.until(run => run.past);
    await cockpit.button('Now').click();
    await cockpit.until(run => !run.past);
  },
  charge: async ({ page, run }, { between }) => {
    if (run.battery) await page.locator('#charge').fill(String(Math.round(between(1, 100))));
  },
  drive: async ({ page, run }, { between, pick }) => {
    if (!run.pose) return;
    await page.locator('h1').click();
    const key = pick(ARROWS);
    await page.keyboard.down(key);
    await page.waitForTimeout(between(20, 300));
    await page.keyboard.up(key);
  },
  pad: async ({ page, run }, { between }) => {
    if (!run.pose) return;
    await page.locator('#pad').scrollIntoViewIfNeeded();
    const { x, y, width, height } = await page.locator('#pad').boundingBox();
    await page.mouse.move(x + width / 2, y + height / 2);
    await page.mouse.down();
    for (let i = 0; i < 4; i++) await page.mouse.move(x + between(0, width), y + between(0, height));
    await page.mouse.up();
  },
  kidnap: async (cockpit, { between }) => {
    const { page, run } = cockpit;
    if (!run.pose || !run.greeting.floor) return;
    const [x, y] = await cockpit.spot(run.pose);
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x + between(-60, 60), y + between(-60, 60), { steps: 3 });
    await page.mouse.up();
  },
  place: async (cockpit, { between, pick }) => {
    const { page, run } = cockpit;
    if (!run.greeting.floor) return;
    await cockpit.button(pick(await page.locator('#tools button').allTextContents())).click();
    await page.locator('#floor svg').scrollIntoViewIfNeeded();
    for (let clicks = 2; clicks; clicks--) {
      const { x, y, width, height } = await page.locator('#floor svg').boundingBox();
      await page.mouse.click(x + width * between(0.1, 0.9), y + height * between(0.1, 0.9));
    }
    await cockpit.button('Look').click();
  },
  fault: async ({ page }, { pick }) => {
    if (!await page.locator('#faults').evaluate(details => details.open)) await page.locator('#faults summary').click();
    const kinds = await page.locator('#kind option').evaluateAll(options => options.map(({ value }) => value));
    await page.locator('#kind').selectOption(pick(kinds));
    await page.locator('#do').click();
  },
  release: async ({ page }, { pick }) => {
    const ends = await page.locator('#lasting button').elementHandles();
    // The list may be rebuilt at any time.
    if (ends.length) await pick(ends).click({ timeout: 500 }).catch(() => {});
  },
};

async function play(steward, chromium, seed) {
  const chance = dice(seed);
  const scenario = chance.pick(SCENARIOS);
  const live = await Live.start(steward, scenario, '--seed', String(seed));
  const cockpit = await Cockpit.open(chromium, live.address);
  const done = [];
  for (let acts = chance.between(5, 25); acts > 0 && !cockpit.run.end; acts--) {
    const act = chance.pick(Object.keys(ACTS));
    done.push(act);
    // The run may end at any time, and then its buttons are gone.
    await ACTS[act](cockpit, chance).catch(error => { if (!cockpit.run.end) throw error; });
  }
  const { file, hash } = await cockpit.save();
  const replayed = await report(steward, file);
  const acts = (await readFile(file, 'utf8')).split('[[faults]]').length - 1;
  if (replayed.trace_hash !== hash) await copyFile(file, `session-${seed}.toml`);
  assert.equal(replayed.trace_hash, hash, `seed ${seed}, ${scenario}: ${done} (see session-${seed}.toml)`);
  assert.deepEqual(cockpit.problems, [], `seed ${seed}, ${scenario}`);
  await cockpit.close();
  live.stop();
  console.log(`seed ${seed}: ${scenario}, ${cockpit.run.time.toFixed(2)} s, ${acts} faults: replays`);
}

export async function sessions(steward, chromium, { sessions: count, seed }) {
  for (let i = 0; i < count; i++) await play(steward, chromium, seed + i);
}
