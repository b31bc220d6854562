"""A server that is not ours, on Cyclone DDS (packages as for cyclone_ros.py): what a node on rmw_cyclonedds in the
namespace /helper would have.

It says "ready" on the latched topic `told`, serves `switch`, and counts for `count`: every 0.2 s a number and feedback.
With `--misbehave`, it rejects or aborts goals; it hangs, so that not even a canceled goal ends; it dies without a word
while it counts; it responds to everything twice; or it switches late, after 3 s.
"""
import argparse, os, time
from threading import Timer

from cyclone_actions import ABORTED, CANCELED, CANCELING, SUCCEEDED, ActionServer
from cyclone_ros import LATCHED, Service, made, struct
from cyclonedds.idl import types
from cyclonedds.pub import DataWriter
from lines import say

COUNT_S, LATE_S = 0.2, 3.0
Numbers = {"sequence": types.sequence[types.int32]}
String = struct("std_msgs::msg::dds_::String_", data=str)


class Count:
    def __init__(self, goal):
        self.goal, self.numbers, self.due = goal, [0, 1], time.monotonic()

    def go_on(self):
        counted = len(self.numbers) - 2
        if self.goal.status < SUCCEEDED and time.monotonic() >= self.due and misbehaves != "hangs":
            if misbehaves == "dies" and counted == 2:
                os._exit(1)
            elif self.goal.status == CANCELING:
                self.goal.end(CANCELED, sequence=self.numbers)
            elif misbehaves == "aborts" and counted == 2:
                self.goal.end(ABORTED, sequence=self.numbers)
            elif counted >= self.goal.request.order:
                self.goal.end(SUCCEEDED, sequence=self.numbers)
            else:
                self.numbers.append(sum(self.numbers[-2:]))
                self.goal.give_feedback(sequence=self.numbers)
                self.due += COUNT_S
                if counted == 2:
                    say({"counts": True})


parser = argparse.ArgumentParser()
parser.add_argument("--misbehave", choices=["rejects", "aborts", "hangs", "dies", "twice", "late"])
misbehaves = parser.parse_args().misbehave
Service.responses_each = 2 if misbehaves == "twice" else 1
switch = Service("/helper/switch", "std_srvs::srv::dds_::SetBool", {"data": bool}, {"success": bool, "message": str})
kind, order = "test_msgs::action::dds_::Fibonacci", {"order": types.int32}
count, counts = ActionServer({"sequence": []}, "/helper/count", kind, order, Numbers, Numbers), []
told = made(DataWriter, "rt/helper/told", String, *LATCHED)
told.write(String("ready"))
say({"up": True})
while True:
    for request in switch.take():
        fields = {"success": request.data, "message": "switched"}
        Timer(LATE_S if misbehaves == "late" else 0.0, switch.respond, [request], fields).start()
    counts += [Count(goal) for goal in count.take(lambda _: misbehaves != "rejects")]
    for goal in counts:
        goal.go_on()
    time.sleep(0.01)
