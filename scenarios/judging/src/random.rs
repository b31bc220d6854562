//! Random properties on random logs: a bag, an event log and recordings give the verdict that the definition of the
//! language gives, and a verdict that a message left out could change is unsure. Here the definition judges the numbers
//! of the bag itself, as integers of 128 bits: it shares neither reader nor comparison with the program.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::fmt;
use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;

use bags::{Bag, Events, Found, Mapping};
use channels::{Event, EventKind, Ground, Message, Topology, Value, Verdict};
use monitors::{Channels, EventLog, Outcome, Property};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};
use recording::{Archive, Doubts, Evidence, Follower, Judge, Origin, Recording, RunView, event_line};

use crate::judge::{MonitoringResult, judge_without_records};
use crate::log_context::LogContext;
use crate::logged_run::LoggedRun as _;
use crate::recorded_events::RecordedEvents;

const MAPPING: &str = "[[messages]]\ntopic = \"/p\"\nfrom = \"a\"\nto = \"b\"\n[messages.fields]\nwhole = \"whole\"\n\
                       natural = \"natural\"\nlevel = \"level\"\ncode = { path = \"codes[0]\", symbols = { 7 = \"seven\", 8 = \"eight\" } }\n";
const DEFINITION: &str = "int64 whole\nuint64 natural\nfloat64 level\nuint8[] codes\n";

/// Neighbours that a double cannot tell apart, and the ends of the range.
const INTEGERS: [i64; 12] = [
    i64::MIN,
    i64::MIN + 1,
    -1,
    0,
    (1 << 53) - 1,
    1 << 53,
    (1 << 53) + 1,
    1_700_000_000_000_000_001,
    1_700_000_000_000_000_002,
    9_000_000_000_000_000_000,
    i64::MAX - 1,
    i64::MAX,
];
const REALS: [f64; 10] =
    [-f64::MAX, -1e308, -1.0, -0.0, 0.0, 5e-324, 0.1, 9_007_199_254_740_992.0, 9_223_372_036_854_775_808.0, 1e308];

/// The topic's message.
#[derive(Clone, Copy, Debug)]
struct Raw {
    whole: i64,
    natural: u64,
    level: f64,
    code: Option<u8>,
}

impl Raw {
    /// Any message. It may be one that the mapping leaves out.
    fn random(random: &mut ChaCha8Rng) -> Self {
        let whole = pick(random, &INTEGERS);
        let natural = pick(random, &INTEGERS).unsigned_abs().min(i64::MAX as u64);
        let level = match random.next_u32() % 8 {
            0 => f64::NAN,
            1 => pick(random, &[f64::INFINITY, f64::NEG_INFINITY]),
            _ => pick(random, &REALS),
        };
        let code = pick(random, &[None, Some(7), Some(8)]);
        let raw = Self { whole, natural, level, code };
        match one_in(random, 12) {
            true if one_in(random, 2) => Self { natural: i64::MAX as u64 + 1, ..raw },
            true => Self { code: Some(9), ..raw },
            false => raw,
        }
    }

    fn cdr(&self) -> Vec<u8> {
        let (length, code) = (u32::from(self.code.is_some()).to_le_bytes(), self.code.into_iter().collect());
        let numbers = [self.whole.to_le_bytes(), self.natural.to_le_bytes(), self.level.to_le_bytes()].concat();
        [vec![0, 1, 0, 0], numbers, length.to_vec(), code].concat()
    }

    /// What the mapping promises to make of it; none if it leaves it out.
    fn message(&self) -> Option<Message> {
        let none = || Value::symbol("none");
        let code = match self.code {
            None => none(),
            Some(7) => Value::symbol("seven"),
            Some(8) => Value::symbol("eight"),
            Some(_) => return None,
        };
        let level = if self.level.is_nan() { none() } else { Value::Real(self.level) };
        Some(Message::new([Value::Int(self.whole), Value::Int(i64::try_from(self.natural).ok()?), level, code]))
    }
}

fn pick<T: Copy>(random: &mut ChaCha8Rng, from: &[T]) -> T {
    from[random.next_u32() as usize % from.len()]
}

fn one_in(random: &mut ChaCha8Rng, count: u32) -> bool {
    random.next_u32().is_multiple_of(count)
}

