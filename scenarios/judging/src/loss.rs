//! Messages that are lost on the way, or late, planted in runs that are made up: a verdict is that of the run as it was
//! sent, or it is unsure. What is lost is known from numbers, so most verdicts that it cannot change are sure.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

use bags::{Account, Definition, Events, Ground, Head, Mapping, Received, Source, Survey, Topic};
use monitors::{Outcome, Property};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};
use recording::{Certainty, Doubts, Evidence};

use crate::judge::judge_without_records;
use crate::log_context::LogContext;

const TOPICS: [&str; 3] = ["/battery", "/request", "/reply"];

const PROPERTIES: &str = "
    property low := always (battery, monitor, m.x >= 4)
    property answered := always ((request, monitor, m.x > 2) implies time_until (reply, monitor, true) < 0.5 s)
    property allowed := always ((request, monitor, m.x = 3) implies not (battery, monitor, m.x < 15))
    property asked := always ((reply, monitor, true) implies once[<= 2 s] (request, monitor, true))
    property calm := always ((reply, monitor, m.x = 5) implies not time_until (reply, monitor, m.x = 5) < 0.3 s)
    property alive := always ((battery, monitor, true) implies next (battery, monitor, true))
    property regular := always ((battery, monitor, true) implies time_until (request, monitor, true) < 1 s)
    property sometimes := eventually (reply, monitor, m.x = 9)
    property first := (not (request, monitor, m.x = 9)) until (battery, monitor, m.x < 12)
    property steady := always ((battery, monitor, m.x as now) implies not previous (battery, monitor, m.x < now - 50))
    property same := always ((request, monitor, m.x > 6 and m.x as id)
        implies time_until (reply, monitor, m.x != id) < 0.7 s)
    timed property soon := always ((request, monitor, m.x > 8) implies time_until (reply, monitor, true) < 0.35 s)
    property fresh_ones := always ((request, monitor, m.x = 7) and fresh (request, monitor, true) implies
        not (reply, monitor, m.x = 7))
    property charged := always (battery, monitor, m.x > 2 or m.x < 1)
    property both := always ((request, monitor, m.x > 9) implies time_until (reply, monitor, true) < 0.5 s)
        and always (battery, monitor, m.x >= 4)
    property either := (time_until (reply, monitor, m.x = 9) < 0.3 s) implies always (battery, monitor, m.x >= 5)";

/// A message: when it was received, its topic, and its number.
#[derive(Clone, Copy, Debug)]
struct Sent {
    ns: i64,
    topic: usize,
    x: i32,
    is_lost: bool,
    /// How much later than it was due it comes; and how much earlier than that it may have been due.
    late_ns: i64,
    early_ns: i64,
}

impl Sent {
    fn arrives_ns(&self) -> i64 {
        self.ns + self.late_ns
    }
}

/// Numbers that the properties distinguish.
const NUMBERS: [i32; 9] = [0, 1, 3, 5, 7, 9, 11, 13, 60];

const START_NS: i64 = 1_700_000_000_000_000_000;

/// A run with a loss of so many in a thousand. The first message arrives; so does the last on each topic, unless the
/// end may be lost, too: counting does not reveal that.
fn run(random: &mut ChaCha8Rng, per_mille: u32, may_lose_end: bool) -> Vec<Sent> {
    let (mut ns, mut sent) = (START_NS, Vec::new());
    for index in 0..40 + random.next_u32() % 80 {
        let topic = if index == 0 { 0 } else { random.next_u32() as usize % 3 };
        let x = i32::try_from(if topic == 0 { 3 + random.next_u32() % 60 } else { random.next_u32() % 12 });
        let is_lost = index > 0 && random.next_u32() % 1000 < per_mille;
        sent.push(Sent { ns, topic, x: x.expect("a small number"), is_lost, late_ns: 0, early_ns: 0 });
        // No two have the same time, as from a robot.
        ns += i64::from(1 + random.next_u32() % 250_000) * 1000;
    }
    for topic in (0..3).filter(|_| !may_lose_end) {
        if let Some(last) = sent.iter_mut().rfind(|sent| sent.topic == topic) {
            last.is_lost = false;
        }
    }
    sent
}

