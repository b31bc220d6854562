// A connection to the server, byte by byte.

import { randomBytes } from 'node:crypto';
import { connect } from 'node:net';
import { PATIENCE_MS } from './cockpit.mjs';

// The headers of a WebSocket request besides host and origin.
export const upgrade = [
  'Connection: Upgrade',
  'Upgrade: websocket',
  'Sec-WebSocket-Version: 13',
  'Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==',
];

// A connection, and everything received over it.
export class Line {
  static open(port) {
    return new Promise((done, fail) => {
      const line = new Line();
      line.heard = Buffer.alloc(0);
      line.socket = connect(port, '127.0.0.1');
      line.closed = new Promise(closed => line.socket.once('close', closed));
      line.socket.on('data', data => { line.heard = Buffer.concat([line.heard, data]); });
      line.socket.once('connect', () => done(line));
      line.socket.on('error', fail);
      line.socket.setTimeout(PATIENCE_MS, () => line.socket.destroy(new Error('no answer')));
    });
  }

  // Waits until this has been received.
  async hear(words) {
    while (!this.heard.includes(words) && !this.socket.destroyed) {
      await Promise.race([this.closed, new Promise(done => this.socket.once('data', done))]);
    }
    return this.heard.includes(words);
  }

  // Asks for a page or a WebSocket; returns the status of the answer.
  async ask(path, headers) {
    this.socket.write(`GET ${path} HTTP/1.1\r\n${headers.map(header => `${header}\r\n`).join('')}\r\n`);
    await this.hear('\r\n\r\n');
    return Number(this.heard.toString('latin1').split(' ')[1]);
  }
}

// A WebSocket frame as in RFC 6455; `first` is its first byte.
export function frame(first, content, masked = true) {
  const length = content.length < 126 ? [content.length]
    : content.length < 65536 ? [126, content.length >> 8, content.length & 255]
      : [127, 0, 0, 0, 0, ...[24, 16, 8, 0].map(bits => content.length >>> bits & 255)];
  if (masked) length[0] |= 128;
  const mask = randomBytes(4);
  const body = masked ? Buffer.concat([mask, content.map((byte, i) => byte ^ mask[i % 4])]) : content;
  return Buffer.concat([Buffer.from([first, ...length]), body]);
}
