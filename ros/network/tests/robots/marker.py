"""A node of rclpy on Fast DDS (packages as for fast.py) that numbers messages on /count, and tells the truth: reliably,
at 50 Hz, and with best effort on /beat. `marks VALUE ...` says these on /mark, where it is silent otherwise; `truth`
says what it has sent on each topic, and `leaves` says goodbye.
"""
import threading, time

import rclpy
from lines import answer
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from std_msgs.msg import Int32

rclpy.init()
node = Node("marker")
topics = {"/count": 10, "/mark": 10, "/beat": qos_profile_sensor_data}
publishers = {topic: node.create_publisher(Int32, topic, quality) for topic, quality in topics.items()}
sent, is_over = {topic: [] for topic in topics}, threading.Event()


def send(topic, value):
    publishers[topic].publish(Int32(data=value))
    sent[topic].append(value)


def count():
    while not is_over.wait(0.02):
        for topic in ("/count", "/beat"):
            send(topic, len(sent[topic]))


def marks(*values):
    for value in values:
        send("/mark", value)
    return {"at": time.time()}


def truth():
    return sent


def leaves():
    is_over.set()
    counting.join()
    node.destroy_node()
    rclpy.shutdown()
    return sent


counting = threading.Thread(target=count, daemon=True)
counting.start()
answer(marks, truth, leaves, read=int)
