// Measures the live page: node tests/live/measure.mjs STEWARD [MEASUREMENT…]

import { readdirSync, readFileSync } from 'node:fs';
import { readFile, writeFile } from 'node:fs/promises';
import { getPriority, loadavg, setPriority } from 'node:os';
import { setTimeout as sleep } from 'node:timers/promises';
import { browser, Live } from './cockpit.mjs';
import { frame, Line, upgrade } from './line.mjs';
import { report } from './timeline.mjs';

const ENDLESS = ['--set', 'stop.after_s=1000000', '--set', 'execution.max_time_s=1000000'];

// A viewer or pilot without a browser; it keeps only time and pose of what it receives.
async function onlooker(live, token = new URL(live.viewers).searchParams.get('token')) {
  const line = await Line.open(live.port);
  await line.ask(`/socket?token=${token}`, [`Host: ${live.host}`, `Origin: http://${live.host}`, ...upgrade]);
  line.time = 0;
  line.socket.removeAllListeners('data');
  line.socket.on('data', data => {
    const text = data.toString('latin1');
    line.time = Number(/"time":([\d.]+)/.exec(text)?.[1] ?? line.time);
    line.pose = /"pose":(\[.*?\])/.exec(text)?.[1] ?? line.pose;
    line.told?.();
  });
  line.ask = request => line.socket.write(frame(0x81, Buffer.from(JSON.stringify(request))));
  return line;
}

const quantile = (numbers, share) => numbers.toSorted((a, b) => a - b)[Math.ceil(share * numbers.length) - 1];
const median = numbers => quantile(numbers, 0.5);

function spread(what, took) {
  const [middle, most] = [0.5, 0.95].map(share => quantile(took, share).toFixed(1));
  const [load] = loadavg();
  console.log(`${what}: median ${middle} ms, 95 % within ${most} ms, of ${took.length}; load ${load.toFixed(1)}`);
}

// From a request to the first frame in which the robot, which was at rest, has turned: the server's part of the latency.
async function reaction(steward) {
  const live = await Live.start(steward, 'already_there', ...ENDLESS);
  const pilot = await onlooker(live, live.token);
  pilot.ask({ do: 'speed', times: null });
  while (pilot.time < 120) await sleep(50);
  pilot.ask({ do: 'speed', times: 1 });
  await sleep(2000);
  const took = [];
  for (let i = 0; i < 100; i++) {
    await sleep(600 + Math.random() * 100);
    const [before, began] = [pilot.pose, performance.now()];
    const moved = new Promise(done => { pilot.told = () => { if (pilot.pose !== before) done(performance.now()); }; });
    const fault = { kind: 'joypad', linear_mps: 0, angular_radps: i % 2 ? 1 : -1 };
    pilot.ask({ do: 'act', fault, name: 'joypad' });
    took.push(await moved - began);
    await sleep(150);
    pilot.ask({ do: 'release', name: 'joypad' });
  }
  spread('request to motion', took);
  live.stop();
}

// From an arrow key to the first frame in which the robot, which was at rest, has turned.
async function latency(steward) {
  const live = await Live.start(steward, 'already_there', ...ENDLESS);
  const chromium = await browser();
  // Nothing here reads the frames along with the page: that would take a share of its time.
  const page = await (await chromium.newContext({ viewport: { width: 1400, height: 900 } })).newPage();
  await page.goto(live.address);
  await page.locator('#floor .robot .true line').waitFor();
  // Chromium's threads do not inherit the priority of this process.
  const { processInfo } = await (await chromium.newBrowserCDPSession()).send('SystemInfo.getProcessInfo');
  for (const { id } of processInfo) {
    for (const thread of readdirSync(`/proc/${id}/task`)) setPriority(Number(thread), getPriority());
  }
  await page.evaluate(() => {
    const then = done => requestAnimationFrame(() => {
      const { port1, port2 } = new MessageChannel();
      port1.onmessage = done;
      port2.postMessage(null);
    });
    window.robot = () => document.querySelector('#floor .robot .true line')?.outerHTML;
    window.took = [];
    addEventListener('keydown', ({ timeStamp }) => {
      const before = window.robot();
      const observer = new MutationObserver(() => {
        if (window.robot() === before) return;
        observer.disconnect();
        then(() => window.took.push(performance.now() - timeStamp));
      });
      observer.observe(document.querySelector('#floor'), { childList: true, subtree: true, attributes: true });
    }, true);
  });
  await page.locator('#speed').selectOption({ label: 'as fast as possible' });
  await page.waitForFunction(() => parseFloat(document.querySelector('#clock').textContent) > 120);
  await page.locator('#speed').selectOption({ label: '1×' });
  const rests = async () => {
    for (let last; ; await sleep(200)) {
      const now = await page.evaluate(() => window.robot());
      if (now === last) return;
      last = now;
    }
  };
  for (let i = 0; i < 100; i++) {
    await rests();
    await sleep(Math.random() * 100);
    const key = i % 2 ? 'ArrowRight' : 'ArrowLeft';
    await page.keyboard.down(key);
    await page.waitForFunction(count => window.took.length > count, i);
    await page.keyboard.up(key);
  }
  spread('key to motion', await page.evaluate(() => window.took));
  await chromium.close();
  live.stop();
}

