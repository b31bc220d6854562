#!/usr/bin/env python3
"""`steward sim` with real nodes: `sim.py STEWARD FAST CYCLONE`, with Pythons that have the packages of
`robots/driver.py`, and of `robots/listener.py`.

- A node of rclpy plans on the robot's map and drives it through the house, in lock step. The run is the same every
  time. RUNS is the number of repetitions.
- rclpy discovers the robot correctly, and Cyclone DDS reads its transforms.
- `steward watch` gives the verdicts of the scenario's own monitors, and rosbags reads its recording.
- Nodes that send too much, nonsense, or nothing any more do no harm.
- Clients on both middlewares send goals to the robot's own navigation, cancel and replace them, and request the
  impossible. They open a door and use other devices. So does a run of steward.

Everything runs in a network of its own.
"""
import collections, json, os, signal, subprocess, sys, tempfile, time
from pathlib import Path

import apart
from peer import Peer

STEWARD, FAST, CYCLONE = apart.paths()

FOLDER = Path(tempfile.mkdtemp())
DESTINATION = (-11.7, 14.2)
MAPPING = """
tick_s = 0.1
reorder_s = 0.1
[[messages]]
topic = "/battery_state"
type = "sensor_msgs/msg/BatteryState"
from = "Battery"
to = "Monitors"
fields = { level_pct = { path = "percentage", scale = 100 } }
[[messages]]
topic = "/odom"
type = "nav_msgs/msg/Odometry"
from = "Base"
to = "Monitors"
fields = { speed_mps = "twist.twist.linear.x" }
"""
# What `steward watch` received, and what was true in the world. The level falls while the robot stands.
PROPERTIES = """
property charged := always ({Battery}, Monitors, level_pct >= 30)
property spared := always ({Battery}, Monitors, level_pct >= 20)
property drives := eventually ({Base}, Monitors, speed_mps > 0.15)
property races := eventually ({Base}, Monitors, speed_mps > 0.3)
property stops := always (({Base}, Monitors, speed_mps > 0.15)
    implies time_until ({Base}, Monitors, speed_mps < 0.05) < 10 s)
property brakes := always (({Base}, Monitors, speed_mps > 0.15)
    implies time_until ({Base}, Monitors, speed_mps < 0.05) < 1 s)
"""
EXPECTED = {"charged": "violated", "spared": "satisfied", "drives": "satisfied", "races": "inconclusive",
            "stops": "satisfied", "brakes": "violated"}
LEVEL = "faults=[{ kind = 'battery_level', at_s = 25, level_pct = 25 }]"
for file, text in {"robot.toml": MAPPING, "told.scope": PROPERTIES.format(Battery="Battery", Base="Base"),
                   "true.scope": PROPERTIES.format(Battery="World", Base="World")}.items():
    (FOLDER / file).write_text(text)


