//! Random systems that handle texts which a component chooses: what is proved of a component that answers anything
//! holds beside one that has many more texts, and what is violated is violated there.

use std::collections::BTreeSet;
use std::fmt;
use std::path::Path;
use std::sync::Arc;

use explorer::Limits;
use scenarios::scenario::{ProofOutcome, Scenario, find};

use super::Proof;

/// SplitMix64.
pub(super) struct Dice(pub(super) u64);

impl Dice {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    pub(super) fn roll(&mut self, sides: u64) -> u64 {
        self.next() % sides
    }

    fn pick<'t>(&mut self, all: &[&'t str]) -> &'t str {
        all[usize::try_from(self.roll(all.len() as u64)).expect("few")]
    }
}

/// What a system does with texts, beside comparing them with literals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Class {
    /// With data of the scenario.
    Given,
    /// With the content of `<data>`.
    Content,
    /// With an entity.
    Entity,
    /// Whether it is empty.
    Empty,
    /// With earlier answers, and with others of the same message.
    Each,
    /// With a sum of literals.
    Sum,
    /// In a script.
    Script,
    /// In a Switch.
    Case,
    /// Through the blackboard, in another leaf.
    Board,
    /// In another component.
    Component,
    /// In the property, with what it remembers.
    Remembered,
    /// By length, order, and as a number or a part of a sum.
    More,
}

const CLASSES: [Class; 12] = [
    Class::Given,
    Class::Content,
    Class::Entity,
    Class::Empty,
    Class::Each,
    Class::Sum,
    Class::Script,
    Class::Case,
    Class::Board,
    Class::Component,
    Class::Remembered,
    Class::More,
];

/// The results of many proofs.
#[derive(Clone, Debug, Default)]
struct Tally {
    proved: u64,
    violated: u64,
    refused: u64,
    /// Systems of each class.
    drawn: [u64; CLASSES.len()],
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { proved, violated, refused, drawn } = self;
        write!(f, "{proved} proved, {violated} violated, {refused} refused; systems with")?;
        CLASSES.iter().zip(drawn).try_for_each(|(class, count)| write!(f, " {class:?} {count}"))
    }
}

/// A system, as files.
struct System {
    classes: BTreeSet<Class>,
    check: String,
    second: String,
    echo: String,
    tree: String,
    data: String,
    property: String,
}

/// The texts that a component with many of them answers: each literal, what could be confused with it, and others.
const MANY: [&str; 14] = ["", "a", "b", "ab", "R&D", "R&amp;D", "secret", "given", "7", "7.0", "bb", "ä", "x y", "aa"];
/// Texts that nothing mentions.
const OTHERS: [&str; 4] = ["u1", "u2", "u3", "u4"];

impl System {
    fn draw(seed: u64) -> Self {
        let mut dice = Dice(seed);
        let dice = &mut dice;
        let mut classes = BTreeSet::new();
        for _ in 0..=dice.roll(3) {
            classes.insert(CLASSES[usize::try_from(dice.roll(CLASSES.len() as u64)).expect("few")]);
        }
        let has = |class| classes.contains(&class);
        let mut terms = vec!["'a'", "'b'"];
        for (class, term) in [
            (Class::Given, "given"),
            (Class::Content, "want"),
            (Class::Entity, "'R&amp;D'"),
            (Class::Each, "last"),
            (Class::Each, "before"),
            (Class::Each, "_event.data.w"),
            (Class::Sum, "('a' + 'b')"),
        ] {
            if has(class) {
                terms.push(term);
            }
        }
        let check = condition(dice, &terms, &classes);
        let second = condition(dice, &["'a'", "'b'", "input", "input"], &classes);
        let echo = condition(dice, &["'a'", "'b'", "'R&amp;D'"], &BTreeSet::new()).replace("data.v", "data.t");
        let mut after = String::new();
        if has(Class::Script) {
            let (with, relation) = (dice.pick(&["'a'", "'R&amp;D'", "'u1'", "''"]), dice.pick(&["==", "!="]));
            after += &format!("<ScriptCondition code=\"copy := out; copy {relation} {with}\"/>");
        }
        if has(Class::Case) {
            let (one, other) = (dice.pick(&["a", "R&amp;D", "u1"]), dice.pick(&["b", "secret"]));
            let children = ["<AlwaysSuccess/>", "<AlwaysFailure/>"];
            let children = [0, 1, 2].map(|_| dice.pick(&children)).concat();
            after += &format!("<Switch2 variable=\"{{out}}\" case_1=\"{one}\" case_2=\"{other}\">{children}</Switch2>");
        }
        if has(Class::Board) {
            after += "<Action ID=\"Second\" input=\"{out}\"/>";
        }
        if has(Class::Component) {
            after += "<Action ID=\"Third\"/>";
        }
        let tree = format!("<Sequence><Action ID=\"Check\" out=\"{{out}}\"/>{after}<Action ID=\"Report\"/></Sequence>");
        let property = if has(Class::Remembered) {
            let (field, relation) = (dice.pick(&["v", "w"]), dice.pick(&["=", "!="]));
            format!("always ((Oracle, Check, {field} as p) implies next (Oracle, Check, v {relation} p))")
        } else if dice.roll(4) == 0 {
            let word = dice.pick(&["a", "u1", "R&D", ""]);
            format!("always ((Report, BT, true) implies once (Oracle, Check, v = \"{word}\"))")
        } else {
            "always (Report, BT, false)".to_owned()
        };
        let data =
            if has(Class::Given) { "[leaves.Check]\ndata.given = \"given\"\n".to_owned() } else { String::new() };
        Self { classes, check, second, echo, tree, data, property }
    }

