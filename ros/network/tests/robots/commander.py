"""Sends a simulated robot to a place as a script for nav2_simple_commander does: `commander.py X Y DEGREES` (packages as for
driver.py, and nav2_msgs). It does what `BasicNavigator` does in `waitUntilNav2Active`, `goToPose` and `isTaskComplete`, with
the same qualities, and says what came of it. `late` subscribes as late as it can, when the robot has long stood still.
"""
import math, sys, time

import rclpy
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from lifecycle_msgs.srv import GetState
from lines import answer
from nav2_msgs.action import NavigateToPose
from nav_msgs.msg import OccupancyGrid
from rclpy.action import ActionClient
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

LATCHED = QoSProfile(durability=DurabilityPolicy.TRANSIENT_LOCAL, reliability=ReliabilityPolicy.RELIABLE,
                     history=HistoryPolicy.KEEP_LAST, depth=1)


class Commander(Node):
    def __init__(self):
        super().__init__("basic_navigator")
        self.pose, self.feedback = None, 0
        self.navigator = ActionClient(self, NavigateToPose, "navigate_to_pose")
        self.create_subscription(PoseWithCovarianceStamped, "amcl_pose", self.take_pose, LATCHED)
        self.initial_pose = self.create_publisher(PoseWithCovarianceStamped, "initialpose", 10)

    def take_pose(self, pose):
        self.pose = pose

    def take_feedback(self, _):
        self.feedback += 1

    def await_active(self, name):
        """All states that a node has told until it is active."""
        client, states = self.create_client(GetState, f"{name}/get_state"), []
        assert client.wait_for_service(timeout_sec=20), name
        while "active" not in states:
            future = client.call_async(GetState.Request())
            rclpy.spin_until_future_complete(self, future, timeout_sec=20)
            state = future.result().current_state
            states.append(state.label)
            assert {"inactive": 2, "active": 3}[state.label] == state.id, state
            time.sleep(0.1)
        return states


def starts(x, y, degrees):
    """`waitUntilNav2Active`, with the pose that the robot has."""
    states = [node.await_active("amcl")]
    began = time.monotonic()
    while not node.pose and time.monotonic() - began < 20:
        pose = PoseWithCovarianceStamped()
        pose.header.frame_id = "map"
        pose.pose.pose.position.x, pose.pose.pose.position.y = float(x), float(y)
        turn = math.radians(float(degrees)) / 2
        pose.pose.pose.orientation.z, pose.pose.pose.orientation.w = math.sin(turn), math.cos(turn)
        node.initial_pose.publish(pose)
        rclpy.spin_once(node, timeout_sec=1.0)
    states.append(node.await_active("bt_navigator"))
    return {"states": [told[-1] for told in states], "has_pose": node.pose is not None,
            "publishers": {topic: len(node.get_publishers_info_by_topic(topic)) for topic in ("/map", "/amcl_pose")}}


def goes(x, y):
    """`goToPose`, and `isTaskComplete` until it is."""
    goal = NavigateToPose.Goal(pose=PoseStamped())
    goal.pose.header.frame_id = "map"
    goal.pose.pose.position.x, goal.pose.pose.position.y, goal.pose.pose.orientation.w = float(x), float(y), 1.0
    assert node.navigator.wait_for_server(timeout_sec=20)
    sent = node.navigator.send_goal_async(goal, node.take_feedback)
    rclpy.spin_until_future_complete(node, sent, timeout_sec=20)
    if not sent.result().accepted:
        return {"accepted": False}
    result = sent.result().get_result_async()
    rclpy.spin_until_future_complete(node, result, timeout_sec=180)
    return {"succeeded": result.result().status == GoalStatus.STATUS_SUCCEEDED, "has_feedback": node.feedback > 0}


def late():
    """What another node gets of what was published before, with these qualities: the pose, and the map."""
    other, got = Node("late"), set()
    for topic, kind in (("amcl_pose", PoseWithCovarianceStamped), ("map", OccupancyGrid)):
        other.create_subscription(kind, topic, lambda _, topic=topic: got.add(topic), LATCHED)
    began = time.monotonic()
    while time.monotonic() - began < 3:
        rclpy.spin_once(other, timeout_sec=0.1)
    other.destroy_node()
    return sorted(got)


rclpy.init()
node = Commander()
answer(starts, goes, late)
