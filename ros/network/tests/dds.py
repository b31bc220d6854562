#!/usr/bin/env python3
"""`steward watch` with real nodes: `dds.py STEWARD FAST CYCLONE`, with Pythons that have the packages of
`robots/fast.py`, and of `robots/cyclone.py` and `robots/bridge.py`.

- The topics, nodes, services and actions of a robot are listed.
- Planted violations are found at the right messages: the same ones with Fast DDS, Cyclone DDS and a bridge, and again
  when `steward verify` judges the recording.
- The robot does not notice the watch. Its services and its action stay available.
- A network loses, duplicates and delays messages. Exactly the missing ones are counted. Verdicts are those of the sent
  messages, or unsure.
- A robot that is killed and started again is reported.
- Arbitrary datagrams do not end the watch.

Everything runs in a network of its own.
"""
import json, os, signal, socket, struct, subprocess, sys, tempfile, time
from pathlib import Path

import apart
from peer import ROBOTS, Peer, children
from records import records

STEWARD, FAST, CYCLONE = apart.paths()

FOLDER = Path(tempfile.mkdtemp())
MAPPING = """
tick_s = 0.1
reorder_s = 0.1
[[messages]]
topic = "/level"
from = "battery"
to = "base"
fields = { level = "data" }
[[messages]]
topic = "/stop"
from = "operator"
to = "base"
fields = { is_on = "data" }
[[messages]]
topic = "/map_name"
from = "map"
to = "base"
fields = { name = "data" }
"""
PROPERTIES = """
property charged := always (battery, base, m.level >= 25)
property free := always (operator, base, m.is_on = false)
property known := eventually (map, base, m.name = "house")
property dead := always ((battery, base, m.level = 1) implies time_until (battery, base, m.level = 0) < 1 s)
property positive := always (battery, base, m.level > 0)
"""
COUNT = '[[messages]]\ntopic = "/count"\nfrom = "counter"\nto = "base"\nfields = { x = "data" }\n'
for file, text in {"robot.toml": MAPPING, "safety.scope": PROPERTIES, "count.toml": COUNT,
                   "count.scope": "property positive := always (counter, base, m.x >= 0)\n"}.items():
    (FOLDER / file).write_text(text)


