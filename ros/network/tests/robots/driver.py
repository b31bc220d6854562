"""Drives a simulated robot to a place: `driver.py X Y` (packages as for fast.py, and ros-jazzy-sensor-msgs). It drives as
driving.py says, and sends one command for each period, when it has all that belongs to it. When nobody reads them any
more, it says how many it has sent and how busy it was meanwhile, and ends.
"""
import sys, time

import rclpy
from driving import Driver, Going, Trip
from geometry_msgs.msg import Point, Pose, PoseWithCovarianceStamped, TwistStamped
from lines import say
from nav_msgs.msg import OccupancyGrid
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import LaserScan


class Pilot(Node):
    def __init__(self, x, y):
        super().__init__("driver")
        self.driver, self.known, self.worked = Driver(), {}, []
        self.trip = Trip(self.driver, Pose(position=Point(x=x, y=y)))
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.commands = self.create_publisher(TwistStamped, "cmd_vel", 10)
        self.create_subscription(OccupancyGrid, "map", self.driver.take_map, latched)
        self.create_subscription(LaserScan, "scan", self.take_scan, 100)
        self.create_subscription(
            PoseWithCovarianceStamped, "amcl_pose", lambda pose: self.take("pose", pose, pose.header.stamp), 100)
        self.create_subscription(Clock, "clock", lambda clock: self.take("clock", clock, clock.clock), 100)

    def take_scan(self, scan):
        self.driver.take_scan(scan)
        self.take(scan.header.frame_id, scan, scan.header.stamp)

    def take(self, name, message, stamp):
        """Remembers a message, and sends the command of the period to which all of the last ones belong."""
        self.known[name] = message, (stamp.sec, stamp.nanosec)
        stamps = {stamp for _, stamp in self.known.values()}
        if len(self.known) == 4 and len(stamps) == 1 and self.driver.floor:
            next, command = self.trip.step(self.known["pose"][0]), TwistStamped()
            if isinstance(next, Going):
                command.twist.linear.x, command.twist.angular.z = next.speed, next.turn
            command.header.stamp = stamp
            self.commands.publish(command)
            self.known.clear()
            self.worked.append((time.process_time(), time.monotonic()))


rclpy.init()
node = Pilot(float(sys.argv[1]), float(sys.argv[2]))
say({"up": True})
while not node.worked or node.commands.get_subscription_count():
    rclpy.spin_once(node, timeout_sec=0.1)
(worked_s, began_s), (all_worked_s, ended_s) = node.worked[0], node.worked[-1]
say({"sent": len(node.worked), "busy": (all_worked_s - worked_s) / (ended_s - began_s)})
