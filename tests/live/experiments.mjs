// The paper's experiments, done manually on the page, end as on the command line. Together with the last one, they are
// the exercises of docs/src/tutorials/lesson.md.

import assert from 'node:assert/strict';
import { Cockpit, Live, report } from './cockpit.mjs';

const PAPER = {
  battery_fault: ['violated', 'satisfied', 'satisfied'],
  skill_bug: ['satisfied', 'violated', 'violated'],
  joypad: ['violated', 'satisfied', 'violated'],
  nominal: ['satisfied', 'satisfied', 'satisfied'],
};
const STATION = [-7.5, 9.0];

// The battery's slider, while the robot is on its way.
async function battery_fault(cockpit) {
  await cockpit.pauseAt(15);
  await cockpit.charge(10);
  await cockpit.speed('as fast as possible');
  await cockpit.until(run => run.speed === null);
  assert.equal(await cockpit.page.locator('#charge').inputValue(), '10', 'the slider stays while the run is paused');
  await cockpit.button('Go').click();
}

// A wrong threshold from the list of faults, and the slider.
async function skill_bug(cockpit) {
  const { page } = cockpit;
  await cockpit.button('Pause').click();
  await page.getByText('Faults', { exact: true }).click();
  await page.locator('#kind').selectOption('skill_threshold');
  await page.getByLabel('skill', { exact: true }).fill('BatteryLevel');
  await page.getByLabel('value', { exact: true }).fill('20');
  await cockpit.button('Do it now').click();
  await cockpit.until(run => run.lasting.length === 1);
  await cockpit.pauseAt(15);
  await cockpit.charge(25);
  await cockpit.speed('as fast as possible');
  await cockpit.button('Go').click();
}

// Only keys: T advances by one tick, and the arrow drives the robot away when it comes near the station.
async function joypad(cockpit) {
  const { keyboard } = cockpit.page;
  await keyboard.press(' ');
  await cockpit.until(run => run.paused);
  for (let held = 0; !cockpit.run.end;) {
    const [x, y] = cockpit.run.pose;
    const isNear = cockpit.run.battery.pct < 30 && Math.hypot(x - STATION[0], y - STATION[1]) < 3;
    if (held === 0 && isNear) {
      await keyboard.down('ArrowDown');
      await cockpit.until(run => run.lasting.length === 1);
      held = 10;
    } else if (held > 0 && --held === 0) {
      await keyboard.up('ArrowDown');
      await cockpit.until(run => run.lasting.length === 0);
    }
    const { ticks } = cockpit.run;
    await keyboard.press('t');
    await cockpit.until(run => run.end || run.paused && run.ticks > ticks);
  }
}

// A box on the robot's path, a person who crosses it, and the robot lifted elsewhere: it still finds its way.
async function nominal(cockpit) {
  const { page } = cockpit;
  const apart = ({ pose, estimate }) => Math.hypot(pose[0] - estimate[0], pose[1] - estimate[1]);
  const click = async point => page.mouse.click(...await cockpit.spot(point));
  await cockpit.speed('5×');
  await cockpit.pauseAt(10);
  const [x, y] = cockpit.run.pose;
  const { path } = cockpit.run.scene;
  const points = Array.from({ length: path.length / 2 }, (_, i) => path.slice(2 * i, 2 * i + 2));
  const ahead = points.find(point => Math.hypot(point[0] - x, point[1] - y) > 2.5);
  await cockpit.button('Box').click();
  await cockpit.ask(() => click(ahead));
  await cockpit.button('Person').click();
  await click([-4.5, 6.2]);
  await cockpit.ask(() => click([-4.5, 7.4]));
  await cockpit.button('Go').click();
  await cockpit.until(run => run.scene.bodies.length === 2);
  await cockpit.pauseAt(25);
  await cockpit.button('Look').click();
  await page.mouse.move(...await cockpit.spot(cockpit.run.pose));
  await page.mouse.down();
  await page.mouse.move(...await cockpit.spot([-1, 2]), { steps: 5 });
  await cockpit.ask(() => page.mouse.up());
  await cockpit.button('Step').click();
  await cockpit.until(run => apart(run) > 0.5);
  await cockpit.speed('10×');
  await cockpit.button('Go').click();
  await cockpit.until(run => apart(run) < 0.1);
}

export async function experiments(steward, browser) {
  for (const [scenario, experiment] of Object.entries({ battery_fault, skill_bug, joypad, nominal })) {
    const set = scenario === 'nominal' ? 'battery.initial_pct=80' : 'faults=[]';
    const live = await Live.start(steward, scenario, '--set', set);
    const cockpit = await Cockpit.open(browser, live.address);
    await experiment(cockpit);
    const { end } = await cockpit.until(run => run.end);
    await cockpit.page.getByText(end.trace_hash.slice(0, 16)).waitFor();
    const verdicts = await cockpit.verdicts();
    assert.deepEqual(Object.values(verdicts), PAPER[scenario], scenario);
    const { file, hash } = await cockpit.save();
    const replayed = await report(steward, file);
    assert.equal(replayed.trace_hash, hash, `${scenario} replays`);
    assert.equal(replayed.outcome, 'as_expected', replayed.stdout);
    assert.deepEqual(cockpit.problems, []);
    await cockpit.close();
    live.stop();
    console.log(`${scenario} on the page: ${Object.entries(verdicts).map(pair => pair.join(' ')).join(', ')}; replays`);
  }
}
