"""Random messages of the types that `rosbags` knows (pip install rosbags), and the definitions of these types."""
import math, random

import numpy as np

dice = random.Random()
BASES = {
    "bool": np.bool_, "octet": np.uint8, "byte": np.uint8, "char": np.uint8, "int8": np.int8, "uint8": np.uint8,
    "int16": np.int16, "uint16": np.uint16, "int32": np.int32, "uint32": np.uint32, "int64": np.int64,
    "uint64": np.uint64, "float32": np.float32, "float64": np.float64,
}
LETTERS = "abcXYZ 0129_/-äß€語😀\"\\\n"
ONE, NAME, ARRAY, SEQUENCE = 1, 2, 3, 4


def number(base):
    kind = BASES[base]
    if base == "bool":
        return dice.random() < 0.5
    if base.startswith("float"):
        special = [0.0, -0.0, math.inf, -math.inf, math.nan, 5e-324, 1e-40, 0.1]
        value = dice.choice(special) if dice.random() < 0.3 else dice.uniform(-1, 1) * 10 ** dice.randint(-30, 30)
        return float(kind(value))
    # rosbags treats a `byte` as signed.
    limits = np.iinfo(np.int8 if base == "byte" else kind)
    edge = [int(limits.min), int(limits.max), 0, 1]
    value = dice.choice(edge) if dice.random() < 0.3 else dice.randint(int(limits.min), int(limits.max))
    return abs(value) % 128 if base == "byte" else value


def value(store, desc):
    kind, what = int(desc[0]), desc[1]
    if kind == ONE:
        base, bound = what
        if base != "string":
            return number(base)
        return "".join(dice.choice(LETTERS) for _ in range(dice.randint(0, min(bound or 12, 12))))
    if kind == NAME:
        return message(store, what)
    inner, size = what
    length = size if kind == ARRAY else dice.randint(0, min(size or 4, 4))
    items = [value(store, inner) for _ in range(length)]
    base = inner[1][0] if int(inner[0]) == ONE else None
    return np.array(items, dtype=BASES[base]) if base in BASES else items


def message(store, name):
    # In IDL, a struct without members has a dummy, which nobody reads.
    fields = {field: 0 if field == "structure_needs_at_least_one_member" else value(store, desc)
              for field, desc in store.fielddefs[name][1]}
    return store.types[name](**fields)


def definitions(store, folder):
    """The definitions of all types as files."""
    for name in store.fielddefs:
        if "/msg/" in name:
            text, _ = store.generate_msgdef(name, ros_version=2)
            path = folder / f"{name}.msg"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text.split("=" * 80)[0])
