#!/usr/bin/env python3
"""Messages and type hashes of `rosbags` (pip install rosbags), against ours: `foreign.py TRANSCODE [MESSAGES [SEED]]`.

Random messages of every type, in both byte orders, are decoded and encoded again by us: the bytes have to be those that
`rosbags` writes, little-endian, and the type hashes have to be equal. The definitions are in folders, for three
distributions, or on board, for all of them.
"""
import re, subprocess, sys, tempfile
from collections import Counter
from pathlib import Path

from rosbags.typesys import Stores, get_typestore

from random_messages import definitions, dice, message

TRANSCODE = sys.argv[1]
MESSAGES = int(sys.argv[2]) if len(sys.argv) > 2 else 10
dice.seed(int(sys.argv[3]) if len(sys.argv) > 3 else 17)


def has_char(store, name):
    """`rosbags` hashes `char` as a type of its own; ROS 2 itself as `uint8`, as our tests with its own hashes show."""
    def is_char(desc):
        kind, what = int(desc[0]), desc[1]
        return what[0] == "char" if kind == 1 else has_char(store, what) if kind == 2 else is_char(what[0])
    return any(is_char(desc) for _, desc in store.fielddefs[name][1])


def on_board():
    """The definitions on board by name, each with its constants in the newest edition: type, name and value."""
    text = (Path(__file__).parents[1] / "src/on_board.txt").read_text().replace("\n    ", " ")
    lines = [line.split(":", 1) for line in text.splitlines()]
    return {name.split("@")[0]: re.findall(r"(\w+) (\w+)=(-?\d+)", fields) for name, fields in lines}


def compare(distribution, names, source):
    """The definitions are in the folder `source`, or on board if it is `@EDITION`."""
    store = get_typestore(distribution)
    lines, expected = [], []
    for name in names:
        for at in range(MESSAGES):
            made = message(store, name)
            sent = store.serialize_cdr(made, name, little_endian=at % 2 == 0)
            lines.append(f"{name} {bytes(sent).hex()}")
            expected.append((name, bytes(store.serialize_cdr(made, name)).hex()))
    done = subprocess.run([TRANSCODE, source], input="\n".join(lines), capture_output=True, text=True, check=True)
    found = [line.split(" ") for line in done.stdout.splitlines()]
    assert len(found) == len(expected), f"{len(found)} of {len(expected)} messages"
    for (hash, again), (name, sent) in zip(found, expected):
        assert again == sent, f"{name}: {again}, but rosbags writes {sent}"
        assert has_char(store, name) or hash == store.hash_rihs01(name), f"{name}: {hash}"
    hashes = sum(not has_char(store, name) for name in names)
    what = "on board" if str(source).startswith("@") else "in a folder"
    print(f"{distribution.name}, {what}: {len(found)} messages of {len(names)} types are equal, and {hashes} hashes")


ours, newest = on_board(), {}
for distribution in (store for store in Stores if store.name.startswith("ROS2_")):
    store = get_typestore(distribution)
    names = sorted(name for name in store.fielddefs if "/msg/" in name)
    if distribution in (Stores.ROS2_HUMBLE, Stores.ROS2_JAZZY, Stores.ROS2_KILTED):
        with tempfile.TemporaryDirectory(prefix="messages-") as folder:
            definitions(store, Path(folder))
            compare(distribution, names, folder)
    names = [name for name in names if not name.startswith("libstatistics_collector/")]
    compare(distribution, names, f"@{distribution.name.removeprefix('ROS2_').lower()}")
    newest |= {name.replace("/msg/", "/"): store.fielddefs[name][0] for name in names}
for name, constants in newest.items():
    theirs = {(kind, constant, str(value)) for constant, kind, value in constants}
    assert theirs.issuperset(ours[name]), f"{name}: the constants are {theirs}"
rest = Counter(name.split("/")[0] for name in ours if name not in newest)
print("not compared, since rosbags lacks them:", ", ".join(f"{count} of {package}" for package, count in rest.items()))
