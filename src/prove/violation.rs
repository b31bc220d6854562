//! A run in which something goes wrong, in words, as a trail and as JSON.

use campaigns::Error;
use explorer::Outcome;
use proofs::{Answer, Assumption, Proof, Question, ReplayedEvent, ReplayedRun, Subject};
use recording::message_json;
use reports::results::{TrailStep, WrittenPlaces};
use serde_json::json;

/// A run in which something goes wrong.
pub(crate) struct Violation {
    /// What goes wrong, to follow the name of the property.
    what: &'static str,
    pub(crate) run: ReplayedRun,
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
        let what = match &answer.exploration.outcome {
            Outcome::Violated(_) if answer.is_spurious => "is spurious",
            Outcome::Violated(_) => "is violated",
            Outcome::Endless(_) if question.subject == Subject::Progress => "is violated: messages pile up without end",
            Outcome::Endless(_) => "is not decided: messages pile up without end",
            Outcome::Deadlock(_) => "is violated: the tree takes no further tick, and nothing else happens",
            Outcome::Livelock(_) => "is violated: processes communicate forever within a tick",
            Outcome::Proved | Outcome::Undecided(_) => return Ok(None),
        };
        Ok(proof.replay(question, answer)?.map(|run| Self { what, run }))
    }

    /// The end of the run.
    fn end(&self, property: &str) -> String {
        let piled_up = self.run.piled_up.as_ref();
        let piled_up = piled_up.map_or_else(String::new, |what| format!(" ({what}, and what follows is not searched)"));
        format!("{property} {}{piled_up}", self.what)
    }

    /// The run, one event per line: with `all`, all messages; otherwise only those that the property is about.
    pub(crate) fn in_words(&self, property: &str, all: bool) -> String {
        let mut text = format!("\n{}:\n", self.end(property));
        let mut ticks = Ticks(None);
        for (tick, event) in &self.run.events {
            let line = match (event, tick) {
                (ReplayedEvent::Tick { is_delivered: true }, Some(tick)) => {
                    ticks.extend(*tick);
                    continue;
                }
                (ReplayedEvent::Message { is_watched: false, .. }, _) if !all => continue,
                (ReplayedEvent::Repeats, _) => "  over and over:".to_owned(),
                (ReplayedEvent::Environment(words), _) => format!("  {words}"),
                (ReplayedEvent::Tick { .. }, tick) => {
                    format!("  tick {}, lost: the tree has not finished the previous one", tick.unwrap_or(0))
                }
                (ReplayedEvent::Message { ends: [from, to], message, .. }, _) => {
                    format!("    {from} → {to}  {message:#}")
                }
                (ReplayedEvent::Damage { ends: [from, to], how }, _) => format!("    {from} → {to}  {how}"),
            };
            ticks.write(&mut text);
            text += &(line + "\n");
        }
        ticks.write(&mut text);
        let outcome = self.what.strip_prefix("is ").unwrap_or(self.what);
        let replayed = match (self.run.is_as_found, self.run.decided_at()) {
            (true, Some(tick)) => format!("{outcome} at tick {tick}, as found"),
            (true, None) => format!("{outcome} before the first tick, as found"),
            (false, _) => "NOT as found: this is a bug in steward, please report it".to_owned(),
        };
        text += &format!("  replayed in the channel system: {replayed}\n");
        if let [first, others @ ..] = &words(&self.run.rests_on)[..] {
            text += &format!("  it rests on what is assumed:  {first}\n");
            others.iter().for_each(|assumption| text += &format!("{:32}{assumption}\n", ""));
        }
        text
    }

    /// The steps of the run that concern the property, and its end.
    pub(crate) fn trail(&self, property: &str, places: &WrittenPlaces) -> Vec<TrailStep> {
        let step = |(tick, event): &(Option<u64>, ReplayedEvent)| {
            let (words, ends): (String, &[String]) = match event {
                ReplayedEvent::Tick { is_delivered: true } | ReplayedEvent::Message { is_watched: false, .. } => {
                    return None;
                }
                ReplayedEvent::Tick { is_delivered: false } => ("a tick is lost".to_owned(), &[]),
                ReplayedEvent::Repeats => ("from here on, over and over:".to_owned(), &[]),
                ReplayedEvent::Environment(words) => (words.clone(), &[]),
                ReplayedEvent::Message { ends: ends @ [from, to], message, .. } => {
                    (format!("{from} → {to} {message:#}"), ends)
                }
                ReplayedEvent::Damage { ends: ends @ [from, to], how } => (format!("{from} → {to} {how}"), ends),
            };
            let at = tick.map_or("before the first tick".to_owned(), |tick| format!("tick {tick}"));
            let place = ends.iter().find_map(|end| places.processes.get(end));
            Some(TrailStep { words: format!("{at}: {words}"), place: place.cloned() })
        };
        let end = TrailStep { words: self.end(property), place: places.properties.get(property).cloned() };
        self.run.events.iter().filter_map(step).chain([end]).collect()
    }

    pub(crate) fn as_json(&self) -> serde_json::Value {
        let step = |(tick, event): &(Option<u64>, ReplayedEvent)| match event {
            ReplayedEvent::Repeats => json!({ "after_tick": tick, "repeats": true }),
            ReplayedEvent::Environment(words) => json!({ "after_tick": tick, "environment": words }),
            ReplayedEvent::Tick { is_delivered } => json!({ "tick": tick, "delivered": is_delivered }),
            ReplayedEvent::Message { ends: [from, to], message, .. } => {
                json!({ "after_tick": tick, "from": from, "to": to, "message": message_json(message) })
            }
            ReplayedEvent::Damage { ends: [from, to], how } => {
                json!({ "after_tick": tick, "from": from, "to": to, "damage": how })
            }
        };
        json!({
            "ticks": self.run.ticks,
            "decided_at_tick": self.run.decided_at(),
            "replayed": self.run.is_as_found,
            "rests_on": words(&self.run.rests_on),
            "steps": self.run.events.iter().map(step).collect::<Vec<_>>(),
        })
    }
}

pub(super) fn words(assumptions: &[Assumption]) -> Vec<String> {
    assumptions.iter().map(|assumption| assumption.words.clone()).collect()
}
