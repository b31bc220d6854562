#!/usr/bin/env python3
"""`steward run` with components that are real nodes: `components.py STEWARD FAST CYCLONE`, with Pythons that have the
packages of `robots/helper.py` and nav2_msgs (see `robots/make_nav2_msgs.sh`), and of `robots/cyclone_server.py`.

A helper answers on both middlewares, and misbehaves in each way. Meanwhile DDS or the network fails, or the listener of
the run is paused: STOPS times for each middleware (1), for up to LONGEST_S (3).

The paper's tree, unchanged, drives a navigation of ROS 2 with the simulated robot, in its time, for SEEDS seeds. The
seeds alternate between rclpy and Cyclone DDS, so that two seeds run each of the paper's scenarios on both.

Everything runs in networks of its own.
"""
import json, math, os, random, signal, subprocess, tempfile, time
from concurrent.futures import ThreadPoolExecutor
from itertools import cycle
from pathlib import Path

import apart
from peer import Peer, children, go_on

STEWARD, FAST, CYCLONE = apart.paths()

TESTS = Path(__file__).parent
FOLDER = Path(tempfile.mkdtemp())
# Domain 0 is the default of all nodes. Greater numbers have no ports.
DOMAINS = range(1, 233)


def start(domain, *program):
    return Peer(*program, ROS_DOMAIN_ID=str(domain))


def run(domain, scenario, *options, network=(), meanwhile=lambda process: None):
    """The report and the errors of a run, and its messages with their senders and receivers."""
    # Domains in other networks have the same numbers.
    folder = Path(tempfile.mkdtemp(dir=FOLDER))
    record, out = folder / "messages.jsonl", folder / "out"
    words = [*network, STEWARD, "run", scenario, "--domain", str(domain), "--json", "--no-snapshots", *options]
    words += ["--record", record, "--out", out]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    meanwhile(process)
    reported, complaints = process.communicate(timeout=120)
    assert process.returncode in (0, 1), complaints
    messages = [json.loads(line) for line in record.read_text().splitlines()]
    messages = [line for line in messages if "message" in line]
    return json.loads(reported), (out / "report.html").read_text(), messages, complaints


def said(messages, *between):
    """The messages between processes, in order: the symbols of each. `between` are pairs of processes."""
    spoken = [line["message"] for line in messages if (line["from"], line["to"]) in between]
    return [tuple(word["sym"] for word in message if isinstance(word, dict) and "sym" in word) for message in spoken]


def helped(case):
    (file, python, misbehaves), domain = case
    # One of them is in another namespace than in the scenario.
    moves = (file, misbehaves) == ("helper.py", "late")
    elsewhere = ["--ros-args", "-r", "__ns:=/base"] if moves else []
    server = start(domain, python, file, *(["--misbehave", misbehaves] if misbehaves else []), *elsewhere)
    remaps = [f"--remap=/helper/{name}:=/base/{name}" for name in ("told", "switch", "count")] if moves else []
    try:
        report, page, messages, words = run(domain, TESTS / "helped/helped.toml", *remaps)
    finally:
        server.kill()
    heard = [head for head, *_ in said(messages, ("Helper", "Count"))]
    asked = [head for head, *_ in said(messages, ("Count", "Helper"))]
    answers = [head for head in heard if head != "count.feedback"]
    verdict = report["monitors"][0]["verdict"]
    assert [monitor["certainty"] for monitor in report["monitors"]] == ["sure", "sure"], (file, misbehaves, report)
    seen = (misbehaves, verdict, asked, answers)
    good = ("count.goal",), ("count.accepted", "count.succeeded")
    expected = {
        None: ("satisfied", *good), "late": ("satisfied", *good), "twice": ("satisfied", *good),
        "rejects": ("violated", ("count.goal",), ("count.rejected",)),
        "aborts": ("violated", ("count.goal",), ("count.accepted", "count.aborted")),
        "hangs": ("violated", ("count.goal", "count.cancel"), ("count.accepted",)),
        "dies": ("violated", ("count.goal", "count.cancel"), ("count.accepted",)),
    }[misbehaves]
    assert (verdict, tuple(asked), tuple(answers)) == expected, (file, seen)
    shares = {None: 6, "late": 6, "twice": 6, "aborts": 2, "dies": 2}.get(misbehaves, 0)
    assert heard.count("count.feedback") == shares, (file, seen, heard)
    assert ("a response came a second time" in words) == (misbehaves == "twice"), (file, seen, words)
    assert "took part from outside the program" in page


HOW = [None, "late", "rejects", "aborts", "hangs", "dies"]
CASES = [("helper.py", FAST, how) for how in HOW] + [("cyclone_server.py", CYCLONE, how) for how in [*HOW, "twice"]]
with ThreadPoolExecutor(3) as together:
    list(together.map(helped, zip(CASES, DOMAINS)))
