"""Asks the devices of a simulated robot, and hears what it touches, on Cyclone DDS (packages as for cyclone_ros.py).
Each line of its input asks it for something, and it prints what came of it:

    calls SERVICE           a Trigger: whether it succeeded, and its message
    says TEXT...            to /Speaker, several texts at once
    touches                 the contacts so far
"""
import time

from cyclone_nav2 import Header, Vector3
from cyclone_ros import Client, made, struct, take
from cyclonedds.core import Policy
from cyclonedds.idl import types
from cyclonedds.sub import DataReader
from lines import answer

PATIENCE_S = 30
gazebo = "ros_gz_interfaces::msg::dds_::"
Entity = struct(f"{gazebo}Entity_", id=types.uint64, name=str, type=types.uint8)
Wrench = struct("geometry_msgs::msg::dds_::Wrench_", force=Vector3, torque=Vector3)
JointWrench = struct(f"{gazebo}JointWrench_", header=Header, body_1_name=str, body_1_id=types.uint32, body_2_name=str,
                     body_2_id=types.uint32, body_1_wrench=Wrench, body_2_wrench=Wrench)
Contact = struct(f"{gazebo}Contact_", collision1=Entity, collision2=Entity, positions=types.sequence[Vector3],
                 normals=types.sequence[Vector3], depths=types.sequence[types.float64],
                 wrenches=types.sequence[JointWrench])
Contacts = struct(f"{gazebo}Contacts_", header=Header, contacts=types.sequence[Contact])
contacts = made(DataReader, "rt/contacts", Contacts, Policy.Reliability.Reliable(10**9), Policy.History.KeepLast(100))
# In IDL, no struct is empty.
nothing, outcome = {"structure_needs_at_least_one_member": types.uint8}, {"success": bool, "message": str}
trigger = lambda service: Client(service, "std_srvs::srv::dds_::Trigger", nothing, outcome)
clients = {service: trigger(service) for service in ("/Door/open", "/Door/close", "/Door/get_state")}
speaker = Client("/Speaker/say", "steward_msgs::srv::dds_::Say", {"text": str}, outcome)


def matched(client):
    until = time.monotonic() + PATIENCE_S
    is_matched = lambda: client.requests.get_matched_subscriptions() and client.responses.get_matched_publications()
    while not is_matched() and time.monotonic() < until:
        time.sleep(0.05)
    return client


def response(client, number):
    answer = client.response(number, PATIENCE_S)
    return answer and [answer.success, answer.message]


def calls(service):
    client = matched(clients[service])
    return response(client, client.send(structure_needs_at_least_one_member=0))


def says(*texts):
    numbers = [matched(speaker).send(text=text) for text in texts]
    return [response(speaker, number) for number in numbers]


def touches():
    pairs = [(message.header.frame_id, of) for message in take(contacts) for of in message.contacts]
    vectors = lambda of: [[round(number, 2) for number in (at.x, at.y, at.z)] for at in of]
    return [[frame, of.collision1.name, of.collision2.name, vectors(of.positions), vectors(of.normals), list(of.depths),
             len(of.wrenches)] for frame, of in pairs]


answer(calls, says, touches)
