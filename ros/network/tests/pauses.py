#!/usr/bin/env python3
"""The listener of a DDS domain is stopped, frozen and killed, with real nodes: `pauses.py STEWARD FAST CYCLONE`, with
Pythons that have the packages of `robots/marker.py`, and of `robots/cyclone_marker.py`.

STOPS times (4), a process of `steward watch` is paused or killed: the listener, the process that judges, or both. The
logarithm of the pause is uniform between 10 ms and LONGEST_S (3). The robot knows what it has sent. No verdict
contradicts that, every message is received or counted as missing, and messages 5 s after the pause are judged as if
there had been none. `steward sim` is stopped likewise, and comes back to its domain.

Everything runs in networks of their own, WATCHES (1) of them in parallel.
"""
import contextlib, json, math, os, random, signal, struct, subprocess, sys, tempfile, time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import apart
from peer import Peer, children, go_on
from records import records

STEWARD, FAST, CYCLONE = apart.paths()

FOLDER = Path(tempfile.mkdtemp())
STOPS, LONGEST_S = int(os.environ.get("STOPS", 4)), float(os.environ.get("LONGEST_S", 3))
WATCHES, SEED = int(os.environ.get("WATCHES", 1)), int(os.environ.get("SEED", 1))
# The number of stops in one watch.
EACH = 10
SOON_S = 5
TOPICS = {"/count": "counter", "/mark": "marker", "/beat": "beat"}
(FOLDER / "robot.toml").write_text("tick_s = 0.1\nreorder_s = 0.1\n" + "".join(
    f'[[messages]]\ntopic = "{topic}"\nfrom = "{process}"\nto = "base"\nfields = {{ x = "data" }}\n'
    for topic, process in TOPICS.items()))
FREEZER = Path("/sys/fs/cgroup/freezer")


def pause(watching, how, which, seconds):
    """Pauses processes, or kills one."""
    listens, judges = int(children(watching)[0]), watching.pid
    pids = {"listens": [listens], "judges": [judges], "both": [judges, listens]}[which]
    if how == "kill":
        os.kill(listens, signal.SIGKILL)
    elif how == "freeze":
        group = FREEZER / f"steward-{judges}"
        group.mkdir(exist_ok=True)
        # Processes are thawed in the order in which they have joined the group.
        for pid in pids:
            (group / "cgroup.procs").write_text(str(pid))
        (group / "freezer.state").write_text("FROZEN")
        time.sleep(seconds)
        (group / "freezer.state").write_text("THAWED")
        # Meanwhile, a process may have started, or be ending.
        while group.exists():
            for pid in (group / "cgroup.procs").read_text().split():
                with contextlib.suppress(ProcessLookupError):
                    (FREEZER / "cgroup.procs").write_text(pid)
            with contextlib.suppress(OSError):
                group.rmdir()
    else:
        for pid in pids:
            os.kill(pid, signal.SIGSTOP)
        time.sleep(seconds)
        go_on(pids)


def properties(stops):
    """The properties of each stop: for each name, the property and whether it holds."""
    never = lambda value: f"always (marker, base, m.x != {value})"
    answered = lambda asked, answer: (f"always ((marker, base, m.x = {asked}) implies "
                                      f"time_until (marker, base, m.x = {answer}) <= 2 s)")
    return {name: found for k in range(stops) for of in [10 * k] for name, found in {
        f"before_{k}": (never(of + 1), False), f"during_{k}": (never(of + 2), False), f"after_{k}": (never(of + 3), False),
        f"never_{k}": (never(of + 4), True), f"comes_{k}": (f"eventually (marker, base, m.x = {of + 3})", True),
        # A request before the pause is answered during the pause or never. The same is repeated after the pause.
        f"asked_{k}": (answered(of + 5, of + 6), k % 2 == 0), f"again_{k}": (answered(of + 7, of + 8), k % 2 == 0),
    }.items()}