print(f"{len(CASES)} times, a server of rclpy or of Cyclone DDS answered as it should, or misbehaved, and the run saw it")


def cut_off(case):
    """While the helper counts, or accepts the goal, the run loses its listener, or all processes lose the network for a
    while; or the listener, the run or both are paused.
    """
    (file, python, seconds, *misbehaves), domain = case
    network = apart.Network()
    network.run(apart.LOOPBACK)
    server = Peer(python, file, *misbehaves, network=network.inside, ROS_DOMAIN_ID=str(domain))

    def meanwhile(process):
        assert server.heard() == {"counts": True}
        if seconds is None:
            [listener] = children(process)
            os.kill(int(listener), signal.SIGKILL)
        elif isinstance(seconds, tuple):
            which, still_s = seconds
            pids = {"listens": children(process), "runs": [process.pid], "both": [process.pid, *children(process)]}[which]
            for pid in pids:
                os.kill(int(pid), signal.SIGSTOP)
            time.sleep(still_s)
            go_on(pids)
        else:
            network.run("ip link set lo down")
            time.sleep(seconds)
            network.run(apart.LOOPBACK)

    patient = ["--set", "leaves.Count.timeout_s=60", "--set", "execution.max_time_s=80"]
    try:
        report, _, messages, words = run(domain, TESTS / "helped/helped.toml", *patient, network=network.inside,
                                         meanwhile=meanwhile)
    finally:
        server.kill()
    heard = [head for head, *_ in said(messages, ("Helper", "Count"))]
    # It counts for a second. Its feedback may have arrived all at once, or never.
    heard = [head for head in heard if head != "count.feedback"]
    assert heard == ["count.accepted", "count.succeeded"], (case, heard, words)
    counted, kept = report["monitors"]
    # The result of the tree's leaf is computed. Messages of the helper are lost meanwhile.
    assert (counted["verdict"], counted["certainty"]) == ("satisfied", "sure"), (case, heard, words)
    assert isinstance(seconds, tuple) or "DDS failed after" in words, (case, words)
    assert isinstance(seconds, tuple) or (kept["certainty"], report["outcome"]) == ("unsure", "not_as_expected"), \
        (case, kept, words)
    assert ("counts as accepted" in " ".join(words.split())) == bool(misbehaves), (case, words)


# Participants are given up after 10 or 20 s.
SHORT, LONG = 3, 25
SERVERS = [("helper.py", FAST), ("cyclone_server.py", CYCLONE)]
CUTS = [(*server, seconds) for server in SERVERS for seconds in (None, SHORT, LONG)]
CUTS += [(*SERVERS[0], seconds, "--misbehave", "hesitates") for seconds in (None, LONG)]
# They mostly wait, and the following runs in parallel.
draw = random.Random(1)
LONGEST_S = float(os.environ.get("LONGEST_S", 3))
still = [(*server, (draw.choice(["listens", "listens", "runs", "both"]),
                    math.exp(draw.uniform(math.log(0.01), math.log(LONGEST_S)))))
         for _ in range(int(os.environ.get("STOPS", 1))) for server in SERVERS]
cut = ThreadPoolExecutor(len(CUTS)).map(cut_off, zip(CUTS, DOMAINS))


NAVIGATIONS = {"rclpy": (FAST, "navigator.py"), "Cyclone DDS": (CYCLONE, "cyclone_navigator.py")}


