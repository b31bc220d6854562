"""The same robot without a node, on Cyclone DDS (pip install cyclonedds mcap): its topics as ROS 2 names them. With a
second argument, it sends so many numbered messages on /count instead, one each millisecond, with best effort. With a
third, as JSON, it sends `burst` of them each millisecond, begins anew as another participant after each `restart`,
sends `answers` instead of some numbers, and records what it sends in the file `record`.
"""
import json, sys, time
from dataclasses import dataclass

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct, types
from cyclonedds.idl.annotations import final
from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic
from cyclonedds.util import duration
from mcap.writer import Writer


@dataclass
@final
class Int32(IdlStruct, typename="std_msgs::msg::dds_::Int32_"):
    data: types.int32


@dataclass
@final
class Bool(IdlStruct, typename="std_msgs::msg::dds_::Bool_"):
    data: bool


@dataclass
@final
class String(IdlStruct, typename="std_msgs::msg::dds_::String_"):
    data: str


for kind in (Int32, Bool, String):
    kind.__idl__.xcdrv2_supported = False
participant = DomainParticipant(0)
reliable = Policy.Reliability.Reliable(duration(seconds=1))


def writer(name, kind, *policies):
    qos = Qos(*policies, Policy.DataRepresentation(use_cdrv0_representation=True))
    return DataWriter(participant, Topic(participant, name, kind, qos=qos), qos=qos)


def counter():
    return writer("rt/count", Int32, Policy.Reliability.BestEffort, Policy.History.KeepLast(10))


def say(**line):
    print(json.dumps(line), flush=True)


def send_numbers(total, burst=1, restart=0, answers={}, record="/dev/null"):
    global participant
    count = counter()
    yield
    with open(record, "wb") as file:
        recorded = Writer(file)
        recorded.start("ros2")
        schema = recorded.register_schema("std_msgs/msg/Int32", "ros2msg", b"int32 data")
        channel = recorded.register_channel("/count", "cdr", schema)
        for number in range(total):
            if restart and number % restart == restart - 1:
                del count
                participant = DomainParticipant(0)
                count = counter()
                time.sleep(5)
            value = answers.get(str(number), number)
            now = time.time_ns()
            recorded.add_message(channel, now, b"\0\1\0\0" + value.to_bytes(4, "little", signed=True), now)
            count.write(Int32(data=value))
            if number % burst == 0:
                time.sleep(0.001)
        recorded.finish()
    say(done=total)
    yield


steps = int(sys.argv[1])
if len(sys.argv) > 2:
    sending = send_numbers(int(sys.argv[2]), **json.loads("".join(sys.argv[3:]) or "{}"))
    next(sending)
else:
    level = writer("rt/level", Int32, reliable, Policy.History.KeepLast(10))
    stop = writer("rt/stop", Bool, Policy.Reliability.BestEffort, Policy.History.KeepLast(5))
    name = writer("rt/map_name", String, reliable, Policy.History.KeepLast(1), Policy.Durability.TransientLocal)
    name.write(String(data="house"))
say(up=True)
for line in sys.stdin:
    if line.strip() == "go" and len(sys.argv) > 2:
        next(sending)
    elif line.strip() == "go":
        for step in range(steps):
            stop.write(Bool(data=step == 40))
            level.write(Int32(data=60 - step))
            time.sleep(0.01)
        say(done=steps)