def network():
    made = apart.Network()
    made.run(apart.LOOPBACK)
    return made.inside


def watched(case):
    """A watch with some stops: what they were, and how long it took until a message was received again."""
    number, stops = case
    draw, inside = random.Random(SEED * 1000 + number), network()
    folder = FOLDER / str(number)
    folder.mkdir()
    asked = properties(stops)
    (folder / "marks.scope").write_text("".join(f"property {name} := {what}\n" for name, (what, _) in asked.items()))
    robot = Peer(*[(FAST, "marker.py"), (CYCLONE, "cyclone_marker.py")][number % 2], network=inside)
    words = [*inside, STEWARD, "watch", "--json", "--map-channels", FOLDER / "robot.toml", "--record", folder / "run.mcap"]
    # It is started in the other network directly, so that its process id is known.
    watching = subprocess.Popen([*words, "--property", folder / "marks.scope", "--out", folder / "report"],
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert "listening" in watching.stderr.readline()
    errors = ThreadPoolExecutor(1).submit(watching.stderr.read)
    time.sleep(2)
    drawn = []
    for k in range(stops):
        of = 10 * k
        how = draw.choice(["stop", "stop", "stop", "freeze", "kill"]) if FREEZER.exists() else draw.choice(["stop", "stop", "kill"])
        which = draw.choice(["listens", "listens", "judges", "both"])
        seconds = 0 if how == "kill" else math.exp(draw.uniform(math.log(0.01), math.log(LONGEST_S)))
        time.sleep(draw.uniform(0, 1))
        robot.ask(f"marks {of + 1}")
        time.sleep(0.5)
        robot.ask(f"marks {of + 5}")
        # The answer is sent during the pause, or right after it.
        meanwhile = [of + 2, *([of + 6] if k % 2 == 0 else [])]
        with ThreadPoolExecutor(1) as beside:
            paused = beside.submit(pause, watching, how, which, seconds)
            time.sleep(min(seconds / 2, 0.5))
            robot.ask("marks " + " ".join(map(str, meanwhile)))
            paused.result()
        ended = time.time()
        time.sleep(SOON_S)
        robot.ask(f"marks {of + 3} {of + 7}")
        time.sleep(0.3)
        if k % 2 == 0:
            robot.ask(f"marks {of + 8}")
        time.sleep(2.5)
        drawn.append((how, which, seconds, ended))
    sent = robot.ask("truth")
    time.sleep(1)
    watching.send_signal(signal.SIGINT)
    out = watching.stdout.read()
    watching.wait(timeout=60)
    robot.kill()
    report = json.loads(out.splitlines()[-1])
    found = {of["name"]: "unsure" if of["unsure"] else of["verdict"] for of in report["monitors"]}
    why = {of["name"]: of["unsure"] for of in report["monitors"]}
    heard, lost, held_up = {topic: [] for topic in TOPICS}, {topic: 0 for topic in TOPICS}, []
    for topic, data, at_ns in records(folder / "run.mcap"):
        if topic in TOPICS:
            heard[topic].append((struct.unpack_from("<i", data, 4)[0], at_ns))
        elif topic == "/steward/missing":
            missing = json.loads(data[8:-1])
            held_up += [missing["since_ns"] / 1e9] if "until_ns" not in missing else []
            if heard.get(missing["topic"]):
                lost[missing["topic"]] += missing["count"] or 0
    problems, seen = [], {value for value, _ in heard["/mark"]}
    for name, (_, holds) in asked.items():
        k = int(name.rsplit("_", 1)[1])
        soon = name.startswith(("after_", "comes_")) or name.startswith("again_") and not holds
        # On a busy machine, the listener may have been delayed once more. Then it has recorded that.
        once_more = any(0 < since - drawn[k][-1] - SOON_S < 3 for since in held_up)
        right = ["satisfied"] if holds else ["violated"]
        # A message that was received after a pause decides. One that was not received may be missing. An answer in time
        # may have been received late, by the length of the pause.
        allowed = right if soon and not once_more else [*right, "unsure", *(["inconclusive"] if holds else [])]
        if name.startswith("before_"):
            # On a busy machine, the listener may not have recovered from the previous pause.
            allowed = ["violated"] if 10 * k + 1 in seen else ["unsure"]
        if found[name] not in allowed:
            problems.append(f"{name}: {found[name]} ({why[name]}), and {right} is true, after {drawn[k]}")
    for topic, values in heard.items():
        numbers = [sent[topic].index(value) for value, _ in values] if topic == "/mark" else [value for value, _ in values]
        if numbers != sorted(set(numbers)):
            problems.append(f"messages on {topic} came twice, or in another order: {numbers}")
        missing = numbers[-1] - numbers[0] + 1 - len(numbers) if numbers else -1
        if missing != lost[topic]:
            problems.append(f"{missing} messages on {topic} are missing, and {lost[topic]} are counted")
    # When the first message that was sent after each pause was received.
    again = [min([at_ns / 1e9 - ended for _, at_ns in heard["/count"] if at_ns > ended * 1e9], default=math.inf)
             for *_, ended in drawn]
    counts = {verdict: sum(of == verdict for of in found.values()) for verdict in set(found.values())}
    return problems, drawn, again, counts, lost["/count"], errors.result()


def simulated(seconds):
    """A simulated robot whose processes were paused is in its domain again."""
    inside = network()
    words = [*inside, STEWARD, "sim", "nominal", "--set", "expect={}", "--no-snapshots", "--json", "--out", FOLDER / "sim"]
    robot = subprocess.Popen([*words, "--set", "execution.max_time_s=60"], stdout=subprocess.DEVNULL,
                             stderr=subprocess.PIPE, text=True)
    listed = lambda: json.loads(subprocess.run([*inside, STEWARD, "watch", "--list", "--json"], stdout=subprocess.PIPE,
                                               text=True).stdout)
    known = lambda found: {"/odom", "/scan", "/tf"} <= {topic["name"] for topic in found["topics"]}
    since = time.monotonic()
    while not known(listed()):
        assert robot.poll() is None and time.monotonic() - since < 60
    pause(robot, "stop", "both", seconds)
    time.sleep(SOON_S)
    found = listed()
    robot.send_signal(signal.SIGINT)
    words = robot.stderr.read()
    robot.wait(timeout=60)
    assert known(found) and "/steward" in found["nodes"], (seconds, found, words)
    assert "DDS failed after" in words, words


cases = [(number, min(EACH, STOPS - number * EACH)) for number in range(math.ceil(STOPS / EACH))]
with ThreadPoolExecutor(WATCHES) as together:
    results = list(together.map(watched, cases))
problems = [problem for found, *_ in results for problem in found]
drawn = [(f"{how} {which}", round(seconds, 3), round(soon, 2)) for _, drawn, again, *_ in results
         for (how, which, seconds, _), soon in zip(drawn, again)]
for of in sorted(drawn):
    print(*of)
counts = {}
for *_, of, _, _ in results:
    counts = {verdict: counts.get(verdict, 0) + of.get(verdict, 0) for verdict in {*counts, *of}}
assert not problems, "\n".join(problems)
slowest = max(soon for *_, soon in drawn)
print(f"{len(drawn)} times, what watches was stopped, frozen or killed: no wrong verdict, {sum(lost for *_, lost, _ in results)} "
      f"messages on /count missing, each counted; heard again after at most {slowest:.1f} s; verdicts: {counts}")
if not FREEZER.exists():
    print("not run here: freezing, as there is no cgroup freezer that can be written")
draw = random.Random(SEED)
for _ in range(int(os.environ.get("SIMULATED", 1))):
    simulated(math.exp(draw.uniform(math.log(0.01), math.log(LONGEST_S))))
print("a simulated robot that was stopped comes back to its domain")
