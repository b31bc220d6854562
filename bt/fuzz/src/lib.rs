//! Operations on a text that may be a tree file, and a generator of texts that resemble tree files. The modules have
//! the same for logs of trees, and for what each side of Groot2's protocol may send the other.

pub mod groot_client;
pub mod groot_server;
pub mod log;
mod wire;

use std::sync::Arc;
use std::time::Duration;

use bt::{Execution, Leaf, Leaves, Loader, Status, Tree};

/// Loads a text. If it is a tree, writes it, reads the result, and ticks and halts the tree.
pub fn exercise(text: &str) {
    let loader = Loader::default().max_nodes(2000);
    let tree = match loader.load("fuzz.xml", text) {
        Ok(tree) => tree,
        Err(error) => {
            assert!(!error.problems().is_empty(), "a refusal has a reason");
            for problem in error.problems() {
                assert!(problem.offset() <= text.len(), "a problem is in the file");
            }
            return;
        }
    };
    let written = tree.to_xml();
    let again = loader.load("again.xml", &written).unwrap_or_else(|error| panic!("{error:?}\n{written}"));
    assert_eq!(again.to_string(), tree.to_string(), "{written}");
    tick(Arc::new(tree));
}

fn tick(tree: Arc<Tree>) {
    let mut execution = Execution::new(tree);
    let mut leaves = Counting { calls: 0 };
    for tick in 0..3 {
        execution.tick(Duration::from_millis(100 * tick), &mut leaves);
        if leaves.calls > 10_000 {
            return;
        }
    }
    execution.halt(Duration::from_secs(1), &mut leaves);
}

struct Counting {
    calls: u32,
}

impl Leaves for Counting {
    fn tick(&mut self, _: Leaf<'_>) -> Status {
        self.calls += 1;
        [Status::Success, Status::Running, Status::Failure][self.calls as usize % 3]
    }

    fn halt(&mut self, _: Leaf<'_>) {
        self.calls += 1;
    }
}

/// A source of random numbers that are the same on every machine.
pub struct Random(u64);

impl Random {
    /// Creates a source from a seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 20) as usize) % limit.max(1)
    }

    fn pick<'a>(&mut self, choices: &[&'a str]) -> &'a str {
        choices[self.below(choices.len())]
    }

    fn bytes(&mut self, most: usize) -> Vec<u8> {
        let length = self.below(most);
        (0..length).map(|_| self.below(256) as u8).collect()
    }

    /// Changes, cuts, inserts or repeats bytes.
    fn damage_bytes(&mut self, bytes: &mut Vec<u8>) {
        for _ in 0..self.below(20) {
            let place = self.below(bytes.len() + 1);
            match self.below(24) {
                0 => bytes.truncate(place),
                1 => drop(bytes.splice(place..place, self.bytes(20))),
                2 => drop(bytes.splice(place.., bytes[place / 2..place].to_vec())),
                kind => {
                    if let Some(byte) = bytes.get_mut(place) {
                        *byte = if kind < 8 { *byte ^ 1 << self.below(8) } else { self.below(256) as u8 };
                    }
                }
            }
        }
    }
}

const NAMES: [&str; 48] = [
    "Sequence", "ReactiveSequence", "SequenceWithMemory", "AsyncSequence", "Fallback", "ReactiveFallback",
    "AsyncFallback", "Parallel", "ParallelAll", "IfThenElse", "WhileDoElse", "Switch2", "TryCatch", "Inverter",
    "ForceSuccess", "Repeat", "RetryUntilSuccessful", "KeepRunningUntilFailure", "Delay", "Timeout", "RunOnce", "LoopInt",
    "LoopString", "Precondition", "SkipUnlessUpdated", "WaitValueUpdate", "SubTree", "SubTreePlus", "AlwaysSuccess",
    "AlwaysFailure", "Script", "ScriptCondition", "SetBlackboard", "UnsetBlackboard", "Sleep", "WasEntryUpdated",
    "Action", "Condition", "Control", "Decorator", "SequenceStar", "BehaviorTree", "TreeNodesModel", "include", "root",
    "input_port", "Foo", "ManualSelector",
];

