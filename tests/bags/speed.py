#!/usr/bin/env python3
"""How fast bags are read, ours and Python's readers in one sitting: `speed.py CHECK_BAG FOLDER [GIGABYTES]`.

Needs `pip install rosbags mcap mcap-ros2-support`, GNU time, room in FOLDER for the bags, and a release build:
`cargo build --release -p bags --example check_bag`.
"""
import re, subprocess, sys, time
from pathlib import Path

from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer as Mcap
from mcap_ros2.decoder import DecoderFactory
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

CHECK_BAG, FOLDER = sys.argv[1], Path(sys.argv[2])
GIGABYTES = float(sys.argv[3]) if len(sys.argv) > 3 else 5
STORE = get_typestore(Stores.ROS2_JAZZY)
SMALL = 300_000
IMAGE = 2_000_000
TWIST, CAMERA = "geometry_msgs/msg/Twist", "sensor_msgs/msg/Image"


def write(name, images, messages, compression):
    """A folder with one MCAP file in chunks of 4 MB: images, and small messages evenly between them."""
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
        # A recorder writes what comes; the small ones come in bursts, so most chunks have images alone.
        every = max(messages // max(images // 100, 1), 1)
        written = 0
        for at in range(max(images, 1)):
            if images:
                bag.add_message(channels[CAMERA], at * 33_000_000, image, at * 33_000_000)
            for _ in range(every if at % 100 == 0 else 0):
                if written < messages:
                    speed = 0.5 + (written % 10) / 100
                    small = STORE.types[TWIST](linear=vector(x=speed, y=0.0, z=0.0), angular=vector(x=0.0, y=0.0, z=0.1))
                    stamp = at * 33_000_000 + written % every * (3_300_000_000 // every)
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
    began = time.perf_counter()
    command = ["/usr/bin/time", "-v", CHECK_BAG, folder / f"{name}.mcap", mapping, scope]
    done = subprocess.run(command, capture_output=True, text=True)
    took = time.perf_counter() - began
    assert done.returncode == 0, done.stderr
    count = int(done.stdout.split()[0])
    kilobytes = int(re.search(r"Maximum resident set size \(kbytes\): (\d+)", done.stderr).group(1))
    print(f"  ours                {took:8.2f} s  {count / took:12.0f} messages/s  at most {kilobytes / 1024:.0f} MiB")
    return count / took


def python(folder, name):
    def with_rosbags():
        with Reader(folder) as bag:
            wanted = [connection for connection in bag.connections if connection.topic == "/cmd_vel"]
            return sum(STORE.deserialize_cdr(data, TWIST).linear.x <= 2 for _, _, data in bag.messages(wanted))

    def with_mcap():
        with (folder / f"{name}.mcap").open("rb") as stream:
            reader = make_reader(stream, decoder_factories=[DecoderFactory()])
            return sum(found[3].linear.x <= 2 for found in reader.iter_decoded_messages(topics=["/cmd_vel"]))

    rates = []
    for reader, read in (("rosbags", with_rosbags), ("mcap-ros2-support", with_mcap)):
        began = time.perf_counter()
        count = read()
        took = time.perf_counter() - began
        rates.append(count / took)
        print(f"  {reader:<18}  {took:8.2f} s  {count / took:12.0f} messages/s")
    return max(rates)


def main():
    for name, compression in (("small", CompressionType.NONE), ("small-zstd", CompressionType.ZSTD)):
        folder = write(name, 0, SMALL, compression)
        print(f"{name}: {SMALL} small messages")
        print(f"  {ours(folder, name) / python(folder, name):.0f} times the faster of Python's readers")
    images = int(GIGABYTES * 1e9 / IMAGE)
    folder = write("camera", images, 20_000, CompressionType.NONE)
    print(f"camera: {GIGABYTES:g} GB of images, 20000 small messages")
    ours(folder, "camera")


main()
