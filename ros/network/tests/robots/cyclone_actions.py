"""Actions on Cyclone DDS, as a node on rmw_cyclonedds has them: three services and two topics."""
from cyclone_ros import LATCHED, Service, Time, made, struct
from cyclonedds.idl import types

UNKNOWN, ACCEPTED, EXECUTING, CANCELING, SUCCEEDED, CANCELED, ABORTED = range(7)  # action_msgs/msg/GoalStatus
NO_ERROR, REJECTED, UNKNOWN_GOAL, TERMINATED = range(4)  # action_msgs/srv/CancelGoal
Id = struct("unique_identifier_msgs::msg::dds_::UUID_", uuid=types.array[types.uint8, 16])
GoalInfo = struct("action_msgs::msg::dds_::GoalInfo_", goal_id=Id, stamp=Time)
GoalStatus = struct("action_msgs::msg::dds_::GoalStatus_", goal_info=GoalInfo, status=types.int8)
GoalStatuses = struct("action_msgs::msg::dds_::GoalStatusArray_", status_list=types.sequence[GoalStatus])


def key(id):
    """An identifier as something that can be compared."""
    return bytes(id.uuid)


class Action:
    """What the servers and the clients of an action have: `side` is Service or Client."""

    def __init__(self, side, name, kind, goal, result, feedback):
        at, (_, answers) = f"{name}/_action", side.makes
        self.Goal, self.Result = struct(f"{kind}_Goal_", **goal), struct(f"{kind}_Result_", **result)
        self.Feedback = struct(f"{kind}_Feedback_", **feedback)
        self.FeedbackMessage = struct(f"{kind}_FeedbackMessage_", goal_id=Id, feedback=self.Feedback)
        self.send_goal = side(f"{at}/send_goal", f"{kind}_SendGoal", {"goal_id": Id, "goal": self.Goal},
                              {"accepted": bool, "stamp": Time})
        self.get_result = side(f"{at}/get_result", f"{kind}_GetResult", {"goal_id": Id},
                               {"status": types.int8, "result": self.Result})
        self.cancel_goal = side(f"{at}/cancel_goal", "action_msgs::srv::dds_::CancelGoal", {"goal_info": GoalInfo},
                                {"return_code": types.int8, "goals_canceling": types.sequence[GoalInfo]})
        self.feedback = made(answers, f"rt{at}/feedback", self.FeedbackMessage)
        self.statuses = made(answers, f"rt{at}/status", GoalStatuses, *LATCHED)


class Goal:
    """A goal that a server has accepted."""

    def __init__(self, server, request):
        self.server, self.id, self.request = server, request.goal_id, request.goal
        self.status, self.result, self.asking = EXECUTING, None, []

    def give_feedback(self, **fields):
        self.server.feedback.write(self.server.FeedbackMessage(self.id, self.server.Feedback(**fields)))

    def end(self, status, **result):
        self.status, self.result = status, self.server.Result(**result)
        self.server.publish_statuses()
        for request in self.asking:
            self.server.get_result.respond(request, status=self.status, result=self.result)


class ActionServer(Action):
    """The server of an action; `no_result` has the fields of the result of a goal that it does not know."""

    def __init__(self, no_result, *of):
        super().__init__(Service, *of)
        self.no_result, self.goals = no_result, {}

    def take(self, judge):
        """The new goals that `judge` accepts. What else has been asked of the server is answered."""
        new = []
        for request in self.send_goal.take():
            accepted = judge(request.goal)
            self.send_goal.respond(request, accepted=accepted, stamp=Time(0, 0))
            new += [Goal(self, request)] if accepted else []
        self.goals.update({key(goal.id): goal for goal in new})
        for request in self.cancel_goal.take():
            goal = self.goals.get(key(request.goal_info.goal_id))
            code = UNKNOWN_GOAL if goal is None else TERMINATED if goal.status >= SUCCEEDED else NO_ERROR
            self.cancel_goal.respond(request, return_code=code, goals_canceling=[] if code else [request.goal_info])
            if code == NO_ERROR:
                goal.status = CANCELING
                self.publish_statuses()
        for request in self.get_result.take():
            goal = self.goals.get(key(request.goal_id))
            if goal and goal.status < SUCCEEDED:
                goal.asking.append(request)
            else:
                status, result = (goal.status, goal.result) if goal else (UNKNOWN, self.Result(**self.no_result))
                self.get_result.respond(request, status=status, result=result)
        if new:
            self.publish_statuses()
        return new

    def publish_statuses(self):
        infos = [(GoalInfo(goal.id, Time(0, 0)), goal.status) for goal in self.goals.values()]
        self.statuses.write(GoalStatuses([GoalStatus(*info) for info in infos]))