// Processor time of a process, in seconds.
function busy(pid) {
  const [user, system] = readFileSync(`/proc/${pid}/stat`, 'latin1').split(') ')[1].split(' ').slice(11, 13);
  return (Number(user) + Number(system)) / 100;
}

const resident = pid => Number(/VmRSS:\s+(\d+)/.exec(readFileSync(`/proc/${pid}/status`, 'latin1'))[1]) / 1024;

// The share of a core that simulation and server need in real time, with one browser.
async function processor(steward) {
  for (const scenario of ['nominal', 'populated', 'guide']) {
    const live = await Live.start(steward, scenario);
    const line = await onlooker(live);
    await sleep(2000);
    const [before, began, from] = [busy(live.pid), performance.now(), line.time];
    await sleep(20_000);
    const seconds = (performance.now() - began) / 1000;
    console.log(`${scenario}: ${((busy(live.pid) - before) / seconds * 100).toFixed(1)} % of a core, ` +
      `${((line.time - from) / seconds).toFixed(3)} simulated seconds per second`);
    line.socket.destroy();
    live.stop();
  }
}

// How fast a run goes alone and with twenty viewers: as fast as possible, and in real time.
async function viewers(steward) {
  for (const times of [1, 10, null]) {
    const speeds = { alone: [], watched: [] };
    const live = await Live.start(steward, 'nominal', ...ENDLESS);
    const pilot = await onlooker(live, live.token);
    pilot.ask({ do: 'speed', times });
    for (let round = 0; round < 10; round++) {
      const crowd = await Promise.all(Array.from({ length: round % 2 ? 20 : 0 }, () => onlooker(live)));
      await sleep(500);
      const [began, from] = [performance.now(), pilot.time];
      await sleep(4000);
      speeds[round % 2 ? 'watched' : 'alone'].push((pilot.time - from) / (performance.now() - began) * 1000);
      crowd.forEach(({ socket }) => socket.destroy());
    }
    console.log(`at ${times ?? 'any'} speed: ${median(speeds.alone).toFixed(2)} simulated seconds per second alone, ` +
      `${median(speeds.watched).toFixed(2)} with 20 viewers`);
    live.stop();
  }
}

// How much memory an hour of a session adds, while the robot drives, charges and rests, or people walk around it.
async function memory(steward) {
  for (const scenario of ['nominal', 'populated']) {
    const live = await Live.start(steward, scenario, ...ENDLESS);
    const pilot = await onlooker(live, live.token);
    pilot.ask({ do: 'speed', times: null });
    const at = async time => {
      while (pilot.time < time) await sleep(50);
      return resident(live.pid);
    };
    const start = await at(60);
    for (const hours of [1, 2]) {
      const grown = await at(60 + hours * 3600) - start;
      console.log(`${scenario}, ${hours} h: ${grown.toFixed(1)} MB more than the ${start.toFixed(1)} MB after a minute`);
    }
    live.stop();
  }
}

// What a frame of the report's timeline costs in script and layout while one zooms, with 100,000 bars in 20 lanes.
async function timeline(steward) {
  const file = await report(steward);
  const bars = Array.from({ length: 5000 }, (_, bar) => [200, bar % 7 - 1]).flat();
  const lanes = Array.from({ length: 20 }, (_, lane) => ({ name: `lane ${lane}`, bars }));
  const crowd = data => ({ ...data, end: 1000, axis: [[0, 1000, 0, 1, false]], groups: [{ title: 'Lanes', lanes, rest: '' }] });
  const page = await readFile(file, 'utf8');
  const [before, rest] = page.split('<script type="application/json">');
  const end = rest.indexOf('</script>');
  await writeFile(file, `${before}<script type="application/json">${JSON.stringify(crowd(JSON.parse(rest.slice(0, end))))}${rest.slice(end)}`);
  const chromium = await browser();
  const context = await chromium.newPage({ viewport: { width: 1366, height: 768 } });
  await context.goto(`file://${file}`);
  const took = await context.evaluate(async () => {
    const canvas = document.querySelector('.explore canvas'), took = [];
    canvas.focus();
    for (let step = 0; step < 300; step++) {
      const deltaY = step % 100 < 50 ? -60 : 60, { left, top } = canvas.getBoundingClientRect();
      canvas.dispatchEvent(new WheelEvent('wheel', { deltaY, clientX: left + 600, clientY: top + 200, cancelable: true }));
      took.push(await new Promise(done => requestAnimationFrame(began => {
        canvas.getBoundingClientRect();
        done(performance.now() - began);
      })));
    }
    return took;
  });
  spread('a frame of the timeline with 100,000 bars', took);
  await chromium.close();
}

const measurements = { latency, reaction, processor, viewers, memory, timeline };
const [steward, ...wanted] = process.argv.slice(2);
for (const name of wanted.length ? wanted : Object.keys(measurements)) await measurements[name](steward);