def drive(case):
    """The paper's tree and a navigation drive the simulated robot, in its time. Another client sends the navigation the
    requests `asked`. Returns the verdicts, the messages, what that client receives, and the errors of the navigation.
    """
    (world, robot, tree, limit_s, misbehaves, asked, seed, navigation), domain = case
    options = ["--use-sim-time", "--seed", str(seed), "--set", f"execution.max_time_s={limit_s}", "--set", "expect={}"]
    simulated = [STEWARD, "sim", world, "--domain", str(domain), "--seed", str(seed), "--localize", "--speed", "10"]
    simulated += ["--set", "stop={}", "--set", "expect={}", "--set", "execution.max_time_s=600", *robot]
    simulated += ["--no-snapshots", "--json", "--out", FOLDER / f"sim-{domain}"]
    navigator = start(domain, *NAVIGATIONS[navigation], *misbehaves)
    somebody = start(domain, FAST, "goals.py") if asked else None
    with ThreadPoolExecutor(2) as beside:
        driven = beside.submit(run, domain, "on_a_robot", *options, *tree)
        heard = beside.submit(lambda: [somebody.ask(what) for what in asked])
        time.sleep(2)
        simulated = subprocess.Popen(simulated, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        try:
            report, _, messages, _ = driven.result()
            heard = heard.result()
        finally:
            navigator.kill()
            asked and somebody.kill()
            simulated.send_signal(signal.SIGINT)
    robot = json.loads(simulated.communicate(timeout=60)[0])
    # A person who drives it away with a joypad may hit something.
    assert world == "joypad" or robot["robot"]["collisions"] == 0, (world, navigation, seed, robot["robot"])
    assert report["seed"] == robot["seed"] == seed, (report["seed"], robot["seed"], seed)
    return [monitor["verdict"] for monitor in report["monitors"]], messages, heard, navigator.said()


def fault(**keys):
    return ["--set", "faults=[{%s}]" % ", ".join(f"{key} = {json.dumps(value)}" for key, value in keys.items())]


YES, NO, OPEN = "satisfied", "violated", "inconclusive"
THRESHOLD = fault(kind="skill_threshold", at_s=0, skill="BatteryLevel", value="20")
QUARTER = ["--set", "battery.initial_pct=80", *fault(kind="battery_level", at_s=20.5, level_pct=25)]
ALL = ["--set", "stop={}"]
# Charging is faster than in the paper.
PAPER = [("nominal", ["--set", "battery.charge_pct_per_s=4"], [], 300, [], [YES, YES, YES, YES]),
         ("battery_fault", [], ALL, 90, [], [NO, YES, YES, OPEN]),
         ("nominal", QUARTER, [*ALL, *THRESHOLD], 150, [], [YES, NO, NO, YES]),
         # The level is below 30 after 35 s or later. The robot stands until the goal has reached the navigation.
         ("joypad", [], ["--set", "stop={when_settled='phi3'}"], 400, [], [NO, YES, NO, OPEN])]
DEAD = ("nominal", [], ALL, 40, ["--misbehave", "dies", "--after", "10"], [YES, YES, YES, OPEN])
FULL = ["--set", "battery.initial_pct=90"]
# Three seconds without feedback, the adapter's default, may pass in a third of a second of real time.
PATIENT = ["--set", "components.Navigation.data.silence='30s'"]
REPLACED = ("nominal", FULL, PATIENT, 150, [], [YES, YES, YES, YES])
ELSEWHERE = ["waits", "until 10", "goes -3.0 6.6 180"]
SEEDS = int(os.environ.get("SEEDS", 1))
cases = [(*case[:5], [], seed, list(NAVIGATIONS)[(number + seed) % 2]) for seed in range(1, SEEDS + 1)
         for number, case in enumerate(PAPER, 1)]
cases += [(*DEAD[:5], [], 1, "rclpy"), (*REPLACED[:5], ELSEWHERE, 1, "rclpy")]
with ThreadPoolExecutor(2) as together:
    results = list(together.map(drive, zip(cases, cycle(DOMAINS))))
table = [expected for *_, expected in [*PAPER * SEEDS, DEAD, REPLACED]]
others = [(case, verdicts, complaints) for case, (verdicts, *_, complaints), expected in zip(cases, results, table)
          if verdicts != expected]
assert not others, others
list(cut)
with ThreadPoolExecutor(4) as together:
    list(together.map(cut_off, zip(still, cycle(DOMAINS))))
print(f"{len(still)} times, what listens for a run, or the run, stood still, and it heard how its goal ended")
print(f"a run whose DDS is killed, or whose network is cut off for {SHORT} or {LONG} s, goes on, hears how its goal ended, and "
      "reports that a verdict about what it missed is unsure")
driven = [case[-1] for case in cases[:-2]]
print("the paper's tree had a navigation of ROS 2 drive, with the verdicts of the paper's table: " + ", ".join(
    f"{driven.count(navigation)} times one on {navigation}" for navigation in NAVIGATIONS))

(_, dead, *_), (_, replaced, heard, _) = results[-2:]
answers = said(dead, ("Navigation", "GoToDestination"))
assert ("error",) in answers, set(answers)
print("of a navigation that has died, nobody knows how the trip is going, and that is what the tree's skill hears")


def course(messages):
    """The messages between GoToDestination and Navigation, without repetitions and without requests for the status."""
    words = said(messages, ("GoToDestination", "Navigation"), ("Navigation", "GoToDestination"))
    words = [word for word in words if word[0] != "get_status"]
    return [word for word, before in zip(words, [None, *words]) if word != before]


record = FOLDER / "operator.jsonl"
words = [STEWARD, "run", "scenarios/faults/operator_goal.toml", *FULL, "--set", "expect={}", "--no-snapshots"]
subprocess.run([*words, "--record", record, "--out", FOLDER / "operator"], check=True, capture_output=True)
as_in_scenario = course([line for line in map(json.loads, record.read_text().splitlines()) if "message" in line])
assert ("ok", "failure") in as_in_scenario and course(replaced) == as_in_scenario, (course(replaced), as_in_scenario)
server, _, foreign = heard
assert server["server"] and foreign["accepted"] and foreign["statuses"][-2:] == [2, 6], heard
assert foreign["error_msg"] == "a newer goal has come" and foreign["feedback"] > 0, heard
print("a goal of somebody else ends the trip: the skill hears it as with the fault operator_goal, and sets off again")
