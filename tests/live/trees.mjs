// A tree of a thousand nodes on the page: folded, searched, opened; and two recordings, beside each other.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtemp, rm, writeFile } from 'node:fs/promises';
import os from 'node:os';
import path from 'node:path';
import { Cockpit, Live } from './cockpit.mjs';

// Rooms of twenty steps each; the robot waits in the first of them.
const room = number => `<Sequence name="room ${number}">${Array.from({ length: 20 }, (_, step) => number || step
  ? `<AlwaysSuccess name="Clean${number}Step${step}"/>` : '<Sleep name="Wait" msec="60000"/>').join('')}</Sequence>`;
const TREE = `<root BTCPP_format="4"><BehaviorTree ID="Main"><Sequence name="all">${
  Array.from({ length: 50 }, (_, number) => room(number)).join('')}</Sequence></BehaviorTree></root>`;

export async function trees(steward, chromium) {
  const folder = await mkdtemp(path.join(os.tmpdir(), 'steward-trees-'));
  const scenario = path.join(folder, 'rooms.toml');
  await writeFile(path.join(folder, 'rooms.xml'), TREE);
  await writeFile(scenario, 'about = "Many rooms"\ntree = "rooms.xml"\n[execution]\nmax_time_s = 100\n');
  const live = await Live.start(steward, scenario);
  const cockpit = await Cockpit.open(chromium, live.address);
  const { page } = cockpit;
  const drawn = () => page.locator('#tree [data-node]').count();
  await page.locator('#tree').getByText('Wait').waitFor();
  assert.ok(await drawn() < 40, `${await drawn()} nodes`);
  await page.locator('#find').fill('clean31step7');
  await page.locator('#find').press('Enter');
  await page.locator('#tree').getByText('Clean31Step7', { exact: true }).waitFor();
  assert.equal(await page.locator('#details h2').textContent(), 'Clean31Step7');
  // The room below which nothing is going on opens with a click, and shows all of its steps.
  await page.locator('#tree .chosen').waitFor();
  const before = await drawn();
  await page.locator('#tree').getByText(/room 31/).first().click();
  await page.locator('#tree').getByText('Clean31Step19', { exact: true }).waitFor();
  assert.ok(await drawn() > before);
  assert.deepEqual(cockpit.problems, []);
  await cockpit.close();
  live.stop();
  await beside(steward, chromium, folder);
  await rm(folder, { recursive: true });
}

// The page scrolls over both runs, and a click on a timeline of one shows that moment of both.
async function beside(steward, chromium, folder) {
  const files = ['1', '2'].map(seed => path.join(folder, `${seed}.rec`));
  files.forEach((file, index) => execFileSync(steward, ['run', 'pick', '-q', '--seed', `${index + 1}`, '--record', file,
    '--out', path.join(folder, 'out')]));
  const live = await Live.start(steward, files[0], files[1]);
  const page = await chromium.newPage({ viewport: { width: 1366, height: 768 } });
  await page.goto(live.address);
  const side = page.frameLocator('iframe').first();
  const canvas = side.locator('#course canvas');
  await canvas.waitFor();
  assert.ok(await page.evaluate(() => document.documentElement.scrollHeight > innerHeight));
  const { width } = await canvas.boundingBox();
  await canvas.click({ position: { x: width * 0.7, y: 8 } });
  await page.waitForFunction(() => Number(document.getElementById('when').value) > 0);
  await page.close();
  live.stop();
}
