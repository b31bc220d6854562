"""A robot of rclpy on Fast DDS (pip install "ros-jazzy-rclpy[fastrtps]" ros-jazzy-std-msgs ros-jazzy-std-srvs
ros-jazzy-test-msgs ros-jazzy-diagnostic-msgs numpy): topics of three kinds of quality, one latched, a service, an
action, and a node with a lifecycle. It answers each line of its input: `go` when it has driven; `seen` with what it
knows of those who listen to it, whether its services and its action are available to its own clients, and the state of
that node; `diagnosed` with what is published of its properties.
"""
import sys, threading, time

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from lifecycle_msgs.srv import GetState
from lines import answer
from rclpy.action import ActionClient, ActionServer
from rclpy.executors import MultiThreadedExecutor
from rclpy.lifecycle import LifecycleNode
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from std_msgs.msg import Bool, Int32, String
from std_srvs.srv import Trigger
from test_msgs.action import Fibonacci

steps = int(sys.argv[1])
rclpy.init()
node = Node("base", namespace="/robot")
level = node.create_publisher(Int32, "/level", 10)
stop = node.create_publisher(Bool, "/stop", qos_profile_sensor_data)
name = node.create_publisher(String, "/map_name", QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL))
name.publish(String(data="house"))
node.create_service(Trigger, "/dock", lambda request, response: response)


def succeed(handle):
    handle.succeed()
    return Fibonacci.Result()


camera = LifecycleNode("camera", namespace="/robot")
camera.trigger_configure()
state = node.create_client(GetState, "/robot/camera/get_state")
server = ActionServer(node, Fibonacci, "/go", succeed)
client = node.create_client(Trigger, "/dock")
action = ActionClient(node, Fibonacci, "/go")


def seen():
    return {
        "dock": client.wait_for_service(1.0), "go": action.wait_for_server(1.0),
        "called": client.call(Trigger.Request()) is not None,
        "state": state.call(GetState.Request()).current_state.label,
        "clients": node.count_clients("/dock"), "services": node.count_services("/dock"),
        "publishers": node.count_publishers("/level"), "nodes": sorted(node.get_node_names_and_namespaces()),
        "requests": [node.count_subscribers(topic) for topic in ("rq/dockRequest", "/dockRequest")],
    }


def diagnosed():
    heard = {}
    state = lambda status: [status.name, int.from_bytes(status.level, "little"), status.message,
                            {value.key: value.value for value in status.values}]
    together = lambda message: heard.update(all=[state(status) for status in message.status],
                                            age_s=time.time() - message.header.stamp.sec)
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    listeners = [
        node.create_subscription(DiagnosticArray, "/diagnostics", together, 10),
        node.create_subscription(DiagnosticStatus, "/steward/properties/charged",
                                 lambda status: heard.update(charged=state(status)), latched),
    ]
    until = time.monotonic() + 10
    while len(heard) < 3 and time.monotonic() < until:
        time.sleep(0.01)
    for listener in listeners:
        node.destroy_subscription(listener)
    return heard


def go():
    for step in range(steps):
        stop.publish(Bool(data=step == 40))
        level.publish(Int32(data=60 - step))
        time.sleep(0.01)
    return {"done": steps, "listeners": level.get_subscription_count()}


executor = MultiThreadedExecutor()
executor.add_node(node)
executor.add_node(camera)
threading.Thread(target=answer, args=[seen, diagnosed, go], daemon=True).start()
executor.spin()
