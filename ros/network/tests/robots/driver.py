"""Drives a simulated robot to a place: `driver.py X Y SECONDS` (packages as for fast.py, and ros-jazzy-sensor-msgs). It
plans on the latched map, follows the plan by where localization sees the robot, slows down before obstacles, and sends
one command for each period, when it has all that belongs to it. Without the time for so many seconds, it says how many
commands it has sent, and ends.
"""
import json, math, sys, time
from collections import deque

import numpy, rclpy
from geometry_msgs.msg import PoseWithCovarianceStamped, TwistStamped
from nav_msgs.msg import OccupancyGrid
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import LaserScan

ROBOT_M, AHEAD_M, SPEED = 0.5, 0.6, 0.4
goal, patience = (float(sys.argv[1]), float(sys.argv[2])), float(sys.argv[3])
rclpy.init()
node, known, sent = Node("driver"), {"stamps": {}, "sent": None}, 0
commands = node.create_publisher(TwistStamped, "/cmd_vel", 10)


def distances(grid):
    """How many cells each free cell is from the goal; what is too near to a wall is not free."""
    info, size = grid.info, (grid.info.height, grid.info.width)
    free = numpy.array(grid.data, dtype=numpy.int8).reshape(size) == 0
    reach = int(ROBOT_M / info.resolution)
    wide = free.copy()
    for dy in range(-reach, reach + 1):
        for dx in range(-reach, reach + 1):
            if dx * dx + dy * dy <= reach * reach:
                wide &= numpy.roll(free, (dy, dx), (0, 1))
    start = cell(info, *goal)
    steps, waiting = {start: 0}, deque([start])
    while waiting:
        x, y = waiting.popleft()
        for next in ((x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)):
            if wide[next[1], next[0]] and next not in steps:
                steps[next] = steps[x, y] + 1
                waiting.append(next)
    return info, steps


def cell(info, x, y):
    return int((x - info.origin.position.x) / info.resolution), int((y - info.origin.position.y) / info.resolution)


def drive(pose, scans):
    x, y, turned = pose.position.x, pose.position.y, 2 * math.atan2(pose.orientation.z, pose.orientation.w)
    if math.dist((x, y), goal) < 0.3:
        return 0.0, 0.0
    info, steps = known["plan"]
    here = cell(info, x, y)
    around = [(here[0] + dx, here[1] + dy) for dx in range(-8, 9) for dy in range(-8, 9)]
    at = min((place for place in around if place in steps), key=lambda place: math.dist(place, here))
    for _ in range(int(AHEAD_M / info.resolution)):
        near = [(at[0] + dx, at[1] + dy) for dx in (-1, 0, 1) for dy in (-1, 0, 1)]
        at = min((place for place in near if place in steps), key=lambda place: steps[place])
    target_x = info.origin.position.x + (at[0] + 0.5) * info.resolution
    target_y = info.origin.position.y + (at[1] + 0.5) * info.resolution
    off = math.remainder(math.atan2(target_y - y, target_x - x) - turned, math.tau)
    front = next(scan for scan in scans if scan.header.frame_id == "laser_front")
    beams = front.ranges[len(front.ranges) // 3 : -len(front.ranges) // 3]
    room = min((range for range in beams if range > 0), default=math.inf)
    return (SPEED * min(1.0, max(0.0, room - 0.15)) if abs(off) < 0.6 else 0.0), max(-1.0, min(1.0, 1.5 * off))


def take(name, message, stamp=None):
    """Remembers a message, and sends the command of the period to which all of the last ones belong."""
    global sent
    known[name], known["heard"] = message, time.monotonic()
    if stamp:
        known["stamps"][name] = (stamp.sec, stamp.nanosec)
    stamps = known["stamps"]
    if len(stamps) < 4 or len(set(stamps.values())) > 1 or "plan" not in known or known["sent"] == stamps["clock"]:
        return
    command = TwistStamped()
    command.header.stamp = known["clock"].clock
    velocity = drive(known["pose"].pose.pose, [known["laser_front"], known["laser_back"]])
    command.twist.linear.x, command.twist.angular.z = velocity
    commands.publish(command)
    known["sent"], sent = stamps["clock"], sent + 1
    known["worked"] = (*known.get("worked", ())[:1], (time.process_time(), time.monotonic()))


latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
node.create_subscription(OccupancyGrid, "/map", lambda grid: take("plan", distances(grid)), latched)
node.create_subscription(LaserScan, "/scan", lambda scan: take(scan.header.frame_id, scan, scan.header.stamp), 100)
node.create_subscription(PoseWithCovarianceStamped, "/amcl_pose", lambda pose: take("pose", pose, pose.header.stamp), 100)
node.create_subscription(Clock, "/clock", lambda clock: take("clock", clock, clock.clock), 100)
print(json.dumps({"up": True}), flush=True)
while time.monotonic() < known.setdefault("heard", time.monotonic() + 30) + patience:
    rclpy.spin_once(node, timeout_sec=0.1)
(worked_s, began_s), (all_worked_s, ended_s) = known["worked"]
print(json.dumps({"sent": sent, "busy": (all_worked_s - worked_s) / (ended_s - began_s)}))
