// Debian's Firefox, or the one that FIREFOX names: the battery experiment on the page, and the session that it saves.

import assert from 'node:assert/strict';
import { existsSync } from 'node:fs';
import { writeFile } from 'node:fs/promises';
import path from 'node:path';
import { firefox as playwright } from 'playwright-core';
import { folder, Live, PATIENCE_MS, report } from './cockpit.mjs';

// The reason if there is no Firefox.
export async function firefox(steward) {
  const executablePath = process.env.FIREFOX || '/usr/bin/firefox-esr';
  if (!existsSync(executablePath)) return 'there is no Firefox (firefox-esr), and FIREFOX names none';
  const browser = await playwright.launch({ channel: 'moz-firefox', executablePath, timeout: PATIENCE_MS });
  const live = await Live.start(steward, 'battery_fault', '--set', 'faults=[]');
  const page = await (await browser.newContext({ viewport: { width: 1400, height: 900 } })).newPage();
  page.setDefaultTimeout(PATIENCE_MS);
  const problems = [];
  page.on('console', message => { if (message.type() === 'error') problems.push(message.text()); });
  page.on('pageerror', error => problems.push(String(error)));
  // Playwright hears of no downloads here, so the page keeps what it saves.
  await page.addInitScript(() => {
    const make = URL.createObjectURL;
    URL.createObjectURL = blob => {
      window.saved = blob.text();
      return make.call(URL, blob);
    };
  });
  await page.goto(live.address);
  await page.locator('#floor .robot .true').waitFor();
  await page.locator('#speed').selectOption({ label: '10×' });
  await page.waitForFunction(() => parseFloat(document.querySelector('#clock').textContent) > 15);
  await page.getByRole('slider', { name: 'Battery' }).fill('10');
  await page.getByText('battery level set to 10 %').first().waitFor({ state: 'attached' });
  await page.locator('#speed').selectOption({ label: 'as fast as possible' });
  const ended = await page.getByText('Its trace hash is').textContent();
  const pills = (await page.locator('#verdicts .pill').allTextContents()).map(words => words.trim());
  assert.deepEqual(pills, ['violated', 'satisfied', 'satisfied']);
  await page.getByRole('button', { name: 'Save as scenario' }).click();
  await page.waitForFunction(() => window.saved);
  const file = path.join(folder, 'firefox-session.toml');
  await writeFile(file, await page.evaluate(() => window.saved));
  const { trace_hash, outcome } = await report(steward, file);
  assert.ok(ended.includes(trace_hash.slice(0, 16)), `${ended} ${trace_hash} replayed`);
  assert.equal(outcome, 'as_expected');
  assert.deepEqual(problems, []);
  console.log(`battery_fault on the page in Firefox ${browser.version()}: ${pills.join(', ')}; replays`);
  await browser.close();
  live.stop();
}