/// A comparison of a field with a constant.
#[derive(Clone, Copy)]
enum Comparison {
    Whole(&'static str, Number),
    Natural(&'static str, Number),
    Level(&'static str, Number),
    /// Whether the code is this symbol or, without a number, missing; or whether it is not.
    Code(bool, Option<u8>),
}

#[derive(Clone, Copy)]
enum Number {
    Int(i128),
    Real(f64),
}

impl Number {
    fn random(random: &mut ChaCha8Rng) -> Self {
        if one_in(random, 3) { Self::Real(pick(random, &REALS)) } else { Self::Int(pick(random, &INTEGERS).into()) }
    }

    fn order(self, other: Self) -> Option<Ordering> {
        match (self, other) {
            (Self::Int(a), Self::Int(b)) => Some(a.cmp(&b)),
            (Self::Real(a), Self::Real(b)) => a.partial_cmp(&b),
            (Self::Real(_), Self::Int(_)) => other.order(self).map(Ordering::reverse),
            (Self::Int(_), Self::Real(b)) if b.is_nan() => None,
            // Beyond 2⁶⁴, a real is larger than any integer. Below, twice the integer part tells halves apart.
            (Self::Int(_), Self::Real(b)) if b.abs() >= 18_446_744_073_709_551_616.0 => Some(0.0.partial_cmp(&b)?),
            (Self::Int(a), Self::Real(b)) => {
                let floor = b.floor();
                let part = i128::from(floor < b);
                Some((2 * a).cmp(&(2 * floor as i128 + part)))
            }
        }
    }

    fn relates(self, relation: &str, other: Self) -> bool {
        let order = self.order(other);
        match relation {
            "=" => order == Some(Ordering::Equal),
            "!=" => order != Some(Ordering::Equal),
            "<" => order == Some(Ordering::Less),
            ">" => order == Some(Ordering::Greater),
            "<=" => order.is_some_and(Ordering::is_le),
            _ => order.is_some_and(Ordering::is_ge),
        }
    }
}

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Int(number) => write!(f, "{number}"),
            Self::Real(number) => write!(f, "{number:?}"),
        }
    }
}

impl Comparison {
    fn random(random: &mut ChaCha8Rng) -> Self {
        let relation = pick(random, &["<", ">", "=", "!=", "<=", ">="]);
        match random.next_u32() % 4 {
            0 => Self::Whole(relation, Number::random(random)),
            1 => Self::Natural(relation, Number::random(random)),
            2 => Self::Level(relation, Number::random(random)),
            _ => Self::Code(one_in(random, 2), pick(random, &[Some(7), Some(8), None])),
        }
    }

    fn holds(self, raw: &Raw) -> bool {
        match self {
            Self::Whole(relation, number) => Number::Int(raw.whole.into()).relates(relation, number),
            Self::Natural(relation, number) => Number::Int(raw.natural.into()).relates(relation, number),
            Self::Level(relation, number) => Number::Real(raw.level).relates(relation, number),
            Self::Code(is, code) => (raw.code == code) == is,
        }
    }
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole(relation, number) => write!(f, "m.whole {relation} {number}"),
            Self::Natural(relation, number) => write!(f, "m.natural {relation} {number}"),
            Self::Level(relation, number) => write!(f, "m.level {relation} {number}"),
            Self::Code(is, code) => {
                let relation = if *is { "=" } else { "!=" };
                let symbol = code.map_or("none", |code| if code == 7 { "seven" } else { "eight" });
                write!(f, "m.code {relation} <{symbol}>")
            }
        }
    }
}

/// Comparisons that all hold.
type Condition = Vec<Comparison>;

/// A property, as text and as its meaning on the messages of one channel.
struct Formula {
    form: u32,
    first: Condition,
    second: Condition,
}

impl Formula {
    fn random(random: &mut ChaCha8Rng) -> Self {
        let [first, second] = [(); 2].map(|()| {
            let count = 1 + random.next_u32() % 3;
            (0..count).map(|_| Comparison::random(random)).collect()
        });
        Self { form: random.next_u32() % 10, first, second }
    }

    fn text(&self) -> String {
        let [a, b] = [&self.first, &self.second].map(|all| {
            let all: Vec<String> = all.iter().map(Comparison::to_string).collect();
            format!("(a, b, {})", all.join(" and "))
        });
        match self.form {
            0 => format!("always not {a}"),
            1 => format!("eventually {a}"),
            2 => format!("always ({a} implies once {b})"),
            3 => format!("always ({a} implies eventually {b})"),
            4 => format!("eventually ({a} and next {b})"),
            5 => format!("(not {a}) until {b}"),
            // With parts that are trivially true or false.
            6 => format!("always ({a} implies (next {b} or true))"),
            7 => format!("always (({a} and false) or not {b})"),
            8 => format!("always ({a} implies time_until {b} < 1)"),
            _ => format!("next ({a} or {b} and true)"),
        }
    }

