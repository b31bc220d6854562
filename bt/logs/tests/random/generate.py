# Random trees of all kinds of nodes that need no clock, with scripts and subtrees; one per line.
import random, sys
seed, count = int(sys.argv[1]), int(sys.argv[2])
CONTROLS = [
    ("Sequence", 1, 4), ("ReactiveSequence", 1, 4), ("SequenceWithMemory", 1, 4), ("AsyncSequence", 1, 4),
    ("Fallback", 1, 4), ("ReactiveFallback", 1, 4), ("AsyncFallback", 1, 4), ("Parallel", 1, 4),
    ('Parallel success_count="1" failure_count="-1"', 1, 4), ('Parallel success_count="-2" failure_count="2"', 2, 4),
    ("ParallelAll", 1, 4), ('ParallelAll max_failures="-1"', 1, 4), ("IfThenElse", 2, 3), ("WhileDoElse", 2, 3),
    ("TryCatch", 2, 4), ('TryCatch catch_on_halt="true"', 2, 4), ('Switch2 variable="{k}" case_1="0" case_2="1"', 3, 3),
]
DECORATORS = [
    "Inverter", "ForceSuccess", "ForceFailure", "KeepRunningUntilFailure", "RunOnce", 'RunOnce then_skip="false"',
    'Repeat num_cycles="3"', 'Repeat num_cycles="{k}"', 'RetryUntilSuccessful num_attempts="2"',
    'RetryUntilSuccessful num_attempts="{j}"', 'Precondition if="k == 1"', 'Precondition if="j &lt; 2" else="SKIPPED"',
    'Precondition if="k == 0" else="RUNNING"', 'LoopInt queue="1;2" value="{l}"', 'SkipUnlessUpdated entry="{k}"',
    'WaitValueUpdate entry="{j}"', 'Timeout msec="3600000"',
]
CONDITIONS = ["k == 1", "j &lt; 2", "k != j", "k == 0 || j == 1"]
DEEDS = ["k := 1 - k", "j := j + 1", "j := 0", "k := 0", "j -= 1"]
def hook(r):
    n = r.random()
    if n < .05: return f' {r.choice(["_failureIf", "_successIf", "_skipIf", "_while"])}="{r.choice(CONDITIONS)}"'
    if n < .1: return f' {r.choice(["_onSuccess", "_onFailure", "_onHalted", "_post"])}="{r.choice(DEEDS)}"'
    return ""
def leaf(r, subtrees):
    n = r.random()
    if n < .8:
        tag, letters, weights = ("Scripted", "rsfk", [3, 3, 3, 1]) if n < .6 else ("Look", "sfk", [3, 3, 1])
        return f'<{tag}{hook(r)} answers="{"".join(r.choices(letters, weights, k=r.randint(1, 5)))}"/>'
    if n < .9 or not subtrees:
        script = f'Script code="{r.choice(DEEDS)}"'
        condition = f'ScriptCondition code="{r.choice(CONDITIONS)}"'
        return f'<{r.choice([script, condition, "AlwaysSuccess", "AlwaysFailure"])}{hook(r)}/>'
    ports = r.choice(['k="{k}" j="{j}"', 'k="{j}" j="{k}"', '_autoremap="true"', 'k="{k}" j="2"'])
    name = f' name="s{r.randrange(99999)}"' if r.random() < .3 else ""
    return f'<SubTree ID="{r.choice(["S0", "S1"])}"{name}{hook(r)} {ports}/>'
def node(r, depth, subtrees):
    if depth == 0 or r.random() < .1: return leaf(r, subtrees)
    if r.random() < .35:
        tag = r.choice(DECORATORS)
        inside = node(r, depth - 1, subtrees)
    else:
        tag, least, most = r.choice(CONTROLS)
        inside = "".join(node(r, depth - 1, subtrees) for _ in range(r.randint(least, most)))
    return f'<{tag}{hook(r)}>{inside}</{tag.split()[0]}>'
def tree(number):
    r = random.Random(seed * 1000003 + number)
    # The entries are written in the first tick.
    start = '<RunOnce><Script code="k := 0; j := 1"/></RunOnce>'
    main = r.choice(["Sequence", "ReactiveSequence", "SequenceWithMemory"])
    main = f'<{main}>{start}{node(r, r.randint(1, 4), True)}</{main}>'
    trees = [("T", main), ("S0", node(r, 2, False)), ("S1", node(r, 1, False))]
    trees = "".join(f'<BehaviorTree ID="{name}">{body}</BehaviorTree>' for name, body in trees)
    return f'<root BTCPP_format="4" main_tree_to_execute="T">{trees}</root>'
for number in range(count): print(tree(number))
