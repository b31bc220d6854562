"""The same server as cyclone_server.py, which says what it does, as a node of ROS 2 (packages as for fast.py, and
test_msgs): there, a response refers to its request beside the message. It cannot respond twice. With
`--misbehave hesitates`, it says that it counts before it accepts the goal.
"""
import argparse, os, sys, time

import rclpy
from lines import say
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.utilities import remove_ros_args
from std_msgs.msg import String
from std_srvs.srv import SetBool
from test_msgs.action import Fibonacci

COUNT_S, LATE_S, HESITATES_S = 0.2, 3.0, 0.3


def serve_switch(request, response):
    time.sleep(LATE_S if misbehaves == "late" else 0.0)
    response.success, response.message = request.data, "switched"
    return response


def judge(_):
    if misbehaves == "hesitates":
        say({"counts": True})
        time.sleep(HESITATES_S)
    return GoalResponse.REJECT if misbehaves == "rejects" else GoalResponse.ACCEPT


def count(goal):
    numbers = [0, 1]
    while rclpy.ok():
        counted = len(numbers) - 2
        if misbehaves == "dies" and counted == 2:
            os._exit(1)
        elif misbehaves == "hangs":
            pass
        elif goal.is_cancel_requested:
            goal.canceled()
            break
        elif misbehaves == "aborts" and counted == 2:
            goal.abort()
            break
        elif counted >= goal.request.order:
            goal.succeed()
            break
        else:
            numbers.append(sum(numbers[-2:]))
            goal.publish_feedback(Fibonacci.Feedback(sequence=numbers))
            if counted == 2:
                say({"counts": True})
        time.sleep(COUNT_S)
    return Fibonacci.Result(sequence=numbers)


parser = argparse.ArgumentParser()
parser.add_argument("--misbehave", choices=["rejects", "aborts", "hangs", "dies", "late", "hesitates"])
misbehaves = parser.parse_args(remove_ros_args(sys.argv)[1:]).misbehave
rclpy.init(args=sys.argv)
node = rclpy.create_node("helper", namespace="/helper")
told = node.create_publisher(String, "told", QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL))
told.publish(String(data="ready"))
node.create_service(SetBool, "switch", serve_switch)
ActionServer(node, Fibonacci, "count", count, goal_callback=judge,
             cancel_callback=lambda _: CancelResponse.ACCEPT, callback_group=ReentrantCallbackGroup())
executor = MultiThreadedExecutor(num_threads=8)
executor.add_node(node)
say({"up": True})
try:
    executor.spin()
except (KeyboardInterrupt, ExternalShutdownException):
    pass
