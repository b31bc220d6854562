//! Which messages of a violation's episode are worth drawing.

use std::collections::BTreeSet;
use std::time::Duration;

use channels::{Event, EventKind, Topology};
use diagnostics::counted;
use monitors::WORLD;
use recording::{FaultCourse, FaultRecord, Moved};

use crate::html::evidence::{Evidence, Seen};

/// Beyond this number, ticks are summarized even if something happened at them.
const MOST_TICKS: usize = 8;
/// How many messages after the verdict are drawn.
const MOST_AFTERWARDS: usize = 6;

/// How much a message matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Weight {
    /// It shows that things continued.
    Plain,
    /// It belongs to what caused the violation.
    Cause,
    /// It is the one that violated the property.
    Decisive,
    /// It came after the verdict.
    Afterwards,
}

/// A line of a sequence chart.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Row {
    /// A tick begins; of a run whose ticks are not known, what follows.
    Tick { tick: Option<u64>, time: Duration },
    /// A message is received. Lifelines are indices.
    Message { from: usize, to: usize, seen: Seen, weight: Weight },
    /// Ticks that are summarized.
    Ticks { first: u64, last: u64, words: String },
    /// A fault takes effect.
    Fault { words: String, time: Duration },
    /// Something happens around the processes.
    Moved { words: String },
    /// A message that should have come did not.
    Missing { from: usize, to: usize, message: String, words: String },
    /// The property is violated.
    Verdict { words: String, time: Duration },
}

/// The lifelines and lines of a sequence chart.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sequence {
    /// The processes that are drawn, in the order of the system.
    pub lifelines: Vec<String>,
    /// The lines, from the top.
    pub rows: Vec<Row>,
}

struct TickEvents<'a> {
    tick: u64,
    time: Duration,
    /// Those between processes that are drawn.
    events: Vec<&'a Event>,
}

impl Sequence {
    /// The chart for a violation; `faults` are all faults of the run, and `moves` what happened around it.
    pub(crate) fn of(evidence: &Evidence<'_>, topology: &Topology, faults: &[FaultRecord], moves: &[Moved]) -> Self {
        let lifelines = lifelines(evidence, topology);
        let ticks = by_tick(evidence, topology, &lifelines);
        let mut narrator = Narrator { evidence, topology, lifelines: &lifelines, faults, moves, rows: Vec::new() };
        narrator.narrate(&ticks);
        let rows = narrator.rows;
        Self { lifelines, rows }.without_idle_lifelines()
    }

    /// Whether one of its messages is this important.
    pub(crate) fn has(&self, wanted: Weight) -> bool {
        self.rows.iter().any(|row| matches!(row, Row::Message { weight, .. } if *weight == wanted))
    }

    /// Drops the lifelines without messages.
    fn without_idle_lifelines(self) -> Self {
        let used: BTreeSet<usize> = self
            .rows
            .iter()
            .flat_map(|row| match row {
                Row::Message { from, to, .. } | Row::Missing { from, to, .. } => vec![*from, *to],
                _ => Vec::new(),
            })
            .collect();
        let place = |old: usize| used.range(..old).count();
        let mut rows = self.rows;
        for row in &mut rows {
            if let Row::Message { from, to, .. } | Row::Missing { from, to, .. } = row {
                (*from, *to) = (place(*from), place(*to));
            }
        }
        let lifelines = self.lifelines.into_iter().enumerate().filter(|(index, _)| used.contains(index));
        Self { lifelines: lifelines.map(|(_, name)| name).collect(), rows }
    }
}

/// The processes that the property concerns, and the tree if it talks to one of them, in the order of the system.
fn lifelines(evidence: &Evidence<'_>, topology: &Topology) -> Vec<String> {
    let ticked_by = |name: &str| {
        let ends = topology.channels().map(|channel| topology.ends(channel));
        let asking = ends.filter(|(_, to)| *to == name).map(|(from, _)| from.to_owned());
        asking.collect::<Vec<_>>()
    };
    let tree = tree_of(evidence, &ticked_by);
    let all = topology.processes().filter(|process| topology.whole(*process) == *process);
    let names = all.map(|process| topology.name(process).to_owned());
    let is_tree = |name: &String| tree.as_ref() == Some(name) && !is_tick_source(name, topology);
    names.filter(|name| is_tree(name) || evidence.concerned.contains(name)).collect()
}

/// The process that ticks those that the property concerns: the one from which most of them get messages.
fn tree_of(evidence: &Evidence<'_>, ticked_by: &impl Fn(&str) -> Vec<String>) -> Option<String> {
    let heard: Vec<String> = evidence.concerned.iter().flat_map(|name| ticked_by(name)).collect();
    let others = heard.iter().filter(|name| !evidence.concerned.contains(name));
    let times = |name: &str| heard.iter().filter(|other| *other == name).count();
    others.max_by_key(|name| (times(name), std::cmp::Reverse((*name).clone()))).cloned()
}

