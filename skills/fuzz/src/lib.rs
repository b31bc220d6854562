//! Operations on a text that may be a machine, and a generator of texts that resemble machines.

use std::time::Duration;

use skills::{Chart, Event, Machine, SkillError, Strictness, Transcript};

/// Loads a text as strictly as possible. If it is a machine, shows it and runs it for a while. Returns whether it is
/// one.
pub fn exercise(text: &str) -> bool {
    match Chart::load_with("fuzz.scxml", text, Strictness::Standard) {
        Ok(chart) => {
            let _ = (chart.outline(), chart.to_dot());
            let mut machine = Machine::new(chart);
            let mut host = Transcript::default();
            machine.start(Duration::ZERO, &mut host);
            for (second, name) in (1..).zip(["a", "b.c", "done.state.s", "error.execution"]) {
                let now = Duration::from_secs(second);
                machine.fire_timers(now, &mut host);
                machine.handle(Event::external(name), now, &mut host);
            }
            assert_eq!(machine, machine.clone());
            true
        }
        Err(SkillError::Load { problems, .. }) => {
            assert!(!problems.is_empty(), "a refusal has a reason");
            false
        }
        Err(other) => panic!("{other}"),
    }
}

/// A source of random numbers that are the same on every machine (xorshift64).
struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 20) as usize) % limit.max(1)
    }

    fn one_in(&mut self, limit: usize) -> bool {
        self.below(limit) == 0
    }

    fn pick<'a>(&mut self, choices: &[&'a str]) -> &'a str {
        choices[self.below(choices.len())]
    }
}

const STATES: [&str; 5] = ["state", "state", "parallel", "final", "history"];
const HANDLERS: [&str; 6] = ["onentry", "onexit", "transition", "transition", "datamodel", "invoke"];
const ACTIONS: [&str; 8] = ["raise", "if", "foreach", "log", "assign", "script", "send", "cancel"];
const ODD: [&str; 10] =
    ["scxml", "initial", "donedata", "content", "param", "finalize", "else", "elseif", "data", "stat"];
const ATTRIBUTES: [&str; 29] = [
    "id",
    "initial",
    "event",
    "cond",
    "target",
    "type",
    "expr",
    "location",
    "array",
    "item",
    "index",
    "label",
    "delay",
    "delayexpr",
    "name",
    "namelist",
    "src",
    "srcexpr",
    "sendid",
    "idlocation",
    "autoforward",
    "eventexpr",
    "targetexpr",
    "typeexpr",
    "binding",
    "datamodel",
    "version",
    "sendidexpr",
    "xmlns:x",
];
const VALUES: [&str; 44] = [
    "s",
    "t",
    "u",
    "s t",
    "a",
    "b.c",
    "*",
    "a.*",
    ".*",
    "x",
    "y",
    "1",
    "x + 1",
    "x == 1",
    "In('s')",
    "_event.data.x",
    "[1, 2, x]",
    "{a: 1}",
    "x.y.z",
    "x[0]",
    "1 +",
    "'open",
    "((((((((1))))))))",
    "!!!!!x",
    "deep",
    "shallow",
    "internal",
    "1s",
    "10ms",
    "-1s",
    "#_internal",
    "#_parent",
    "#_s",
    "channel",
    "scxml",
    "true",
    "false",
    "",
    "late",
    "null",
    "x = 2",
    "x++",
    "f(x)",
    "&#x10FFFF;&lt;&amp;",
];
const TEXTS: [&str; 16] = [
    "x = 1",
    "x += 1; y = x",
    "var z = 3, w",
    "[1, 2]",
    "{\"a\": [1]}",
    "some  text",
    "function f(n) { return n + 1 }",
    "for (var i = 0; i &lt; 3; i++) { x = i }",
    "while (x) { x-- }",
    "if (x",
    "`${x}`",
    "x = [].concat(x)",
    "<a b='c'>d</a>",
    "/re/.test(x)",
    "throw x",
    "]]&gt;",
];

