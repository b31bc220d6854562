#!/usr/bin/env python3
"""`steward run` with components that are real nodes: `components.py STEWARD FAST CYCLONE`, with Pythons that have the
packages of `robots/helper.py` and nav2_msgs (see `robots/make_nav2_msgs.sh`), and of `robots/cyclone_server.py`.

A helper answers, on both middlewares, and misbehaves in each way. The paper's tree, unchanged, drives a navigation of
ROS 2 with the simulated robot, in its time, for SEEDS seeds. All of it happens in a network of its own.
"""
import json, os, signal, subprocess, sys, tempfile, time
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
    return json.loads(process.stdout), (out / "report.html").read_text(), messages, process.stderr


def helped(case):
    (file, python, misbehaves), domain = case
    server = start(domain, python, file, *(["--misbehave", misbehaves] if misbehaves else []))
    try:
        report, page, messages, words = run(domain, TESTS / "helped/helped.toml")
    finally:
        server.kill()
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
    assert ("a response came a second time" in words) == (misbehaves == "twice"), (file, seen, words)
    assert "took part from outside the program" in page


HOW = [None, "late", "rejects", "aborts", "hangs", "dies"]
CASES = [("helper.py", FAST, how) for how in HOW] + [("cyclone_server.py", CYCLONE, how) for how in [*HOW, "twice"]]
with ThreadPoolExecutor(3) as together:
    list(together.map(helped, zip(CASES, range(1, 100))))
print(f"{len(CASES)} times, a server of rclpy or of Cyclone DDS answered as it should, or misbehaved, and the run saw it")


def drive(case):
    """The paper's tree and a navigation of ROS 2 drive the simulated robot, in its time: verdicts, and what else."""
    (world, robot, tree, limit_s, misbehaves, seed), domain = case
    options = ["--use-sim-time", "--seed", str(seed), "--set", f"execution.max_time_s={limit_s}", "--set", "expect={}", *tree]
    simulated = [STEWARD, "sim", world, "--domain", str(domain), "--seed", str(seed), "--localize", "--speed", "10", *robot]
    simulated += ["--set", "stop={}", "--set", "expect={}", "--set", "execution.max_time_s=600"]
    simulated += ["--no-snapshots", "--json", "--out", FOLDER / f"sim-{domain}"]
    navigator = start(domain, FAST, "navigator.py", *misbehaves)
    with ThreadPoolExecutor(1) as beside:
        driven = beside.submit(run, domain, "on_a_robot", *options)
        time.sleep(2)
        simulated = subprocess.Popen(simulated, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        try:
            report, _, messages, _ = driven.result()
        finally:
            navigator.kill()
            simulated.send_signal(signal.SIGINT)
    robot = json.loads(simulated.communicate(timeout=60)[0])
    # Somebody who drives it away with a joypad does not look where it goes.
    assert world == "joypad" or robot["robot"]["collisions"] == 0, (world, robot["robot"])
    return {monitor["name"]: monitor["verdict"] for monitor in report["monitors"]}, messages


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
         ("joypad", [], ALL, 165, [], [NO, YES, NO, OPEN])]
DEAD = ("nominal", [], ALL, 40, ["--misbehave", "dies", "--after", "10"], [YES, YES, YES, OPEN])
SEEDS = int(os.environ.get("SEEDS", 1))
cases = [(*case[:5], seed) for seed in range(1, SEEDS + 1) for case in PAPER] + [(*DEAD[:5], 1)]
with ThreadPoolExecutor(2) as together:
    results = list(together.map(drive, zip(cases, range(1, 233))))
for (world, *_, seed), (verdicts, _), expected in zip(cases, results, [case[5] for case in PAPER] * SEEDS + [DEAD[5]]):
    assert list(verdicts.values()) == expected, (world, seed, verdicts)
print(f"{len(cases) - 1} times, the paper's tree had a navigation of ROS 2 drive: the verdicts of the paper's table")
_, messages = results[-1]
answers = [head for sender, to, head in messages if (sender, to) == ("Navigation", "GoToDestination")]
assert "error" in answers, set(answers)
print("of a navigation that has died, nobody knows how the trip is going, and that is what the tree's skill hears")
