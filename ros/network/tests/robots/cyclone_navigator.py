"""The same navigation as navigator.py, on Cyclone DDS (packages as for cyclone_ros.py, and numpy)."""
import sys, time

from cyclone_actions import ABORTED, CANCELED, CANCELING, SUCCEEDED, ActionServer
from cyclone_nav2 import (NAVIGATE_TO_POSE, LaserScan, OccupancyGrid, PoseStamped, PoseWithCovarianceStamped, Twist,
                          Vector3, duration)
from cyclone_ros import LATCHED, NEWEST, made, take
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from driving import CANCELED as IS_CANCELED
from driving import NEWER, SPEED, End, Going, Trip, driver
from lines import say

STATUSES = {"succeed": SUCCEEDED, "canceled": CANCELED, "abort": ABORTED}
driver = driver(sys.argv[1:])
commands = made(DataWriter, "rt/cmd_vel", Twist)
maps = made(DataReader, "rt/map", OccupancyGrid, *LATCHED)
scans = made(DataReader, "rt/scan", LaserScan, *NEWEST)
poses = made(DataReader, "rt/amcl_pose", PoseWithCovarianceStamped, *NEWEST)
navigate = ActionServer({"error_code": 0, "error_msg": ""}, *NAVIGATE_TO_POSE)


def drive(speed, turn):
    commands.write(Twist(Vector3(speed, 0.0, 0.0), Vector3(0.0, 0.0, turn)))


def go_on(goal, trip, pose, is_newest):
    """Whether the trip to a goal goes on."""
    next = trip.step(pose, IS_CANCELED if goal.status == CANCELING else None if is_newest else NEWER)
    if isinstance(next, Going):
        drive(next.speed, next.turn)
        goal.give_feedback(
            current_pose=PoseStamped(pose.header, pose.pose.pose), navigation_time=duration(next.seconds),
            estimated_time_remaining=duration(next.left_m / SPEED), number_of_recoveries=0,
            distance_remaining=next.left_m)
    if isinstance(next, End):
        is_newest and drive(0.0, 0.0)
        goal.end(STATUSES[next.how], error_code=next.code, error_msg=next.why)
    return not isinstance(next, End)


trips = []
say({"up": True})
while True:
    for grid in take(maps):
        driver.take_map(grid)
    for scan in take(scans):
        driver.take_scan(scan)
    goals = navigate.take(lambda goal: driver.would_go(goal.pose))
    trips += [(goal, Trip(driver, goal.request.pose.pose)) for goal in goals]
    for pose in take(poses)[-1:]:
        trips = [(goal, trip) for goal, trip in trips if go_on(goal, trip, pose, goal is trips[-1][0])]
    time.sleep(0.002)
