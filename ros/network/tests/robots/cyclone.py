"""The same robot without a node, on Cyclone DDS (packages as for cyclone_ros.py, and mcap): its topics as ROS 2 names
them. With a second argument, it sends so many numbered messages on /count instead, one each millisecond, with best
effort. With a third, as JSON, it sends `burst` of them each millisecond, begins anew as another participant after each
`restart`, sends `answers` instead of some numbers, and records what it sends in the file `record`. With a third, `pairs`,
it sends each number reliably on /asked, and but for each 400th, 2 ms later, on /answered.
"""
import json, sys, time

import cyclone_ros
from cyclone_ros import LATCHED, made, struct
from cyclonedds.core import Policy
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import types
from cyclonedds.pub import DataWriter
from lines import answer
from mcap.writer import Writer

Int32 = struct("std_msgs::msg::dds_::Int32_", data=types.int32)
Bool = struct("std_msgs::msg::dds_::Bool_", data=bool)
String = struct("std_msgs::msg::dds_::String_", data=str)
lossy = Policy.Reliability.BestEffort


def counter():
    return made(DataWriter, "rt/count", Int32, lossy, Policy.History.KeepLast(10))


def send_numbers(total, burst=1, restart=0, answers={}, record="/dev/null"):
    global count
    with open(record, "wb") as file:
        recorded = Writer(file)
        recorded.start("ros2")
        schema = recorded.register_schema("std_msgs/msg/Int32", "ros2msg", b"int32 data")
        channel = recorded.register_channel("/count", "cdr", schema)
        for number in range(total):
            if restart and number % restart == restart - 1:
                # Without anything of its own, the old participant ends.
                del count
                cyclone_ros.participant = DomainParticipant(0)
                count = counter()
                time.sleep(5)
            value = answers.get(str(number), number)
            now = time.time_ns()
            recorded.add_message(channel, now, b"\0\1\0\0" + value.to_bytes(4, "little", signed=True), now)
            count.write(Int32(data=value))
            if number % burst == 0:
                time.sleep(0.001)
        recorded.finish()
    return {"done": total}


def send_pairs(total):
    for number in range(total):
        asked.write(Int32(data=number))
        time.sleep(0.002)
        if number % 400 != 399:
            answered.write(Int32(data=number))
    return {"done": total}


def send_levels(steps):
    for step in range(steps):
        stop.write(Bool(data=step == 40))
        level.write(Int32(data=60 - step))
        time.sleep(0.01)
    return {"done": steps}


def go():
    if is_robot:
        return send_levels(int(sys.argv[1]))
    if has_pairs:
        return send_pairs(int(sys.argv[2]))
    return send_numbers(int(sys.argv[2]), **json.loads("".join(sys.argv[3:]) or "{}"))


is_robot, has_pairs = len(sys.argv) == 2, sys.argv[3:] == ["pairs"]
if is_robot:
    level = made(DataWriter, "rt/level", Int32)
    stop = made(DataWriter, "rt/stop", Bool, lossy, Policy.History.KeepLast(5))
    name = made(DataWriter, "rt/map_name", String, *LATCHED)
    name.write(String(data="house"))
elif has_pairs:
    asked, answered = (made(DataWriter, f"rt/{name}", Int32) for name in ["asked", "answered"])
else:
    count = counter()
answer(go)
