//! Event logs from which lines are missing, or in which they come twice or elsewhere, and logs that are converted from
//! one format into another: a verdict is that of the whole log, or it is unsure, or the log is refused.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use channels::{Capacity, Domain, Event, EventKind, FieldKind, Message, Shape, Topology, Value, Verdict};
use monitors::{MONITORS, Outcome, Property, WORLD};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};
use recording::{Archive, Certainty, Doubts, Follower as _, Judge, Origin, RunView, fitting};

use crate::formats::{check_tree_log, in_every_format, judge};

/// The time between ticks.
const TICK: Duration = Duration::from_millis(100);

/// Properties whose verdicts depend on the values of a message, on order, on ticks and times, and on the end.
const PROPERTIES: &str = "
    property low := always (battery, monitor, m.x >= 2)
    property never := always not (reply, monitor, m.x = 8)
    property asked := always ((reply, monitor, m.x > 6) implies once (request, monitor, m.x > 4))
    property answered := always ((request, monitor, m.x > 5) implies time_until (reply, monitor, true) < 3)
    property in_time := always ((request, monitor, m.x > 5) implies time_until (reply, monitor, true) < 0.4 s)
    timed property soon := always ((request, monitor, m.x > 6) implies time_until (reply, monitor, true) < 0.15 s)
    property next_one := always ((request, monitor, m.x = 7) implies next (reply, monitor, m.x != 3))
    property at_first := next (battery, monitor, true)
    property early := time_until (request, monitor, true) < 2
    property before := (not (request, monitor, m.x = 9)) until (battery, monitor, m.x < 4)
    property ends := eventually (always (battery, monitor, m.x > 3))
    property steady := always ((battery, monitor, m.x as now) implies not previous (battery, monitor, m.x < now - 5))
    property few := always at most 3 (reply, monitor, m.x > 3) in 2
    property shown := always ((request, monitor, m.x > 6) implies (World, Monitors, a > 0))
    property changed := always ((World, Monitors, b = 1) implies previous (World, Monitors, a < 2))
    property known := always ((reply, monitor, m.x > 6) implies once (World, Monitors, b = 1))
    property told := always ((World, Monitors, a = 2) implies time_until (reply, monitor, true) < 2)
    property fits := always (World, Monitors, a + b < 3)";

/// The number of a line, and how many of its bytes are left.
type LineLeft = (usize, usize);

/// What becomes of each property if the run ends, and if it goes on.
type Prospects = Vec<(Outcome, Verdict)>;

/// What is done to a log. Only after the last two is its first line missing, which describes the run.
const DAMAGES: [&str; 10] = ["nothing", "first", "last", "middle", "end", "cut", "doubled", "swapped", "start", "both"];

fn below(random: &mut ChaCha8Rng, count: usize) -> usize {
    random.next_u32() as usize % count
}

/// Channels with numbers, and what is true in the world.
fn system() -> Arc<Topology> {
    const NEW: &str = "every name is another";
    let mut topology = Topology::default();
    let monitor = topology.process("monitor").expect(NEW);
    for name in ["battery", "request", "reply"] {
        let (process, number) = (topology.process(name).expect(NEW), Shape::new([("x", FieldKind::Int)]));
        topology.channel(process, monitor, Capacity::One, Domain::new([number])).expect(NEW);
    }
    let [world, monitors] = [WORLD, MONITORS].map(|name| topology.outside(name).expect(NEW));
    let facts = Shape::new([("a", FieldKind::Int), ("b", FieldKind::Int)]);
    topology.channel(world, monitors, Capacity::Zero, Domain::new([facts])).expect(NEW);
    Arc::new(topology)
}

/// A message on the channel at this place. Numbers that violate something are rare.
fn message(place: usize, random: &mut ChaCha8Rng) -> Message {
    let is_rare = below(random, 6) == 0;
    let [a, b, x] = [2, 2, 10].map(|count| i64::from(random.next_u32() % count));
    match place {
        3 => Message::new([if is_rare { 2 } else { a }, b].map(Value::Int)),
        _ => Message::new([Value::Int(if is_rare { x } else { 4 + x % 4 })]),
    }
}

