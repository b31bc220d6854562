#!/usr/bin/env python3
"""How fast bags are judged, by us, Python's readers and reelay in one sitting: `speed.py CHECK_BAG FOLDER [GIGABYTES]`.

Needs `pip install rosbags mcap mcap-ros2-support reelay`, GNU time, room in FOLDER for the bags, and a release build:
`cargo build --release -p steward -p bags --example check_bag`.
"""
import os, resource, subprocess, sys, time
from pathlib import Path

import reelay
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer as Mcap
from mcap_ros2.decoder import DecoderFactory
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

CHECK_BAG, FOLDER = sys.argv[1], Path(sys.argv[2])
GIGABYTES = float(sys.argv[3]) if len(sys.argv) > 3 else 5
STORE = get_typestore(Stores.ROS2_JAZZY)
SMALL = 1_000_000
ROUNDS = 3
IMAGE = 2_000_000
TWIST, CAMERA = "geometry_msgs/msg/Twist", "sensor_msgs/msg/Image"


def write(name, images, messages, compression):
    """A folder with one MCAP file in chunks of 4 MB: images, with small messages spread evenly among them."""
    folder = FOLDER / name
    if folder.exists():
        return folder
    folder.mkdir(parents=True)
    vector = STORE.types["geometry_msgs/msg/Vector3"]
    header = STORE.types["std_msgs/msg/Header"](
        stamp=STORE.types["builtin_interfaces/msg/Time"](sec=1, nanosec=2), frame_id="camera")
    import numpy as np
    pixels = np.random.default_rng(1).integers(0, 255, IMAGE, dtype=np.uint8)
    image = bytes(STORE.serialize_cdr(STORE.types[CAMERA](
        header=header, height=1000, width=2000, encoding="mono8", is_bigendian=0, step=2000, data=pixels), CAMERA))
    with (folder / f"{name}.mcap").open("wb") as stream:
        bag = Mcap(stream, chunk_size=4_000_000, compression=compression)
        bag.start("ros2", "speed")
        channels = {}
        for kind, topic in ((TWIST, "/cmd_vel"), (CAMERA, "/camera")):
            text, _ = STORE.generate_msgdef(kind, ros_version=2)
            channels[kind] = bag.register_channel(topic, "cdr", bag.register_schema(kind, "ros2msg", text.encode()), {
                "offered_qos_profiles": ""})
        # A recorder writes messages as they come; the small ones come in bursts, so most chunks contain only images.
        every = max(messages // max(images // 100, 1), 1)
        written = 0
        for at in range(max(images, 1)):
            if images:
                bag.add_message(channels[CAMERA], at * 33_000_000, image, at * 33_000_000)
            for _ in range(every if at % 100 == 0 else 0):
                if written < messages:
                    speed = 0.5 + (written % 10) / 100
                    small = STORE.types[TWIST](linear=vector(x=speed, y=0.0, z=0.0), angular=vector(x=0.0, y=0.0, z=0.1))
                    stamp = at * 33_000_000 + written % every * (3_300_000_000 // every if images else 1_000_000)
                    bag.add_message(channels[TWIST], stamp, bytes(STORE.serialize_cdr(small, TWIST)), stamp)
                    written += 1
        bag.finish()
    size = (folder / f"{name}.mcap").stat().st_size
    (folder / "metadata.yaml").write_text(
        "rosbag2_bagfile_information:\n  version: 9\n  storage_identifier: mcap\n  duration: {nanoseconds: 1}\n"
        "  starting_time: {nanoseconds_since_epoch: 0}\n  message_count: 1\n  topics_with_message_count:\n"
        f"  - topic_metadata: {{name: /cmd_vel, type: {TWIST}, serialization_format: cdr, offered_qos_profiles: [],\n"
        f"      type_description_hash: ''}}\n    message_count: {messages}\n"
        f"  compression_format: ''\n  compression_mode: ''\n  relative_file_paths:\n    - {name}.mcap\n"
        f"  files:\n    - path: {name}.mcap\n      starting_time: {{nanoseconds_since_epoch: 0}}\n"
        "      duration: {nanoseconds: 1}\n      message_count: 1\n  custom_data: null\n  ros_distro: jazzy\n")
    print(f"{name}: {size / 1e9:.2f} GB, {images} images, {written} small messages")
    return folder


def ours(folder, name):
    mapping = FOLDER / "mapping.toml"
    mapping.write_text('[[messages]]\ntopic = "/cmd_vel"\nfrom = "controller"\nto = "base"\n'
                       'fields = { x = "linear.x", turn = "angular.z" }\n')
    scope = FOLDER / "speed.scope"
    scope.write_text("property speed := always (controller, base, m.x <= 2)\n")
    command = ["/usr/bin/time", "-f", "%M", CHECK_BAG, folder / f"{name}.mcap", mapping, scope]
    began, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert "satisfied" in done.stdout, done
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return int(done.stdout.split()[0]), used, time.perf_counter() - began, int(done.stderr.split()[-1])


def decoded_by_rosbags(folder):
    with Reader(folder) as bag:
        wanted = [connection for connection in bag.connections if connection.topic == "/cmd_vel"]
        for _, _, data in bag.messages(wanted):
            yield STORE.deserialize_cdr(data, TWIST).linear.x


def decoded_by_mcap(folder):
    with next(folder.glob("*.mcap")).open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for found in reader.iter_decoded_messages(topics=["/cmd_vel"]):
            yield found[3].linear.x


def judged_by_reelay(values):
    monitor = reelay.discrete_timed_monitor(pattern="historically{x <= 2}", semantics="boolean", condense=False)
    return sum(monitor.update({"x": value})["value"] for value in values)


def theirs(folder):
    """Python programs, each with what it does; the last one already has its messages."""
    yield "rosbags", lambda: sum(value <= 2 for value in decoded_by_rosbags(folder))
    yield "mcap-ros2-support", lambda: sum(value <= 2 for value in decoded_by_mcap(folder))
    yield "rosbags, reelay", lambda: judged_by_reelay(decoded_by_rosbags(folder))
    values = list(decoded_by_rosbags(folder))
    yield "reelay alone", lambda: judged_by_reelay(values)


def compare(folder, name):
    """Run in turn, since other programs may be running: the least processor time of each counts."""
    least = {}
    for _ in range(ROUNDS):
        count, used, _, kilobytes = ours(folder, name)
        least["ours"] = min(used, least.get("ours", used))
        for who, judge in theirs(folder):
            began = time.process_time()
            assert judge() == count, who
            used = time.process_time() - began
            least[who] = min(used, least.get(who, used))
    print(f"{name}: {count} small messages, at most {kilobytes / 1024:.0f} MiB")
    for who, used in least.items():
        print(f"  {who:<18} {used:7.3f} s of processor time {count / used:10.0f} messages/s "
              f"{used / least['ours']:6.1f} ×")


def stream(folder, name):
    """The large bag, compared with `dd`; from the disk if its cache may be emptied."""
    path = folder / f"{name}.mcap"

    def forget():
        os.sync()
        try:
            Path("/proc/sys/vm/drop_caches").write_text("3")
            return "from the disk"
        except OSError:
            return "perhaps from memory"

    where = forget()
    count, used, took, kilobytes = ours(folder, name)
    print(f"{name}: {path.stat().st_size / 1e9:.2f} GB, {where}: {took:.2f} s, {used:.2f} s of processor time, "
          f"{count} small messages, at most {kilobytes / 1024:.0f} MiB")
    where, began = forget(), time.perf_counter()
    subprocess.run(["dd", f"if={path}", "of=/dev/null", "bs=1M", "status=none"], check=True)
    print(f"  dd of the same file, {where}: {time.perf_counter() - began:.2f} s")


def main():
    for name, compression in (("small", CompressionType.NONE), ("small-zstd", CompressionType.ZSTD)):
        compare(write(name, 0, SMALL, compression), name)
    if GIGABYTES:
        images = int(GIGABYTES * 1e9 / IMAGE)
        stream(write("camera", images, 20_000, CompressionType.NONE), "camera")


main()
