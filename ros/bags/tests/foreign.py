#!/usr/bin/env python3
"""Bags that `rosbags` writes (pip install rosbags), read by us: `foreign.py PRINT_MESSAGES [MESSAGES [SEED]]`.

Every message type of two distributions, with random values, in MCAP and (if the program reads it) SQLite, in all
compressions, both byte orders, split, with definitions as `.msg` and as IDL, and without any, in a folder or on board:
each message has to be decoded equal in every field. Then files that are cut off, empty, without an index or with wrong definitions: nothing
may panic, and everything before the damage has to be there.
"""
import json, math, shutil, struct, subprocess, sys, tempfile
from pathlib import Path

import numpy as np
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

sys.path.insert(0, str(Path(__file__).parents[2] / "messages/tests"))
from random_messages import ARRAY, ONE, SEQUENCE, definitions, dice, message

PRINT = sys.argv[1]
MESSAGES = int(sys.argv[2]) if len(sys.argv) > 2 else 1000
CUTS = 200
dice.seed(int(sys.argv[3]) if len(sys.argv) > 3 else 17)


def plain(store, thing):
    """The JSON that we must give for it."""
    if isinstance(thing, (bool, np.bool_)):
        return bool(thing)
    if isinstance(thing, (float, np.floating)):
        thing = float(thing)
        return thing if math.isfinite(thing) else {math.inf: "inf", -math.inf: "-inf"}.get(thing, "NaN")
    if isinstance(thing, (int, np.integer)):
        return int(thing)
    if isinstance(thing, str):
        return thing
    if isinstance(thing, (list, np.ndarray)):
        return [plain(store, item) for item in thing]
    return {name: plain(store, getattr(thing, name)) for name, _ in store.fielddefs[thing.__msgtype__][1]}


def same(ours, theirs):
    if isinstance(theirs, float):
        return isinstance(ours, (int, float)) and struct.pack("<d", ours) == struct.pack("<d", theirs)
    if isinstance(theirs, list):
        return isinstance(ours, list) and len(ours) == len(theirs) and all(map(same, ours, theirs))
    if isinstance(theirs, dict):
        # In IDL, a struct without members has this one.
        [thing.pop("structure_needs_at_least_one_member", None) for thing in (ours, theirs)]
        return ours.keys() == theirs.keys() and all(same(ours[name], theirs[name]) for name in theirs)
    return type(ours) is type(theirs) and ours == theirs


IDL = {"bool": "boolean", "byte": "octet", "float32": "float", "float64": "double"}


def idl(store, name, done):
    """The type and all types in it, as rosidl_adapter writes them."""
    if name in done:
        return ""
    done.add(name)
    package, _, own = name.split("/")
    below, typedefs, fields = "", "", ""

    def of(desc):
        nonlocal below
        if int(desc[0]) == ONE:
            base, bound = desc[1]
            return IDL.get(base, base) + (f"<{bound}>" if bound else "")
        below += idl(store, desc[1], done)
        return desc[1].replace("/", "::")

    for field, desc in store.fielddefs[name][1]:
        if int(desc[0]) == ARRAY:
            inner, size = of(desc[1][0]), desc[1][1]
            alias = f"{inner.replace('::', '__')}__{size}"
            typedefs += f"    typedef {inner} {alias}[{size}];\n"
            kind = alias
        elif int(desc[0]) == SEQUENCE:
            bound = f", {desc[1][1]}" if desc[1][1] else ""
            kind = f"sequence<{of(desc[1][0])}{bound}>"
        else:
            kind = of(desc)
        fields += f"      @verbatim (language=\"comment\", text=\"a ({field}\" \"\\n\")\n      {kind} {field};\n"
    text = f"module {package} {{\n  module msg {{\n{typedefs}    struct {own} {{\n{fields}    }};\n  }};\n}};\n"
    return f"{'=' * 80}\nIDL: {name}\n// generated\n#include \"x.idl\"\n{text}" + below


