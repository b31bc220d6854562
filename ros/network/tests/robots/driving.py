"""How a navigation that is not ours drives, whatever its middleware: the messages of each have the same fields. It
plans on the map with A*, follows its path by where localization sees the robot, waits for what is in the way, turns as
the goal asks unless its orientation is all zeros, and gives up where it makes no progress.

It acts on each estimate of localization, and knows no other time, so the robot's may pass at any speed. So many seconds
after it has begun with a goal, it can misbehave: it `aborts`; it `hangs`, so that not even a canceled goal ends; or it
`dies` without a word. If it `rejects`, then every goal.
"""
import argparse, heapq, math, os
from collections import namedtuple

import numpy

CELL_M, ROBOT_M, WIDE_M = 0.1, 0.45, 0.8  # the cells of plans; how far from walls the robot must be, and is best
SPEED, TURN, AHEAD_M, LOST_M, PATIENCE_S = 0.45, 1.0, 0.5, 1.0, 30.0
GOAL_M, GOAL_RAD = 0.2, 0.05
STEPS = [((y, x), CELL_M * math.hypot(y, x)) for y in (-1, 0, 1) for x in (-1, 0, 1) if y or x]

Going = namedtuple("Going", "speed turn left_m seconds")
End = namedtuple("End", "how code why")
# The codes are those of Nav2.
SUCCEEDED, CANCELED = End("succeed", 0, ""), End("canceled", 0, "")
NEWER, MISBEHAVES = End("abort", 100, "a newer goal has come"), End("abort", 100, "it misbehaves")
NO_PROGRESS, NO_PATH = End("abort", 105, "it makes no progress"), End("abort", 208, "no path leads to the goal")


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


class Driver:
    """What is known of the robot: the floor once the map has come, and how far the robot can go straight on."""

    def __init__(self, misbehaves=None, after_s=0.0):
        self.misbehaves, self.after_s, self.floor, self.room_m = misbehaves, after_s, None, math.inf

    def take_map(self, grid):
        self.floor = Floor(grid)

    def take_scan(self, scan):
        if scan.header.frame_id.endswith("front"):
            ranges = numpy.array(scan.ranges)
            [seen] = numpy.nonzero(numpy.isfinite(ranges) & (ranges >= scan.range_min))
            angles = scan.angle_min + scan.angle_increment * seen
            x, y = ranges[seen] * numpy.cos(angles), ranges[seen] * numpy.sin(angles)
            self.room_m = min(x[(x > 0) & (abs(y) < ROBOT_M - 0.1)], default=math.inf)

    def would_go(self, to):
        """Whether it accepts a goal: one that is on the map, and in no wall."""
        place = to.pose.position.x, to.pose.position.y
        in_wall = self.floor and self.floor.solid.flat[self.floor.away(place).argmin()]
        return not in_wall and to.header.frame_id == "map" and self.misbehaves != "rejects"


class Trip:
    """The way to a goal. Each pose of the robot is a step of it."""

    def __init__(self, driver, to):
        self.driver, self.to, self.began, self.path, self.arrived = driver, to, None, [], False

    def step(self, stamped, stop=None):
        """How the robot drives on from a pose, or how the trip ends: as `stop` says, unless it is None."""
        stamp, pose, to = stamped.header.stamp, stamped.pose.pose, (self.to.position.x, self.to.position.y)
        now, at = stamp.sec + stamp.nanosec * 1e-9, (pose.position.x, pose.position.y)
        self.began = now if self.began is None else self.began
        if self.driver.misbehaves and now >= self.began + self.driver.after_s:
            if self.driver.misbehaves == "dies":
                os._exit(1)
            return MISBEHAVES if self.driver.misbehaves == "aborts" else None
        if stop or self.driver.floor is None:
            return stop
        if not self.path or math.dist(self.path[self.passed], at) > LOST_M:
            self.path, self.passed, self.least_m, self.progress_s = self.driver.floor.path(at, to), 0, math.inf, now
            if self.path is None:
                return NO_PATH
        path, passed = self.path, range(self.passed, min(self.passed + 20, len(self.path)))
        self.passed = passed = min(passed, key=lambda index: math.dist(path[index], at))
        left_m = math.dist(path[passed], at) + sum(map(math.dist, path[passed:], path[passed + 1 :]))
        if left_m < self.least_m - GOAL_M:
            self.least_m, self.progress_s = left_m, now
        if now > self.progress_s + PATIENCE_S:
            return NO_PROGRESS
        self.arrived = self.arrived or math.dist(at, to) < GOAL_M
        turned = heading(pose.orientation)
        ahead = path[min(passed + round(AHEAD_M / CELL_M), len(path) - 1)]
        way = math.atan2(ahead[1] - at[1], ahead[0] - at[0])
        off = math.remainder((heading(self.to.orientation, turned) if self.arrived else way) - turned, math.tau)
        if self.arrived and abs(off) < GOAL_RAD:
            return SUCCEEDED
        goes = not self.arrived and abs(off) < 0.7
        speed = max(0.0, min(SPEED * math.cos(off), self.driver.room_m - 0.2, left_m)) if goes else 0.0
        return Going(float(speed), max(-TURN, min(TURN, 1.5 * off)), left_m, now - self.began)


def heading(orientation, otherwise=0.0):
    return 2 * math.atan2(orientation.z, orientation.w) if orientation.z or orientation.w else otherwise


def driver(words):
    """The driver that the words of a command line ask for."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--misbehave", choices=["rejects", "aborts", "hangs", "dies"])
    parser.add_argument("--after", type=float, default=0.0)
    options = parser.parse_args(words)
    return Driver(options.misbehave, options.after)
