#!/usr/bin/env python3
"""`steward sim` beside real nodes: `sim.py STEWARD FAST CYCLONE`, with Pythons that have the packages of
`robots/driver.py`, and of `robots/listener.py`.

A node of rclpy plans on the robot's map and drives it through the house, in lock step: every time, the run is the same.
What rclpy knows of the robot is right, and so is what Cyclone DDS reads of its transforms. Whoever sends too much,
nonsense, or nothing any more does no harm. RUNS are the repetitions. All of it happens in a network of its own.
"""
import json, os, subprocess, sys, tempfile
from pathlib import Path

STEWARD, FAST, CYCLONE = (os.path.abspath(path) for path in sys.argv[1:4])
NETWORK = "ip link set lo up && ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo && exec \"$@\""
if "IN_A_NETWORK" not in os.environ:
    words = [sys.executable, os.path.abspath(sys.argv[0]), STEWARD, FAST, CYCLONE]
    os.execvpe("unshare", ["unshare", "-rn", "sh", "-c", NETWORK, "sh", *words], {**os.environ, "IN_A_NETWORK": "1"})

ROBOTS = Path(__file__).parent / "robots"
FOLDER = Path(tempfile.mkdtemp())
DESTINATION = (-11.7, 14.2)


def start(python, file, *args):
    env = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    pipe = subprocess.PIPE
    process = subprocess.Popen([python, ROBOTS / file, *map(str, args)], stdout=pipe, stdin=pipe, text=True, env=env)
    assert json.loads(process.stdout.readline()) == {"up": True}
    return process


def end(process):
    return json.loads(process.communicate(timeout=60)[0].splitlines()[-1])


def sim(*options):
    words = [STEWARD, "sim", "nominal", "--set", "expect={}", "--no-snapshots", "--json", "--out", FOLDER / "out"]
    return subprocess.Popen([*words, *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def report(process):
    out, errors = process.communicate(timeout=120)
    assert process.returncode == 0, errors
    return json.loads(out), errors


def ask(process, what):
    process.stdin.write(what + "\n")
    process.stdin.flush()
    return json.loads(process.stdout.readline())


visitor = start(FAST, "visitor.py")
robot = sim("--set", "execution.max_time_s=35")
known = ask(visitor, "knows")
transforms = end(start(CYCLONE, "listener.py"))
driven = ask(visitor, "drives")
flooded = ask(visitor, "floods")
babbled = ask(visitor, "babbles")
visitor.kill()
of, errors = report(robot)
assert known["nodes"] == ["steward"] and known["listeners"] == 1, known
kinds = {"/clock": "rosgraph_msgs/msg/Clock", "/tf": "tf2_msgs/msg/TFMessage", "/tf_static": "tf2_msgs/msg/TFMessage",
         "/odom": "nav_msgs/msg/Odometry", "/scan": "sensor_msgs/msg/LaserScan", "/map": "nav_msgs/msg/OccupancyGrid",
         "/battery_state": "sensor_msgs/msg/BatteryState", "/contacts": "ros_gz_interfaces/msg/Contacts"}
durable = lambda topic: "TRANSIENT_LOCAL" if topic in ("/map", "/tf_static") else "VOLATILE"
assert known["offers"] == {topic: ["steward", kind, "RELIABLE", durable(topic)] for topic, kind in kinds.items()}, known
assert known["map"][:2] == [600, 480] and known["map"][2] > 1000 and known["map"][3] == "map", known
assert known["scans"] == [["laser_back", "laser_front"], 360, 10.0], known
assert known["odom"] == ["odom", "base_footprint", [0.02]] and 0.3 < known["battery"] < 0.32, known
assert transforms.keys() == {"odom base_footprint", "base_footprint base_link", "base_link laser_front",
                             "base_link laser_back"}, transforms
assert transforms["base_link laser_back"] == [-0.245, 0, 1, 0], transforms
print("what rclpy and Cyclone DDS know of the robot is right: its node, topics, qualities, frames, map and stamps")
assert driven["driving"] > 0.15 and abs(driven["after"]) < 0.01, driven
assert abs(babbled["speed"]) < 0.01 and of["robot"]["collisions"] == 0, (babbled, of)
for said in ("not finite", "another type", "more than one publisher", "more than to drive forwards"):
    assert said in errors, (said, errors)
assert flooded["sent"] > 10000 and of["timing"]["real_time_factor"] > 0.9, (flooded, of["timing"])
print(f"it stops when commands do, and goes on in real time through {flooded['sent']} commands in 3 s and nonsense")

runs, factors = [], []
for _ in range(int(os.environ.get("RUNS", 3))):
    driver = start(FAST, "driver.py", *DESTINATION, 8)
    of, errors = report(sim("--lock-step", "--localize"))
    runs.append((of["trace_hash"], end(driver)["sent"]))
    arrived = {place["name"]: place["reached_at_s"] for place in of["places"]}
    assert arrived["Destination"] and of["robot"]["collisions"] == 0, of
    factors.append(of["timing"]["real_time_factor"])
assert len(set(runs)) == 1 and runs[0][1] > 500, runs
print(f"{len(runs)} times, rclpy drove it to its destination with {runs[0][1]} commands, at {min(factors):.0f} to "
      f"{max(factors):.0f} times real time: one trace, {runs[0][0]}")
