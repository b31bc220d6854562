// The socket to the run: receives frames, and sends requests, each with an answer.

import { notice, retract } from './dom.js';

// The token, and which of several runs this page shows.
const access = new URLSearchParams(location.search);

export class Link {
  // `take` is called with every frame.
  constructor(take) {
    this.take = take;
    this.waiting = [];
    this.connect();
  }

  connect() {
    const address = new URL('/socket', location.href);
    address.protocol = 'ws:';
    address.search = access;
    this.socket = new WebSocket(address);
    this.socket.onmessage = ({ data }) => this.hear(JSON.parse(data));
    this.socket.onopen = () => notice('');
    this.socket.onclose = () => {
      this.waiting = [];
      notice('Lost the connection to the run. Is `steward live` still running?', true);
      setTimeout(() => this.connect(), 1000);
    };
  }

  // Call it when there will be no more frames.
  end() {
    this.socket.onclose = null;
  }

  hear(frame) {
    if ('answer' in frame || 'refused' in frame) {
      const answered = this.waiting.shift();
      const refused = frame.refused ?? frame.answer?.refused;
      retract(this.refusal);
      this.refusal = refused && `Not done: ${refused}`;
      if (refused) notice(this.refusal);
      answered?.(refused ? null : frame.answer ?? {});
    } else {
      this.take(frame);
    }
  }

  // The answer to a request; null if it was refused.
  ask(what, details = {}) {
    if (this.socket.readyState !== WebSocket.OPEN) return Promise.resolve(null);
    this.socket.send(JSON.stringify({ do: what, ...details }));
    return new Promise(answered => this.waiting.push(answered));
  }

  // Performs an act now; `name` identifies it for `release`.
  act(kind, parameters, name = '') {
    return this.ask('act', { fault: { kind, ...parameters }, name });
  }
}
