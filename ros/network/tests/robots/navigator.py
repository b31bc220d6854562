"""A navigation that is not ours: `navigator.py [--misbehave HOW] [--after SECONDS]` serves the action navigate_to_pose
(packages as for driver.py, and nav2_msgs). It plans on the latched map with A*, follows its path by where localization
sees the robot, waits for what is in the way, turns as the goal asks unless its orientation is all zeros, and gives up
where it makes no progress. A newer goal aborts an older one; a goal that is not on free floor is rejected.

It acts on each estimate of localization, and knows no other time, so the robot's may pass at any speed. So many seconds
after it has begun with a goal, it can misbehave: it `aborts`; it `hangs`, so that not even a canceled goal ends; or it
`dies` without a word. If it `rejects`, then every goal.
"""
import argparse, heapq, json, math, os, sys

import numpy, rclpy
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped, Twist
from nav2_msgs.action import NavigateToPose
from nav_msgs.msg import OccupancyGrid
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.task import Future
from rclpy.utilities import remove_ros_args
from sensor_msgs.msg import LaserScan

CELL_M, ROBOT_M, WIDE_M = 0.1, 0.45, 0.8  # the cells of plans; how far from walls the robot must be, and is best
SPEED, TURN, AHEAD_M, LOST_M, PATIENCE_S = 0.45, 1.0, 0.5, 1.0, 30.0
GOAL_M, GOAL_RAD = 0.2, 0.05
OTHER, NO_PROGRESS, NO_PATH = 100, 105, 208  # as Nav2 numbers them
STEPS = [((y, x), CELL_M * math.hypot(y, x)) for y in (-1, 0, 1) for x in (-1, 0, 1) if y or x]