/// Lets so many in a thousand come later. Those after them on their topics wait for them.
fn delay(sent: &mut [Sent], random: &mut ChaCha8Rng, per_mille: u32) {
    let mut last_ns = [i64::MIN; 3];
    for sent in sent.iter_mut().skip(1) {
        if random.next_u32() % 1000 < per_mille {
            sent.late_ns = i64::from(random.next_u32() % 700_000) * 1000;
            sent.early_ns = i64::from(random.next_u32() % 50_000) * 1000;
        }
        let last_ns = &mut last_ns[sent.topic];
        sent.late_ns = sent.late_ns.max(last_ns.saturating_add(1000).saturating_sub(sent.ns));
        *last_ns = sent.arrives_ns();
    }
}

/// The run with other messages in place of those that are lost, at other times within the gaps.
fn elsewhere(sent: &[Sent], random: &mut ChaCha8Rng) -> Vec<Sent> {
    let mut others = Vec::new();
    for (index, lost) in sent.iter().enumerate() {
        let received = |sent: &&Sent| sent.topic == lost.topic && !sent.is_lost;
        let (mut ns, mut x) = (lost.ns, lost.x);
        if lost.is_lost {
            let first = sent[..index].iter().rfind(received).map_or(START_NS, |before| before.ns);
            let last = sent[index..].iter().find(received).map_or(end_ns(sent) + 1, |next| next.ns);
            ns = first + 1 + (random.next_u64() % (last - first - 1) as u64) as i64;
            x = NUMBERS[random.next_u32() as usize % NUMBERS.len()];
        }
        others.push(Sent { ns, x, is_lost: false, late_ns: 0, ..*lost });
    }
    others.sort_by_key(|sent| sent.ns);
    others
}

/// When a run ends: at the same time, whatever is lost.
fn end_ns(sent: &[Sent]) -> i64 {
    sent.iter().map(Sent::arrives_ns).max().unwrap_or(START_NS)
}

/// The run as it is received, or as it was sent.
struct Robot {
    sent: std::vec::IntoIter<Sent>,
    survey: Survey,
    /// What comes next, after what is lost before it.
    next: Option<Sent>,
    /// For each topic, how many messages are missing since when.
    missing: [(u64, i64); 3],
    /// Since when the last message may have been due, if it was late.
    late: Option<(usize, i64)>,
    /// The reported number of messages in a gap, if it is not the true one.
    reported: Option<u64>,
    end_ns: i64,
    is_over: bool,
    /// Whether silence is reported before the next message.
    is_silent: bool,
}

impl Robot {
    fn new(mut sent: Vec<Sent>, end_ns: i64, ground: Ground) -> Self {
        sent.sort_by_key(Sent::arrives_ns);
        let mut survey = Survey { ground, ..Survey::default() };
        for name in TOPICS {
            let definition = Definition { language: "ros2msg".to_owned(), text: "int32 x\n".to_owned() };
            let [name, kind, encoding] = [name, "p/msg/P", "cdr"].map(str::to_owned);
            survey.add(Topic { name, kind, encoding, definition: Some(definition), hash: None });
        }
        Self {
            sent: sent.into_iter(),
            survey,
            next: None,
            missing: [(0, START_NS); 3],
            late: None,
            reported: None,
            end_ns,
            is_over: false,
            is_silent: true,
        }
    }
}

