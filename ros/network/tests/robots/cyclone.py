"""The same robot without a node, on Cyclone DDS (pip install cyclonedds): its topics as ROS 2 names them. With a second
argument, it sends so many numbered messages on /count instead, one each millisecond, with best effort.
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


def say(**line):
    print(json.dumps(line), flush=True)


steps = int(sys.argv[1])
if len(sys.argv) > 2:
    count = writer("rt/count", Int32, Policy.Reliability.BestEffort, Policy.History.KeepLast(10))
else:
    level = writer("rt/level", Int32, reliable, Policy.History.KeepLast(10))
    stop = writer("rt/stop", Bool, Policy.Reliability.BestEffort, Policy.History.KeepLast(5))
    name = writer("rt/map_name", String, reliable, Policy.History.KeepLast(1), Policy.Durability.TransientLocal)
    name.write(String(data="house"))
say(up=True)
for line in sys.stdin:
    if line.strip() == "go" and len(sys.argv) > 2:
        for number in range(int(sys.argv[2])):
            count.write(Int32(data=number))
            time.sleep(0.001)
        say(done=number + 1)
    elif line.strip() == "go":
        for step in range(steps):
            stop.write(Bool(data=step == 40))
            level.write(Int32(data=60 - step))
            time.sleep(0.01)
        say(done=steps)