    /// The machine of a leaf that asks the oracle, and what it sends once it has been answered.
    fn leaf(&self, name: &str, condition: &str, to: &str) -> String {
        let keep = "<assign location=\"before\" expr=\"last\"/><assign location=\"last\" expr=\"_event.data.v\"/>";
        let keep = if self.classes.contains(&Class::Each) && name == "Check" { keep } else { "" };
        let out = if name == "Check" { "<param name=\"out\" expr=\"_event.data.v\"/>" } else { "" };
        let (ask, answer) =
            if to == "Echo" { ("<param name=\"t\" expr=\"'a'\"/>", "_event.data.t == 'yes'") } else { ("", condition) };
        let back = format!("<send type=\"channel\" target=\"BT\" event=\"success\">{out}</send>");
        let fail = "<send type=\"channel\" target=\"BT\" event=\"failure\"/>";
        let input = if name == "Second" { "<data id=\"input\"/>" } else { "" };
        format!(
            r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" datamodel="ecmascript" name="{name}">
<datamodel><data id="last" expr="''"/><data id="before" expr="''"/><data id="want">secret</data>
<data id="given" expr="'none'"/><data id="n" expr="7"/>{input}</datamodel>
<state id="idle"><transition event="BT.tick" target="asking"/>
<transition event="BT.halt"><send type="channel" target="BT" event="halted"/></transition></state>
<state id="asking"><onentry><send type="channel" target="{to}" event="ask">{ask}</send></onentry>
<transition event="{to}.ok" cond="{answer}" target="idle">{keep}{back}</transition>
<transition event="{to}.ok" target="idle">{keep}{fail}</transition>
<transition event="{to}.error" target="idle">{fail}</transition>
<transition event="BT.halt" target="idle"><send type="channel" target="BT" event="halted"/></transition></state></scxml>"#
        )
    }

    fn write(&self, folder: &Path) {
        let report = r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" datamodel="ecmascript" name="Report">
<state id="idle"><transition event="BT.tick"><send type="channel" target="BT" event="success"/></transition>
<transition event="BT.halt"><send type="channel" target="BT" event="halted"/></transition></state></scxml>"#;
        // It passes what it gets on to a component, and answers whether that is what is wanted.
        let third = self.leaf("Third", "true", "Echo");
        let third = third.replace(
            r#"<onentry><send type="channel" target="Echo" event="ask"><param name="t" expr="'a'"/></send></onentry>"#,
            r#"<onentry><send type="channel" target="Oracle" event="ask"/></onentry>
<transition event="Oracle.ok"><send type="channel" target="Echo" event="ask"><param name="t" expr="_event.data.v"/></send></transition>
<transition event="Oracle.error" target="idle"><send type="channel" target="BT" event="failure"/></transition>"#,
        );
        let echo = format!(
            r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" datamodel="ecmascript" name="Echo">
<state id="on"><transition event="ask" cond="{}"><send type="channel" targetexpr="_event.origin" event="ok"><param name="t" expr="'yes'"/></send></transition>
<transition event="ask"><send type="channel" targetexpr="_event.origin" event="ok"><param name="t" expr="'no'"/></send></transition></state></scxml>"#,
            self.echo
        );
        let models = r#"<TreeNodesModel><Action ID="Check"><output_port name="out" type="std::string"/></Action>
<Action ID="Second"><input_port name="input" type="std::string"/></Action></TreeNodesModel>"#;
        let tree = format!(
            "<root BTCPP_format=\"4\" main_tree_to_execute=\"M\"><BehaviorTree ID=\"M\">{}</BehaviorTree>{models}</root>",
            self.tree
        );
        let scenario = format!(
            "tree = \"tree.xml\"\nskills = \".\"\nproperties = [\"p.scope\"]\n{}[components.Oracle]\nprogram = [\"python3\", \"o.py\"]\n\
             interface = \"oracle.toml\"\n[components.Echo]\nmachine = \"Echo.scxml\"\ninterface = \"echo.toml\"\n[prove]\n",
            self.data
        );
        for (name, text) in [
            ("Check.scxml", self.leaf("Check", &self.check, "Oracle")),
            ("Second.scxml", self.leaf("Second", &self.second, "Oracle")),
            ("Third.scxml", third),
            ("Echo.scxml", echo),
            ("Report.scxml", report.to_owned()),
            ("tree.xml", tree),
            ("oracle.toml", "[services.ask]\nreply = { v = \"text\", w = \"text\" }\n".to_owned()),
            ("echo.toml", "[services.ask]\nrequest = { t = \"text\" }\nreply = { t = \"text\" }\n".to_owned()),
            ("p.scope", format!("property p := {}\n", self.property)),
            ("many.scxml", self.many()),
            ("few.toml", format!("{scenario}components.Oracle.answers = \"anything\"\n")),
            ("many.toml", format!("{scenario}components.Oracle.machine = \"many.scxml\"\n")),
            ("o.py", String::new()),
        ] {
            std::fs::write(folder.join(name), text).expect("room for a file");
        }
    }