impl Source for Robot {
    fn receive(&mut self, body: &mut Vec<u8>) -> Received {
        loop {
            if let Some((topic, since_ns)) = self.late.take() {
                return Received::Late { topic, since_ns };
            }
            let Some(sent) = self.next.take().or_else(|| self.sent.next()) else {
                // The end is at the same time, whether or not the last message arrived.
                let is_over = std::mem::replace(&mut self.is_over, true);
                return if is_over { Received::Over } else { Received::ClockAdvanced(self.end_ns) };
            };
            // At the same times, whatever is lost.
            let at_ns = sent.arrives_ns();
            if std::mem::take(&mut self.is_silent) && sent.ns % 3 == 0 {
                self.next = Some(sent);
                return Received::ClockAdvanced(at_ns);
            }
            self.is_silent = true;
            let (count, since_ns) = &mut self.missing[sent.topic];
            if sent.is_lost {
                *count += 1;
                continue;
            }
            if *count > 0 {
                (self.next, self.is_silent) = (Some(sent), false);
                let count = Some(self.reported.unwrap_or(std::mem::take(count)));
                return Received::Lost { topic: sent.topic, count, since_ns: *since_ns };
            }
            // It is known when the one before was due, and that this one was due after it.
            let due_ns = (sent.ns - sent.early_ns).max(*since_ns);
            *since_ns = due_ns;
            self.late = (sent.late_ns > 0).then_some((sent.topic, due_ns));
            *body = [&[0, 1, 0, 0], &sent.x.to_le_bytes()[..]].concat();
            self.survey.count(sent.topic, at_ns);
            return Received::Message(Head { topic: sent.topic, log_ns: at_ns, publish_ns: at_ns });
        }
    }

    fn account(&self) -> Account<'_> {
        Account { survey: &self.survey, lost: &[], notes: &[], counts_losses: false }
    }
}

fn mapping(reorder_s: &str) -> Mapping {
    let entry = |topic: &str| {
        let from = &topic[1..];
        format!("[[messages]]\ntopic = {topic:?}\nfrom = {from:?}\nto = \"monitor\"\nfields = {{ x = \"x\" }}\n")
    };
    let text = format!("tick_s = 0.1\nreorder_s = {reorder_s}\ntime = \"log\"\n{}", TOPICS.map(entry).concat());
    Mapping::load(Path::new("m.toml"), &|_| Ok(text.clone().into_bytes())).expect("correct")
}

/// What was found of a property.
struct LossVerdict {
    name: String,
    outcome: Outcome,
    certainty: Certainty,
    /// When it was violated.
    violated: Option<Duration>,
}

impl LossVerdict {
    /// The outcome if it is sure.
    fn sure(&self) -> Option<Outcome> {
        (self.certainty == Certainty::Sure).then_some(self.outcome)
    }
}

fn outcomes(robot: Robot, mapping: &Mapping) -> Vec<LossVerdict> {
    let read = &diagnostics::from_disk;
    let Ok(compiled) = mapping.compile(&robot.survey, None, read) else { panic!("it fits") };
    let topology = compiled.topology.clone();
    let mut properties = monitors::load("p.scope", PROPERTIES, &topology, mapping.tick).expect("correct").properties;
    let doubts = Doubts::about_losses(&properties, &topology);
    let found = Events::new(Box::new(robot), mapping, compiled, read).map(Ok);
    let Ok(monitoring) = judge_without_records(found, &mut properties, doubts, &LogContext::default(), None) else {
        panic!("no event is an error")
    };
    let found = |(property, evidence): (&Property, &Evidence)| LossVerdict {
        name: property.name.clone(),
        outcome: Outcome::of(property.monitor.as_ref()),
        certainty: evidence.certainty().clone(),
        violated: property.scope_monitor().and_then(|monitor| monitor.witness()).map(|witness| witness.settled.time),
    };
    properties.iter().zip(&monitoring.evidence).map(found).collect()
}

/// What was found in many runs: how many messages; of the verdicts on runs with losses that no lost message changes,
/// how many are sure.
#[derive(Debug, Default)]
struct Shares {
    messages: usize,
    unchanged: usize,
    sure: usize,
    /// How many are sure unless a message was lost.
    unless: usize,
    /// The others, by the names of properties.
    unsure: BTreeMap<String, usize>,
}

