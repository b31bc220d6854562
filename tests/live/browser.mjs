// Drives `steward live` in a real browser:
//
//     npm ci --prefix tests/live
//     node tests/live/browser.mjs STEWARD [--only CHECK] [--sessions N] [--seed N] [--pictures FOLDER]

import { mkdir, rm } from 'node:fs/promises';
import { parseArgs } from 'node:util';
import { attacks } from './attacks.mjs';
import { browser, folder } from './cockpit.mjs';
import { experiments } from './experiments.mjs';
import { firefox } from './firefox.mjs';
import { looks } from './looks.mjs';
import { sessions } from './sessions.mjs';
import { names, sites } from './strangers.mjs';
import { timeline } from './timeline.mjs';
import { trees } from './trees.mjs';

const checks = { experiments, firefox, looks, timeline, trees, names, sites, attacks, sessions };
const { positionals: [steward], values } = parseArgs({
  allowPositionals: true,
  options: {
    only: { type: 'string', multiple: true, default: Object.keys(checks) },
    sessions: { type: 'string', default: '3' },
    seed: { type: 'string', default: '1' },
    pictures: { type: 'string' },
  },
});
const options = { sessions: Number(values.sessions), seed: Number(values.seed), pictures: values.pictures };
if (options.pictures) await mkdir(options.pictures, { recursive: true });
const unknown = values.only.find(name => !(name in checks));
if (unknown) throw new Error(`--only ${unknown}: there are ${Object.keys(checks).join(', ')}`);
const chromium = await browser();
// Experiments mostly wait for the robot; meanwhile, the other checks run.
const lanes = [['experiments'], ['firefox'], ['looks', 'timeline', 'trees', 'names', 'sites', 'attacks', 'sessions']];
const check = async lane => {
  for (const name of lane.filter(name => values.only.includes(name))) {
    const began = Date.now();
    const reason = await checks[name](steward, chromium, options);
    const took = Math.round((Date.now() - began) / 1000);
    console.log(`${name}: ${reason ? `not run here: ${reason}` : `ok, in ${took} s`}`);
  }
};
try {
  await Promise.all(lanes.map(check));
} finally {
  await chromium.close();
  await rm(folder, { recursive: true });
}