    /// A component that answers each of many texts, written without looking at what they are compared with.
    fn many(&self) -> String {
        // What no condition compares with `w` needs no variety there; what one does needs fewer texts that look alike.
        let uses_w = self.classes.contains(&Class::Each) || self.classes.contains(&Class::Remembered);
        let many = if uses_w { &MANY[..8] } else { &MANY[..] };
        let all: Vec<&str> = many.iter().chain(&OTHERS).copied().collect();
        let of_w = if uses_w { all.clone() } else { vec![""] };
        let pairs = all.iter().flat_map(|v| of_w.iter().map(move |w| (*v, *w)));
        let (mut choices, mut answers) = (String::new(), String::new());
        for (number, (v, w)) in pairs.enumerate() {
            let text = |text: &str| diagnostics::markup::attribute(&format!("'{text}'"));
            choices += &format!("<send type=\"choice\" event=\"c.{number}\"/>");
            answers += &format!(
                "<transition event=\"c.{number}\"><send type=\"channel\" targetexpr=\"client\" event=\"ok\">\
                 <param name=\"v\" expr=\"{}\"/><param name=\"w\" expr=\"{}\"/></send></transition>\n",
                text(v),
                text(w)
            );
        }
        format!(
            r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" datamodel="ecmascript" name="many">
<datamodel><data id="client" expr="''"/></datamodel>
<state id="any"><transition event="ask"><assign location="client" expr="_event.origin"/>{choices}</transition>
{answers}</state></scxml>"#
        )
    }
}

/// A condition on the answer.
fn condition(dice: &mut Dice, terms: &[&str], classes: &BTreeSet<Class>) -> String {
    let mut parts = Vec::new();
    for _ in 0..=dice.roll(4) {
        let mut all = vec!["_event.data.v"; 3];
        all.extend(terms);
        let (one, other) = (dice.pick(&all), dice.pick(&all));
        parts.push(match dice.roll(8) {
            0 if classes.contains(&Class::Empty) => format!("!{one}"),
            1 if classes.contains(&Class::Empty) => one.to_owned(),
            2 if classes.contains(&Class::Empty) => format!("{one} == ''"),
            3 => format!("{one} === {other}"),
            4 | 5 => format!("{one} == {other}"),
            _ => format!("{one} != {other}"),
        });
    }
    if classes.contains(&Class::More) {
        parts.push(
            dice.pick(&[
                "_event.data.v.length == 2",
                "_event.data.v &lt; 'b'",
                "_event.data.v > 'a' &amp;&amp; _event.data.v &lt; 'c'",
                "_event.data.v == 7",
                "_event.data.v == n",
                "_event.data.v + 'a' == 'aa'",
                "_event.data.v[1] == 'b'",
                "_event.data.v * 2 == 14",
            ])
            .to_owned(),
        );
    }
    let joined: Vec<String> = parts.into_iter().map(|part| format!("({part})")).collect();
    joined.join(dice.pick(&[" &amp;&amp; ", " &amp;&amp; ", " || "]))
}

/// The result for the property `p`; `Err` if it is refused.
fn outcome(folder: &Path, scenario: &str) -> Result<ProofOutcome, String> {
    let found = find::find(folder.join(scenario).to_str().expect("UTF-8")).expect("it was written");
    let scenario = Scenario::load_for_proof(&found, &[]).map_err(|error| error.reasons())?;
    let proof = Proof::new(Arc::new(scenario), &["p".to_owned()]).map_err(|error| error.reasons())?;
    let question = &proof.questions()[0];
    let answer = proof.prove(question, &Limits::default(), &mut |_| {}).map_err(|error| error.reasons())?;
    Ok(answer.outcome().expect("few states"))
}