const ATTRIBUTES: [&str; 40] = [
    "ID", "ID", "ID", "name", "num_cycles", "num_attempts", "delay_msec", "msec", "success_count", "failure_count",
    "max_failures", "variable", "case_1", "case_2", "then_skip", "catch_on_halt", "if", "else", "queue", "if_empty",
    "value", "entry", "code", "output_key", "key", "_skipIf", "_failureIf", "_successIf", "_while", "_onSuccess",
    "_onFailure", "_onHalted", "_post", "_autoremap", "goal", "type", "default", "path", "main_tree_to_execute",
    "BTCPP_format",
];

const VALUES: [&str; 40] = [
    "A", "B", "T", "Sequence", "Repeat", "1", "0", "-1", "3", "4", "99999999999999999999", "1.5", "true", "false", "{x}",
    "{y}", "{=}", "{@x}", "{}", "1;2;3", "SUCCESS", "SKIPPED", "x := 1", "x += 1", "x &lt; 3", "x == 'a' &amp;&amp; !y", "x ? 1 : 2",
    "1 +", "((((((1))))))", "x := y := 3", "'open", "x .. 'a'", "~x | 3 ^ 2", "a;b;", "", "int", "std::string", "&#x10FFFF;",
    "ü", "x = x / 0",
];

/// Valid nodes, with their minimum and maximum number of children.
const RIGHT: [(&str, usize, usize); 44] = [
    ("Sequence", 1, 3), ("ReactiveSequence", 1, 3), ("SequenceWithMemory", 1, 3), ("AsyncSequence", 1, 3),
    ("Fallback", 1, 3), ("ReactiveFallback", 1, 3), ("AsyncFallback", 1, 3), ("Parallel failure_count=\"-1\"", 1, 3),
    ("Parallel success_count=\"{x}\"", 1, 3), ("ParallelAll", 1, 3), ("IfThenElse", 2, 3), ("WhileDoElse", 2, 3),
    ("Switch2 variable=\"{x}\" case_1=\"1\" case_2=\"{y}\"", 3, 3), ("TryCatch catch_on_halt=\"true\"", 2, 3),
    ("TryCatch catch_on_halt=\"{x}\"", 2, 3), ("Inverter", 1, 1), ("ForceSuccess", 1, 1), ("ForceFailure", 1, 1),
    ("Repeat num_cycles=\"3\"", 1, 1), ("Repeat num_cycles=\"{x}\"", 1, 1), ("RetryUntilSuccessful num_attempts=\"{y}\"", 1, 1),
    ("KeepRunningUntilFailure", 1, 1), ("Delay delay_msec=\"100\"", 1, 1), ("Timeout msec=\"100\"", 1, 1), ("RunOnce", 1, 1),
    ("LoopInt queue=\"1;2\" value=\"{x}\"", 1, 1), ("LoopString queue=\"{q}\"", 1, 1), ("Precondition if=\"x == 1\"", 1, 1),
    ("SkipUnlessUpdated entry=\"{x}\"", 1, 1), ("WaitValueUpdate entry=\"y\"", 1, 1), ("SubTree ID=\"A\" x=\"{y}\"", 0, 0),
    ("SubTree ID=\"B\" _autoremap=\"1\" y=\"2\"", 0, 0), ("Script code=\"x := 1; q := '1;2'\"", 0, 0),
    ("Script code=\"y += x\" _post=\"x -= 1\"", 0, 0), ("ScriptCondition code=\"x &lt; 3 ? true : y\"", 0, 0),
    ("SetBlackboard value=\"{x}\" output_key=\"y\"", 0, 0), ("UnsetBlackboard key=\"x\"", 0, 0), ("Sleep msec=\"50\"", 0, 0),
    ("WasEntryUpdated entry=\"{x}\"", 0, 0), ("Action ID=\"GoTo\" goal=\"{x}\" _skipIf=\"x == 2\"", 0, 0),
    ("Condition ID=\"Look\" _while=\"!y\"", 0, 0), ("Action ID=\"Wave\" _onHalted=\"x := 3\" name=\"hand &amp; arm\"", 0, 0),
    ("AlwaysSuccess", 0, 0), ("AlwaysFailure", 0, 0),
];