    /// Whether it holds on these messages, which all follow the first tick.
    fn holds(&self, raws: &[&Raw]) -> bool {
        let is = |condition: &Condition, raw: &Raw| condition.iter().all(|comparison| comparison.holds(raw));
        let (a, b) = (|i: usize| is(&self.first, raws[i]), |i: usize| is(&self.second, raws[i]));
        let (count, mut all) = (raws.len(), 0..raws.len());
        match self.form {
            0 => !all.any(a),
            1 => all.any(a),
            2 => all.all(|i| !a(i) || (0..=i).any(b)),
            3 | 8 => all.all(|i| !a(i) || (i..count).any(b)),
            4 => all.any(|i| a(i) && i + 1 < count && b(i + 1)),
            5 => all.any(|i| b(i) && !(0..i).any(a)),
            6 => true,
            7 => !all.any(b),
            _ => count > 0 && (a(0) || b(0)),
        }
    }
}

fn bag(raws: &[Raw], path: &Path) -> Bag {
    let mut bytes = Cursor::new(Vec::new());
    let mut writer = mcap::WriteOptions::new().compression(None).profile("ros2").create(&mut bytes).unwrap();
    let schema = writer.add_schema("p/msg/P", "ros2msg", DEFINITION.as_bytes()).unwrap();
    let channel_id = writer.add_channel(schema, "/p", "cdr", &BTreeMap::new()).unwrap();
    for (raw, sequence) in raws.iter().zip(0_u32..) {
        let log_time = u64::from(sequence) * 1_000_000;
        let header = mcap::records::MessageHeader { channel_id, sequence, log_time, publish_time: log_time };
        writer.write_to_known_channel(&header, &raw.cdr()).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    std::fs::write(path, bytes.into_inner()).unwrap();
    Bag::open(path).unwrap()
}

fn properties(formulas: &[Formula], topology: &Arc<Topology>) -> Vec<Property> {
    let named =
        formulas.iter().enumerate().map(|(index, formula)| format!("property p{index} := {}\n", formula.text()));
    let text: String = named.collect();
    match monitors::load("random", &text, topology, std::time::Duration::from_secs(1)) {
        Ok(file) => file.properties,
        Err(error) => panic!("{text}{error:?}"),
    }
}

/// The verdicts on the events that are found, and whether each is unsure.
fn verdicts(
    found: impl Iterator<Item = Found>,
    properties: &mut [Property],
    topology: &Arc<Topology>,
) -> Vec<(Outcome, Verdict, bool)> {
    let doubts = Doubts::about_any_messages(properties, topology).on(&Ground::Complete);
    let Ok(MonitoringResult { evidence, .. }) =
        judge_without_records(found.map(Ok), properties, doubts, &LogContext::default(), None)
    else {
        panic!("no event is an error")
    };
    let verdict = |(property, evidence): (&Property, Evidence)| {
        (Outcome::of(property.monitor.as_ref()), property.monitor.verdict(), !evidence.has_verdict())
    };
    properties.iter().zip(evidence).map(verdict).collect()
}

/// The events as an event log has them, or a recording in either format.
fn read_again(events: &[Event], topology: &Arc<Topology>, file: Option<&Path>) -> Vec<Event> {
    let Some(path) = file else {
        let text: String = events.iter().map(|event| event_line(event, topology) + "\n").collect();
        return EventLog::new(text.as_bytes(), topology, Channels::All).map(Result::unwrap).collect();
    };
    let tick = std::time::Duration::from_secs(1);
    let (mut judge, header, start) =
        Judge::begin(Default::default(), Origin::default(), topology, tick, &[], Doubts::new(&[], topology));
    let mut view = RunView::new(header, start).unwrap();
    let mut archive = Archive::begin(path, &view).unwrap();
    for (place, event) in events.iter().enumerate() {
        view.apply(judge.step(event.clone(), &mut [])).unwrap();
        if place + 1 == events.len() {
            view.finish(judge.finish(&[])).unwrap();
        }
        archive.follow(&view).unwrap();
    }
    archive.finish().unwrap();
    let mut recording = Recording::open(path).unwrap();
    let start = recording.begin().unwrap();
    let mut recorded = RecordedEvents::new(path, recording, start, topology);
    std::iter::from_fn(|| recorded.next_event().unwrap()).collect()
}

/// Checks this many logs, each with ten properties. Returns how many pairs there were, and how many were unsure.
fn check(logs: u64, seed: u64) -> (u64, u64) {
    let folder = tempfile::tempdir().unwrap();
    let mapping = Mapping::load(Path::new("m.toml"), &|_| Ok(MAPPING.as_bytes().to_vec())).unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let (mut pairs, mut doubtful) = (0, 0);
    for log in 0..logs {
        let count = 1 + random.next_u32() % 8;
        let raws: Vec<Raw> = (0..count).map(|_| Raw::random(&mut random)).collect();
        let bag = bag(&raws, &folder.path().join("bag.mcap"));
        let Ok(compiled) = mapping.compile(bag.survey(), None, &diagnostics::from_disk) else { panic!("it fits") };
        let topology = Arc::clone(&compiled.topology);
        let formulas: Vec<Formula> = (0..10).map(|_| Formula::random(&mut random)).collect();
        let messages = Box::new(bag.messages_on(mapping.topics()));
        let found: Vec<Found> = Events::new(messages, &mapping, compiled, &diagnostics::from_disk).collect();
        let messages: Vec<Message> = raws.iter().filter_map(Raw::message).collect();
        let present = found.iter().filter_map(|found| if let Found::Event(event) = found { Some(event) } else { None });
        let present: Vec<Event> = present.cloned().collect();
        let received = |event: &Event| match &event.kind {
            EventKind::Received { message, .. } => Some(message.clone()),
            EventKind::Tick => None,
        };
        assert_eq!(present.iter().filter_map(received).collect::<Vec<_>>(), messages, "the bag's messages are exact");
        let of_bag = verdicts(found.into_iter(), &mut properties(&formulas, &topology), &topology);
        let files = ["run.rec", "run.mcap"].map(|name| folder.path().join(name));
        let files = files.iter().filter(|_| log % 5 == 0 && !present.is_empty()).map(|file| Some(file.as_path()));
        for file in std::iter::once(None).chain(files) {
            let again = read_again(&present, &topology, file);
            assert_eq!(again, present, "{file:?}");
            let of_log =
                verdicts(again.into_iter().map(Found::Event), &mut properties(&formulas, &topology), &topology);
            // On a log without events, there is no verdict.
            let is_sure = |(.., is_unsure): &(Outcome, Verdict, bool)| *is_unsure == present.is_empty();
            let same = of_bag.iter().zip(&of_log).all(|(bag, log)| (bag.0, bag.1) == (log.0, log.1) && is_sure(log));
            assert!(same, "{of_bag:?}, {of_log:?}");
        }
        pairs += formulas.len() as u64;
        doubtful += of_bag.iter().filter(|(.., unsure)| *unsure).count() as u64;
        for (formula, verdict) in formulas.iter().zip(of_bag) {
            check_by_definition(formula, verdict, &raws, &mut random);
        }
    }
    (pairs, doubtful)
}

/// Compares the verdict on a log with its definition: that of the messages that were read and, unless it is unsure, of
/// whatever the unreadable ones may have been.
fn check_by_definition(
    formula: &Formula,
    (outcome, verdict, unsure): (Outcome, Verdict, bool),
    raws: &[Raw],
    random: &mut ChaCha8Rng,
) {
    let read: Vec<&Raw> = raws.iter().filter(|raw| raw.message().is_some()).collect();
    let is_whole = read.len() == raws.len();
    assert_eq!(formula.holds(&read), outcome == Outcome::Satisfied, "{}: {raws:?}", formula.text());
    assert!(!unsure || !is_whole, "nothing is left out");
    if is_whole || unsure {
        return;
    }
    // It was settled, so nothing that may have been there changes it.
    assert_ne!(verdict, Verdict::Inconclusive, "{}", formula.text());
    assert_eq!(formula.holds(&raws.iter().collect::<Vec<_>>()), verdict == Verdict::True, "{}", formula.text());
    for _ in 0..3 {
        let others: Vec<Raw> = raws.iter().map(|_| Raw::random(random)).collect();
        let fill = |(raw, other)| if Raw::message(raw).is_some() { raw } else { other };
        let filled: Vec<&Raw> = raws.iter().zip(&others).map(fill).collect();
        assert_eq!(formula.holds(&filled), verdict == Verdict::True, "{}", formula.text());
    }
}

#[test]
fn verdicts_on_bags_logs_and_recordings_are_those_of_the_definition_or_unsure() {
    let (pairs, doubtful) = check(600, 1);
    assert!(doubtful > pairs / 10 && doubtful < pairs / 2, "{doubtful} of {pairs} verdicts are unsure");
}

#[test]
#[ignore = "long: LOGS=100000 cargo test verdicts_on_demand -- --ignored --nocapture"]
fn verdicts_on_demand() {
    let logs = std::env::var("LOGS").ok().and_then(|logs| logs.parse().ok()).unwrap_or(10_000);
    let (pairs, doubtful) = check(logs, 2);
    println!("{pairs} pairs, none wrong; {doubtful} verdicts are unsure");
}
