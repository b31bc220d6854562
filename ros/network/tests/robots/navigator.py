"""A navigation that is not ours, as a node of ROS 2: `navigator.py [--misbehave HOW] [--after SECONDS]` serves the
action navigate_to_pose (packages as for driver.py, and nav2_msgs), and drives as driving.py says. A newer goal aborts
an older one; a goal that is not on free floor is rejected.
"""
import sys

import rclpy
from driving import CANCELED, NEWER, SPEED, End, Going, Trip, driver
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped, Twist
from lines import say
from nav2_msgs.action import NavigateToPose
from nav_msgs.msg import OccupancyGrid
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.task import Future
from rclpy.utilities import remove_ros_args
from sensor_msgs.msg import LaserScan


class Navigator(Node):
    def __init__(self, driver):
        super().__init__("navigator", parameter_overrides=[Parameter("use_sim_time", value=True)])
        self.driver, self.goal, self.sensed = driver, None, Future()
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        newest = QoSProfile(depth=2, reliability=ReliabilityPolicy.BEST_EFFORT)
        self.commands = self.create_publisher(Twist, "cmd_vel", 1)
        self.create_subscription(OccupancyGrid, "map", driver.take_map, latched)
        self.create_subscription(LaserScan, "scan", driver.take_scan, newest)
        self.create_subscription(PoseWithCovarianceStamped, "amcl_pose", self.take_pose, newest)
        ActionServer(self, NavigateToPose, "navigate_to_pose", self.navigate, goal_callback=self.judge,
                     cancel_callback=lambda _: CancelResponse.ACCEPT)

    def take_pose(self, pose):
        sensed, self.sensed = self.sensed, Future()
        sensed.set_result(pose)

    def judge(self, goal):
        return GoalResponse.ACCEPT if self.driver.would_go(goal.pose) else GoalResponse.REJECT

    async def navigate(self, goal):
        self.goal, trip, next = goal, Trip(self.driver, goal.request.pose.pose), None
        while not isinstance(next, End):
            pose = await self.sensed
            next = trip.step(pose, CANCELED if goal.is_cancel_requested else NEWER if self.goal is not goal else None)
            if isinstance(next, Going):
                self.drive(next.speed, next.turn)
                goal.publish_feedback(NavigateToPose.Feedback(
                    current_pose=PoseStamped(header=pose.header, pose=pose.pose.pose), distance_remaining=next.left_m,
                    navigation_time=Duration(seconds=next.seconds).to_msg(),
                    estimated_time_remaining=Duration(seconds=next.left_m / SPEED).to_msg()))
        if self.goal is goal:
            self.drive(0.0, 0.0)
        getattr(goal, next.how)()
        return NavigateToPose.Result(error_code=next.code, error_msg=next.why)

    def drive(self, speed, turn):
        command = Twist()
        command.linear.x, command.angular.z = speed, turn
        self.commands.publish(command)


rclpy.init(args=sys.argv)
node = Navigator(driver(remove_ros_args(sys.argv)[1:]))
say({"up": True})
rclpy.spin(node)
