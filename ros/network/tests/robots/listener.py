"""Reads the transforms of a robot with Cyclone DDS (pip install cyclonedds), for two seconds: which frames are where."""
import json, time
from dataclasses import dataclass

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct, types
from cyclonedds.idl.annotations import final
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration


@dataclass
@final
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec: types.int32
    nanosec: types.uint32


@dataclass
@final
class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    stamp: Time
    frame_id: str


@dataclass
@final
class Vector(IdlStruct, typename="geometry_msgs::msg::dds_::Vector3_"):
    x: types.float64
    y: types.float64
    z: types.float64


@dataclass
@final
class Quaternion(IdlStruct, typename="geometry_msgs::msg::dds_::Quaternion_"):
    x: types.float64
    y: types.float64
    z: types.float64
    w: types.float64


@dataclass
@final
class Transform(IdlStruct, typename="geometry_msgs::msg::dds_::Transform_"):
    translation: Vector
    rotation: Quaternion


@dataclass
@final
class TransformStamped(IdlStruct, typename="geometry_msgs::msg::dds_::TransformStamped_"):
    header: Header
    child_frame_id: str
    transform: Transform


@dataclass
@final
class Transforms(IdlStruct, typename="tf2_msgs::msg::dds_::TFMessage_"):
    transforms: types.sequence[TransformStamped]


for kind in (Time, Header, Vector, Quaternion, Transform, TransformStamped, Transforms):
    kind.__idl__.xcdrv2_supported = False
participant = DomainParticipant(0)


def reader(topic, *policies):
    qos = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(100), *policies,
              Policy.DataRepresentation(use_cdrv0_representation=True))
    return DataReader(participant, Topic(participant, topic, Transforms, qos=qos), qos=qos)


moving, fixed = reader("rt/tf"), reader("rt/tf_static", Policy.Durability.TransientLocal)
print(json.dumps({"up": True}), flush=True)
end, found = time.monotonic() + 2, {}
while time.monotonic() < end:
    for transforms in [*moving.take(N=100), *fixed.take(N=100)]:
        for of in transforms.transforms:
            at, turn = of.transform.translation, of.transform.rotation
            found[f"{of.header.frame_id} {of.child_frame_id}"] = [round(number, 3) for number in (at.x, at.y, turn.z, turn.w)]
    time.sleep(0.01)
print(json.dumps(found))