/// The text with this number: a valid machine with a few mistakes, sometimes with changed bytes.
#[must_use]
pub fn text(number: u64) -> String {
    let mut random = Random(number.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
    random.below(1);
    if random.one_in(200) {
        let piece = random.pick(&["<state>", "<!--", "&amp;", "<x y='", "(", "<![CDATA[", "<if cond='1'>"]);
        return format!("{HEAD}{}", piece.repeat(random.below(3_000)));
    }
    let mut text = HEAD.to_owned();
    if !random.one_in(4) {
        text.push_str("<datamodel><data id='x' expr='0'/><data id='y'/></datamodel>");
    }
    let mut count = 0;
    for _ in 0..=random.below(3) {
        state(&mut random, 0, &mut count, &mut text);
    }
    text.push_str("</scxml>");
    if random.one_in(3) { damaged(&mut random, text) } else { text }
}

const HEAD: &str = "<scxml xmlns='http://www.w3.org/2005/07/scxml' version='1.0'>";

/// A state with its contents. Ids rarely repeat, and targets are among the first ids.
fn state(random: &mut Random, depth: usize, count: &mut usize, text: &mut String) {
    let leaf = depth > 3 || random.one_in(2);
    let name = if leaf || !random.one_in(8) { random.pick(&["state", "state", "final"]) } else { random.pick(&STATES) };
    let name = if leaf || name != "final" { name } else { "state" };
    let id = match ["s", "t", "u", "s1", "t2"].get(*count) {
        Some(id) => (*id).to_owned(),
        None => format!("n{}", if random.one_in(50) { 7 } else { *count }),
    };
    *count += 1;
    text.push_str(&format!("<{name} id='{id}'>"));
    if name == "final" {
        text.push_str("</final>");
        return;
    }
    for _ in 0..random.below(3) {
        handler(random, text);
    }
    for _ in 0..if leaf { 0 } else { random.below(3) } {
        state(random, depth + 1, count, text);
    }
    text.push_str(&format!("</{name}>"));
}

fn handler(random: &mut Random, text: &mut String) {
    let name = random.pick(&HANDLERS);
    match name {
        "transition" => {
            let (event, target) =
                (random.pick(&["a", "b.c", "*", "error", "done"]), random.pick(&["s", "t", "u", "s1", "t2"]));
            text.push_str(&format!("<transition event='{event}' target='{target}'>"));
            for _ in 0..random.below(2) {
                action(random, 0, text);
            }
        }
        "datamodel" => {
            text.push_str(&format!("<datamodel><data id='d{}' expr=\"{}\"/>", random.below(9), random.pick(&VALUES)))
        }
        "invoke" => {
            text.push_str("<invoke>");
            if random.one_in(2) {
                text.push_str(&format!("<content>{HEAD}<state id='s'><onentry>"));
                action(random, 0, text);
                text.push_str("</onentry></state></scxml></content>");
            }
        }
        other => {
            text.push_str(&format!("<{other}>"));
            for _ in 0..random.below(3) {
                action(random, 0, text);
            }
        }
    }
    text.push_str(&format!("</{name}>"));
}

fn action(random: &mut Random, depth: usize, text: &mut String) {
    let name = if random.one_in(40) { random.pick(&ODD) } else { random.pick(&ACTIONS) };
    let needed = match name {
        "raise" => "event='a'",
        "if" => "cond='x == 1'",
        "foreach" => "array='[1, 2]' item='i'",
        "assign" => "location='x'",
        "send" => "event='b.c'",
        "cancel" => "sendid='i'",
        _ => "",
    };
    text.push_str(&format!("<{name} {needed}"));
    if random.one_in(6) {
        let attribute = random.pick(&ATTRIBUTES);
        if !needed.contains(attribute) {
            text.push_str(&format!(" {attribute}=\"{}\"", random.pick(&VALUES)));
        }
    }
    text.push('>');
    if ["script", "content", "data", "assign"].contains(&name) && random.one_in(2) {
        text.push_str(random.pick(&TEXTS));
    }
    if ["if", "foreach"].contains(&name) && depth < 4 {
        for _ in 0..random.below(3) {
            action(random, depth + 1, text);
        }
    }
    text.push_str(&format!("</{name}>"));
}

fn damaged(random: &mut Random, text: String) -> String {
    let mut letters: Vec<char> = text.chars().collect();
    for _ in 0..=random.below(4) {
        let place = random.below(letters.len());
        match random.below(3) {
            0 => letters[place] = ['<', '>', '\'', '&', '(', 'ü', '\0', '"'][random.below(8)],
            1 => drop(letters.remove(place)),
            _ => {
                let end = (place + random.below(30)).min(letters.len());
                let copy = letters[place..end].to_vec();
                letters.splice(place..place, copy);
            }
        }
    }
    letters.into_iter().collect()
}