/// Whether a process only supplies ticks; they are drawn as lines across.
fn is_tick_source(name: &str, topology: &Topology) -> bool {
    !topology.channels().any(|channel| topology.ends(channel).1 == name)
}

/// The events from shortly before the story begins, tick by tick.
fn by_tick<'a>(evidence: &Evidence<'a>, topology: &Topology, lifelines: &[String]) -> Vec<TickEvents<'a>> {
    let before = u64::from(evidence.missing.is_empty());
    let from_tick = evidence.first_tick().saturating_sub(before);
    let drawn = |event: &Event| match &event.kind {
        EventKind::Tick => false,
        EventKind::Received { channel, .. } => {
            let (from, to) = topology.ends(*channel);
            [from, to].iter().all(|end| lifelines.iter().any(|name| name == end))
        }
    };
    let mut ticks: Vec<TickEvents<'a>> = Vec::new();
    for event in evidence.episode.events.iter().filter(|event| event.tick >= from_tick) {
        if ticks.last().is_none_or(|last| last.tick != event.tick) {
            ticks.push(TickEvents { tick: event.tick, time: event.time, events: Vec::new() });
        }
        if let Some(last) = ticks.last_mut().filter(|_| drawn(event)) {
            last.events.push(event);
        }
    }
    ticks
}

struct Narrator<'a> {
    evidence: &'a Evidence<'a>,
    topology: &'a Topology,
    lifelines: &'a [String],
    faults: &'a [FaultRecord],
    /// Events around the processes that have not been drawn yet.
    moves: &'a [Moved],
    rows: Vec<Row>,
}

