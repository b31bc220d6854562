#!/usr/bin/env python3
"""Compares the cost of watching ten topics of 1 kB at 100 Hz with ten properties to Python programs that do less:
`cost.py STEWARD ROS`, with a Python that has rclpy, std_msgs and reelay, and beside it `ros2` with its command `topic`,
which needs a process for each topic. All watch the same robot, one after the other.

Prints the processor time as a share of one core, and the peak memory of the largest process. Runs in a network of its
own.
"""
import os, subprocess, sys, tempfile, time
from pathlib import Path

SECONDS = 20
ROBOT = """
import time, rclpy
from rclpy.node import Node
from std_msgs.msg import String
rclpy.init()
node = Node("load")
publishers = [node.create_publisher(String, f"/t{i}", 10) for i in range(10)]
begun, count = time.time(), 0
while True:
    for publisher in publishers:
        publisher.publish(String(data="x" * 1000))
    count += 1
    time.sleep(max(0, begun + count * 0.01 - time.time()))
"""
ECHO = """
import time, rclpy
from rclpy.node import Node
from std_msgs.msg import String
rclpy.init()
node, count = Node("echo"), 0
MONITORS
def hear(i):
    def heard(message):
        global count
        count += 1
        HEARD
    return heard
subscriptions = [node.create_subscription(String, f"/t{i}", hear(i), 10) for i in range(10)]
end = time.time() + SECONDS
while time.time() < end:
    rclpy.spin_once(node, timeout_sec=0.1)
print(count, "messages")
""".replace("SECONDS", str(SECONDS))
MONITORS = """
import reelay
begun = time.time()
rules = [reelay.dense_timed_monitor(pattern=f"historically({{t: {i}}} -> once[0:1]{{t: {(i + 1) % 10}}})") for i in range(10)]
"""
HEARD = """for rule in rules:
            rule.update({"time": time.time() - begun, "t": i})"""
MAPPING = "tick_s = 0.1\nreorder_s = 0\n" + "".join(
    f'[[messages]]\ntopic = "/t{i}"\nfrom = "t{i}"\nto = "m"\nfields = {{ x = "data" }}\n' for i in range(10))
PROPERTIES = "".join(
    f"property p{i} := always ((t{i}, m, true) implies time_until (t{(i + 1) % 10}, m, true) < 1 s)\n" for i in range(10))
NETWORK = "ip link set lo up && ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo && exec \"$@\""

if "IN_A_NETWORK" not in os.environ:
    words = [sys.executable, os.path.abspath(sys.argv[0]), *map(os.path.abspath, sys.argv[1:3])]
    os.execvpe("unshare", ["unshare", "-rn", "sh", "-c", NETWORK, "sh", *words], {**os.environ, "IN_A_NETWORK": "1"})
STEWARD, ROS = sys.argv[1:3]
FOLDER = Path(tempfile.mkdtemp())
(FOLDER / "m.toml").write_text(MAPPING)
(FOLDER / "p.scope").write_text(PROPERTIES)
robot = subprocess.Popen([ROS, "-c", ROBOT], start_new_session=True)
time.sleep(3)


def cost(name, words):
    begun = time.time()
    process = subprocess.Popen(words, stdout=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    assert os.waitstatus_to_exitcode(status) in (0, 1), name
    share = (used.ru_utime + used.ru_stime) / (time.time() - begun)
    print(f"{name:35} {100 * share:5.2f} % of a core, {used.ru_maxrss / 1024:5.1f} MB")


options = ["--map-channels", FOLDER / "m.toml", "--property", FOLDER / "p.scope", "--seconds", str(SECONDS), "--json"]
cost("steward watch, ten properties", [STEWARD, "watch", *options])
cost("rclpy, which only counts", [ROS, "-c", ECHO.replace("MONITORS", "").replace("HEARD", "")])
cost("rclpy with ten monitors of reelay", [ROS, "-c", ECHO.replace("MONITORS", MONITORS).replace("HEARD", HEARD)])
ros2 = Path(ROS).parent / "ros2"
if ros2.exists():
    echo = f"for i in 0 1 2 3 4 5 6 7 8 9; do timeout {SECONDS} {ros2} topic echo /t$i std_msgs/msg/String & done; wait"
    cost("ten of `ros2 topic echo`", ["sh", "-c", echo])
else:
    print(f"not run here: `ros2 topic echo`: there is no {ros2}")
os.killpg(robot.pid, 9)