fn agree(first: u64, systems: u64) -> Tally {
    let (mut tally, mut wrong) = (Tally::default(), Vec::new());
    for seed in first..first + systems {
        let system = System::draw(seed);
        let folder = tempfile::tempdir().expect("a folder");
        system.write(folder.path());
        for (class, count) in CLASSES.iter().zip(&mut tally.drawn) {
            *count += u64::from(system.classes.contains(class));
        }
        let System { classes, check, second, echo, tree, property, .. } = &system;
        let mut note = |what: String| {
            wrong.push(format!("seed {seed}: {what}\n{classes:?}\n{check}\n{second}\n{echo}\n{tree}\n{property}"));
        };
        match (outcome(folder.path(), "few.toml"), outcome(folder.path(), "many.toml")) {
            (Err(_), _) if classes.contains(&Class::More) => tally.refused += 1,
            (Err(why), _) => note(format!("only compares, but is refused: {why}")),
            (Ok(few), Ok(many)) if few != many => note(format!("{few:?} of few texts, {many:?} of many")),
            (Ok(ProofOutcome::Proved), Ok(_)) => tally.proved += 1,
            (Ok(ProofOutcome::Violated), Ok(_)) => tally.violated += 1,
            (_, Err(why)) => note(format!("a machine is refused: {why}")),
        }
    }
    eprintln!("{systems} systems: {tally}");
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong[..wrong.len().min(5)].join("\n\n"));
    tally
}

#[test]
fn texts_come_from_wherever_they_are_compared_and_anything_more_is_refused() {
    let ask = "<Action ID=\"Check\" out=\"{out}\"/>";
    let result = |check: &str, after: &str, class: Class| {
        let system = System {
            classes: [class].into(),
            check: check.to_owned(),
            second: "true".to_owned(),
            echo: "true".to_owned(),
            tree: format!("<Sequence>{ask}{after}<Action ID=\"Report\"/></Sequence>"),
            data: "[leaves.Check]\ndata.given = \"given\"\n".to_owned(),
            property: "always (Report, BT, false)".to_owned(),
        };
        let folder = tempfile::tempdir().expect("a folder");
        system.write(folder.path());
        outcome(folder.path(), "few.toml")
    };
    let case = "<Switch2 variable=\"{out}\" case_1=\"hello\" case_2=\"bye\"><AlwaysSuccess/><AlwaysFailure/><AlwaysFailure/></Switch2>";
    for (check, after) in [
        ("_event.data.v == given", ""),
        ("_event.data.v == want", ""),
        ("_event.data.v == 'R&amp;D'", ""),
        ("_event.data.v == 'a' + 'b'", ""),
        ("!_event.data.v", ""),
        ("_event.data.v == _event.data.w", ""),
        ("_event.data.v == '..' || _event.data.v == '&lt; b'", ""),
        (
            "last != '' &amp;&amp; before != '' &amp;&amp; _event.data.v != last &amp;&amp; _event.data.v != before &amp;&amp; last != before \
          &amp;&amp; _event.data.w != _event.data.v &amp;&amp; _event.data.w != last &amp;&amp; _event.data.w != before",
            "",
        ),
        ("true", case),
    ] {
        assert_eq!(result(check, after, Class::Each), Ok(ProofOutcome::Violated), "{check}");
    }
    for (check, why) in [
        ("_event.data.v.length == 5", "takes the length of `v` of Oracle"),
        ("_event.data.v &lt; 'b'", "compares `v` of Oracle by order"),
        ("_event.data.v > 'b' &amp;&amp; _event.data.v &lt; 'c'", "compares `v` of Oracle by order"),
        ("_event.data.v == 7", "compares `v` of Oracle with a number"),
        ("_event.data.v + 'b' == 'ab'", "computes with `v` of Oracle"),
    ] {
        let refused = result(check, "", Class::More).expect_err(check);
        assert!(refused.contains(why), "{check}: {refused}");
    }
}

#[test]
fn proofs_about_texts_agree_with_many_more_texts() {
    let tally = agree(0, 48);
    assert!(tally.proved > 0 && tally.violated > 0 && tally.refused > 0, "{tally}");
    assert!(tally.drawn.iter().all(|count| *count > 0), "{tally}");
}

/// A number from the environment.
pub(super) fn demanded(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).ok().map_or(otherwise, |count| count.parse().expect("a number"))
}

#[test]
#[ignore = "long: SYSTEMS=1000 SEED=0 cargo test -p proofs proofs_agree_on_demand -- --ignored --nocapture"]
fn proofs_agree_on_demand() {
    let systems = demanded("SYSTEMS", 500);
    let tally = agree(demanded("SEED", 0), systems);
    let share = |count: &u64| *count * 20 >= systems;
    assert!(systems < 200 || tally.drawn.iter().all(share), "each class is at least 5 % of the draws: {tally}");
    println!("{systems} systems: {tally}; none wrong");
}
