"""A node of rclpy that asks the devices of a simulated robot, and hears what they tell (packages as for driver.py).
Each line of its input asks it for something, and it prints what came of it:

    knows                   the types of the services and topics of devices
    calls SERVICE           a Trigger: whether it succeeded, and its message
    hears TOPIC COUNT       what has been heard on a topic, once that is so many messages
    doors                   the last state of doors, for who has just come
    drives SPEED SECONDS    the robot
"""
import time

import rclpy
from geometry_msgs.msg import Twist
from lines import answer
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import Empty, String
from std_srvs.srv import Trigger

PATIENCE_S = 30
rclpy.init()
node, clients, heard = Node("caller"), {}, {}
latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
commands = node.create_publisher(Twist, "/cmd_vel", 10)
for topic, kind in {"/CallButton/pressed": Empty, "/Door/moved": String, "/Speaker/spoken": String}.items():
    node.create_subscription(kind, topic, heard.setdefault(topic, []).append, 10)


def spin(until, patience_s=PATIENCE_S):
    end = time.monotonic() + patience_s
    while not until() and time.monotonic() < end:
        rclpy.spin_once(node, timeout_sec=0.02)
    return until()


def of_devices(names):
    return {name: kinds for name, kinds in names if name.split("/")[1] in ("CallButton", "Door", "Speaker", "Tray")}


def knows():
    services = lambda: of_devices(node.get_service_names_and_types_by_node("steward", "/"))
    topics = lambda: of_devices(node.get_publisher_names_and_types_by_node("steward", "/"))
    # Who a node is, and what it has, may be known a moment later.
    there = lambda: "steward" in node.get_node_names() and len(services()) == 8 and len(topics()) == 3
    return {"found": spin(there), "services": services(), "topics": topics()}


def calls(service):
    client = clients.setdefault(service, node.create_client(Trigger, service))
    if not client.wait_for_service(PATIENCE_S):
        return None
    answer = client.call_async(Trigger.Request())
    spin(answer.done)
    return answer.result() and [answer.result().success, answer.result().message]


def hears(topic, count):
    spin(lambda: len(heard[topic]) >= int(count))
    return [getattr(message, "data", None) for message in heard[topic]]


def doors():
    states = []
    subscription = node.create_subscription(JointState, "/doors", states.append, latched)
    spin(lambda: states)
    # Earlier states may come first.
    while spin(lambda known=len(states): len(states) > known, 0.5):
        pass
    node.destroy_subscription(subscription)
    return [[state.header.frame_id, dict(zip(state.name, state.position))] for state in states[-1:]]


def drives(speed, seconds):
    command, end = Twist(), time.monotonic() + float(seconds)
    command.linear.x = float(speed)
    while time.monotonic() < end:
        commands.publish(command)
        rclpy.spin_once(node, timeout_sec=0.05)
    return {"driven": True}


answer(knows, calls, hears, doors, drives)