/// A valid node, with everything below it.
fn right_node(random: &mut Random, depth: usize, text: &mut String) {
    let mut choice = RIGHT[random.below(RIGHT.len())];
    while depth > 5 && choice.2 > 0 {
        choice = RIGHT[random.below(RIGHT.len())];
    }
    let (tag, least, most) = choice;
    let name = tag.split(' ').next().unwrap_or(tag);
    text.push_str(&format!("<{tag}>"));
    for _ in 0..least + random.below(most - least + 1) {
        right_node(random, depth + 1, text);
    }
    text.push_str(&format!("</{name}>"));
}

/// A valid tree file.
fn right_text(random: &mut Random) -> String {
    let mut text = "<root BTCPP_format=\"4\" main_tree_to_execute=\"T\">".to_owned();
    for (id, subtree) in [("T", false), ("A", true), ("B", true)] {
        text.push_str(&format!("<BehaviorTree ID=\"{id}\">"));
        let mut body = String::new();
        right_node(random, if subtree { 4 } else { 0 }, &mut body);
        // A tree may not contain itself, so subtrees contain no subtrees.
        text.push_str(&if subtree { body.replace("SubTree ID=\"A\" x=", "Sleep msec=\"1\" x=").replace("SubTree ID=\"B\" _autoremap", "Sleep msec=\"1\" _a").replace("</SubTree>", "</Sleep>") } else { body });
        text.push_str("</BehaviorTree>");
    }
    text.push_str("</root>");
    text
}

/// A text that resembles a tree file.
pub fn text(random: &mut Random) -> String {
    if random.below(2) == 0 {
        let mut text = right_text(random);
        if random.below(3) == 0 {
            damage(random, &mut text);
        }
        return text;
    }
    let mut text = String::new();
    // Mostly inside a correct frame: without it, the loader stops at the first element.
    if random.below(4) > 0 {
        text.push_str("<root BTCPP_format=\"4\"><BehaviorTree ID=\"T\">");
        node(random, 0, &mut text);
        text.push_str("</BehaviorTree>");
        for _ in 0..random.below(3) {
            text.push_str(random.pick(&["<BehaviorTree ID=\"A\">", "<BehaviorTree ID=\"B\">", "<TreeNodesModel>", "<Foo>"]));
            node(random, 2, &mut text);
            text.push_str(random.pick(&["</BehaviorTree>", "</BehaviorTree>", "</TreeNodesModel>", "</Foo>"]));
        }
        text.push_str("</root>");
    } else {
        node(random, 0, &mut text);
    }
    if random.below(8) == 0 {
        damage(random, &mut text);
    }
    text
}

fn node(random: &mut Random, depth: usize, text: &mut String) {
    let name = random.pick(&NAMES);
    text.push('<');
    text.push_str(name);
    let mut given: Vec<&str> = Vec::new();
    for _ in 0..random.below(5) {
        let attribute = random.pick(&ATTRIBUTES);
        if !given.contains(&attribute) {
            given.push(attribute);
            text.push_str(&format!(" {attribute}=\"{}\"", random.pick(&VALUES)));
        }
    }
    let children = if depth > 5 { 0 } else { random.below(4) };
    if children == 0 {
        text.push_str("/>");
        return;
    }
    text.push('>');
    for _ in 0..children {
        node(random, depth + 1, text);
    }
    text.push_str(&format!("</{name}>"));
}

/// Cuts, duplicates or changes a piece, as in a damaged file.
fn damage(random: &mut Random, text: &mut String) {
    for _ in 0..=random.below(3) {
        let mut place = random.below(text.len() + 1);
        while !text.is_char_boundary(place) {
            place -= 1;
        }
        match random.below(5) {
            0 => text.truncate(place),
            1 => text.insert_str(place, random.pick(&["<", ">", "\"", "&", "<!--", "]]>", "<!DOCTYPE r [", "\u{0}", "'", "<?x?>"])),
            2 => text.insert_str(place, random.pick(&NAMES)),
            3 => text.insert_str(place, random.pick(&VALUES)),
            _ => {
                let piece = text[place..].to_owned();
                text.push_str(&piece);
            }
        }
    }
}
