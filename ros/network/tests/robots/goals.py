"""A client that is not ours of the action navigate_to_pose, as a node of ROS 2 (packages as for navigator.py). Each
line of its input asks it for something, and it prints what came of it:

    waits               whether there is a server, and which node it is
    until SECONDS       lets the robot's time pass until then
    goes X Y DEGREES    sends a goal and awaits its end
    cancels X Y DEGREES SECONDS    and cancels it so many seconds later, in the robot's time
    replaces X Y DEGREES SECONDS X Y DEGREES    and sends another one so many seconds later
    errs                sends goals that no robot can have
    asks                for the result of a goal that nobody has sent, and to cancel it
"""
import math, os, time

import rclpy
from action_msgs.msg import GoalInfo, GoalStatusArray
from action_msgs.srv import CancelGoal
from lines import answer
from nav2_msgs.action import NavigateToPose
from rclpy.action import ActionClient, get_action_server_names_and_types_by_node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from unique_identifier_msgs.msg import UUID

NAME, PATIENCE_S = "/navigate_to_pose", 30
rclpy.init()
node = rclpy.create_node("goals", parameter_overrides=[Parameter("use_sim_time", value=True)])
client = ActionClient(node, NavigateToPose, NAME)
statuses = {}


def hear(message):
    for of in message.status_list:
        heard = statuses.setdefault(bytes(of.goal_info.goal_id.uuid), [])
        heard += [of.status] if heard[-1:] != [of.status] else []


latched = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
node.create_subscription(GoalStatusArray, f"{NAME}/_action/status", hear, latched)


def now():
    return node.get_clock().now().nanoseconds * 1e-9


def spin(is_done):
    end = time.monotonic() + PATIENCE_S
    while not is_done() and time.monotonic() < end:
        rclpy.spin_once(node, timeout_sec=0.02)
    return is_done()


def answered(future):
    """The answer to a request, or None."""
    return future.result() if spin(future.done) else None


class Trip:
    def __init__(self, x, y, degrees, frame="map"):
        goal, self.left_m, self.id = NavigateToPose.Goal(), [], os.urandom(16)
        goal.pose.header.frame_id, turned = frame, math.radians(degrees) / 2
        goal.pose.pose.position.x, goal.pose.pose.position.y = x, y
        goal.pose.pose.orientation.z, goal.pose.pose.orientation.w = math.sin(turned), math.cos(turned)
        hear = lambda message: self.left_m.append(round(message.feedback.distance_remaining, 2))
        self.handle = answered(client.send_goal_async(goal, hear, UUID(uuid=list(self.id))))
        self.ending = self.handle.get_result_async() if self.handle and self.handle.accepted else None
        self.began_s = now()

    def drive(self, seconds):
        spin(lambda: now() > self.began_s + seconds or self.ending.done())

    def cancel(self):
        answer = answered(self.handle.cancel_goal_async())
        return answer and [answer.return_code, [bytes(of.goal_id.uuid) == self.id for of in answer.goals_canceling]]

    def end(self):
        """What became of the goal."""
        if self.ending is None:
            return {"accepted": self.handle and self.handle.accepted, "statuses": statuses.get(self.id, [])}
        end = answered(self.ending)
        spin(lambda: end is None or statuses.get(self.id, [])[-1:] == [end.status])
        return {"accepted": True, "statuses": statuses.get(self.id, []), "feedback": len(self.left_m),
                "left_m": self.left_m[:: len(self.left_m) - 1 or 1], "status": end and end.status,
                "error_code": end and end.result.error_code, "error_msg": end and end.result.error_msg}


def serves(name, namespace):
    try:
        served = get_action_server_names_and_types_by_node(node, name, namespace)
        return (NAME, ["nav2_msgs/action/NavigateToPose"]) in served
    except RuntimeError:
        # There is no such node any more.
        return False


def waits():
    found = client.wait_for_server(PATIENCE_S)
    servers = lambda: [name for name, namespace in node.get_node_names_and_namespaces() if serves(name, namespace)]
    # Who a node is may be known a moment later.
    spin(servers)
    return {"server": found, "nodes": servers()}


def until(seconds):
    return {"passed": spin(lambda: now() >= seconds)}


def goes(*goal):
    return Trip(*goal).end()


def cancels(x, y, degrees, seconds):
    trip = Trip(x, y, degrees)
    trip.drive(seconds)
    canceled = trip.cancel()
    return {**trip.end(), "canceled": canceled, "canceled_again": trip.cancel()}


def replaces(x, y, degrees, seconds, *goal):
    trip = Trip(x, y, degrees)
    trip.drive(seconds)
    other = Trip(*goal)
    return [trip.end(), other.end()]


def errs():
    elsewhere, nowhere = [(0.0, 0.0, 0.0, "odom"), (0.0, 0.0, 0.0, "")], [(math.nan, 0.0, 0.0), (0.0, math.inf, 0.0)]
    return [Trip(*goal).end() for goal in elsewhere + nowhere]


def asks():
    nobody = UUID(uuid=list(os.urandom(16)))
    result, cancel = NavigateToPose.Impl.GetResultService, CancelGoal
    results = node.create_client(result, f"{NAME}/_action/get_result")
    cancels = node.create_client(cancel, f"{NAME}/_action/cancel_goal")
    found = [service.wait_for_service(PATIENCE_S) for service in (results, cancels)]
    end = answered(results.call_async(result.Request(goal_id=nobody)))
    canceled = answered(cancels.call_async(cancel.Request(goal_info=GoalInfo(goal_id=nobody))))
    return {"found": found, "status": end and end.status, "error_code": end and end.result.error_code,
            "canceled": canceled and [canceled.return_code, len(canceled.goals_canceling)]}


answer(waits, until, goes, cancels, replaces, errs, asks, read=float)
