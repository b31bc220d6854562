"""Runs the cases of `src/bin/reelay_cases.rs` in reelay: `python3 reelay_cases.py cases.jsonl`.

Exits with 1 at the first pattern that does not fail first where it should.
"""

import json
import sys

import reelay

agreed = 0
for line in open(sys.argv[1], encoding="utf-8"):
    case = json.loads(line)
    monitor = reelay.discrete_timed_monitor(pattern=case["pattern"], semantics="boolean", condense=False)
    values = [monitor.update(dict(zip("pqr", step)))["value"] for step in case["run"]]
    fails = values.index(False) if False in values else None
    if fails != case["fails"]:
        sys.exit(f"reelay fails at {fails}, the monitor at {case['fails']}: {line}")
    agreed += 1
print(f"reelay agrees on {agreed} runs")
