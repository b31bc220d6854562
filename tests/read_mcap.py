"""Reads MCAP recordings with other tools, message by message, and compares them with the event log and report
of the same run:

    pip install mcap mcap-ros2-support rosbags rerun-sdk && python3 tests/read_mcap.py target/release/steward
"""

import collections
import dataclasses
import json
import math
import pathlib
import subprocess
import sys
import tempfile

import numpy
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.interfaces import QosDurability, QosHistory, QosReliability
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

steward = str(pathlib.Path(sys.argv[1]).resolve())
RUNS = {
    "battery_fault": ["--set", "execution.max_time_s=25"],
    "populated": ["--set", "execution.max_time_s=12"],
    "guide/crowd": ["--set", "execution.max_time_s=60"],
    "pick": [],
}
LATCHED = ("/map", "/places", "/robot", "/tf_static", "/bodies", "/tree", "/processes", "/monitors", "/navigation",
           "/rosout")
DRAWN = {  # the types that Rerun draws, and what they become
    "sensor_msgs/msg/PointCloud2": "Points3D",
    "nav_msgs/msg/OccupancyGrid": "GridMap",
    "tf2_msgs/msg/TFMessage": "Transform3D",
    "geometry_msgs/msg/PoseStamped": "InstancePoses3D",
    "sensor_msgs/msg/Image": "Image",
    "sensor_msgs/msg/BatteryState": "Scalars",
    "rcl_interfaces/msg/Log": "TextLog",
    "std_msgs/msg/String": "TextDocument",
}


def plain(value):
    """A decoded message as dictionaries, lists and numbers, whichever library decoded it."""
    if isinstance(value, (int, float, str)):
        return value
    if dataclasses.is_dataclass(value):
        # Constants are in capitals, and the name of the type is not a field.
        names = [field.name for field in dataclasses.fields(value) if field.name[0].islower()]
        return {name: plain(getattr(value, name)) for name in names}
    if isinstance(value, numpy.ndarray):
        return value.tolist()
    if isinstance(value, (bytes, bytearray, memoryview)):
        return list(value)
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if hasattr(value, "__slots__"):
        return {name.lstrip("_"): plain(getattr(value, name)) for name in value.__slots__}
    return value


def same(a, b):
    """Equality under which NaN equals itself, and a byte its number."""
    if a == b:
        return True
    if isinstance(a, dict):
        return isinstance(b, dict) and a.keys() == b.keys() and all(same(a[key], b[key]) for key in a)
    if isinstance(a, list) and isinstance(b, list):
        return len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, list) or isinstance(b, list):
        return a == [b] or b == [a]
    return a != a and b != b


def field_values(message):
    """The values of a channel's message; a sequence has at most one."""
    values = [value for name, value in message.items() if name != "event"]
    return [item for value in values for item in (value if isinstance(value, list) else [value])]


def logged_values(line):
    """The same from a line of the event log; `none` is no value."""
    values = [value["sym"] if isinstance(value, dict) else value for value in line["message"]]
    return [value for value in values if value != "none"]


def quaternion_to_matrix(rotation):
    angle = 2 * math.atan2(rotation["z"], rotation["w"])
    return numpy.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])


def points(cloud):
    return numpy.frombuffer(bytes(cloud["data"]), numpy.float32).reshape(-1, 3)[:, :2]


def token(name):
    return "".join(letter if letter.isascii() and letter.isalnum() else "_" for letter in name)


def compare_with_log(topics, log):
    """Compares channels, ticks and the tree, message by message."""
    channels = collections.defaultdict(list)
    for line in log:
        if "message" in line:
            channels[f"/channels/{token(line['from'])}/{token(line['to'])}"].append(line)
    for name, found in topics.items():
        if name.startswith("/channels/"):
            expected = channels.pop(name, [])
            assert len(found) == len(expected), (name, len(found), len(expected))
            for (time, message), line in zip(found, expected):
                assert message["event"] == {"step": line["step"], "tick": line["tick"]}, (name, line)
                assert time / 1e9 == line["time_s"], (name, time, line)
                found_values, expected_values = field_values(message), logged_values(line)
                assert sorted(map(repr, found_values)) == sorted(map(repr, expected_values)), (name, message, line)
    assert not channels, f"no topics for {channels.keys()}"
    ticks = [(line["step"], line["tick"], line["time_s"]) for line in log if "generated" in line]
    assert [(m["step"], m["tick"], time / 1e9) for time, m in topics["/ticks"]] == ticks
    # The first message has the state before the first tick.
    states = [{node["name"]: node["message"] or None for node in m["status"]} for _, m in topics["/tree"]][1:]
    assert states == [line["tree"] for line in log if "tree" in line]


