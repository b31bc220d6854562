"""Gives the cases of tests/schemas.rs to Python's jsonschema:

    STEWARD_SCHEMA_CASES=/tmp/cases.jsonl cargo test --test main schemas && python3 tests/schemas/foreign.py /tmp/cases.jsonl
"""

import json
import multiprocessing
import pathlib
import sys

import jsonschema

root = pathlib.Path(__file__).parents[2]
files = [
    "scenarios/scenario", "scenarios/campaigns/campaign", "channels/interfaces/interface", "ros/bags/mapping",
    "maps/places",
]
validators = {}
for file in files:
    schema = json.loads((root / f"{file}.schema.json").read_text())
    jsonschema.Draft202012Validator.check_schema(schema)
    validators[schema["title"]] = jsonschema.Draft202012Validator(schema)


def judge(line):
    case = json.loads(line)
    valid = validators[case["schema"]].is_valid(case["value"])
    assert valid == case["valid"], case
    return valid


count = {True: 0, False: 0}
with multiprocessing.get_context("fork").Pool() as pool:
    for valid in pool.imap_unordered(judge, open(sys.argv[1]), chunksize=500):
        count[valid] += 1
print(f"{count[True]} valid and {count[False]} invalid files, for both")
