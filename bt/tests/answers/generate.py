# Random trees with scripts, typed leaves, subtrees, constants and copies; one per line.
import random, sys
seed, count = int(sys.argv[1]), int(sys.argv[2])
K = ["a", "b", "c", "d"]
T = {"Int": ["3", "-1"], "Unsigned": ["4", "7"], "Double": ["2.5", "3"], "Text": ["7", "x"]}
def leaf(r, depth):
    k, o = r.choice(K), r.choice(K)
    n = r.randrange(12)
    if n < 3:
        t = r.choice(list(T)); return f'<Put{t} is="{r.choice(T[t])}" out="{{{k}}}"/>'
    if n < 5:
        t = r.choice(list(T)); return f'<Get{t} in="{{{k}}}"/>' if r.random() < .6 else f'<Get{t}/>'
    if n < 8:
        v = r.choice(["1", "2.5", "'7'", "'x'", o, f"{o} + 1", "1 + 1"])
        return f'<Script code="{k} {r.choice([":=", ":=", ":=", "=", "+="])} {v}"/>'
    if n < 10:
        v = r.choice(["7", "x", "2.5"]) if r.random() < .5 else "{" + o + "}"
        return f'<SetBlackboard value="{v}" output_key="{k}"/>'
    if n == 10 and depth > 0:
        p = [f'{x}="{r.choice(["{" + r.choice(K) + "}", "{" + x + "}", "3", "2.5", "x"])}"' for x in K if r.random() < .5]
        auto = ' _autoremap="true"' if r.random() < .2 else ''
        return f'<SubTree ID="S" {" ".join(p)}{auto}/>'
    return f'<ScriptCondition code="{k} == {r.choice(["1", "7", "3"])}"/>'
def tree(i):
    r = random.Random(seed * 1000003 + i)
    def b(n, d):
        kind = r.choice(["Sequence", "Sequence", "ParallelAll max_failures=\"-1\"", "ParallelAll max_failures=\"-1\""])
        return f'<{kind}>' + "".join(leaf(r, d) for _ in range(n)) + f'</{kind.split()[0]}>'
    main = b(r.randint(2, 6), 1); sub = b(r.randint(1, 4), 0)
    return f'<root BTCPP_format="4" main_tree_to_execute="T"><BehaviorTree ID="T">{main}</BehaviorTree><BehaviorTree ID="S">{sub}</BehaviorTree></root>'
for i in range(count): print(tree(i))
