//! A run in which something goes wrong, in words, and its replay.

use campaigns::Error;
use channels::{ChannelId, ChannelSystem, EnabledKind, EventKind, Message, NoNormalForm, Topology, Verdict};
use explorer::{Damage, Outcome, Path, PathStep, Replay};
use monitors::scope_monitor;
use proofs::{Answer, Assumption, Proof, Question, Subject};
use recording::message_json;
use reports::results::{TrailStep, WrittenPlaces};
use serde_json::json;

/// A run in which something goes wrong, replayed in the channel system with the ordinary monitor.
pub(crate) struct Violation {
    /// The violation, to follow the name of the property.
    what: &'static str,
    /// Which messages pile up, if that is so, to follow the violation.
    piled_up: String,
    lines: Vec<RunLine>,
    ticks: usize,
    /// Whether the replay confirms the search.
    pub(crate) is_replayed: bool,
    /// The assumptions of which it makes use.
    rests_on: Vec<String>,
}

/// Each event, with the tick after which it happened.
struct RunLine {
    tick: Option<u64>,
    what: What,
}

enum What {
    /// The following events repeat forever.
    Repeats,
    Environment(String),
    Tick {
        is_delivered: bool,
    },
    Message {
        from: String,
        to: String,
        message: Message,
        /// Whether the property is about such messages.
        is_watched: bool,
    },
    Damage {
        from: String,
        to: String,
        how: &'static str,
    },
}

/// The first and last of the ticks since the last line that was written.
struct Ticks(Option<(u64, u64)>);

impl Ticks {
    fn extend(&mut self, tick: u64) {
        self.0 = Some((self.0.map_or(tick, |(first, _)| first), tick));
    }

    /// Writes them: the last one by itself, since the next line belongs to it.
    fn write(&mut self, text: &mut String) {
        let Some((first, last)) = self.0.take() else { return };
        match last - first {
            0 => {}
            1 => *text += &format!("  tick {first}\n"),
            _ => *text += &format!("  ticks {first} to {}\n", last - 1),
        }
        *text += &format!("  tick {last}\n");
    }
}

impl Violation {
    /// The run that the search found, if any.
    pub(crate) fn of(proof: &Proof, question: &Question, answer: &Answer) -> Result<Option<Self>, Error> {
        let monitor = proof.monitor(question);
        let (path, what) = match &answer.exploration.outcome {
            Outcome::Violated(path) if answer.is_spurious => (path, "is spurious"),
            Outcome::Violated(path) => (path, "is violated"),
            Outcome::Endless(path) if question.subject == Subject::Progress => {
                (path, "is violated: messages pile up without end")
            }
            Outcome::Endless(path) => (path, "is not decided: messages pile up without end"),
            Outcome::Deadlock(path) => (path, "is violated: the tree takes no further tick, and nothing else happens"),
            Outcome::Livelock(path) => (path, "is violated: processes communicate forever within a tick"),
            Outcome::Proved | Outcome::Undecided(_) => return Ok(None),
        };
        let mut replay = path.replay(&answer.model, monitor).map_err(|error| {
            let help = "this is a bug in steward: please report it, with the scenario";
            Error::refused(format!("a run that violates {} cannot be replayed: {error}", question.property), help)
        })?;
        let mut watched: Vec<ChannelId> = Vec::new();
        if let Some(scope) = monitor.and_then(scope_monitor) {
            scope.formula().events(&mut |event| watched.push(event.channel));
        }
        // Without a property, only the end of the run matters.
        let is_tick = |step: &PathStep| matches!(step, PathStep::Tick { delivered: true });
        let end = match (monitor, path.cycle()) {
            (Some(_), _) => path.steps().len(),
            (None, 0) => path.steps().iter().rposition(is_tick).unwrap_or(0),
            (None, cycle) => path.steps().len() - cycle,
        };
        let is_watched = |step, channel| step >= end || watched.contains(&channel);
        let waiting = match &answer.exploration.outcome {
            Outcome::Endless(_) => piled_up(&replay.system),
            _ => None,
        };
        let is_replayed = match &answer.exploration.outcome {
            Outcome::Violated(_) => replay.verdict() == Verdict::False,
            Outcome::Endless(_) => waiting.is_some(),
            Outcome::Deadlock(_) => replay.system.enabled().is_empty(),
            _ => replay.comes_back,
        };
        let lines = lines(path, &replay, is_watched);
        let rests_on = words(&proof.assumptions_of(path, &replay));
        let piled_up = waiting.map(|what| format!(" ({what}, and what follows is not searched)")).unwrap_or_default();
        Ok(Some(Self { what, piled_up, lines, ticks: path.ticks(), is_replayed, rests_on }))
    }