/// With so many other runs with the same losses, besides those with other messages at the same times; if 0, with none.
fn check(messages: usize, [per_mille, late]: [u32; 2], seed: u64, others: usize, may_lose_end: bool) -> Shares {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut found = Shares::default();
    let assumed = Ground::Assumed("the last messages arrive".to_owned());
    let ground = if may_lose_end { Ground::Numbered } else { assumed.clone() };
    while found.messages < messages {
        let reorder_s = ["0", "0.3"][random.next_u32() as usize % 2];
        let mapping = mapping(reorder_s);
        let mut sent = run(&mut random, per_mille, may_lose_end);
        if late > 0 {
            delay(&mut sent, &mut random, late);
        }
        found.messages += sent.len();
        if !sent.iter().any(|sent| sent.is_lost || sent.late_ns > 0) {
            continue;
        }
        let judged = |sent: Vec<Sent>, end_ns: i64, ground: &Ground| {
            outcomes(Robot::new(sent, end_ns, ground.clone()), &mapping)
        };
        let (end, whole) =
            (end_ns(&sent), sent.iter().map(|sent| Sent { is_lost: false, late_ns: 0, ..*sent }).collect());
        let (received, truth) = (judged(sent.clone(), end, &ground), judged(whole, end, &assumed));
        let last = |topic: usize| sent.iter().rfind(|sent| sent.topic == topic);
        let loses_end = (0..3).any(|topic| last(topic).is_some_and(|last| last.is_lost));
        // Whether other messages in place of those that are lost, then or at other times, or none at all, lead to other
        // verdicts: the properties distinguish no more numbers than these.
        let in_place = NUMBERS.map(|x| {
            let other =
                |sent: &Sent| Sent { x: if sent.is_lost { x } else { sent.x }, is_lost: false, late_ns: 0, ..*sent };
            sent.iter().map(other).collect()
        });
        let in_time = |sent: &Sent| (!sent.is_lost).then_some(Sent { late_ns: 0, ..*sent });
        let received_only = sent.iter().filter_map(in_time).collect();
        let at_other_times = (0..others).map(|_| elsewhere(&sent, &mut random));
        let runs = in_place.into_iter().chain([received_only]).chain(at_other_times);
        let runs = runs.filter(|_| others > 0).map(|other| judged(other, end, &assumed));
        let found_by_others: Vec<_> = runs.collect();
        for (index, (found_now, truth)) in received.iter().zip(&truth).enumerate() {
            let LossVerdict { name, violated, certainty, .. } = found_now;
            let (verdict, first) = (found_now.sure(), truth.violated);
            let is_unchanged = found_by_others.iter().all(|other| other[index].sure() == truth.sure());
            let is_right = is_unchanged && verdict == truth.sure();
            assert!(
                verdict.is_none() || is_right,
                "{name}: {verdict:?}, and not {:?}, or another: {sent:?}",
                truth.outcome
            );
            assert!(verdict.is_none() || *violated >= first, "{name}: {violated:?}, and not {first:?}: {sent:?}");
            if let Certainty::Unless(why) = certainty {
                found.unless += 1;
                let is_right = loses_end || found_now.outcome == truth.outcome;
                assert!(
                    is_right,
                    "{name}: {:?} unless {why}, and not {:?}: {sent:?}",
                    found_now.outcome, truth.outcome
                );
            }
            if is_unchanged {
                found.unchanged += 1;
                found.sure += usize::from(verdict.is_some());
                if verdict.is_none() {
                    *found.unsure.entry(name.clone()).or_default() += 1;
                }
            }
        }
    }
    found
}

