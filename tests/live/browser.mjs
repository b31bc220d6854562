// Drives `steward live` in a real browser:
//
//     npm ci --prefix tests/live
//     node tests/live/browser.mjs STEWARD [--only CHECK] [--sessions N] [--seed N] [--pictures FOLDER]

import { mkdir, rm } from 'node:fs/promises';
import { parseArgs } from 'node:util';
import { attacks } from './attacks.mjs';
import { browser, folder } from './cockpit.mjs';
import { experiments } from './experiments.mjs';
import { looks } from './looks.mjs';
import { sessions } from './sessions.mjs';
import { names, sites } from './strangers.mjs';

const checks = { experiments, looks, names, sites, attacks, sessions };
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
const chromium = await browser();
try {
  for (const name of values.only) {
    const began = Date.now();
    await checks[name](steward, chromium, options);
    console.log(`${name}: well, in ${Math.round((Date.now() - began) / 1000)} s`);
  }
} finally {
  await chromium.close();
  await rm(folder, { recursive: true });
}