def watch(mapping, properties, record, *more, network=()):
    options = ["--map-channels", FOLDER / mapping, "--property", FOLDER / properties, "--record", FOLDER / record,
               "--black-box", "3s", "--out", FOLDER / f"{record}.report", *more]
    process = subprocess.Popen([*network, STEWARD, "watch", "--json", *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                               text=True)
    # The watch finds the publishers and subscribes. Messages count half a second later. A latched message may take as
    # long as its publisher's period of heartbeats.
    assert "listening" in process.stderr.readline()
    time.sleep(4)
    return process


def follow(record, mapping, properties):
    words = [STEWARD, "verify", "--follow", "--json", FOLDER / record, "--map-channels", FOLDER / mapping]
    return subprocess.Popen([*words, "--property", FOLDER / properties], stdout=subprocess.PIPE, text=True)


def end(process):
    process.send_signal(signal.SIGINT)
    out, errors = process.communicate(timeout=60)
    lines = [json.loads(line) for line in out.splitlines()]
    return process.returncode, lines[:-1], lines[-1]


def judged(record, mapping, properties):
    words = [STEWARD, "verify", FOLDER / record, "--map-channels", FOLDER / mapping, "--property", FOLDER / properties]
    return json.loads(subprocess.run([*words, "--json"], stdout=subprocess.PIPE, text=True).stdout)


def verdicts(report):
    """Each verdict, with the messages that show it."""
    shown = lambda witness: witness and [message["message"] for message in witness["messages"]]
    return {of["name"]: (of["verdict"], shown(of["witness"]), of["unsure"]) for of in report["monitors"]}


def beside(robot, record, passive, *target):
    before = robot.ask("seen") if passive else None
    watching = watch("robot.toml", "safety.scope", record, *target)
    following = follow(record, "robot.toml", "safety.scope")
    during = robot.ask("seen") if passive else None
    done = robot.ask("go")
    time.sleep(0.5)
    status, said, report = end(watching)
    assert status == 1 and report["loss"] == ("unknown" if target else "counted"), report
    assert "missing" not in " ".join(note for note in report["notes"] if "best effort" not in note), report["notes"]
    found = verdicts(report)
    assert found == {
        "charged": ("violated", [[24]], None),
        "free": ("violated", [[True]], None),
        "known": ("satisfied", None, None),
        "dead": ("satisfied", None, None),
        "positive": ("violated", [[0]], None),
    }, found
    assert {line["property"] for line in said} == {"charged", "free", "known", "positive"}, said
    box = records(FOLDER / f"{record}.report" / "black-box-charged-1.mcap")
    levels = [struct.unpack_from("<i", data, 4)[0] for topic, data, _ in box if topic == "/level"]
    assert levels[:37] == list(range(60, 23, -1)) and box[-1][0] == "/steward/violation", (levels, box[-1])
    again = judged(record, "robot.toml", "safety.scope")
    followed = json.loads(following.communicate(timeout=60)[0].splitlines()[-1])
    assert again["monitors"] == followed["monitors"] == report["monitors"], (again, followed, report)
    if passive:
        after = robot.ask("seen")
        assert before == during == after, (before, during, after)
        assert during["dock"] and during["go"] and during["called"] and during["requests"] == [0, 0], during
        assert during["state"] == "inactive", during
        assert done["listeners"] == 1, done
        assert "incompatible" not in robot.said().lower(), robot.said()
    return report


robot = Peer(FAST, "fast.py", 61)
begun = time.monotonic()
listed = json.loads(subprocess.run([STEWARD, "watch", "--list", "--json"], stdout=subprocess.PIPE, text=True).stdout)
print(f"listed in {time.monotonic() - begun:.1f} s")
assert listed["nodes"] == ["/robot/base", "/robot/camera"], listed["nodes"]
assert {"name": "/go", "type": "test_msgs/action/Fibonacci"} in listed["actions"], listed["actions"]
services = {service["name"]: service["type"] for service in listed["services"]}
assert services.get("/dock") == "std_srvs/srv/Trigger", services
assert [service["introspected"] for service in listed["services"] if service["name"] == "/dock"] == [False], listed
kinds = {topic["name"]: topic["type"] for topic in listed["topics"]}
assert kinds["/level"] == "std_msgs/msg/Int32" and kinds["/go/_action/status"] == "action_msgs/msg/GoalStatusArray", kinds
offers = listed["publishers"]
assert offers["/level"] == "1 publisher, reliable" and offers["/stop"] == "1 publisher, best effort", offers
assert offers["/map_name"] == "1 publisher, reliable, latched", offers
(FOLDER / "calls.toml").write_text(MAPPING + '[[messages]]\ntopic = "/dock/_service_event"\nfrom = "dock"\nto = "base"\n'
                                   'fields = { what = "info.event_type" }\n')
words = [STEWARD, "watch", "--map-channels", FOLDER / "calls.toml", "--property", FOLDER / "safety.scope"]
refused = subprocess.run(words, stderr=subprocess.PIPE, text=True)
assert refused.returncode == 2 and "calls of the service /dock are unknown" in refused.stderr, refused
beside(robot, "fast.mcap", True)
print("beside rclpy: planted violations found, recorded, and unseen by the robot")

watching = watch("robot.toml", "safety.scope", "published.mcap", "--diagnostics")
before = robot.ask("diagnosed")
robot.ask("go")
time.sleep(1.5)
after = robot.ask("diagnosed")
end(watching)
undecided = ["steward: charged", 0, "undecided", {"violations": "0"}]
assert before["charged"] == undecided and before["age_s"] < 3, before
assert [name for name, *_ in before["all"]] == [f"steward: {name}" for name in
                                                ["charged", "free", "known", "dead", "positive"]], before
name, level, message, values = after["charged"]
assert (level, message, values["violations"]) == (2, "violated", "1") and "24" in values["witness"], after
levels = {name: level for name, level, *_ in after["all"]}
assert levels["steward: charged"] == levels["steward: positive"] == 2 and levels["steward: known"] == 0, levels
print("--diagnostics: rclpy hears how the properties stand, before and after")

watching = watch("robot.toml", "safety.scope", "killed.mcap")
# The latched message was received: the watch has discovered the robot.
assert json.loads(watching.stdout.readline())["property"] == "known"
robot.kill()
robot = Peer(FAST, "fast.py", 61)
time.sleep(5)
robot.ask("go")
time.sleep(0.5)
_, _, report = end(watching)
assert any(note.startswith("/robot/base publishes on /level since ") for note in report["notes"]), report["notes"]
assert verdicts(report)["charged"][0] == "violated", report
assert judged("killed.mcap", "robot.toml", "safety.scope")["monitors"] == report["monitors"]
robot.kill()
print("a robot that was killed and started again is told of")

(FOLDER / "later.scope").write_text("property low := eventually (battery, base, m.level = 5)\n"
                                    "property charged := always (battery, base, m.level >= 25)\n"
                                    "property never := always (battery, base, m.level != 1000)\n")
LEASE = "<CycloneDDS><Domain><Discovery><LeaseDuration>4s</LeaseDuration></Discovery></Domain></CycloneDDS>"
robot = Peer(CYCLONE, "cyclone.py", 61, CYCLONEDDS_URI=LEASE)
watching = watch("robot.toml", "later.scope", "respawned.mcap")
robot.kill()
robot = Peer(CYCLONE, "cyclone.py", 61, CYCLONEDDS_URI=LEASE)
time.sleep(6)
robot.ask("go")
time.sleep(0.5)
_, _, report = end(watching)
robot.kill()
found = {name: (verdict, witness) for name, (verdict, witness, _) in verdicts(report).items()}
assert "was given up" in str(report["notes"]), report["notes"]
# Messages of the new robot decide. Further messages of the killed one may be missing.
assert found == {"low": ("satisfied", None), "charged": ("violated", [[24]]), "never": ("unsure", None)}, (found, report)
print("when a robot is started again before it is given up, what it says then is sure")

robot = Peer(CYCLONE, "cyclone.py", 61)
beside(robot, "cyclone.mcap", False)
robot.kill()
print("beside Cyclone DDS: the same verdicts")

with socket.socket() as free:
    free.bind(("127.0.0.1", 0))
    port = free.getsockname()[1]
robot = Peer(CYCLONE, "bridge.py", 61, port)
beside(robot, "bridge.mcap", False, "--foxglove", f"ws://127.0.0.1:{port}")
robot.kill()
print("behind a bridge: the same verdicts, and nothing is said to be known of losses")

robot = Peer(CYCLONE, "cyclone.py", 61)
watching = watch("robot.toml", "safety.scope", "replaced.mcap")
first = children(watching)
os.kill(int(first[0]), signal.SIGKILL)
time.sleep(4)
robot.ask("go")
time.sleep(0.5)
second = children(watching)
_, said, report = end(watching)
assert first != second and "DDS failed after" in str(report["notes"]), (first, second, report["notes"])
# A verdict that one message shows is sure, and is reported at once.
assert any((line["property"], line["verdict"]) == ("charged", "violated") for line in said), said
assert verdicts(report)["charged"] == ("violated", [[24]], None), report
assert verdicts(report)["dead"][2], report
watching = watch("robot.toml", "safety.scope", "orphan.mcap")
orphan = Path("/proc") / children(watching)[0]
watching.kill()
watching.wait()
time.sleep(3)
assert not orphan.exists(), orphan
robot.kill()
print("when what listens is killed, another takes its place; when the watch is killed, nothing is left")

LOSSY = "<CycloneDDS><Domain><Internal><Test><XmitLossiness>20</XmitLossiness></Test></Internal></Domain></CycloneDDS>"
robot = Peer(CYCLONE, "cyclone.py", 61, CYCLONEDDS_URI=LOSSY.replace("20", "200"))
watching = watch("robot.toml", "safety.scope", "again.mcap")
robot.ask("go")
time.sleep(4)
_, _, report = end(watching)
robot.kill()
# Reliable messages are sent again, and recorded in the order of their numbers.
levels = [struct.unpack_from("<i", data, 4)[0] for topic, data, _ in records(FOLDER / "again.mcap") if topic == "/level"]
assert levels == sorted(levels, reverse=True) and len(levels) > 30, levels
found = verdicts(report)
assert found["charged"] == ("violated", [[24]] if 24 in levels else [[max(level for level in levels if level < 25)]], None)
assert found["dead"][0] == "satisfied" or found["dead"][2], found
print(f"of 61 reliable messages, {len(levels)} came, {61 - len(levels)} never, in the order in which they were sent")

robot = Peer(CYCLONE, "cyclone.py", 0, 7000, CYCLONEDDS_URI=LOSSY)
robot.begin("go")
watching = watch("count.toml", "count.scope", "count.mcap")
time.sleep(1)
_, _, report = end(watching)
robot.kill()
numbers, missing, before, expected = [], 0, 0, None
for topic, data, _ in records(FOLDER / "count.mcap"):
    if topic == "/count":
        number = struct.unpack_from("<i", data, 4)[0]
        assert expected in (None, number), f"{number} follows {numbers[-1]}, and {expected} was expected"
        numbers.append(number)
        expected = number + 1
    if topic == "/steward/missing" and expected is None:
        # These were lost after the last message before messages counted.
        before = json.loads(data[8:-1])["count"]
    elif topic == "/steward/missing" and not json.loads(data[8:-1]).get("is_late"):
        count = json.loads(data[8:-1])["count"]
        expected, missing = expected + count, missing + count
# The last gap may be recorded, and the message that shows it may not.
assert missing > 0 and len(numbers) + missing == expected - numbers[0], (len(numbers), missing, expected)
total = f"{missing + before} messages on /count are missing"
assert any(note.startswith(total) for note in report["notes"]), (total, report["notes"])
assert verdicts(report)["positive"][0] == "unsure" or report["monitors"][0]["unsure"], report["monitors"]
print(f"of {len(numbers) + missing} messages, the {missing} that Cyclone DDS lost are counted, each in its place")

# The network between a robot and the watch loses, duplicates and delays datagrams.
robots, between, watchers = apart.Network(), apart.Network(), apart.Network()
for network, name, address, other in [(robots, "robot", "10.0.0.1", "from"), (watchers, "watch", "10.0.0.2", "to")]:
    between.run(f"ip link add {other} type veth peer name {name} netns {network.holder.pid} && ip link set {other} up")
    network.run(f"ip link set lo up && ip address add {address}/24 dev {name} && ip link set {name} up && "
                f"ip route add 224.0.0.0/4 dev {name}")
relay = Peer(sys.executable, "relay.py", "from", "to", network=between.inside)
total = int(os.environ.get("MESSAGES", 8000))
asked = {number: -number for number in range(200, total, total // 40)}
# For every other request, the next message is the answer.
answers = {number + 1: answer for number, answer in list(asked.items())[::2]}
(FOLDER / "asked.scope").write_text("".join(
    f"property answered_{number} := always ((counter, base, m.x = {number}) implies next (counter, base, m.x = {answer}))\n"
    f"property seen_{number} := eventually (counter, base, m.x = {answer})\n" for number, answer in asked.items()))
burst = 1 if total < 100000 else 10
sending = {"burst": burst, "restart": total // 2, "answers": answers, "record": str(FOLDER / "sent.mcap")}
robot = Peer(CYCLONE, "cyclone.py", 0, total, json.dumps(sending), network=robots.inside)
watching = watch("count.toml", "asked.scope", "impaired.mcap", network=watchers.inside)
robot.ask("go")
time.sleep(1)
_, _, report = end(watching)
robot.kill()
counts = relay.end()
expected, lost = 0, 0
numbers = {answer: number for number, answer in answers.items()}
for topic, data, _ in records(FOLDER / "impaired.mcap"):
    if topic == "/steward/missing":
        missing = json.loads(data[8:-1])["count"] or 0
        expected, lost = expected + missing, lost + missing
    if topic == "/count":
        value = struct.unpack_from("<i", data, 4)[0]
        number = numbers.get(value, value)
        # The last messages of a participant may be lost unnoticed. Two other participants follow the first.
        begins = number % sending["restart"] == sending["restart"] - 1
        assert number == expected or begins and number - expected < 5, (number, expected)
        expected = number + 1
live, sent = verdicts(report), verdicts(judged("sent.mcap", "count.toml", "asked.scope"))
known = {name: of for name, of in live.items() if of[0] != "unsure"}
assert lost >= counts["lost"] and counts["twice"] and counts["late"] and total - expected < 5, (lost, counts, expected)
for name, (verdict, witness, _) in known.items():
    assert sent[name] == (verdict, witness, None), (name, live[name], sent[name])
by_verdict = {verdict: sum(of[0] == verdict for of in live.values()) for verdict in ["violated", "satisfied", "unsure"]}
assert all(by_verdict.values()), (by_verdict, lost, counts, report["notes"])
print(f"of {total} messages through a network that lost {counts['lost']}, sent {counts['twice']} twice and {counts['late']} late, "
      f"exactly the {lost} that came too late or never are counted; verdicts as for what was sent: {by_verdict}")

# Over the same network, reliable messages are sent again. A request may arrive after its answer.
(FOLDER / "pairs.toml").write_text("reorder_s = 0.1\n" + "".join(
    COUNT.replace("/count", f"/{name}").replace("counter", name) for name in ["asked", "answered"]))
(FOLDER / "pairs.scope").write_text("".join(
    f"timed property {name} := always ((asked, base, m.x as n and {which}) implies time_until (answered, base, m.x = n) < 1 s)\n"
    for name, which in [("most", " and ".join(f"m.x != {number}" for number in range(399, 2000, 400))), ("all", "true")]))
relay = Peer(sys.executable, "relay.py", "from", "to", network=between.inside)
robot = Peer(CYCLONE, "cyclone.py", 0, 2000, "pairs", network=robots.inside)
watching = watch("pairs.toml", "pairs.scope", "pairs.mcap", network=watchers.inside)
robot.ask("go")
time.sleep(3)
_, _, report = end(watching)
robot.kill()
counts, found = relay.end(), verdicts(report)
assert counts["lost"] and found["most"][0] in ("satisfied", "unsure"), (counts, report)
verdict, witness, _ = found["all"]
assert verdict == "unsure" or verdict == "violated" and any(number % 400 == 399 for [number] in witness), (counts, report)
pairs = [(topic, struct.unpack_from("<i", data, 4)[0]) for topic, data, _ in records(FOLDER / "pairs.mcap") if "ed" in topic]
answered = [number for topic, number in pairs if topic == "/answered"]
# When the watch ended, a request that was sent again may not have come.
is_late = lambda number: ("/asked", number) not in pairs[:pairs.index(("/answered", number))]
late = sum(map(is_late, answered))
print(f"of 2000 requests and their answers, {counts['lost']} datagrams were lost: {late} requests came after their answers, "
      f"verdicts {found['most'][0]} and {found['all'][0]}")

# Its lease ends before it announces itself again, as if an announcement were lost.
LATE = "<CycloneDDS><Domain><Discovery><LeaseDuration>2s</LeaseDuration><SPDPInterval>4s</SPDPInterval></Discovery></Domain></CycloneDDS>"
robot = Peer(CYCLONE, "cyclone.py", 0, 20000, CYCLONEDDS_URI=LATE)
robot.begin("go")
watching = watch("count.toml", "count.scope", "late.mcap")
# At the beginning of the watch, it may be out of reach until its next announcement, and be given up only after that.
time.sleep(14)
_, _, report = end(watching)
robot.kill()
numbers = [struct.unpack_from("<i", data, 4)[0] for topic, data, _ in records(FOLDER / "late.mcap") if topic == "/count"]
assert "was given up" in str(report["notes"]), report["notes"]
assert numbers[-1] - numbers[0] > 5000, (numbers[0], numbers[-1])
print("a robot that announces itself late is heard again")

# Firmware with a fixed GUID restarts, and its numbers begin with 1 again. Its messages are received.
(FOLDER / "firmware.scope").write_text("property positive := always (counter, base, m.x >= 0)\n"
                                       "property low := always (counter, base, m.x < 1000)\n"
                                       "property comes := eventually (counter, base, m.x = 500)\n")


def begin_anew(how, stamped, ends):
    """The verdicts on firmware that begins anew, and what the watch notes of it."""
    robot = Peer(sys.executable, "firmware.py", how, stamped)
    watching = watch("count.toml", "firmware.scope", f"firmware-{how}-{ends}.mcap")
    robot.ask("sends 0 300")
    robot.ask(f"restarts {ends}")
    # Its messages are missing until it is discovered again.
    robot.ask("sends 300 50")
    time.sleep(5)
    robot.ask("sends 500 1")
    robot.ask("sends -1 1")
    robot.ask("sends 501 20")
    time.sleep(0.5)
    _, _, report = end(watching)
    robot.kill()
    return {name: (verdict, bool(unsure)) for name, (verdict, _, unsure) in verdicts(report).items()}, str(report["notes"])


for case in [("counts", 1, "goodbye"), ("counts", 0, "cut"), ("repeats", 1, "cut"), ("repeats", 0, "goodbye")]:
    for _ in range(3):
        found, notes = begin_anew(*case)
        # On a machine that is too busy to receive for a second, all that comes meanwhile is missing, too.
        if "nothing was received any more" not in notes:
            break
    assert found == {"positive": ("violated", False), "low": ("unsure", True), "comes": ("satisfied", False)}, (
        case, found, notes)
    assert "begun anew" in notes, notes
print("firmware that begins anew with the same GUID is heard, after a goodbye and without one")

# Any participant may send anything here. There are verdicts, but none is certain.
seconds = float(os.environ.get("HOSTILE_SECONDS", 6))
robot = Peer(FAST, "fast.py", int(seconds * 100))
watching = watch("robot.toml", "safety.scope", "hostile.mcap")
robot.begin("go")
hostile = subprocess.Popen([sys.executable, ROBOTS / "hostile.py", str(seconds)], stdout=subprocess.PIPE, text=True)
largest_mb = 0
while hostile.poll() is None:
    for pid in [watching.pid, *children(watching)]:
        try:
            status = Path(f"/proc/{pid}/status").read_text()
        except OSError:
            continue
        largest_mb = max([largest_mb, *(int(line.split()[1]) // 1024 for line in status.splitlines() if "VmHWM" in line)])
    time.sleep(0.1)
sent = int(hostile.stdout.read())
assert watching.poll() is None, watching.communicate()
status, _, report = end(watching)
robot.kill()
assert sent > 1000 * seconds and status in (0, 1) and len(report["monitors"]) == 5, (sent, status, report)
assert largest_mb < 1200, largest_mb
failed = sum("DDS failed after" in note for note in report["notes"])
print(f"{sent} changed datagrams: at most {largest_mb} MB, and what listens began anew {failed} times")