impl Narrator<'_> {
    fn narrate(&mut self, ticks: &[TickEvents<'_>]) {
        let shown = self.shown_ticks(ticks);
        let first = ticks.first().map_or(Duration::ZERO, |tick| tick.time);
        let mut narrated = first;
        let mut skipped: Vec<&TickEvents<'_>> = Vec::new();
        for tick in ticks {
            let strikes = self.faults.iter().any(|fault| fault.time > narrated && fault.time <= tick.time);
            let moves = self.moves.first().is_some_and(|moved| moved.time <= tick.time);
            if strikes || moves || shown.contains(&tick.tick) {
                self.sum_up(&std::mem::take(&mut skipped));
                self.narrate_faults(narrated, tick.time);
                narrated = tick.time;
            }
            if shown.contains(&tick.tick) {
                self.narrate_tick(tick);
            } else {
                skipped.push(tick);
            }
        }
    }

    /// The ticks that are drawn in full: those of the causes, the last one, those of faults, and one from before unless
    /// an answer is missing.
    fn shown_ticks(&self, ticks: &[TickEvents<'_>]) -> BTreeSet<u64> {
        let last = self.evidence.episode.decided.tick;
        let mut shown = BTreeSet::from([last]);
        let causes = self.evidence.causes.iter().rev().map(|seen| seen.at.tick);
        for tick in causes.chain(self.evidence.since.map(|since| since.tick)) {
            if shown.len() < MOST_TICKS {
                shown.insert(tick);
            }
        }
        // For a fault that repeats, the first time is enough.
        let firsts = FaultCourse::of(self.faults);
        let faults = firsts.iter().filter_map(|course| ticks.iter().find(|tick| tick.time >= course.first().time));
        shown.extend(faults.map(|tick| tick.tick).take(MOST_TICKS));
        if let Some(first) = shown.first().filter(|_| self.evidence.missing.is_empty()) {
            // This shows what happened when all was well.
            shown.insert(first.saturating_sub(1));
        }
        shown
    }

    fn narrate_faults(&mut self, after: Duration, until: Duration) {
        let new = self.faults.iter().filter(|fault| fault.time > after && fault.time <= until);
        let rows: Vec<Row> =
            new.map(|fault| Row::Fault { words: fault.fault.words.clone(), time: fault.time }).collect();
        self.rows.extend(rows);
        let (moves, later) = self.moves.split_at(self.moves.partition_point(|moved| moved.time <= until));
        self.moves = later;
        self.rows.extend(moves.iter().map(|moved| Row::Moved { words: moved.words.clone() }));
    }

    fn narrate_tick(&mut self, tick: &TickEvents<'_>) {
        let number = Some(tick.tick).filter(|_| self.evidence.knows_ticks);
        self.rows.push(Row::Tick { tick: number, time: tick.time });
        let decided = &self.evidence.episode.decided;
        let is_last = tick.tick == decided.tick;
        if is_last && decided.kind == EventKind::Tick {
            return self.narrate_verdict();
        }
        let mut afterwards = 0;
        let mut alike = 0;
        for (index, event) in tick.events.iter().enumerate() {
            let Some(mut seen) = Seen::of(event, self.topology) else { continue };
            let later = is_last && event.step > decided.step;
            // The rest of the tick shows that the run went on; a few messages are enough for that.
            afterwards += usize::from(later);
            if afterwards > MOST_AFTERWARDS {
                break;
            }
            let weight = match () {
                () if *event == decided => Weight::Decisive,
                () if later => Weight::Afterwards,
                () if self.evidence.causes.contains(&seen) => Weight::Cause,
                () => Weight::Plain,
            };
            // The world shows itself in each step of the physics: of a row of such messages, the last one is drawn.
            alike += 1;
            let next = tick.events.get(index + 1).filter(|next| **next != decided);
            let next = next.and_then(|next| Seen::of(next, self.topology));
            let goes_on = next.is_some_and(|next| next.from == WORLD && !self.evidence.causes.contains(&next));
            if weight == Weight::Plain && seen.from == WORLD && goes_on {
                continue;
            }
            let run = std::mem::take(&mut alike);
            if run > 1 {
                seen.message += &format!(", the last of {run}");
            }
            let (from, to) = (self.place(&seen.from), self.place(&seen.to));
            self.rows.push(Row::Message { from, to, seen, weight });
            if weight == Weight::Decisive {
                self.narrate_verdict();
            }
        }
    }

    fn place(&self, name: &str) -> usize {
        self.lifelines.iter().position(|known| known == name).unwrap_or(0)
    }

    fn narrate_verdict(&mut self) {
        let evidence = self.evidence;
        for missing in &evidence.missing {
            let words = match evidence.deadline_tick {
                Some(tick) => format!("missing until tick {tick}"),
                None => "missing".to_owned(),
            };
            let (from, to) = (self.place(&missing.from), self.place(&missing.to));
            self.rows.push(Row::Missing { from, to, message: missing.message.clone(), words });
        }
        let words = format!("{} is violated", evidence.name);
        self.rows.push(Row::Verdict { words, time: evidence.episode.decided.time });
    }

    /// Adds one line for ticks that are not drawn.
    fn sum_up(&mut self, ticks: &[&TickEvents<'_>]) {
        let (Some(first), Some(last)) = (ticks.first(), ticks.last()) else { return };
        let alike = ticks.iter().all(|tick| self.outline(tick) == self.outline(first));
        let messages: usize = ticks.iter().map(|tick| tick.events.len()).sum();
        let mut words = match (ticks.len(), alike, messages) {
            (.., 0) => "no message between these processes".to_owned(),
            (1, ..) => counted(messages, "message"),
            (count, true, _) => {
                format!("the same {} at each of {count} ticks", counted(first.events.len(), "message"))
            }
            (count, false, _) => format!("{} at {count} ticks", counted(messages, "message")),
        };
        for missing in &self.evidence.missing {
            let on = |event: &&Event| matches!(&event.kind, EventKind::Received { channel, .. } if *channel == missing.channel);
            let found = ticks.iter().flat_map(|tick| tick.events.iter().copied()).filter(on);
            // What came before the condition cannot be its answer, though it came on the right channel.
            let owed_since = self.evidence.since.map_or(0, |since| since.step);
            let (early, other): (Vec<&Event>, Vec<&Event>) = found.partition(|event| event.step < owed_since);
            let ends = format!("from {} to {}", missing.from, missing.to);
            words += &match (early.len(), other.len()) {
                (0, 0) => format!(", none {ends}"),
                (0, 1) => format!(", one {ends}, but not the one that was due"),
                (0, count) => format!(", {count} {ends}, but not the one that was due"),
                (1, 0) => format!(", one {ends}, before one was due"),
                (early, 0) => format!(", {early} {ends}, before one was due"),
                (early, other) => format!(", {} {ends}, {early} of them before one was due", early + other),
            };
        }
        self.rows.push(Row::Ticks { first: first.tick, last: last.tick, words });
    }

    /// The contents of a tick, ignoring numbers.
    fn outline(&self, tick: &TickEvents<'_>) -> Vec<(usize, Option<String>)> {
        let outline = |event: &&Event| match &event.kind {
            EventKind::Tick => None,
            EventKind::Received { channel, message } => Some((channel.index(), message.head().map(str::to_owned))),
        };
        tick.events.iter().filter_map(outline).collect()
    }
}