def write(path, store, names, count, plugin, mode=CompressionMode.NONE, language="msg", little=True):
    """Writes random messages; returns the JSON that we must give for them."""
    written, connections = [], {}
    bag = Writer(path, version=9, storage_plugin=plugin)
    bag.set_compression(mode, CompressionFormat.ZSTD)
    with bag:
        for at in range(count):
            name = names[at % len(names)]
            if name not in connections:
                definition = {"typestore": store}
                if language != "msg":
                    text = idl(store, name, set()) if language == "idl" else ""
                    definition = {"msgdef": text, "rihs01": store.hash_rihs01(name)}
                connections[name] = bag.add_connection(f"/{name}", name, **definition)
            made = message(store, name)
            written.append({"topic": f"/{name}", "type": name, "log_ns": 1_000_000_000 + at, "message": plain(store, made)})
            bag.write(connections[name], 1_000_000_000 + at, store.serialize_cdr(made, name, little_endian=little))
    return written


def read(bag, *folders):
    done = subprocess.run([PRINT, bag, *folders], capture_output=True, text=True)
    assert done.returncode in (0, 1) and "panicked" not in done.stderr, done.stderr
    return [json.loads(line) for line in done.stdout.splitlines()], done.stderr


def compare(what, ours, theirs):
    wrong = [(a, b) for a, b in zip(ours, theirs) if not same(a, b)]
    assert len(ours) == len(theirs) and not wrong, f"{what}: {len(ours)} of {len(theirs)}, {wrong[:1]}"
    print(f"{what}: {len(theirs)} messages are equal")


def cut(what, bag, theirs, folder):
    """Truncates a file anywhere: everything before that is read, and the loss is reported."""
    whole = bag.read_bytes()
    most = 0
    for at in [0, 1, 7, 8, len(whole) - 1] + [dice.randrange(len(whole)) for _ in range(CUTS - 5)]:
        short = folder / f"cut{bag.suffix}"
        short.write_bytes(whole[:at])
        ours, said = read(short)
        assert all(map(same, ours, theirs)), f"{what}, cut off at byte {at}"
        assert said.strip() or len(ours) == len(theirs), f"{what}, cut off at byte {at}: the loss is not reported"
        most = max(most, len(ours))
    assert most, f"{what}: nothing is read, wherever it is cut off"
    print(f"{what}: cut off {CUTS} times, up to {most} of {len(theirs)} messages")


