"""Somebody of rclpy beside a simulated robot (packages as for driver.py). It says what it knows of the robot, drives it,
and sends what no robot should obey, as its input asks: `knows`, `drives`, `floods`, `babbles`.
"""
import math, time

import rclpy
from geometry_msgs.msg import Twist, TwistStamped
from lines import answer
from nav_msgs.msg import OccupancyGrid, Odometry
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import BatteryState, LaserScan

rclpy.init()
node, heard = Node("visitor"), {}
latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
commands = node.create_publisher(Twist, "/cmd_vel", 10)


def listen(kind, topic, quality=1000):
    node.create_subscription(kind, topic, lambda message: heard.setdefault(topic, []).append(message), quality)


listen(Clock, "/clock")
listen(Odometry, "/odom")
listen(LaserScan, "/scan", qos_profile_sensor_data)
listen(BatteryState, "/battery_state")
listen(OccupancyGrid, "/map", latched)


def spin(seconds, each=lambda: None):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        each()
        rclpy.spin_once(node, timeout_sec=0.02)


def twist(x, turn=0.0):
    command = Twist()
    command.linear.x, command.angular.z = x, turn
    return command


def seconds(stamp):
    return stamp.sec + stamp.nanosec * 1e-9


def lacks():
    is_unknown = any("UNKNOWN" in of.node_name for of in node.get_publishers_info_by_topic("/map"))
    topics = ("/clock", "/odom", "/battery_state", "/map")
    lasers = {scan.header.frame_id for scan in heard.get("/scan", [])}
    return is_unknown or len(lasers) < 2 or not all(topic in heard for topic in topics)


def knows():
    spin(3)
    # Who a node is, and the first large messages, may come a moment later.
    end = time.monotonic() + 10
    while time.monotonic() < end and lacks():
        spin(0.1)
    offers = {}
    for topic in ("/clock", "/tf", "/tf_static", "/odom", "/scan", "/battery_state", "/map", "/contacts"):
        [of] = node.get_publishers_info_by_topic(topic)
        offers[topic] = [of.node_name, of.topic_type, of.qos_profile.reliability.name, of.qos_profile.durability.name]
    [grid], scans, odometry = heard["/map"], heard["/scan"], heard["/odom"]
    steps = [round(seconds(b.header.stamp) - seconds(a.header.stamp), 9) for a, b in zip(odometry, odometry[1:])]
    return {
        "nodes": sorted(name for name in node.get_node_names() if name != "visitor"), "offers": offers,
        "listeners": len(node.get_subscriptions_info_by_topic("/cmd_vel")),
        "map": [grid.info.width, grid.info.height, sum(cell == 100 for cell in grid.data), grid.header.frame_id],
        "scans": [sorted({scan.header.frame_id for scan in scans}), len(scans[-1].ranges), scans[-1].range_max],
        "odom": [odometry[-1].header.frame_id, odometry[-1].child_frame_id, sorted(set(steps))],
        "battery": heard["/battery_state"][-1].percentage, "clock_s": seconds(heard["/clock"][-1].clock),
    }


def drives():
    spin(2, lambda: commands.publish(twist(0.2)))
    before = heard["/odom"][-1].twist.twist.linear.x
    spin(2)
    return {"driving": before, "after": heard["/odom"][-1].twist.twist.linear.x}


def floods():
    end, sent = time.monotonic() + 3, 0
    while time.monotonic() < end:
        commands.publish(twist(0.0, 1e308 if sent % 2 else -1e308))
        sent += 1
    before = heard["/clock"][-1].clock.sec
    spin(2)
    return {"sent": sent, "passed_s": heard["/clock"][-1].clock.sec - before}


def babbles():
    for number in (math.nan, math.inf, -math.inf):
        commands.publish(twist(number, number))
    # In one participant, all publishers on a topic have one type.
    elsewhere = rclpy.Context()
    rclpy.init(context=elsewhere)
    others = rclpy.create_node("other", context=elsewhere).create_publisher(TwistStamped, "/cmd_vel", 10)
    second = node.create_publisher(Twist, "/cmd_vel", 10)
    spin(1)
    others.publish(TwistStamped())
    sideways = twist(0.0)
    sideways.linear.y = 1.0
    second.publish(sideways)
    spin(1)
    return {"speed": heard["/odom"][-1].twist.twist.linear.x}


answer(knows, drives, floods, babbles)