def sim(*options, scenario="nominal"):
    words = [STEWARD, "sim", scenario, "--set", "expect={}", "--no-snapshots", "--json", "--out", FOLDER / "out"]
    return subprocess.Popen([*words, *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def report(process, status=0):
    out, errors = process.communicate(timeout=120)
    assert process.returncode == status, errors
    return json.loads(out), errors


def watch():
    words = [STEWARD, "watch", "--json", "--map-channels", FOLDER / "robot.toml", "--property", FOLDER / "told.scope"]
    words += ["--record", FOLDER / "watch.mcap"]
    return subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)


def verdicts(of):
    return {monitor["name"]: monitor["verdict"] for monitor in of["monitors"]}


visitor, watching = Peer(FAST, "visitor.py"), watch()
judged = ["--set", f"properties=['{FOLDER}/true.scope']", "--set", LEVEL]
judged += ["--set", "expect={%s}" % ", ".join(f"{name} = '{verdict}'" for name, verdict in EXPECTED.items())]
robot = sim("--set", "execution.max_time_s=35", *judged)
known = visitor.ask("knows")
transforms = Peer(CYCLONE, "listener.py").end()
driven = visitor.ask("drives")
flooded = visitor.ask("floods")
babbled = visitor.ask("babbles")
visitor.kill()
of, errors = report(robot)
watching.send_signal(signal.SIGINT)
watched = json.loads(watching.communicate(timeout=60)[0].splitlines()[-1])
assert known["nodes"] == ["steward"] and known["listeners"] == 1, known
kinds = {"/clock": "rosgraph_msgs/msg/Clock", "/tf": "tf2_msgs/msg/TFMessage", "/tf_static": "tf2_msgs/msg/TFMessage",
         "/odom": "nav_msgs/msg/Odometry", "/scan": "sensor_msgs/msg/LaserScan", "/map": "nav_msgs/msg/OccupancyGrid",
         "/battery_state": "sensor_msgs/msg/BatteryState", "/contacts": "ros_gz_interfaces/msg/Contacts"}
durable = lambda topic: "TRANSIENT_LOCAL" if topic in ("/map", "/tf_static") else "VOLATILE"
assert known["offers"] == {topic: ["steward", kind, "RELIABLE", durable(topic)] for topic, kind in kinds.items()}, known
assert known["map"][:2] == [600, 480] and known["map"][2] > 1000 and known["map"][3] == "map", known
assert known["scans"] == [["laser_back", "laser_front"], 360, 10.0], known
assert known["odom"] == ["odom", "base_footprint", [0.02]] and 0.3 < known["battery"] < 0.32, known
assert transforms.keys() == {"odom base_footprint", "base_footprint base_link", "base_link laser_front",
                             "base_link laser_back"}, transforms
assert transforms["base_link laser_back"] == [-0.245, 0, 1, 0], transforms
print("what rclpy and Cyclone DDS know of the robot is right: its node, topics, qualities, frames, map and stamps")
assert driven["driving"] > 0.15 and abs(driven["after"]) < 0.01, driven
assert abs(babbled["speed"]) < 0.01 and of["robot"]["collisions"] == 0, (babbled, of)
for said in ("not finite", "another type", "more than one publisher", "more than driving forwards"):
    assert said in errors, (said, errors)
assert flooded["sent"] > 10000 and of["timing"]["real_time_factor"] > 0.9, (flooded, of["timing"])
print(f"it stops when commands do, and goes on in real time through {flooded['sent']} commands in 3 s and nonsense")

both = {name: [verdict, verdicts(watched)[name]] for name, verdict in verdicts(of).items()}
assert {name: verdict for name, [verdict, _] in both.items()} == EXPECTED, both
assert all(verdict == other for verdict, other in both.values()) and watching.returncode == 1, (both, watched["notes"])
assert watched["loss"] == "counted" and not any(monitor["unsure"] for monitor in watched["monitors"]), watched
below, heard_below = ({of["name"]: of for of in where["monitors"]}["charged"] for where in (of, watched))
assert [told["witness"]["messages"][0]["message"][0] for told in (below, heard_below)] == [25, 25], (below, heard_below)
assert abs(below["violations"]["total_s"] - heard_below["violations"]["total_s"]) < 1, (below, heard_below)
print(f"beside it, watch gives {len(both)} properties the verdicts of the scenario's own monitors: "
      + ", ".join(f"{list(EXPECTED.values()).count(verdict)} {verdict}" for verdict in sorted(set(EXPECTED.values()))))
try:
    from rosbags.rosbag2 import Reader
    from rosbags.typesys import Stores, get_typestore
except ImportError:
    print("not run here: rosbags reads what watch records (pip install rosbags)")
else:
    # The recording contains the names of types, but not their definitions.
    store, told = get_typestore(Stores.ROS2_JAZZY), collections.defaultdict(list)
    with Reader(FOLDER / "watch.mcap") as reader:
        for connection, _, data in reader.messages():
            told[connection.topic].append(store.deserialize_cdr(data, connection.msgtype))
    at = lambda message: round(message.header.stamp.sec + message.header.stamp.nanosec * 1e-9, 3)
    steps = {round(at(after) - at(before), 3) for before, after in zip(told["/odom"], told["/odom"][1:])}
    low = [at(message) for message in told["/battery_state"] if message.percentage < 0.3]
    speeds = [message.twist.twist.linear.x for message in told["/odom"]]
    assert steps == {0.02} and at(told["/odom"][-1]) == 35 and 0.15 < max(speeds) < 0.3, (steps, max(speeds))
    assert 25 <= low[0] <= 25.2 and low[-1] == 35 and told["/battery_state"][-1].percentage == 0.25, low
    print(f"ran: rosbags reads what watch records, {sum(map(len, told.values()))} messages, all of them and in order")

runs, factors, busy = [], [], []
for _ in range(int(os.environ.get("RUNS", 3))):
    driver = Peer(FAST, "driver.py", *DESTINATION)
    of, errors = report(sim("--lock-step", "--localize"))
    seen = driver.end()
    runs.append((of["trace_hash"], seen["sent"]))
    busy.append(seen["busy"])
    arrived = {place["name"]: place["reached_at_s"] for place in of["places"]}
    assert arrived["Destination"] and of["robot"]["collisions"] == 0, of
    factors.append(of["timing"]["real_time_factor"])
assert len(set(runs)) == 1 and runs[0][1] > 500, runs
print(f"{len(runs)} times, rclpy drove it to its destination with {runs[0][1]} commands, at {min(factors):.0f} to "
      f"{max(factors):.0f} times real time, of which it was busy for at least {100 * min(busy):.0f} % itself: one trace, "
      f"{runs[0][0]}")

HALL, STATION, OUTSIDE = "-3.0 6.6 180", "-7.5 9.0 180", "1000 0 0"
EXECUTING, CANCELING, SUCCEEDED, CANCELED, ABORTED = range(2, 7)
TERMINATED, UNKNOWN_GOAL, GOAL_OUTSIDE = 3, 2, 204
INTERRUPTED = 130
goals, cyclone = Peer(FAST, "goals.py"), Peer(CYCLONE, "cyclone_goals.py")
robot = sim("--localize", "--navigate", "--speed", "10", "--set", "stop={}", "--set", "execution.max_time_s=600")
began = time.monotonic()
assert goals.ask("waits") == {"server": True, "nodes": ["steward"]}
assert cyclone.ask("waits") == {"server": True}


def assert_ends(seen, statuses, code):
    """A goal was accepted, and had these statuses and this end. If it ends at once, the first status may be missing."""
    assert seen["accepted"] and seen["statuses"] in (statuses, statuses[1:]), seen
    assert (seen["status"], seen["error_code"], bool(seen["error_msg"])) == (statuses[-1], code, code != 0), seen


def assert_serves(client, way_m):
    """It drives to the hall, at first this many meters away, cancels, and knows the goals."""
    seen = client.ask(f"goes {HALL}")
    assert_ends(seen, [EXECUTING, SUCCEEDED], 0)
    [first_m, last_m] = seen["left_m"]
    # There is feedback ten times a second, and the robot is not faster than 0.5 m/s.
    assert seen["feedback"] > 20 * (first_m - last_m) * 0.8 and way_m < first_m < way_m + 3 and last_m < 0.3, seen
    seen = client.ask(f"cancels {STATION} 1")
    canceled, again = seen.pop("canceled"), seen.pop("canceled_again")
    assert seen["statuses"] in ([EXECUTING, CANCELING, CANCELED], [EXECUTING, CANCELED]), seen
    assert (seen["status"], seen["error_code"], canceled, again) == (CANCELED, 0, [0, [True]], [TERMINATED, []]), seen
    assert_ends(client.ask(f"goes {OUTSIDE}"), [EXECUTING, ABORTED], GOAL_OUTSIDE)
    seen = client.ask("asks")
    assert seen["status"] == 0 and seen["error_code"] == 0 and seen["canceled"] == [UNKNOWN_GOAL, 0], seen


assert_serves(goals, 10)
older, newer = goals.ask(f"replaces {STATION} 2 {HALL}")
assert_ends(older, [EXECUTING, ABORTED], 200)
assert_ends(newer, [EXECUTING, SUCCEEDED], 0)
assert goals.ask("errs") == 4 * [{"accepted": False, "statuses": []}]
goals.begin(f"goes {STATION}")
time.sleep(0.4)
assert_serves(cyclone, 0)
older = goals.heard()
assert_ends(older, [EXECUTING, ABORTED], 200)
assert older["feedback"] > 0, older
robot.send_signal(signal.SIGINT)
of, errors = report(robot, INTERRUPTED)
assert of["robot"]["collisions"] == 0 and [why["reason"] for why in of["robot"]["given_up"]] == 2 * [
    "the goal is outside the map"], of["robot"]
goals.kill()
cyclone.kill()
print(f"rclpy and Cyclone DDS had its own navigation drive, in {time.monotonic() - began:.0f} s: goals succeeded, were "
      "canceled, replaced and rejected, also one of the other's")

# A script for nav2_simple_commander, with the quality of service that it requests.
for options, got in ([], ["amcl_pose", "map"]), (["--no-map"], ["amcl_pose"]):
    commander = Peer(FAST, "commander.py")
    robot = sim("--localize", "--navigate", "--speed", "10", "--set", "stop={}", "--set", "execution.max_time_s=600", *options)
    started = commander.ask("starts 0.0 0.0 0")
    assert started == {"states": ["active", "active"], "has_pose": True,
                       "publishers": {"/map": int("map" in got), "/amcl_pose": 1}}, started
    assert commander.ask("late") == got, got
    if not options:
        gone = commander.ask("goes -7.5 9.0")
        assert gone == {"succeeded": True, "has_feedback": True}, gone
    commander.kill()
    robot.send_signal(signal.SIGINT)
    report(robot, INTERRUPTED)
print("what a script for nav2_simple_commander waits for comes: active nodes, a latched pose, and the end of its goal")

# Its devices from the other side: a run in which they are components of ROS 2.
(FOLDER / "closes.xml").write_text("""
<root BTCPP_format="4" main_tree_to_execute="Closes">
  <BehaviorTree ID="Closes"><SequenceWithMemory>
    <Take/><Close/><RetryUntilSuccessful num_attempts="-1"><AwaitClosed/></RetryUntilSuccessful><Put/>
  </SequenceWithMemory></BehaviorTree>
  <TreeNodesModel><Action ID="Take"/><Action ID="Close"/><Action ID="AwaitClosed"/><Action ID="Put"/></TreeNodesModel>
</root>""")
(FOLDER / "closes.toml").write_text("""
tree = "closes.xml"
leaves.Take = { request = "Tray.take", timeout_s = 10 }
leaves.Close = { request = "Door.close", timeout_s = 10 }
leaves.AwaitClosed = { topic = "Door.moved", success_when = "message.state == 'closed'" }
leaves.Put = { request = "Tray.put", timeout_s = 10 }
components.Door = { ros = "/Door", interface = "components/devices/door.toml" }
components.Tray = { ros = "/Tray", interface = "components/devices/tray.toml" }
execution = { tick_s = 0.1, max_time_s = 60 }
stop.when_settled = true
[expect.satisfied]
took = 'eventually (Tray, Take, m[1] = <ok> and box = "parcel")'
closed = "eventually (Door, AwaitClosed, state = <closed>)"
put = "eventually (Tray, Put, m[1] = <ok>)"
""")
caller, cyclone = Peer(FAST, "caller.py"), Peer(CYCLONE, "cyclone_caller.py")
judged = "expect.satisfied.opened='eventually (Door, ROS, m[1] = <moved> and state = <open>)'"
robot = sim("--speed", "2", "--set", "stop={}", "--set", "execution.max_time_s=600", "--set", judged, scenario="parcel")
known = caller.ask("knows")
trigger, text = ["std_srvs/srv/Trigger"], ["std_msgs/msg/String"]
assert known == {"found": True, "services": {
    "/CallButton/get_press": trigger, "/Door/close": trigger, "/Door/get_state": trigger, "/Door/open": trigger,
    "/Speaker/say": ["steward_msgs/srv/Say"], "/Tray/get_load": trigger, "/Tray/put": trigger, "/Tray/take": trigger,
}, "topics": {"/CallButton/pressed": ["std_msgs/msg/Empty"], "/Door/moved": text, "/Speaker/spoken": text}}, known
assert caller.ask("hears /CallButton/pressed 1") == [None]
assert [caller.ask("calls /CallButton/get_press") for _ in range(2)] == [[True, ""], [False, ""]]
assert caller.ask("calls /Door/get_state") == [True, "closed"]
assert caller.ask("doors") == [["map", {"kitchen door": 0}]]
assert caller.ask("calls /Door/open") == [True, ""]
assert caller.ask("hears /Door/moved 2") == ["moving", "open"]
assert cyclone.ask("calls /Door/get_state") == [True, "open"]
[[frame, opening]] = caller.ask("doors")
assert frame == "map" and abs(opening["kitchen door"]) > 1, opening
# A speaker speaks one text at a time, and answers requests in order. Both sides receive both.
assert cyclone.ask("says Hello! Goodbye!") == [[True, ""], [True, ""]]
assert caller.ask("hears /Speaker/spoken 2") == ["Hello!", "Goodbye!"]
assert caller.ask("drives 0.3 2") == {"driven": True}
[[frame, *bodies, [at], [normal], [depth_m], wrenches]] = cyclone.ask("touches")
assert (frame, bodies, wrenches) == ("base_link", ["steward", "parcel"], 0), (frame, bodies)
assert abs(at[0] - 0.3) < 0.02 and abs(at[1]) < 0.02 and normal[0] < -0.99 and 0 <= depth_m < 0.02, (at, normal)
assert caller.ask("calls /Tray/take") == [True, "parcel"]
assert caller.ask("calls /Tray/take") == [False, "there is already a box on the tray"]
assert caller.ask("calls /Tray/put") == [True, "parcel"]
ran = subprocess.run([STEWARD, "run", FOLDER / "closes.toml", "--no-snapshots", "--out", FOLDER / "closes"],
                     stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=120)
assert ran.returncode == 0, ran.stdout
assert caller.ask("hears /Door/moved 4") == ["moving", "open", "moving", "closed"]
assert caller.ask("calls /Tray/get_load") == [True, ""]
robot.send_signal(signal.SIGINT)
of, errors = report(robot, INTERRUPTED)
caller.kill()
cyclone.kill()
assert verdicts(of)["opened"] == "satisfied" and of["robot"]["collisions"] >= 1, of
print("rclpy and Cyclone DDS open a door, take a box, and hear a button, a speaker and what the robot touches; a run that "
      "has the devices as components of ROS 2 uses them, too")


def processes(of):
    """A process, and the processes that it has started."""
    inner = Path(f"/proc/{of}/task/{of}/children").read_text().split()
    return [of, *(process for other in inner for process in processes(int(other)))]


def worked_s(of):
    """The processor time of processes."""
    stats = [Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split() for process in of]
    return sum(int(stat[11]) + int(stat[12]) for stat in stats) / os.sysconf("SC_CLK_TCK")


SPACES = [f"/r{place}" for place in range(20)]
fleet = Peer(FAST, "fleet.py", *SPACES)
robots = sim(*(word for space in SPACES for word in ("--namespace", space)), "--set", "execution.max_time_s=20")
for line in robots.stderr:
    if SPACES[-1] in line:
        break
time.sleep(2)
of, before_s, since = processes(robots.pid), worked_s(processes(robots.pid)), time.monotonic()
seen = fleet.ask("go")
share = (worked_s(of) - before_s) / (time.monotonic() - since)
reports, _ = report(robots)
fleet.kill()
assert seen["nodes"] == sorted(f"{space}/steward" for space in SPACES), seen
assert seen["publishers"] == {space: [space] for space in SPACES} and seen["steps_s"] == [0.02], seen
assert seen["speeds"] == [round(0.1 + 0.02 * (place % 10), 2) for place in range(len(SPACES))], seen
assert [of["scenario"] for of in reports] == [f"nominal{space}" for space in SPACES], reports
assert len({of["seed"] for of in reports}) == len(SPACES) and all(of["robot"]["distance_m"] > 0.3 for of in reports)
factor = min(of["timing"]["real_time_factor"] for of in reports)
print(f"{len(SPACES)} robots in one process obey one client, each in its namespace, on one clock, at {factor:.2f} times real "
      f"time; that takes {100 * share:.0f} % of a core")