def compare_with_report(topics, report):
    """Compares what is known at the end, and how it happened."""
    final = {status["name"]: status for status in topics["/monitors"][-1][1]["status"]}
    assert {name: status["message"] for name, status in final.items()} == {
        monitor["name"]: monitor["verdict"] for monitor in report["monitors"]
    }
    for monitor in report["monitors"]:
        values = {pair["key"]: pair["value"] for pair in final[monitor["name"]]["values"]}
        assert values["property"] == monitor["property"] and values["location"] == monitor["state"]
        # The report has the tick only for violations.
        assert monitor["tick"] is None or values["tick"] == str(monitor["tick"])
    told = [(message["name"], message["msg"]) for _, message in topics["/rosout"]]
    assert told[-1] == (report["scenario"], report["ended_because"])
    for fault in report["faults"]:
        assert any(name == "fault" and text == fault["effect"] for name, text in told), fault
    said = [(said["by"], f"“{said['text']}”") for said in report["said"]]
    assert [entry for entry in told if entry[1].startswith("“")] == said
    if report["robot"] is None:
        assert "/tf" not in topics
        return
    poses = [message["transforms"][0] for _, message in topics["/tf"]]
    places = [numpy.array([pose["transform"]["translation"][axis] for axis in "xy"]) for pose in poses]
    driven = sum(numpy.linalg.norm(b - a) for a, b in zip(places, places[1:]))
    assert abs(driven - report["robot"]["distance_m"]) < 0.01, (driven, report["robot"])
    x, y, heading = report["robot"]["final_pose"]
    last = poses[-1]["transform"]["rotation"]
    angle = 2 * math.atan2(last["z"], last["w"])
    assert abs(math.remainder(angle - heading, math.tau)) < 1e-9 and tuple(places[-1]) == (x, y)
    charge = [message["percentage"] * 100 for _, message in topics["/battery_state"]]
    assert abs(charge[0] - report["battery"]["initial"]) < 0.1 and abs(charge[-1] - report["battery"]["final"]) < 1e-4


def compare_with_each_other(topics):
    """Compares scans with their points; grid, image and points of the map; markers with their points."""
    static = topics["/tf_static"][0][1]["transforms"]
    for mount in static:
        frame = mount["child_frame_id"]
        shift = numpy.array([mount["transform"]["translation"][axis] for axis in "xy"])
        turn = quaternion_to_matrix(mount["transform"]["rotation"])
        scans, clouds = topics[f"/{frame}/scan"], topics[f"/{frame}/points"]
        assert len(scans) == len(clouds) > 0
        for (_, scan), (_, cloud) in zip(scans, clouds):
            assert scan["header"]["frame_id"] == frame and scan["header"]["stamp"] == cloud["header"]["stamp"]
            ranges = numpy.array(scan["ranges"], numpy.float64)
            angles = scan["angle_min"] + scan["angle_increment"] * numpy.arange(len(ranges))
            hits = (ranges[:, None] * numpy.stack([numpy.cos(angles), numpy.sin(angles)], 1))[numpy.isfinite(ranges)]
            assert numpy.allclose(points(cloud), hits @ turn.T + shift, atol=1e-3)
    grid, image = topics["/map"][0][1], topics["/map/image"][0][1]
    info, cells = grid["info"], numpy.array(grid["data"], numpy.int8).reshape(grid["info"]["height"], -1)
    grey = numpy.array(image["data"], numpy.uint8).reshape(image["height"], image["width"], 3)[::-1, :, 0]
    assert {(0, 254), (100, 0)} <= set(zip(cells.flat, grey.flat)) <= {(0, 254), (100, 0), (-1, 205)}
    rows, columns = numpy.nonzero(cells == 100)
    origin = numpy.array([info["origin"]["position"][axis] for axis in "xy"])
    centers = origin + info["resolution"] * (numpy.stack([columns, rows], 1) + 0.5)
    assert numpy.allclose(points(topics["/map/points"][0][1]), centers, atol=1e-3)
    for name in ["/places", "/robot", "/bodies"]:
        for (_, markers), (_, cloud) in zip(topics[name], topics[f"{name}/points"], strict=True):
            corners = [[p["x"], p["y"]] for m in markers["markers"] for p in m["points"]]
            along = points(cloud)
            assert all(numpy.abs(along - corner).max(1).min() < 1e-5 for corner in corners)