#[test]
fn a_verdict_is_that_of_the_run_as_it_was_sent_or_unsure() {
    for (per_mille, seed) in [(10, 1), (100, 2)] {
        let found = check(4000, [per_mille, 0], seed, 16, false);
        let share = found.sure as f64 / found.unchanged as f64;
        println!("{per_mille} of 1000 lost: {found:?}, {share:.3}");
        assert!(per_mille > 10 || share >= 0.95, "{found:?}");
    }
}

#[test]
fn a_verdict_is_that_of_the_run_in_which_every_message_came_when_it_was_due_or_unsure() {
    for (per_mille, late, seed) in [(0, 20, 7), (20, 50, 8)] {
        let found = check(4000, [per_mille, late], seed, 16, false);
        println!("of 1000, {per_mille} lost and {late} late: {found:?}");
        assert!(found.sure * 2 > found.unchanged, "{found:?}");
    }
}

#[test]
fn a_verdict_that_the_loss_of_a_last_message_could_change_holds_unless_it_was_lost() {
    for (per_mille, seed) in [(10, 5), (100, 6)] {
        let found = check(4000, [per_mille, 0], seed, 16, true);
        println!("{per_mille} of 1000 lost: {found:?}");
        assert!(found.unless > 0 && found.sure > 0, "{found:?}");
    }
}

#[test]
fn a_verdict_that_only_two_lost_messages_together_could_change_holds_unless_both_were_lost() {
    let at =
        |s: i64, topic: usize, x: i32| Sent { ns: START_NS + s, topic, x, is_lost: false, late_ns: 0, early_ns: 0 };
    // A low battery alone changes nothing, and neither does a request of 3.
    let sent = vec![at(0, 0, 60), at(1, 1, 0), at(2, 2, 0)];
    let found = outcomes(Robot::new(sent, START_NS + 3, Ground::Numbered), &mapping("0"));
    let allowed = found.iter().find(|found| found.name == "allowed").expect("a property");
    let both =
        matches!(&allowed.certainty, Certainty::Unless(why) if why.contains("battery") && why.contains("request"));
    assert!(both, "{:?}", allowed.certainty);
}

/// What a gap can change does not depend on its length, which forged numbers make as large as they like.
#[test]
fn a_verdict_is_as_sure_however_many_messages_a_gap_has() {
    let mut random = ChaCha8Rng::seed_from_u64(9);
    let (mapping, mut unsure) = (mapping("0"), 0);
    for _ in 0..30 {
        let sent = run(&mut random, 100, true);
        let judged = |reported: Option<u64>| {
            let robot = Robot { reported, ..Robot::new(sent.clone(), end_ns(&sent), Ground::Numbered) };
            let found = outcomes(robot, &mapping).into_iter();
            found
                .map(|of| (of.name, of.outcome, std::mem::discriminant(&of.certainty), of.violated))
                .collect::<Vec<_>>()
        };
        let counted = judged(None);
        let sure = std::mem::discriminant(&Certainty::Sure);
        unsure += counted.iter().filter(|(.., certainty, _)| *certainty != sure).count();
        for reported in [0, 1, 1 << 32, 1 << 61, u64::MAX] {
            assert_eq!(judged(Some(reported)), counted, "{reported} instead of the true numbers: {sent:?}");
        }
    }
    assert!(unsure > 0);
}

#[test]
#[ignore = "long: MESSAGES=10000000 cargo test --release loss_on_demand -- --ignored --nocapture"]
fn loss_on_demand() {
    let messages = std::env::var("MESSAGES").ok().and_then(|count| count.parse().ok()).unwrap_or(1_000_000);
    for (lost, late, seed, may_lose_end) in
        [(10, 0, 3, false), (50, 0, 4, false), (50, 0, 5, true), (0, 20, 6, false), (10, 50, 7, false)]
    {
        let Shares { messages, sure, unchanged, .. } = check(messages / 5, [lost, late], seed, 0, may_lose_end);
        println!(
            "of 1000, {lost} lost and {late} late: {messages} messages; of {unchanged} verdicts, {sure} are sure, and right"
        );
    }
}