/// The events of a run. If properties are about the world, its first message comes before the first tick.
fn run(random: &mut ChaCha8Rng, topology: &Topology) -> Vec<Event> {
    let has_facts = below(random, 4) > 0;
    let (mut events, mut step, mut ms, mut fact_ms) = (Vec::new(), 0, 0, 0);
    for round in 0_u64..3 + random.next_u64() % 5 {
        let tick = round.saturating_sub(1);
        if round > 0 {
            ms = ms.max(tick * 100);
            events.push(Event { step, tick, time: Duration::from_millis(ms), kind: EventKind::Tick });
        }
        let count = if round == 0 { usize::from(has_facts) } else { [0, 1, 2, 4, 9][below(random, 5)] };
        for _ in 0..count {
            let place = if round == 0 { 3 } else { below(random, 3 + usize::from(has_facts)) };
            // Many messages have the time of their tick, but no two facts are of one time: a step has one.
            ms += u64::from(random.next_u32() % 2 * (random.next_u32() % 30));
            if place == 3 {
                (ms, fact_ms) = (ms.max(fact_ms), ms.max(fact_ms) + 1);
            } else {
                step += 1;
            }
            let channel = topology.channels().nth(place).expect("a channel");
            let kind = EventKind::Received { channel, message: message(place, random) };
            events.push(Event { step, tick, time: Duration::from_millis(ms), kind });
        }
    }
    events
}

/// Writes a run as `run --record` does. It ends some time after its last event.
fn record(events: &[Event], topology: &Arc<Topology>, path: &Path) {
    let doubts = Doubts::new(&[], topology);
    let (mut judge, header, start) = Judge::begin(Default::default(), Origin::default(), topology, TICK, &[], doubts);
    let mut view = fitting(RunView::new(header, start));
    let mut archive = Archive::begin(path, &view).expect("room for a file");
    for event in events {
        fitting(view.apply(judge.step(event.clone(), &mut [])));
        archive.follow(&view).expect("room for an event");
    }
    fitting(view.apply(judge.end_at(view.time() + Duration::from_millis(50))));
    fitting(view.finish(judge.finish(&[])));
    archive.follow(&view).expect("room for the end");
    archive.finish().expect("room for a file");
}

/// What becomes of each property after each number of events.
fn outcomes(events: &[Event], topology: &Arc<Topology>) -> Vec<Prospects> {
    let mut properties = monitors::load("p.scope", PROPERTIES, topology, TICK).expect("correct").properties;
    let of = |property: &Property| (Outcome::of(property.monitor.as_ref()), property.monitor.verdict());
    let mut outcomes: Vec<Prospects> = vec![properties.iter().map(of).collect()];
    for event in events {
        properties.iter_mut().for_each(|property| property.monitor.observe(event));
        outcomes.push(properties.iter().map(of).collect());
    }
    outcomes
}

/// Damages a log with at least four lines.
fn damage(left: &mut Vec<LineLeft>, what: &str, random: &mut ChaCha8Rng) {
    let count = left.len();
    let most = [2, count - 2][below(random, 2)];
    let length = 1 + below(random, most);
    let at = below(random, count - length);
    match what {
        // Events at the beginning, at the end, and anywhere; the end with its last line.
        "first" => drop(left.drain(1..=length)),
        "last" => drop(left.drain(count - 1 - length..count - 1)),
        "middle" => drop(left.drain(at.max(1)..at.max(1) + length)),
        "end" => left.truncate(count - length),
        "cut" => {
            left.truncate(at + 1);
            // At most all but the brace and the line break.
            left[at].1 = 1 + below(random, left[at].1.max(3) - 2);
        }
        "doubled" => {
            let again = left[at + 1..=at + length].to_vec();
            drop(left.splice(at + 1..at + 1, again));
        }
        "swapped" => left.swap(at, at + length),
        "start" => drop(left.drain(..length)),
        // The first line and the end.
        "both" => *left = left[1..count - length].to_vec(),
        _ => {}
    }
}

