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
  // A viewer, who cannot open anything, is told what the node is folded into.
  const viewer = await Cockpit.open(chromium, live.viewers);
  await viewer.page.locator('#tree').getByText('Wait').waitFor();
  await viewer.page.locator('#find').fill('clean40step3');
  await viewer.page.locator('#find').press('Enter');
  await viewer.page.locator('#tree .chosen').first().waitFor();
  const described = await viewer.page.locator('#details').textContent();
  assert.match(described, /^all/);
  assert.doesNotMatch(described, /kept open/);
  assert.deepEqual([...viewer.problems, ...cockpit.problems], []);
  await viewer.close();
  await cockpit.close();
  live.stop();
  await beside(steward, chromium, folder);
  await aligned(steward, chromium, folder);
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

// A log of BehaviorTree.CPP: the clock of its robot is ahead by seconds, and the third leaf says this at last.
async function log(file, { ahead, last }) {
  const leaves = Array.from({ length: 30 }, (_, leaf) => `<Work name="Leaf${leaf}" _uid="${leaf + 2}"/>`).join('');
  const xml = Buffer.from(`<root BTCPP_format="4"><BehaviorTree ID="Main" _fullpath=""><Sequence name="all" _uid="1">${
    leaves}</Sequence></BehaviorTree></root>`);
  const size = Buffer.alloc(5);
  size.writeInt8(1);
  size.writeInt32LE(xml.length, 1);
  const began = Buffer.alloc(8);
  began.writeBigInt64LE(1795779814000000n);
  const [RUNNING, SUCCESS] = [1, 2];
  const changes = [[0, 1, RUNNING], [0, 2, RUNNING], [1, 2, SUCCESS], [1, 3, RUNNING], [2, 3, SUCCESS], [2, 4, RUNNING],
    [3, 4, last], [4, 5, RUNNING]].map(([second, uid, status]) => {
    const change = Buffer.alloc(9);
    change.writeUIntLE((second + ahead) * 1_000_000, 0, 6);
    change.writeUInt16LE(uid, 6);
    change.writeUInt8(status, 8);
    return change;
  });
  await writeFile(file, Buffer.concat([Buffer.from('BTCPP4-FileLogger2'), size, xml, began, ...changes]));
}

// Two logs are shown where they agree; the first result that differs is marked in both trees and named.
async function aligned(steward, chromium, folder) {
  const files = ['good', 'bad'].map(name => path.join(folder, `${name}.btlog`));
  await log(files[0], { ahead: 0, last: 2 });
  await log(files[1], { ahead: 10, last: 3 });
  const live = await Live.start(steward, files[0], files[1]);
  const page = await chromium.newPage({ viewport: { width: 1366, height: 768 } });
  await page.goto(live.address);
  const compared = page.locator('#compared');
  await compared.getByText(/Leaf2, success at 3.00 s in good.btlog, failure at 13.00 s in bad.btlog/).waitFor();
  await compared.getByText(/Aligned where all first answered running: 0.00 s in good.btlog, 10.00 s in bad/).waitFor();
  const sides = [0, 1].map(side => page.frameLocator('iframe').nth(side));
  for (const side of sides) await side.locator('#tree .differing').getByText('Leaf2', { exact: true }).waitFor();
  await page.locator('#go').click();
  await page.locator('#differ').click();
  for (const [side, clock] of [[sides[0], '3.00 s'], [sides[1], '13.00 s']]) {
    await side.locator('#clock').getByText(clock, { exact: true }).waitFor();
  }
  await page.locator('#aligns').uncheck();
  await compared.getByText(/each is shown from its own start/).waitFor();
  // At that time after its start, the first log has ended.
  await sides[0].locator('#clock').getByText('4.00 s', { exact: true }).waitFor();
  // A name that is found in one tree is shown in both.
  await sides[0].locator('#find').fill('leaf29');
  await sides[0].locator('#find').press('Enter');
  for (const side of sides) await side.locator('#tree').getByText('Leaf29', { exact: true }).waitFor();
  await page.close();
  live.stop();
}
