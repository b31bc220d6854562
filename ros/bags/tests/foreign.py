#!/usr/bin/env python3
"""Bags that `rosbags` writes (pip install rosbags), read by us: `foreign.py PRINT_MESSAGES STEWARD [MESSAGES [SEED]]`.

Every message type of two distributions, with random values, in MCAP and (if the program reads it) SQLite, in all
compressions, both byte orders, split, with definitions as `.msg` and as IDL, and without any, in a folder or on board:
each message has to be decoded equal in every field. Then files that are cut off, empty, without an index or with wrong definitions: nothing
may panic, and everything before the damage has to be there. Last, trees that Nav2 ran, with messages lost: STEWARD has to
give the verdicts of a naive judge, or say that it is unsure.
"""
import json, math, shutil, struct, subprocess, sys, tempfile
from pathlib import Path

import numpy as np
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

sys.path.insert(0, str(Path(__file__).parents[2] / "messages/tests"))
from random_messages import ARRAY, ONE, SEQUENCE, definitions, dice, message

PRINT, STEWARD = sys.argv[1:3]
MESSAGES = int(sys.argv[3]) if len(sys.argv) > 3 else 1000
CUTS, TREES = 200, 24
dice.seed(int(sys.argv[4]) if len(sys.argv) > 4 else 17)


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
    trees(folder, plugins)
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
    (split / "metadata.yaml").write_text(f"rosbag2_bagfile_information:\n  relative_file_paths:\n{files}  compression_mode: ''\n")
    ours, said = read(split)
    # The parts overlap: their messages come in the order of their times, those of one time in the order of the parts.
    parts.sort(key=lambda message: message["log_ns"])
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


TREE = """<root BTCPP_format="4" main_tree_to_execute="Main">
  <BehaviorTree ID="Main"><Fallback name="Navigate"><Sequence name="Go">
    <ComputePathToPose name="Plan" goal="{goal}" path="{path}"/><SubTree ID="Drive" _autoremap="true"/>
  </Sequence><Spin spin_dist="1.57"/></Fallback></BehaviorTree>
  <BehaviorTree ID="Drive"><FollowPath name="Follow" path="{path}"/></BehaviorTree>
</root>
"""
# By their numbers, from 1.
NODES = ["Navigate", "Go", "Plan", "Drive", "Follow", "Spin"]
STATUSES = {"IDLE": "idle", "RUNNING": "running", "SUCCESS": "success", "FAILURE": "failure"}
BEHAVIOR_TREE_LOG = "nav2_msgs/msg/BehaviorTreeLog"


def nav2(distribution):
    """The types of a distribution, with those of Nav2 that rosbags does not have."""
    store = get_typestore(distribution)
    change, time = "nav2_msgs/msg/BehaviorTreeStatusChange", "builtin_interfaces/Time timestamp\n"
    uid = "uint16 uid\n" if distribution == Stores.ROS2_JAZZY else ""
    text = f"{time}string node_name\n{uid}string previous_status\nstring current_status\n"
    store.register(get_types_from_msg(text, change))
    store.register(get_types_from_msg(f"{time}BehaviorTreeStatusChange[] event_log\n", BEHAVIOR_TREE_LOG))
    return store


def run(store, ahead_s):
    """What Nav2 publishes of a tree that does what it likes: times, and messages. Stamps of changes are `ahead_s` ahead."""
    time, change = (store.types[f"{name}"] for name in ("builtin_interfaces/msg/Time", "nav2_msgs/msg/BehaviorTreeStatusChange"))
    statuses, changes, published, at_s = dict.fromkeys(NODES, "IDLE"), [], [], 1000.0

    def stamp(at_s):
        return time(sec=int(at_s), nanosec=int(at_s % 1 * 1e9))

    def become(node, status):
        uid = {"uid": NODES.index(node) + 1} if "uid" in [name for name, _ in store.fielddefs[change.__msgtype__][1]] else {}
        if statuses[node] != status:
            changes.append(change(timestamp=stamp(at_s + ahead_s), node_name=node, previous_status=statuses[node],
                                  current_status=status, **uid))
        statuses[node] = status

    for _ in range(dice.randrange(1, 5)):
        become("Navigate", "RUNNING")
        for _ in range(dice.randrange(1, 12)):
            for node in NODES[1:]:
                if dice.random() < 0.3:
                    become(node, dice.choice(list(STATUSES)))
            if changes:
                published.append((at_s, store.types[BEHAVIOR_TREE_LOG](timestamp=stamp(at_s), event_log=list(changes))))
            changes.clear()
            at_s += dice.choice([0.01, 0.25, 3.0])
        become("Navigate", dice.choice(["SUCCESS", "FAILURE"]))
        for node in NODES:
            become(node, "IDLE")
        at_s += 10.0
    return published


