// Threats from outside: names that are markup, pages of other sites, other names for this address.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFile, writeFile } from 'node:fs/promises';
import { createServer } from 'node:http';
import path from 'node:path';
import { Cockpit, folder, Live, PATIENCE_MS, report } from './cockpit.mjs';

const EVIL = '<img src=x onerror=alert(1)>';
const WORSE = '"><script>alert(2)</script><svg onload=alert(3)>';

// A scenario whose names are all markup, as far as file formats allow.
async function evilScenario(steward) {
  const robot = path.join(folder, 'evil');
  execFileSync(steward, ['init', robot]);
  const rewrite = async (file, edit, to = file) =>
    writeFile(path.join(robot, to), edit(await readFile(path.join(robot, file), 'utf8')));
  const xml = text => text.replaceAll('&', '&amp;').replaceAll('<', '&lt;').replaceAll('"', '&quot;');
  const key = text => JSON.stringify(text);
  await rewrite('maps/house.places.toml', text => text.replace('[Destination]', `[${key(WORSE)}]`));
  for (const skill of ['AtDestination', 'GoToDestination']) {
    await rewrite(`skills/${skill}.scxml`, text => text.replace("'Destination'", xml(`'${WORSE}'`)));
  }
  await rewrite('trees/recharge.xml', text => text.replace('<WaitForUser/>', `<Action ID="${xml(EVIL)}"/>`));
  const renamed = text => text.replace('name="WaitForUser"', `name="${xml(EVIL)}"`);
  await rewrite('skills/WaitForUser.scxml', renamed, `skills/${EVIL}.scxml`);
  await rewrite('properties/phi1.scope', text => `// ${EVIL}${WORSE}\n${text.replace(/^\/\/.*\n/, '')}`);
  const scenario = `${EVIL.replaceAll('/', '')}.toml`;
  await rewrite('battery_fault.toml', text => text
    .replace(/^about = .*$/m, `about = ${key(EVIL + WORSE)}`)
    .replace('"Destination"', key(WORSE))
    .replace('[battery]', `
[[people]]
name = ${key(EVIL)}
at = [2.0, 0.5]

[[doors]]
name = ${key(WORSE)}
at = [-11.3, 12.1, 0]
width_m = 1.4

[[boxes]]
name = ${key(EVIL + WORSE)}
at = [-3.0, 6.1, 0]
mass_kg = 4

[battery]`), scenario);
  return path.join(robot, scenario);
}

export async function names(steward, chromium) {
  const live = await Live.start(steward, await evilScenario(steward));
  const cockpit = await Cockpit.open(chromium, live.address);
  const { page } = cockpit;
  await page.getByRole('searchbox').fill(EVIL);
  await page.getByText('Faults', { exact: true }).click();
  await page.locator('#kind').selectOption('message_corrupted');
  await cockpit.speed('10×');
  await page.locator('#kind').selectOption('obstacle_appears');
  await cockpit.ask(() => cockpit.button('Do it now').click());
  await cockpit.until(run => run.time > 30);
  await cockpit.ask(() => cockpit.button('End').click());
  await page.locator('#stories').getByText('phi1 is violated').first().waitFor();
  assert.equal(await page.getByRole('heading', { level: 1 }).textContent(), EVIL);
  assert.equal(await page.locator('img, script:not([src="/main.js"], [src="/timeline.js"]), [onerror], [onload]').count(), 0);
  assert.ok((await page.content()).includes('&lt;script'));
  assert.deepEqual(cockpit.problems, []);
  await cockpit.close();
  live.stop();
}

// Runs in another site's page: what it gets from the server at this address.
async function prowl({ address, token }) {
  const socket = new Promise(done => {
    const socket = new WebSocket(`${address.replace('http', 'ws')}/socket?token=${token}`);
    socket.onmessage = ({ data }) => done(data);
    socket.onerror = () => done(null);
  });
  const read = path => fetch(address + path).then(answer => answer.ok ? answer.text() : null, () => null);
  const frame = new Promise(done => {
    const frame = document.createElement('iframe');
    frame.src = `${address}/?token=${token}`;
    frame.onload = () => {
      try { done(frame.contentDocument?.querySelector('#scenario')?.textContent ?? null); } catch { done(null); }
    };
    document.body.append(frame);
  });
  return Promise.all([socket, read(`/?token=${token}`), read('/main.js'), frame]);
}

// Pages of other sites get nothing, even if they know the token, and even if their name comes to mean this address.
export async function sites(steward, chromium) {
  const live = await Live.start(steward, 'nominal');
  const cockpit = await Cockpit.open(chromium, live.address);
  const server = createServer((_, answer) => answer.setHeader('Content-Type', 'text/html').end('<body>elsewhere'));
  await new Promise(done => server.listen(0, '127.0.0.1', done));
  const elsewhere = `http://evil.example:${server.address().port}/`;
  const rebound = `http://evil.example:${live.port}`;
  const context = await chromium.newContext();
  const page = await context.newPage();
  await page.goto(elsewhere, { timeout: PATIENCE_MS });
  assert.equal(await page.textContent('body'), 'elsewhere');
  const nothing = [null, null, null, null];
  for (const address of [`http://127.0.0.1:${live.port}`, `http://localhost:${live.port}`, rebound]) {
    assert.deepEqual(await page.evaluate(prowl, { address, token: live.token }), nothing, address);
  }
  // The name now means this address: the page has the origin of the server under that name.
  await page.route(`${rebound}/`, route => route.fulfill({ contentType: 'text/html', body: '<body>rebound' }));
  await page.goto(`${rebound}/`, { timeout: PATIENCE_MS });
  assert.deepEqual(await page.evaluate(prowl, { address: rebound, token: live.token }), nothing, 'rebound');
  assert.equal((await page.goto(`${rebound}/?token=${live.token}`)).status(), 403);
  await context.close();
  server.close();
  await undisturbed(steward, live, cockpit);
}

// The pilot still steers, and the run is the same as without any interference.
export async function undisturbed(steward, live, cockpit) {
  assert.equal(cockpit.run.pilot, true);
  const { file, hash } = await cockpit.save();
  assert.deepEqual(cockpit.problems, []);
  assert.ok(!(await readFile(file, 'utf8')).includes('[[faults]]'));
  assert.equal((await report(steward, file)).trace_hash, hash);
  await cockpit.close();
  live.stop();
}
