#!/usr/bin/env python3
"""Messages and type hashes of `rosbags` (pip install rosbags), against ours: `foreign.py TRANSCODE [MESSAGES [SEED]]`.

Random messages of every type of three distributions, in both byte orders, are decoded and encoded again by us: the bytes
have to be those that `rosbags` writes, little-endian, and the type hashes have to be equal.
"""
import subprocess, sys, tempfile
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


def compare(distribution, folder):
    store = get_typestore(distribution)
    definitions(store, folder)
    names = sorted(name for name in store.fielddefs if "/msg/" in name)
    lines, expected = [], []
    for name in names:
        for at in range(MESSAGES):
            made = message(store, name)
            sent = store.serialize_cdr(made, name, little_endian=at % 2 == 0)
            lines.append(f"{name} {bytes(sent).hex()}")
            expected.append((name, bytes(store.serialize_cdr(made, name)).hex()))
    done = subprocess.run([TRANSCODE, folder], input="\n".join(lines), capture_output=True, text=True, check=True)
    found = [line.split(" ") for line in done.stdout.splitlines()]
    assert len(found) == len(expected), f"{len(found)} of {len(expected)} messages"
    for (hash, again), (name, sent) in zip(found, expected):
        assert again == sent, f"{name}: {again}, but rosbags writes {sent}"
        assert has_char(store, name) or hash == store.hash_rihs01(name), f"{name}: {hash}"
    with_char = sum(has_char(store, name) for name in names)
    print(f"{distribution.name}: {len(found)} messages of {len(names)} types are equal, and {len(names) - with_char} hashes")


for distribution in (Stores.ROS2_HUMBLE, Stores.ROS2_JAZZY, Stores.ROS2_KILTED):
    with tempfile.TemporaryDirectory(prefix="messages-") as folder:
        compare(distribution, Path(folder))