def judge(published):
    """The verdicts on the nodes, and whether the messages show that some are missing."""
    changes = [change for _, message in published for change in message.event_log]
    told = {(change.node_name, change.current_status) for change in changes}
    known, is_broken = {}, False
    for change in changes:
        is_broken |= known.get(change.node_name, change.previous_status) != change.previous_status
        known[change.node_name] = change.current_status
    verdicts = {f"{node}_never_fails": "violated" if (node, "FAILURE") in told else "satisfied" for node in NODES}
    return verdicts | {f"{node}_succeeds": "satisfied" if (node, "SUCCESS") in told else "inconclusive" for node in NODES}, is_broken


def verdicts(*args):
    done = subprocess.run([STEWARD, "verify", *args, "--json"], capture_output=True, text=True)
    # Of a tree in which nothing happened, there is no verdict.
    nothing = '"verdict": "no verdict"' in done.stdout
    assert done.returncode == 2 if nothing else done.returncode in (0, 1), done.stderr
    return {monitor["name"]: monitor["verdict"] for monitor in json.loads(done.stdout)["monitors"]}, done.stderr


def trees(folder, plugins):
    """Nav2's topic, as a log of its tree and with a mapping."""
    def scope(of):
        always = "".join(f"property {node}_never_fails := always not ({of(node, 'failure')})\n" for node in NODES)
        return always + "".join(f"property {node}_succeeds := eventually ({of(node, 'success')})\n" for node in NODES)
    (folder / "tree.xml").write_text(TREE)
    (folder / "nodes.scope").write_text(scope(lambda node, reply: f"{node}, BT, reply = <{reply}>"))
    (folder / "items.scope").write_text(scope(lambda node, reply: f"tree, monitor, node = \"{node}\" and status = <{reply}>"))
    symbols = ", ".join(f'{name} = "{symbol}"' for name, symbol in STATUSES.items())
    (folder / "items.toml").write_text(
        'tick_s = 100\n[[messages]]\ntopic = "/behavior_tree_log"\nfrom = "tree"\nto = "monitor"\neach = "event_log"\n'
        f'[messages.fields]\nnode = "node_name"\nstatus = {{ path = "current_status", symbols = {{ {symbols} }} }}\n')
    counted = {"right": 0, "unsure": 0}
    for index in range(TREES):
        store = nav2(dice.choice([Stores.ROS2_HUMBLE, Stores.ROS2_JAZZY]))
        published = run(store, dice.choice([-0.001, 1_795_000_000]))
        expected, _ = judge(published)
        lost = published.copy()
        del lost[dice.randrange(len(lost))]
        for name, messages in {"whole": published, "lossy": lost}.items():
            path = folder / f"tree-{index}-{name}"
            with Writer(path, version=9, storage_plugin=dice.choice(plugins)) as bag:
                topic = bag.add_connection("/behavior_tree_log", BEHAVIOR_TREE_LOG, typestore=store)
                for at_s, message in messages:
                    bag.write(topic, int(at_s * 1e9), store.serialize_cdr(message, BEHAVIOR_TREE_LOG))
            here, is_broken = judge(messages)
            ours, said = verdicts(path, "--tree", folder / "tree.xml", "--property", folder / "nodes.scope")
            assert is_broken == ("messages are missing" in said), said
            for property, verdict in ours.items():
                if verdict == "no verdict":
                    assert set(ours.values()) == {verdict}, f"{path}, {property}: others have one"
                    continue
                # What follows from a single message does so whatever is missing.
                known = expected[property] if is_broken else here[property]
                assert verdict == known or verdict == "unsure" and is_broken, f"{path}, {property}: {verdict}, not {known}"
                counted["unsure" if verdict == "unsure" else "right"] += 1
            items, _ = verdicts(path, "--map-channels", folder / "items.toml", "--property", folder / "items.scope")
            assert items == here or set(items.values()) == {"no verdict"}, f"{path}, with a mapping"
    assert min(counted.values()) > 20, counted
    print(f"trees that Nav2 ran: {counted['right']} verdicts are right, {counted['unsure']} unsure")


main()