/// What was drawn, and what came of it.
#[derive(Debug, Default)]
struct LineCounts {
    /// By class: how many logs, how many of them were refused; of the others, how many verdicts, and how many are sure.
    classes: BTreeMap<&'static str, [usize; 4]>,
    /// How many verdicts had been reached before anything was missing, and how many of these are sure.
    reached: [usize; 2],
    /// Verdicts that are sure and wrong, by class and property: the first of each, and its log.
    wrong: BTreeMap<(&'static str, String), String>,
}

impl LineCounts {
    /// Judges what is left of the `whole` log of a run, of which the outcomes after each number of events are known.
    fn judge(&mut self, what: &'static str, log: &Path, left: &[LineLeft], whole: &[LineLeft], run: &[Prospects]) {
        let [logs, refused, verdicts, sure] = self.classes.entry(what).or_default();
        *logs += 1;
        let found = match judge(log, PROPERTIES, &system()) {
            Ok(found) => found,
            Err(why) => {
                assert!(left != whole, "{}", why.reasons());
                *refused += 1;
                return;
            }
        };
        // Without its first line and its last, it is the log of a shorter run.
        let all = run.len() - 1;
        let is_told = left.iter().any(|(line, _)| *line == 0 || *line > all);
        let truth = if is_told { all } else { left.iter().map(|(line, _)| *line).max().unwrap_or(0) };
        let intact = left.iter().zip(whole).take_while(|(left, whole)| left == whole).count();
        let before = &run[intact.saturating_sub(1).min(all)];
        for (index, ((truth, _), (_, reached))) in run[truth].iter().zip(before).enumerate() {
            let is_sure = found.has_verdict(index);
            let is_right = !is_sure || found.outcome(index) == *truth;
            if !is_right || left == whole && *found.evidence[index].certainty() != Certainty::Sure {
                let text = || fs::read(log).map(|text| String::from_utf8_lossy(&text).into_owned());
                let wrong = || format!("{}, and not {truth}:\n{}", found.verdict(index), text().expect("a file"));
                self.wrong.entry((what, found.properties[index].name.clone())).or_insert_with(wrong);
            }
            *verdicts += 1;
            *sure += usize::from(is_sure);
            if left != whole && *reached != Verdict::Inconclusive {
                self.reached[0] += 1;
                self.reached[1] += usize::from(is_sure);
            }
        }
    }
}

/// Damages each of so many runs in every way, some of them in a second way, and converts them.
fn check(runs: usize, seed: u64) -> LineCounts {
    let topology = system();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut counts = LineCounts::default();
    for _ in 0..runs {
        let folder = tempfile::tempdir().expect("a folder");
        let [log, recording, tree] = ["run.jsonl", "run.mcap", "tree.btlog"].map(|name| folder.path().join(name));
        let events = run(&mut random, &topology);
        let outcomes = outcomes(&events, &topology);
        record(&events, &topology, &log);
        let text = fs::read(&log).expect("a file");
        let lines: Vec<&[u8]> = text.split_inclusive(|byte| *byte == b'\n').collect();
        assert_eq!(lines.len(), events.len() + 2, "{}", String::from_utf8_lossy(&text));
        let whole: Vec<LineLeft> = lines.iter().map(|line| line.len()).enumerate().collect();
        for what in DAMAGES {
            let mut left = whole.clone();
            damage(&mut left, what, &mut random);
            if left != whole && left.len() > 3 && left[0] == whole[0] && below(&mut random, 4) == 0 {
                damage(&mut left, DAMAGES[1 + below(&mut random, 7)], &mut random);
            }
            let text = left.iter().flat_map(|(line, bytes)| &lines[*line][..*bytes]);
            fs::write(&log, text.copied().collect::<Vec<u8>>()).expect("room for a file");
            counts.judge(what, &log, &left, &whole, &outcomes);
        }
        record(&events, &topology, &recording);
        let truth: Vec<&str> = outcomes[events.len()].iter().map(|(outcome, _)| outcome.name()).collect();
        let found = in_every_format(&recording, PROPERTIES, &topology);
        assert!(found.iter().all(|found| found.as_ref() == Some(&truth)), "{found:?}, not {truth:?}: {events:?}");
        check_tree_log(&tree, &mut random);
        for class in ["a run in every format", "a log of BehaviorTree.CPP in every format"] {
            counts.classes.entry(class).or_default()[0] += 1;
        }
    }
    let wrong = counts.wrong.iter().map(|((what, name), log)| format!("{what}: {name} is {log}\n"));
    assert!(counts.wrong.is_empty(), "{}", wrong.collect::<String>());
    counts
}

#[test]
fn a_verdict_on_what_is_left_of_a_log_is_that_of_the_whole_log_or_unsure() {
    let counts = check(60, 1);
    println!("{counts:?}");
    let drawn: usize = counts.classes.values().map(|[logs, ..]| logs).sum();
    let is_drawn = counts.classes.len() == 12 && counts.classes.values().all(|[logs, ..]| logs * 20 >= drawn);
    let [reached, sure] = counts.reached;
    assert!(is_drawn && reached * 2 > drawn && sure * 3 > reached * 2, "{counts:?}");
}

#[test]
#[ignore = "long: LOGS=100000 cargo test --release lines_on_demand -- --ignored --nocapture"]
fn lines_on_demand() {
    let logs = std::env::var("LOGS").ok().and_then(|logs| logs.parse().ok()).unwrap_or(10_000_usize);
    let LineCounts { classes, reached: [reached, sure], .. } = check(logs.div_ceil(DAMAGES.len() + 2), 2);
    for (class, [logs, refused, verdicts, sure]) in classes {
        println!("{class}: {logs} logs, {refused} of them refused; {sure} of {verdicts} verdicts are sure");
    }
    println!("of {reached} verdicts that were reached before anything was missing, {sure} are sure");
}
