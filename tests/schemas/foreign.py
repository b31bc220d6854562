"""Gives the cases of tests/schemas.rs to jsonschema-rs:

    STEWARD_SCHEMA_CASES=/tmp/cases.jsonl cargo test --test main schemas && python3 tests/schemas/foreign.py /tmp/cases.jsonl
"""

import json
import pathlib
import sys

import jsonschema_rs

root = pathlib.Path(__file__).parents[2]
files = [
    "scenarios/scenario", "scenarios/campaigns/campaign", "components/interfaces/interface", "ros/bags/mapping",
    "maps/places",
]
validators = {}
for file in files:
    schema = json.loads((root / f"{file}.schema.json").read_text())
    jsonschema_rs.meta.validate(schema)
    validators[schema["title"]] = jsonschema_rs.Draft202012Validator(schema)

count = {True: 0, False: 0}
for line in open(sys.argv[1]):
    case = json.loads(line)
    valid = validators[case["schema"]].is_valid(case["value"])
    assert valid == case["valid"], case
    count[valid] += 1
print(f"{count[True]} valid and {count[False]} invalid files, for both")
