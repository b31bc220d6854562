"""Reads the transforms of a robot on Cyclone DDS (packages as for cyclone_ros.py), for two seconds: which frames are
where.
"""
import time

from cyclone_nav2 import Header, Quaternion, Vector3
from cyclone_ros import made, struct, take
from cyclonedds.core import Policy
from cyclonedds.idl import types
from cyclonedds.sub import DataReader
from lines import say

geometry = "geometry_msgs::msg::dds_::"
Transform = struct(f"{geometry}Transform_", translation=Vector3, rotation=Quaternion)
TransformStamped = struct(f"{geometry}TransformStamped_", header=Header, child_frame_id=str, transform=Transform)
Transforms = struct("tf2_msgs::msg::dds_::TFMessage_", transforms=types.sequence[TransformStamped])
all_of_them = Policy.Reliability.Reliable(10**9), Policy.History.KeepLast(100)
moving = made(DataReader, "rt/tf", Transforms, *all_of_them)
fixed = made(DataReader, "rt/tf_static", Transforms, *all_of_them, Policy.Durability.TransientLocal)
say({"up": True})
end, found = time.monotonic() + 2, {}
while time.monotonic() < end:
    for transforms in [*take(moving), *take(fixed)]:
        for of in transforms.transforms:
            at, turn = of.transform.translation, of.transform.rotation
            numbers = [round(number, 3) for number in (at.x, at.y, turn.z, turn.w)]
            found[f"{of.header.frame_id} {of.child_frame_id}"] = numbers
    time.sleep(0.01)
say(found)
