"""A client that is not ours of the action navigate_to_pose, on Cyclone DDS (packages as for cyclone_ros.py). Each line
of its input asks it for something, and it prints what came of it, as goals.py does:

    waits               whether there is a server
    goes X Y DEGREES    sends a goal and awaits its end
    cancels X Y DEGREES SECONDS    and cancels it so many seconds later
    asks                for the result of a goal that nobody has sent, and to cancel it
"""
import math, os, time

from cyclone_actions import Action, GoalInfo, Id, key
from cyclone_nav2 import NAVIGATE_TO_POSE, Header, Point, Pose, PoseStamped, Quaternion
from cyclone_ros import Client, Time, take
from lines import answer

PATIENCE_S = 30
navigate = Action(Client, *NAVIGATE_TO_POSE)


class Trip:
    def __init__(self, x, y, degrees):
        turned, self.id = math.radians(degrees) / 2, Id(list(os.urandom(16)))
        pose = Pose(Point(x, y, 0.0), Quaternion(0.0, 0.0, math.sin(turned), math.cos(turned)))
        goal = navigate.Goal(PoseStamped(Header(Time(0, 0), "map"), pose), "")
        response = navigate.send_goal.response(navigate.send_goal.send(goal_id=self.id, goal=goal))
        self.accepted = response and response.accepted
        self.ending, self.left_m, self.statuses = navigate.get_result.send(goal_id=self.id), [], []

    def hear(self):
        own = [of.feedback for of in take(navigate.feedback) if key(of.goal_id) == key(self.id)]
        self.left_m += [feedback.distance_remaining for feedback in own]
        for message in take(navigate.statuses):
            for of in message.status_list:
                if key(of.goal_info.goal_id) == key(self.id) and self.statuses[-1:] != [of.status]:
                    self.statuses.append(of.status)

    def cancel(self):
        info = GoalInfo(self.id, Time(0, 0))
        answer = navigate.cancel_goal.response(navigate.cancel_goal.send(goal_info=info))
        return answer and [answer.return_code, [key(of.goal_id) == key(self.id) for of in answer.goals_canceling]]

    def end(self):
        if not self.accepted:
            return {"accepted": self.accepted, "statuses": self.statuses}
        end, until = None, time.monotonic() + PATIENCE_S
        while time.monotonic() < until and (end is None or self.statuses[-1:] != [end.status]):
            end = navigate.get_result.response(self.ending, 0.01)
            self.hear()
        return {"accepted": True, "statuses": self.statuses, "feedback": len(self.left_m),
                "left_m": [round(left, 2) for left in self.left_m[:: len(self.left_m) - 1 or 1]],
                "status": end and end.status, "error_code": end and end.result.error_code,
                "error_msg": end and end.result.error_msg}


def waits():
    endpoints = [navigate.send_goal, navigate.get_result, navigate.cancel_goal]
    matched = lambda: [len(of.requests.get_matched_subscriptions()) and len(of.responses.get_matched_publications())
                       for of in endpoints]
    until = time.monotonic() + PATIENCE_S
    while not all(matched()) and time.monotonic() < until:
        time.sleep(0.05)
    return {"server": all(matched())}


def goes(*goal):
    return Trip(*goal).end()


def cancels(x, y, degrees, seconds):
    trip, until = Trip(x, y, degrees), time.monotonic() + seconds
    while time.monotonic() < until:
        trip.hear()
        time.sleep(0.01)
    canceled = trip.cancel()
    return {**trip.end(), "canceled": canceled, "canceled_again": trip.cancel()}


def asks():
    nobody = Id(list(os.urandom(16)))
    end = navigate.get_result.response(navigate.get_result.send(goal_id=nobody))
    info = GoalInfo(nobody, Time(0, 0))
    canceled = navigate.cancel_goal.response(navigate.cancel_goal.send(goal_info=info))
    return {"status": end and end.status, "error_code": end and end.result.error_code,
            "canceled": canceled and [canceled.return_code, len(canceled.goals_canceling)]}


answer(waits, goes, cancels, asks, read=float)
