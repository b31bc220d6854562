"""Somebody of rclpy beside several simulated robots (packages as for driver.py): `fleet.py NAMESPACE…` sends each robot
commands, forwards and each at another speed, and says what it has seen of them for some seconds.
"""
import sys, time

import rclpy
from geometry_msgs.msg import Twist
from lines import answer
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock

# On a busy machine, it takes longer until all robots go as fast as they are told.
SECONDS, MOST_S = 6, 15
spaces, seen = sys.argv[1:], {}
rclpy.init()
node = rclpy.create_node("fleet")
commands = {space: node.create_publisher(Twist, f"{space}/cmd_vel", 1) for space in spaces}
for space in spaces:
    see = lambda message, space=space: seen.setdefault(space, []).append(message)
    node.create_subscription(Odometry, f"{space}/odom", see, 10)
node.create_subscription(Clock, "/clock", lambda message: seen.setdefault("clock", []).append(message.clock), 100)


def asked(place):
    return round(0.1 + 0.02 * (place % 10), 2)


def speeds():
    return [round(seen[space][-1].twist.twist.linear.x, 2) for space in spaces if space in seen]


def go():
    began = time.monotonic()
    is_waiting = lambda: speeds() != [asked(place) for place in range(len(spaces))]
    while time.monotonic() < began + SECONDS or is_waiting() and time.monotonic() < began + MOST_S:
        for place, space in enumerate(spaces):
            command = Twist()
            command.linear.x = asked(place)
            commands[space].publish(command)
        until = time.monotonic() + 0.1
        while time.monotonic() < until:
            rclpy.spin_once(node, timeout_sec=0.01)
    times = [clock.sec + clock.nanosec * 1e-9 for clock in seen["clock"]]
    return {
        "nodes": sorted(f"{space}/{name}" for name, space in node.get_node_names_and_namespaces() if name == "steward"),
        "publishers": {space: [of.node_namespace for of in node.get_publishers_info_by_topic(f"{space}/odom")]
                       for space in spaces},
        "speeds": speeds(),
        "messages": sum(len(seen[space]) for space in spaces),
        "passed_s": times[-1] - times[0],
        "steps_s": sorted({round(b - a, 6) for a, b in zip(times, times[1:])}),
    }


answer(go)
