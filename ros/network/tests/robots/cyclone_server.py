"""A server that is not ours, on Cyclone DDS (pip install cyclonedds): what a node on rmw_cyclonedds in the namespace
/helper would have. There, a request begins with its client and a number, and its response with the same.

It says "ready" on the latched topic `told`, serves `switch`, and counts for `count`: every 0.2 s a number and feedback.
With `--misbehave`, it rejects or aborts goals; it hangs, so that not even a canceled goal ends; it dies without a word
while it counts; it responds to everything twice; or it switches late, after 3 s. Each request is a line that it prints.
"""
import argparse, json, os, time
from threading import Timer

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import make_idl_struct, types
from cyclonedds.idl.annotations import final
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

EXECUTING, CANCELING, SUCCEEDED, CANCELED, ABORTED = range(2, 7)  # action_msgs/msg/GoalStatus
ACCEPTED, UNKNOWN_GOAL, TERMINATED = 0, 2, 3  # action_msgs/srv/CancelGoal
COUNT_S, LATE_S = 0.2, 3.0


def struct(typename, **fields):
    kind = final(make_idl_struct(typename.split("::")[-1], typename, fields))
    kind.__idl__.xcdrv2_supported = False
    return kind


Header = struct("Header", client=types.uint64, number=types.int64)
Time = struct("builtin_interfaces::msg::dds_::Time_", sec=types.int32, nanosec=types.uint32)
Id = struct("unique_identifier_msgs::msg::dds_::UUID_", uuid=types.array[types.uint8, 16])
GoalInfo = struct("action_msgs::msg::dds_::GoalInfo_", goal_id=Id, stamp=Time)
Order = struct("test_msgs::action::dds_::Fibonacci_Goal_", order=types.int32)
Result = struct("test_msgs::action::dds_::Fibonacci_Result_", sequence=types.sequence[types.int32])
Feedback = struct("test_msgs::action::dds_::Fibonacci_Feedback_", sequence=types.sequence[types.int32])
FeedbackMessage = struct("test_msgs::action::dds_::Fibonacci_FeedbackMessage_", goal_id=Id, feedback=Feedback)
String = struct("std_msgs::msg::dds_::String_", data=str)


def made(make, name, kind, *policies):
    """A reader or a writer, which has the QoS of rmw's services if it gets no other policies."""
    policies = policies or (Policy.Durability.Volatile, Policy.History.KeepLast(10))
    qos = Qos(*policies, Policy.Reliability.Reliable(max_blocking_time=10**9),
              Policy.DataRepresentation(use_cdrv0_representation=True))
    return make(participant, Topic(participant, name, kind, qos=qos), qos=qos)


def say(**line):
    print(json.dumps(line), flush=True)


class Service:
    def __init__(self, name, kind, request, response):
        self.response = struct(f"{kind}_Response_", header=Header, **response)
        self.responses = made(DataWriter, f"rr{name}Reply", self.response)
        self.requests = made(DataReader, f"rq{name}Request", struct(f"{kind}_Request_", header=Header, **request))

    def take(self):
        return [request for request in self.requests.take(N=100) if request.sample_info.valid_data]

    def respond(self, request, **fields):
        for _ in range(2 if misbehaves == "twice" else 1):
            self.responses.write(self.response(header=request.header, **fields))


class Goal:
    def __init__(self, request):
        self.id, self.order, self.numbers = request.goal_id, request.goal.order, [0, 1]
        self.status, self.due, self.asking = EXECUTING, time.monotonic(), []

    def go_on(self):
        counted = len(self.numbers) - 2
        if self.status < SUCCEEDED and time.monotonic() >= self.due and misbehaves != "hangs":
            if misbehaves == "dies" and counted == 2:
                os._exit(1)
            elif self.status == CANCELING:
                self.status = CANCELED
            elif misbehaves == "aborts" and counted == 2:
                self.status = ABORTED
            elif counted >= self.order:
                self.status = SUCCEEDED
            else:
                self.numbers.append(sum(self.numbers[-2:]))
                feedback.write(FeedbackMessage(self.id, Feedback(self.numbers)))
                self.due += COUNT_S
        while self.asking and self.status >= SUCCEEDED:
            get_result.respond(self.asking.pop(), status=self.status, result=Result(self.numbers))


parser = argparse.ArgumentParser()
parser.add_argument("--misbehave", choices=["rejects", "aborts", "hangs", "dies", "twice", "late"])
misbehaves = parser.parse_args().misbehave
participant, goals = DomainParticipant(int(os.environ.get("ROS_DOMAIN_ID", "0"))), {}
switch = Service("/helper/switch", "std_srvs::srv::dds_::SetBool", {"data": bool}, {"success": bool, "message": str})
at, kind = "/helper/count/_action", "test_msgs::action::dds_::Fibonacci"
send_goal = Service(f"{at}/send_goal", f"{kind}_SendGoal", {"goal_id": Id, "goal": Order},
                    {"accepted": bool, "stamp": Time})
get_result = Service(f"{at}/get_result", f"{kind}_GetResult", {"goal_id": Id}, {"status": types.int8, "result": Result})
cancel_goal = Service(f"{at}/cancel_goal", "action_msgs::srv::dds_::CancelGoal", {"goal_info": GoalInfo},
                      {"return_code": types.int8, "goals_canceling": types.sequence[GoalInfo]})
feedback = made(DataWriter, f"rt{at}/feedback", FeedbackMessage)
told = made(DataWriter, "rt/helper/told", String, Policy.Durability.TransientLocal, Policy.History.KeepLast(1))
told.write(String("ready"))
say(up=True)
while True:
    for request in switch.take():
        say(switch=request.data)
        fields = {"success": request.data, "message": "switched"}
        Timer(LATE_S if misbehaves == "late" else 0.0, switch.respond, [request], fields).start()
    for request in send_goal.take():
        say(count=request.goal.order)
        send_goal.respond(request, accepted=misbehaves != "rejects", stamp=Time(0, 0))
        if misbehaves != "rejects":
            goals[bytes(request.goal_id.uuid)] = Goal(request)
    for request in cancel_goal.take():
        say(cancel=True)
        goal = goals.get(bytes(request.goal_info.goal_id.uuid))
        code = UNKNOWN_GOAL if goal is None else TERMINATED if goal.status >= SUCCEEDED else ACCEPTED
        cancel_goal.respond(request, return_code=code, goals_canceling=[] if code else [request.goal_info])
        if code == ACCEPTED:
            goal.status = CANCELING
    for request in get_result.take():
        if goal := goals.get(bytes(request.goal_id.uuid)):
            goal.asking.append(request)
        else:
            get_result.respond(request, status=0, result=Result([]))
    for goal in goals.values():
        goal.go_on()
    time.sleep(0.01)