    /// The tick in which it is decided.
    fn tick(&self) -> Option<u64> {
        self.lines.last().and_then(|line| line.tick)
    }

    /// The run, one event per line: with `all`, all messages; otherwise only those that the property is about.
    pub(crate) fn in_words(&self, property: &str, all: bool) -> String {
        let mut text = format!("\n{property} {}{}:\n", self.what, self.piled_up);
        let mut ticks = Ticks(None);
        for RunLine { tick, what } in &self.lines {
            let line = match (what, tick) {
                (What::Tick { is_delivered: true }, Some(tick)) => {
                    ticks.extend(*tick);
                    continue;
                }
                (What::Message { is_watched: false, .. }, _) if !all => continue,
                (What::Repeats, _) => "  over and over:".to_owned(),
                (What::Environment(words), _) => format!("  {words}"),
                (What::Tick { .. }, tick) => {
                    format!("  tick {}, lost: the tree has not finished the previous one", tick.unwrap_or(0))
                }
                (What::Message { from, to, message, .. }, _) => format!("    {from} → {to}  {message:#}"),
                (What::Damage { from, to, how }, _) => format!("    {from} → {to}  {how}"),
            };
            ticks.write(&mut text);
            text += &(line + "\n");
        }
        ticks.write(&mut text);
        let replayed = match (self.is_replayed, self.tick()) {
            (true, Some(tick)) => format!("{} at tick {tick}, as found", self.outcome()),
            (true, None) => format!("{} before the first tick, as found", self.outcome()),
            (false, _) => "NOT as found: this is a bug in steward, please report it".to_owned(),
        };
        text += &format!("  replayed in the channel system: {replayed}\n");
        if let [first, others @ ..] = &self.rests_on[..] {
            text += &format!("  it rests on what is assumed:  {first}\n");
            others.iter().for_each(|assumption| text += &format!("{:32}{assumption}\n", ""));
        }
        text
    }

    /// The steps of the run that concern the property, and its end.
    pub(crate) fn trail(&self, property: &str, places: &WrittenPlaces) -> Vec<TrailStep> {
        let step = |RunLine { tick, what }: &RunLine| {
            let (words, ends) = match what {
                What::Tick { is_delivered: true } | What::Message { is_watched: false, .. } => return None,
                What::Tick { is_delivered: false } => ("a tick is lost".to_owned(), None),
                What::Repeats => ("from here on, over and over:".to_owned(), None),
                What::Environment(words) => (words.clone(), None),
                What::Message { from, to, message, .. } => (format!("{from} → {to} {message:#}"), Some((from, to))),
                What::Damage { from, to, how } => (format!("{from} → {to} {how}"), Some((from, to))),
            };
            let at = tick.map_or("before the first tick".to_owned(), |tick| format!("tick {tick}"));
            let place = ends.and_then(|(from, to)| places.processes.get(from).or_else(|| places.processes.get(to)));
            Some(TrailStep { words: format!("{at}: {words}"), place: place.cloned() })
        };
        let words = format!("{property} {}{}", self.what, self.piled_up);
        let end = TrailStep { words, place: places.properties.get(property).cloned() };
        self.lines.iter().filter_map(step).chain([end]).collect()
    }

