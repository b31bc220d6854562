// Runs exported SCXML monitors in SCION, an ECMAScript SCXML engine, and compares where they say `violated` with what
// the Rust monitors said. See src/bin/scxml_traces.rs.
import { createRequire } from 'node:module';
import { readFileSync } from 'node:fs';
import path from 'node:path';
const require = createRequire(path.join(process.cwd(), 'index.js'));
const scxml = require('@scion-scxml/scxml');

const load = (text) => new Promise((done, failed) =>
  scxml.documentStringToModel('monitor.scxml', text, (error, model) =>
    error ? failed(error) : model.prepare((error, prepared) => (error ? failed(error) : done(prepared)))));

let runs = 0, violations = 0, wrong = 0;
for (const line of readFileSync(process.argv[2], 'utf8').trim().split('\n')) {
  const trace = JSON.parse(line);
  for (const run of trace.runs) {
    // The engine keeps the data model with the prepared document, so each run needs its own document.
    const prepared = await load(trace.scxml);
    const machine = new scxml.core.Statechart(prepared);
    const failing = () => machine.getConfiguration().some((state) => ['failure', 'Err', 'violated'].includes(state));
    machine.start();
    let violated = failing() ? 0 : -1;
    run.events.forEach(([name, data], index) => {
      if (violated >= 0) return;
      machine.gen({ name, data });
      if (failing()) violated = index;
    });
    runs += 1;
    violations += run.violated >= 0 ? 1 : 0;
    if (violated !== run.violated) {
      wrong += 1;
      console.log(`seed ${trace.seed}: the engine says ${violated}, the monitor ${run.violated}`);
    }
  }
}
console.log(`${runs} runs, ${violations} violated, ${wrong} different`);
process.exit(wrong ? 1 : 0);
