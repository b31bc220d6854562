#!/usr/bin/env python3
"""`steward run` with components that are real nodes: `components.py STEWARD FAST CYCLONE`, with Pythons that have the
packages of `robots/helper.py` and nav2_msgs (see `robots/make_nav2_msgs.sh`), and of `robots/cyclone_server.py`.

A helper answers, on both middlewares, and misbehaves in each way. The paper's tree, unchanged, drives a navigation of
ROS 2 with the simulated robot, in its time. All of it happens in a network of its own.
"""
import json, os, subprocess, sys, tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

STEWARD, FAST, CYCLONE = (os.path.abspath(path) for path in sys.argv[1:4])
NETWORK = "ip link set lo up && ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo && exec \"$@\""
if "IN_A_NETWORK" not in os.environ:
    words = [sys.executable, os.path.abspath(sys.argv[0]), STEWARD, FAST, CYCLONE]
    os.execvpe("unshare", ["unshare", "-rn", "sh", "-c", NETWORK, "sh", *words], {**os.environ, "IN_A_NETWORK": "1"})

TESTS = Path(__file__).parent
FOLDER = Path(tempfile.mkdtemp())


def start(domain, python, file, *args):
    env = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    words = [python, TESTS / "robots" / file, *map(str, args)]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True, env={**env, "ROS_DOMAIN_ID": str(domain)})
    assert json.loads(process.stdout.readline()) == {"up": True}
    return process


def run(domain, scenario, *options):
    """What a run reports and says, and its messages: who says what to whom, and with which first word."""
    record, out = FOLDER / f"{domain}.jsonl", FOLDER / f"out-{domain}"
    words = [STEWARD, "run", scenario, "--domain", str(domain), "--json", "--no-snapshots", *options]
    process = subprocess.run([*words, "--record", record, "--out", out], capture_output=True, text=True, timeout=120)
    assert process.returncode in (0, 1), process.stderr
    messages = [json.loads(line) for line in record.read_text().splitlines()]
    messages = [(line["from"], line["to"], line["message"][0]["sym"]) for line in messages if "message" in line]
    return json.loads(process.stdout), (out / "report.html").read_text(), messages


def helped(case):
    (file, python, misbehaves), domain = case
    servers = [start(domain, python, file, *(["--misbehave", misbehaves] if misbehaves else []))]
    if misbehaves == "two":
        servers.append(start(domain, python, file))
    try:
        report, page, messages = run(domain, TESTS / "helped/helped.toml")
    finally:
        [server.kill() for server in servers]
    said = [head for sender, to, head in messages if (sender, to) == ("Helper", "Count") and head != "count.feedback"]
    asked = [head for sender, to, head in messages if (sender, to) == ("Count", "Helper")]
    shares = sum(head == "count.feedback" for *_, head in messages)
    verdict = report["monitors"][0]["verdict"]
    seen = (misbehaves, verdict, asked, said)
    good = ("count.goal",), ("count.accepted", "count.succeeded")
    expected = {
        None: ("satisfied", *good), "late": ("satisfied", *good), "twice": ("satisfied", *good),
        "rejects": ("violated", ("count.goal",), ("count.rejected",)),
        "aborts": ("violated", ("count.goal",), ("count.accepted", "count.aborted")),
        "hangs": ("violated", ("count.goal", "count.cancel"), ("count.accepted",)),
        "dies": ("violated", ("count.goal", "count.cancel"), ("count.accepted",)),
    }[misbehaves]
    assert (verdict, tuple(asked), tuple(said)) == expected, (file, seen)
    assert shares == {None: 6, "late": 6, "twice": 6, "aborts": 2, "dies": 2}.get(misbehaves, 0), (file, seen, shares)
    assert ("a response came twice" in page) == (misbehaves == "twice"), (file, seen)
    assert "took part from outside the program" in page


HOW = [None, "late", "rejects", "aborts", "hangs", "dies"]
CASES = [("helper.py", FAST, how) for how in HOW] + [("cyclone_server.py", CYCLONE, how) for how in [*HOW, "twice"]]
with ThreadPoolExecutor(3) as together:
    list(together.map(helped, zip(CASES, range(1, 100))))
print(f"{len(CASES)} times, a server of rclpy or of Cyclone DDS answered as it should, or misbehaved, and the run saw it")


def drives(*misbehaves, robot=(), run_for=()):
    """The paper's tree and a navigation of ROS 2 drive the simulated robot: what both of them report."""
    simulated = [STEWARD, "sim", "nominal", "--localize", "--speed", "10", "--no-snapshots", "--json", *robot]
    simulated += ["--set", "expect={}", "--set", "stop={}", "--set", "execution.max_time_s=300", "--out", FOLDER / "sim"]
    simulated = subprocess.Popen(simulated, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    navigator = start(0, FAST, "navigator.py", *misbehaves)
    try:
        report, page, messages = run(0, "on_a_robot", *run_for)
    finally:
        navigator.kill()
        simulated.send_signal(subprocess.signal.SIGINT)
    of_robot = json.loads(simulated.communicate(timeout=60)[0])
    return {monitor["name"]: monitor["verdict"] for monitor in report["monitors"]}, of_robot, page, messages


verdicts, robot, _, messages = drives(robot=["--set", "battery.charge_pct_per_s=4"])
assert set(verdicts.values()) == {"satisfied"} and len(verdicts) == 4, verdicts
assert robot["robot"]["collisions"] == 0, robot["robot"]
goals = [head for sender, _, head in messages if sender == "Navigation" and head == "navigate_to_pose.goal"]
assert len(goals) >= 3, goals
metres = robot["robot"]["distance_m"]
print(f"the paper's tree had the robot driven to the station and to its destination, {metres:.0f} m: {verdicts}")

dies, soon = ["--misbehave", "dies", "--after", "10"], ["--set", "execution.max_time_s=40"]
verdicts, robot, page, messages = drives(*dies, run_for=soon)
answers = [head for sender, to, head in messages if (sender, to) == ("Navigation", "GoToDestination")]
assert verdicts["arrives"] == "inconclusive" and "error" in answers, (verdicts, set(answers))
assert "navigate_to_pose has said nothing for 3s" in page
print("of a navigation that has died, nobody knows how the trip is going, and that is what the tree's skill hears")