    fn outcome(&self) -> &'static str {
        self.what.strip_prefix("is ").unwrap_or(self.what)
    }

    pub(crate) fn as_json(&self) -> serde_json::Value {
        let line = |RunLine { tick, what }: &RunLine| match what {
            What::Repeats => json!({ "after_tick": tick, "repeats": true }),
            What::Environment(words) => json!({ "after_tick": tick, "environment": words }),
            What::Tick { is_delivered } => json!({ "tick": tick, "delivered": is_delivered }),
            What::Message { from, to, message, .. } => {
                json!({ "after_tick": tick, "from": from, "to": to, "message": message_json(message) })
            }
            What::Damage { from, to, how } => json!({ "after_tick": tick, "from": from, "to": to, "damage": how }),
        };
        json!({
            "ticks": self.ticks,
            "decided_at_tick": self.tick(),
            "replayed": self.is_replayed,
            "rests_on": self.rests_on,
            "steps": self.lines.iter().map(line).collect::<Vec<_>>(),
        })
    }
}

pub(super) fn words(assumptions: &[Assumption]) -> Vec<String> {
    assumptions.iter().map(|assumption| assumption.words.clone()).collect()
}

/// Which messages pile up in this state, in words: `more than 32 messages from Client to Server are waiting`.
fn piled_up(system: &ChannelSystem) -> Option<String> {
    match system.fork().normalize() {
        Err((_, NoNormalForm::Endless { what })) => Some(what),
        _ => None,
    }
}

/// The events of a run, in order.
fn lines(
    path: &Path,
    Replay { events, internal, system, .. }: &Replay,
    is_watched: impl Fn(usize, ChannelId) -> bool,
) -> Vec<RunLine> {
    let topology = system.topology();
    let mut lines = Vec::new();
    let mut tick = None;
    for (number, step) in path.steps().iter().enumerate() {
        let event = events.iter().find(|(after, _)| *after == number).map(|(_, event)| event);
        // Nothing marks the beginning of a cycle in the path: it is as long as the cycle before its end.
        if path.cycle() > 0 && number + path.cycle() == path.steps().len() {
            lines.push(RunLine { tick, what: What::Repeats });
        }
        if let PathStep::Tick { .. } = step {
            tick = event.map(|event| event.tick);
        }
        let received = event.and_then(|event| received(event, topology, |channel| is_watched(number, channel)));
        let done = internal.iter().filter(|(at, _)| *at == number).map(|(_, words)| What::Environment(words.clone()));
        let what = happening(step, topology).into_iter().chain(done).chain(received);
        lines.extend(what.map(|what| RunLine { tick, what }));
    }
    lines
}

/// What happens in a step, apart from the message that is received in it.
fn happening(step: &PathStep, topology: &Topology) -> Option<What> {
    match step {
        PathStep::Environment { words, .. } => (!words.is_empty()).then(|| What::Environment(words.clone())),
        PathStep::Wait(_) => None,
        PathStep::Tick { delivered } => Some(What::Tick { is_delivered: *delivered }),
        PathStep::Take { enabled, damage } => {
            let how = match damage {
                Damage::None => return None,
                Damage::Lost => "is lost",
                Damage::Held => "is delayed",
                Damage::Repeated => "is delivered twice",
            };
            let (EnabledKind::Send(channel) | EnabledKind::Receive(channel)) = &enabled.kind else { return None };
            let (from, to) = ends(topology, *channel);
            Some(What::Damage { from, to, how })
        }
    }
}

fn received(event: &channels::Event, topology: &Topology, is_watched: impl Fn(ChannelId) -> bool) -> Option<What> {
    let EventKind::Received { channel, message } = &event.kind else { return None };
    let (from, to) = ends(topology, *channel);
    Some(What::Message { from, to, message: message.clone(), is_watched: is_watched(*channel) })
}

fn ends(topology: &Topology, channel: ChannelId) -> (String, String) {
    let (from, to) = topology.ends(channel);
    (from.to_owned(), to.to_owned())
}