def run_and_read(scenario, more, folder):
    def run(name):
        command = [steward, "run", scenario, *more, "--quiet", "--no-snapshots"]
        ran = subprocess.run([*command, "--out", folder / "out", "--record", folder / name], capture_output=True)
        assert ran.returncode < 2, ran.stderr.decode()

    run("run.mcap")
    run("run.jsonl")
    path = folder / "run.mcap"
    log = [json.loads(line) for line in (folder / "run.jsonl").read_text().splitlines()]
    report = json.loads((folder / "out" / "report.json").read_text())

    topics, types, last = collections.defaultdict(list), {}, 0
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        counts = reader.get_summary().statistics.channel_message_counts
        for schema, channel, message, decoded in reader.iter_decoded_messages():
            topics[channel.topic].append((message.log_time, plain(decoded)))
            types[channel.topic] = schema.name
            assert last <= message.log_time
            last = message.log_time
        known = {channel.topic: counts.get(id, 0) for id, channel in reader.get_summary().channels.items()}
    assert {topic: count for topic, count in known.items() if count} == {t: len(m) for t, m in topics.items()}
    total = sum(map(len, topics.values()))
    print(f"mcap, mcap-ros2-support: {total} messages on {len(known)} topics of {scenario}")

    compare_with_log(topics, log)
    compare_with_report(topics, report)
    if report["robot"] is not None:
        compare_with_each_other(topics)

    # With the definitions in the file, and with those of ROS that rosbags has.
    stores = [get_typestore(store) for store in (Stores.ROS2_HUMBLE, Stores.ROS2_JAZZY, Stores.ROS2_KILTED)]
    read, standard = collections.Counter(), 0
    with Reader(path) as reader:
        own = get_typestore(Stores.EMPTY)
        for connection in reader.connections:
            own.register(get_types_from_msg(connection.msgdef.data, connection.msgtype))
            [profile] = connection.ext.offered_qos_profiles
            assert (profile.history, profile.reliability) == (QosHistory.KEEP_LAST, QosReliability.RELIABLE)
            is_latched = profile.durability == QosDurability.TRANSIENT_LOCAL
            assert is_latched == connection.topic.startswith(LATCHED) and is_latched == (profile.depth == 1), profile
        for connection, time, raw in reader.messages():
            at, expected = topics[connection.topic][read[connection.topic]]
            read[connection.topic] += 1
            decoded = plain(own.deserialize_cdr(raw, connection.msgtype))
            assert at == time and same(decoded, expected), (connection.topic, decoded, expected)
            for store in stores:
                if connection.msgtype in store.types:
                    standard += 1
                    assert same(plain(store.deserialize_cdr(raw, connection.msgtype)), expected), connection.topic
    assert read == {topic: len(messages) for topic, messages in topics.items()}
    print(f"rosbags: the same {read.total()} messages; {standard} by the definitions of three versions of ROS 2")

    rerun = [sys.executable, "-m", "rerun"]

    def told(*arguments):
        ran = subprocess.run([*rerun, *arguments], capture_output=True, text=True)
        assert ran.returncode == 0, (arguments, ran.stdout, ran.stderr)
        return ran.stdout + ran.stderr

    told("mcap", "check", path)
    told("mcap", "convert", path, "-o", folder / "run.rrd")
    told("rrd", "verify", folder / "run.rrd")
    listed = told("rrd", "print", "-v", folder / "run.rrd")
    drawn = {topic: name for topic, name in types.items() if name in DRAWN}
    for topic, name in drawn.items():
        assert f"{topic}@{DRAWN[name]}:" in listed, (topic, name)
    print(f"rerun: checked and converted; {len(drawn)} topics are drawn")


def violations_of_a_bag(folder):
    """The violations of a recorded robot, in a file that is shown beside the bag."""
    subprocess.run([steward, "init", folder / "bag", "--template", "recording"], check=True, capture_output=True)
    arguments = ["nav2.mcap", "--property", "nav2.scope", "--map-channels", "mapping.toml", "--out", "checked"]
    subprocess.run([steward, "verify", *arguments], cwd=folder / "bag", capture_output=True)
    with open(folder / "bag/checked/violations.mcap", "rb") as file:
        logs = [message for *_, message in make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages()]
    with open(folder / "bag/nav2.mcap", "rb") as file:
        start = make_reader(file).get_summary().statistics.message_start_time
    found = [(log.level, log.msg, log.stamp.sec * 10**9 + log.stamp.nanosec - start) for log in logs]
    expected = [(40, "slow_when_low violated"), (20, "slow_when_low holds again")]
    assert [(level, text) for level, text, _ in found] == expected, found
    assert abs(found[0][2] - 42.01e9) < 1e6 and abs(found[1][2] - found[0][2] - 9.99e9) < 1e6, found
    print("mcap, mcap-ros2-support: the violations of a bag, at their times")


with tempfile.TemporaryDirectory() as folder:
    violations_of_a_bag(pathlib.Path(folder))
for scenario, more in RUNS.items():
    with tempfile.TemporaryDirectory() as folder:
        run_and_read(scenario, more, pathlib.Path(folder))