def main():
    folder = Path(tempfile.mkdtemp(prefix="bags-"))
    has_sqlite = "NoSqlite" not in subprocess.run(
        [PRINT, folder_with_db3(folder)], capture_output=True, text=True).stderr
    plugins = [StoragePlugin.MCAP] + [StoragePlugin.SQLITE3] * has_sqlite
    for distribution in (Stores.ROS2_HUMBLE, Stores.ROS2_JAZZY):
        store = get_typestore(distribution)
        names = sorted(store.fielddefs)
        for plugin in plugins:
            what = f"{distribution.name} {plugin.name}: {len(names)} types"
            path = folder / f"{distribution.name}-{plugin.name}"
            theirs = write(path, store, names, max(MESSAGES, len(names)), plugin)
            compare(what, read(path)[0], theirs)
        if StoragePlugin.SQLITE3 in plugins:
            # `rosbags` hashes `char` as a type of its own.
            known = [name for name in names if "char" not in store.generate_msgdef(name, ros_version=2)[0]]
            path = folder / f"{distribution.name}-on-board"
            theirs = write(path, store, known, len(known), StoragePlugin.SQLITE3, language="none")
            compare(f"{distribution.name}: {len(known)} types on board, by their hashes", read(path)[0], theirs)
    small = [name for name in names if "/msg/" in name]
    for what, options in {"big-endian": {"little": False}, "IDL": {"language": "idl"}}.items():
        path = folder / what
        theirs = write(path, store, small, max(MESSAGES // 4, len(small)), StoragePlugin.MCAP, **options)
        compare(what, read(path)[0], theirs)
    for mode in (CompressionMode.MESSAGE, CompressionMode.STORAGE):
        path = folder / f"mode-{mode.name}"
        theirs = write(path, store, small, len(small), StoragePlugin.MCAP, mode)
        compare(f"compressed by {mode.name}", read(path)[0], theirs)
    path = folder / "undefined"
    theirs = write(path, store, small, len(small), StoragePlugin.MCAP, language="none")
    definitions(store, folder / "share")
    compare("definitions in a folder", read(path, folder / "share")[0], theirs)
    print(f"foreign writers: all equal ({folder})")
    damage(folder, store, plugins)
    shutil.rmtree(folder)


def folder_with_db3(folder):
    path = folder / "probe.db3"
    path.write_bytes(b"SQLite format 3\0" + bytes(84))
    return path


def damage(folder, store, plugins):
    names = ["geometry_msgs/msg/Twist", "std_msgs/msg/String", "sensor_msgs/msg/BatteryState"]
    for plugin in plugins:
        path = folder / f"damaged-{plugin.name}"
        theirs = write(path, store, names, 600, plugin)
        [bag] = [file for file in path.iterdir() if file.suffix in (".mcap", ".db3")]
        cut(f"{plugin.name}", bag, theirs, folder)
    path = folder / "packed"
    theirs = write(path, store, names, 600, StoragePlugin.MCAP, CompressionMode.STORAGE)
    cut("MCAP with Zstandard", next(path.glob("*.mcap")), theirs, folder)
    # A split bag, one part of which is missing.
    split, parts = folder / "split", []
    split.mkdir()
    for part in range(3):
        parts += write(folder / f"part{part}", store, names, 30, StoragePlugin.MCAP)
        shutil.copy(next((folder / f"part{part}").glob("*.mcap")), split / f"split_{part}.mcap")
    files = "".join(f"  - split_{part}.mcap\n" for part in range(4))
    (split / "metadata.yaml").write_text(f"rosbag2_bagfile_information:\n  relative_file_paths:\n{files}")
    ours, said = read(split)
    compare("split", ours, parts)
    assert "split_3.mcap is missing" in said, said
    # Without an index, and with definitions that do not match the messages.
    from mcap.writer import CompressionType, IndexType, Writer as Mcap
    for compression in CompressionType:
        path = folder / f"unindexed-{compression.name}.mcap"
        with path.open("wb") as stream:
            bag = Mcap(stream, chunk_size=2000, compression=compression, index_types=IndexType.NONE,
                       use_statistics=False, use_summary_offsets=False, repeat_channels=False, repeat_schemas=False)
            bag.start("ros2", "test")
            text, _ = store.generate_msgdef(names[0], ros_version=2)
            schema = bag.register_schema(names[0], "ros2msg", text.encode())
            wrong = bag.register_schema(names[1], "ros2msg", b"float64[10] x\n")
            channel, other = bag.register_channel("/a", "cdr", schema), bag.register_channel("/b", "cdr", wrong)
            theirs = []
            for at in range(100):
                made = message(store, names[0])
                theirs.append({"topic": "/a", "type": names[0], "log_ns": at, "message": plain(store, made)})
                bag.add_message(channel, at, bytes(store.serialize_cdr(made, names[0])), at)
                bag.add_message(other, at, bytes(store.serialize_cdr(message(store, names[1]), names[1])), at)
            bag.finish()
        ours = read(path)[0]
        mismatches = [line for line in ours if "mismatch" in line["message"]]
        assert len(mismatches) == 100, f"{len(mismatches)} of 100 messages do not fit"
        compare(f"no index, {compression.name}", [line for line in ours if line["topic"] == "/a"], theirs)
    print("damage: nothing panics, and everything before it is read")


main()