class Floor:
    """The map in cells of CELL_M, with a wall around it: where they are, and what it costs to cross them."""

    def __init__(self, grid):
        info, times = grid.info, round(CELL_M / grid.info.resolution)
        solid = numpy.array(grid.data, dtype=numpy.int8).reshape(info.height, info.width) != 0
        solid = numpy.pad(solid, [(times, times - length % times) for length in solid.shape], constant_values=True)
        self.solid = solid.reshape(solid.shape[0] // times, times, -1, times).any(axis=(1, 3))
        rows, columns = numpy.indices(self.solid.shape)
        self.xs = info.origin.position.x + (columns - 0.5) * CELL_M
        self.ys = info.origin.position.y + (rows - 0.5) * CELL_M
        room = numpy.where(self.solid, 0.0, math.inf)
        for _ in range(round(WIDE_M / CELL_M)):
            room = numpy.min([room, *(numpy.roll(room, step, (0, 1)) + length for step, length in STEPS)], axis=0)
        self.cost = numpy.where(room < ROBOT_M, math.inf, 1.0 + 5.0 * numpy.maximum(0.0, WIDE_M - room))

    def away(self, place):
        """How far each cell is from a place."""
        return numpy.hypot(self.xs - place[0], self.ys - place[1])

    def path(self, start, goal):
        """Points from a place to another, or None. Where the robot stands, it may be nearer to walls than elsewhere."""
        near = (self.away(start) < 2 * ROBOT_M) & ~self.solid
        cost = numpy.where(near, numpy.minimum(self.cost, 10.0), self.cost).ravel().tolist()
        left, here, done = self.away(goal).ravel().tolist(), int(self.away(start).argmin()), set()
        before, spent, queue = {here: None}, {here: 0.0}, [(0.0, here)]
        steps = [(y * self.solid.shape[1] + x, length) for (y, x), length in STEPS]
        while queue:
            here = heapq.heappop(queue)[1]
            if left[here] < GOAL_M / 2:
                points = []
                while here is not None:
                    points.append((float(self.xs.flat[here]), float(self.ys.flat[here])))
                    here = before[here]
                return points[::-1]
            if here not in done:
                done.add(here)
                for step, length in steps:
                    there, so_far = here + step, spent[here] + length * cost[here + step]
                    if so_far < spent.get(there, math.inf):
                        spent[there], before[there] = so_far, here
                        heapq.heappush(queue, (so_far + left[there], there))
        return None


class Navigator(Node):
    def __init__(self, misbehaves, after_s):
        super().__init__("navigator", parameter_overrides=[Parameter("use_sim_time", value=True)])
        self.misbehaves, self.after_s = misbehaves, after_s
        self.floor, self.pose, self.room_m, self.goal, self.sensed = None, None, math.inf, None, Future()
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        newest = QoSProfile(depth=2, reliability=ReliabilityPolicy.BEST_EFFORT)
        self.commands = self.create_publisher(Twist, "cmd_vel", 1)
        self.create_subscription(OccupancyGrid, "map", lambda grid: setattr(self, "floor", Floor(grid)), latched)
        self.create_subscription(LaserScan, "scan", self.take_scan, newest)
        self.create_subscription(PoseWithCovarianceStamped, "amcl_pose", self.take_pose, newest)
        ActionServer(self, NavigateToPose, "navigate_to_pose", self.navigate, goal_callback=self.judge,
                     cancel_callback=lambda _: CancelResponse.ACCEPT)

    def take_scan(self, scan):
        """How far the robot can go straight on, as the laser in front sees it."""
        if scan.header.frame_id.endswith("front"):
            ranges = numpy.array(scan.ranges)
            [seen] = numpy.nonzero(numpy.isfinite(ranges) & (ranges >= scan.range_min))
            angles = scan.angle_min + scan.angle_increment * seen
            x, y = ranges[seen] * numpy.cos(angles), ranges[seen] * numpy.sin(angles)
            self.room_m = min(x[(x > 0) & (abs(y) < ROBOT_M - 0.1)], default=math.inf)

    def take_pose(self, pose):
        self.pose, sensed, self.sensed = pose, self.sensed, Future()
        sensed.set_result(None)

    def judge(self, goal):
        at = goal.pose.pose.position
        in_wall = self.floor and self.floor.solid.flat[self.floor.away((at.x, at.y)).argmin()]
        odd = in_wall or goal.pose.header.frame_id != "map" or self.misbehaves == "rejects"
        return GoalResponse.REJECT if odd else GoalResponse.ACCEPT

    async def navigate(self, goal):
        self.goal, target, began, path, arrived = goal, goal.request.pose.pose, None, [], False
        to = target.position.x, target.position.y
        while True:
            await self.sensed
            if self.floor is None:
                continue
            stamp, pose = self.pose.header.stamp, self.pose.pose.pose
            now, at = stamp.sec + stamp.nanosec * 1e-9, (pose.position.x, pose.position.y)
            began = now if began is None else began
            if self.misbehaves and now >= began + self.after_s:
                if self.misbehaves == "aborts":
                    return self.end(goal, goal.abort, OTHER, "it misbehaves")
                if self.misbehaves == "dies":
                    os._exit(1)
                continue
            if goal.is_cancel_requested:
                return self.end(goal, goal.canceled)
            if self.goal is not goal:
                return self.end(goal, goal.abort, OTHER, "a newer goal has come")
            if not path or math.dist(path[passed], at) > LOST_M:
                path, passed, least_m, progress_s = self.floor.path(at, to), 0, math.inf, now
                if path is None:
                    return self.end(goal, goal.abort, NO_PATH, "no path leads to the goal")
            passed = min(range(passed, min(passed + 20, len(path))), key=lambda index: math.dist(path[index], at))
            left_m = math.dist(path[passed], at) + sum(map(math.dist, path[passed:], path[passed + 1 :]))
            if left_m < least_m - GOAL_M:
                least_m, progress_s = left_m, now
            if now > progress_s + PATIENCE_S:
                return self.end(goal, goal.abort, NO_PROGRESS, "it makes no progress")
            arrived = arrived or math.dist(at, to) < GOAL_M
            turned = heading(pose.orientation)
            ahead = path[min(passed + round(AHEAD_M / CELL_M), len(path) - 1)]
            aim = heading(target.orientation, turned) if arrived else math.atan2(ahead[1] - at[1], ahead[0] - at[0])
            off = math.remainder(aim - turned, math.tau)
            if arrived and abs(off) < GOAL_RAD:
                return self.end(goal, goal.succeed)
            goes = not arrived and abs(off) < 0.7
            self.drive(max(0.0, min(SPEED * math.cos(off), self.room_m - 0.2, left_m)) if goes else 0.0, 1.5 * off)
            goal.publish_feedback(NavigateToPose.Feedback(
                current_pose=PoseStamped(header=self.pose.header, pose=pose), distance_remaining=left_m,
                navigation_time=Duration(seconds=now - began).to_msg(),
                estimated_time_remaining=Duration(seconds=left_m / SPEED).to_msg()))

    def drive(self, speed, turn):
        command = Twist()
        command.linear.x, command.angular.z = float(speed), max(-TURN, min(TURN, turn))
        self.commands.publish(command)

    def end(self, goal, how, code=NavigateToPose.Result.NONE, why=""):
        if self.goal is goal:
            self.drive(0.0, 0.0)
        how()
        return NavigateToPose.Result(error_code=code, error_msg=why)


def heading(orientation, otherwise=0.0):
    return 2 * math.atan2(orientation.z, orientation.w) if orientation.z or orientation.w else otherwise


parser = argparse.ArgumentParser()
parser.add_argument("--misbehave", choices=["rejects", "aborts", "hangs", "dies"])
parser.add_argument("--after", type=float, default=0.0)
options = parser.parse_args(remove_ros_args(sys.argv)[1:])
rclpy.init(args=sys.argv)
node = Navigator(options.misbehave, options.after)
print(json.dumps({"up": True}), flush=True)
rclpy.spin(node)
