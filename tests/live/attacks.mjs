// What a program on this computer can send to the server. None of it disturbs the run.

import assert from 'node:assert/strict';
import { randomBytes } from 'node:crypto';
import { connect } from 'node:net';
import { Cockpit, Live } from './cockpit.mjs';
import { Line, frame, upgrade } from './line.mjs';
import { undisturbed } from './strangers.mjs';

const [FIRST_OF_MORE, TEXT, BINARY, LAST, MORE, PING] = [0x01, 0x81, 0x82, 0x80, 0x00, 0x89];
const pause = Buffer.from('{"do":"pause"}');
const long = Buffer.alloc(20_000, 'x');

// Each of these ends the connection.
const ENDING = {
  'a text that is too long': [frame(TEXT, long)],
  'a text that is too long, in pieces': [frame(FIRST_OF_MORE, long.subarray(9000)), frame(MORE, long.subarray(9000))],
  'a length that nobody would send': [Buffer.from([TEXT, 255, 0x7f, ...Array(7).fill(0xff), 0, 0, 0, 0])],
  'a frame of bytes': [frame(BINARY, pause)],
  'a frame without mask': [frame(TEXT, pause, false)],
  'an opcode that does not exist': [frame(0x83, pause)],
  'reserved bits': [frame(0xf1, pause)],
  'a continuation of nothing': [frame(LAST, pause)],
  'a second beginning': [frame(FIRST_OF_MORE, pause), frame(TEXT, pause)],
  'a ping that is too long': [frame(PING, Buffer.alloc(200))],
  'a text that is not UTF-8': [frame(TEXT, Buffer.from([0xff, 0xfe]))],
  'noise': [randomBytes(5000)],
};

export async function attacks(steward, chromium) {
  const live = await Live.start(steward, 'nominal');
  const cockpit = await Cockpit.open(chromium, live.address);
  await cockpit.speed('2×');
  const { port, host } = live;
  const [own, origin] = [`Host: ${host}`, `Origin: http://${host}`];
  const viewer = `/socket?token=${new URL(live.viewers).searchParams.get('token')}`;
  const once = async (path, headers) => {
    const line = await Line.open(port);
    const status = await line.ask(path, headers);
    line.socket.destroy();
    return status;
  };
  assert.equal(await once(viewer, [own, origin, ...upgrade]), 101);
  for (const [path, headers] of [
    [viewer, ['Host: evil.example', origin, ...upgrade]],
    [viewer, [`Host: 127.0.0.1.evil.example:${port}`, origin, ...upgrade]],
    [viewer, [own, own, origin, ...upgrade]],
    [viewer, [own, 'Origin: http://evil.example', ...upgrade]],
    [viewer, [own, `Origin: https://${host}`, ...upgrade]],
    [viewer, [own, origin, origin, ...upgrade]],
    [viewer, [own, ...upgrade]],
    ['/socket', [own, origin, ...upgrade]],
    ['/socket?token=', [own, origin, ...upgrade]],
    [`${viewer}&token=${live.token}`, [own, origin, ...upgrade]],
    ['/', [own]],
    ['/?token=0', [own]],
    ['/../main.rs', [own, 'Origin: http://evil.example']],
  ]) {
    const status = await once(path, headers);
    assert.ok(status >= 400 && status < 500, `${path} ${headers}: ${status}`);
  }

  for (const [what, frames] of Object.entries(ENDING)) {
    const line = await Line.open(port);
    assert.equal(await line.ask(viewer, [own, origin, ...upgrade]), 101);
    frames.forEach(frame => line.socket.write(frame));
    await line.closed;
    assert.ok(!line.heard.includes('"answer"'), what);
  }
  // A request in pieces counts as one, and is refused like any other from a viewer.
  const line = await Line.open(port);
  await line.ask(viewer, [own, origin, ...upgrade]);
  const pieces = [frame(FIRST_OF_MORE, pause.subarray(0, 5)), frame(PING, pause), frame(LAST, pause.subarray(5))];
  pieces.forEach(piece => line.socket.write(piece));
  assert.ok(await line.hear('another client is controlling this run'));
  line.socket.destroy();

  // Many connections begin a request without ending it, and as many do nothing; the run goes on.
  const before = cockpit.run.time;
  const crowd = Array.from({ length: 1000 }, (_, i) => {
    const socket = connect(port, '127.0.0.1', () => { if (i % 2) socket.write('GET / HTTP/1.1\r\nHost: '); });
    return socket.on('error', () => {});
  });
  await cockpit.until(run => run.time > before + 4);
  const connected = crowd.filter(({ readyState }) => readyState === 'open').length;
  // Connections that ask for nothing are eventually closed, and new ones get in.
  crowd.slice(150).forEach(socket => socket.destroy());
  assert.equal(await once(viewer, [own, origin, ...upgrade]), 101);
  crowd.forEach(socket => socket.destroy());
  await undisturbed(steward, live, cockpit);
  console.log(`${connected} of 1000 connections held at once`);
}
