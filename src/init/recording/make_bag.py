#!/usr/bin/env python3
"""Makes `nav2.mcap`, a one-minute recording of a robot driven by Nav2 (pip install rosbags): `make_bag.py FOLDER`."""
import math
import shutil
import sys
import tempfile
from pathlib import Path

import numpy as np
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

STORE = get_typestore(Stores.ROS2_JAZZY)
STORE.register(get_types_from_msg("""
geometry_msgs/PoseStamped current_pose
builtin_interfaces/Duration navigation_time
builtin_interfaces/Duration estimated_time_remaining
int16 number_of_recoveries
float32 distance_remaining
""", "nav2_msgs/action/NavigateToPose_Feedback"))
STORE.register(get_types_from_msg("""
unique_identifier_msgs/UUID goal_id
nav2_msgs/action/NavigateToPose_Feedback feedback
""", "nav2_msgs/action/NavigateToPose_FeedbackMessage"))
START_S = 1_760_000_000
EXECUTING, SUCCEEDED, ABORTED = 2, 4, 6


def of(name, **fields):
    return STORE.types[name](**fields)


def stamp(at_s):
    return of("builtin_interfaces/msg/Time", sec=START_S + int(at_s), nanosec=round(at_s % 1 * 1e9))


def header(at_s, frame):
    return of("std_msgs/msg/Header", stamp=stamp(at_s), frame_id=frame)


def vector(x, y=0.0, z=0.0):
    return of("geometry_msgs/msg/Vector3", x=x, y=y, z=z)


def pose(at_s, x):
    turned = of("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.0, w=1.0)
    here = of("geometry_msgs/msg/Pose", position=of("geometry_msgs/msg/Point", x=x, y=0.0, z=0.0), orientation=turned)
    return of("geometry_msgs/msg/PoseStamped", header=header(at_s, "map"), pose=here)


def uuid(number):
    return of("unique_identifier_msgs/msg/UUID", uuid=np.full(16, number, dtype=np.uint8))


def speed(at_s):
    """It drives to two goals, and does not slow down when its battery is low."""
    return 0.4 if 3 <= at_s < 22 or 26 <= at_s < 52 else 0.0


def messages():
    """Time, topic, type, message."""
    goals = []
    for half_second in range(120):
        at = half_second / 2
        x = sum(speed(before / 2) / 2 for before in range(half_second))
        if at in (2, 25):
            yield at, "/goal_pose", "geometry_msgs/msg/PoseStamped", pose(at, 8.0 if at == 2 else 20.0)
            goals.append([at, EXECUTING])
        if at in (22, 52):
            goals[-1][1] = SUCCEEDED if at == 22 else ABORTED
        if at in (2, 22, 25, 52):
            def status(number, began, status):
                info = of("action_msgs/msg/GoalInfo", goal_id=uuid(number + 1), stamp=stamp(began))
                return of("action_msgs/msg/GoalStatus", goal_info=info, status=status)
            listed = [status(number, *goal) for number, goal in enumerate(goals)]
            name = "action_msgs/msg/GoalStatusArray"
            yield at + 0.01, "/navigate_to_pose/_action/status", name, of(name, status_list=listed)
        if goals and goals[-1][1] == EXECUTING and at % 1 == 0:
            began = goals[-1][0]
            span = of("builtin_interfaces/msg/Duration", sec=int(at - began), nanosec=0)
            feedback = of("nav2_msgs/action/NavigateToPose_Feedback", current_pose=pose(at, x), navigation_time=span,
                          estimated_time_remaining=span, number_of_recoveries=1 if at >= 45 else 0,
                          distance_remaining=(8.0 if began == 2 else 20.0) - x)
            name = "nav2_msgs/action/NavigateToPose_FeedbackMessage"
            yield at + 0.02, "/navigate_to_pose/_action/feedback", name, of(name, goal_id=uuid(len(goals)), feedback=feedback)
        name = "geometry_msgs/msg/Twist"
        yield at + 0.03, "/cmd_vel", name, of(name, linear=vector(speed(at)), angular=vector(0.0, 0.0, 0.1 * (at in (10, 30))))
        if at % 2 == 0:
            none, empty = math.nan, np.array([], dtype=np.float32)
            name = "sensor_msgs/msg/BatteryState"
            yield at + 0.04, "/battery_state", name, of(
                name, header=header(at, "base_link"), voltage=24.0 - at / 30, temperature=none, current=-2.0, charge=none,
                capacity=none, design_capacity=none, percentage=0.3 - at / 400, power_supply_status=2, power_supply_health=1,
                power_supply_technology=2, present=True, cell_voltage=empty, cell_temperature=empty, location="", serial_number="")


def main():
    folder = Path(tempfile.mkdtemp()) / "bag"
    bag = Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP)
    bag.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    with bag:
        topics = {}
        for at_s, topic, name, message in messages():
            if topic not in topics:
                # Like most versions of rosbag2, this one leaves out what an action defines.
                definition = {"typestore": STORE} if "/msg/" in name else {"msgdef": "", "rihs01": "RIHS01_" + "0" * 64}
                topics[topic] = bag.add_connection(topic, name, **definition)
            time_ns = START_S * 1_000_000_000 + round(at_s * 1e9)
            bag.write(topics[topic], time_ns, STORE.serialize_cdr(message, name))
    [file] = folder.glob("*.mcap")
    shutil.copy(file, Path(sys.argv[1]) / "nav2.mcap")
    shutil.rmtree(folder.parent)


main()
