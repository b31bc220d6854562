//! A session, steered by the pilot.

use std::collections::BTreeMap;
use std::io;
use std::time::{Duration, Instant};

use recording::Detail;
use runs::Session;
use serde_json::{Map, Value, json};

use crate::clock::{Clock, FRAME, now};
use crate::command::Command;
use crate::shown_run::ShownRun;
use crate::things;

/// Makes a session at its start.
pub(crate) type SessionStart = Box<dyn Fn() -> Result<Session, scenarios::Error> + Send>;

/// When a step has waited for partners for this long, the page shows it.
const LONG: Duration = Duration::from_secs(1);

/// The page's note on a saved session with partners.
const APART: &str = "The scenario causes the same faults at the same times. What others did in this run is not in it: \
                     it ends and expects what the original does, and need not go as this run did.";

/// A session that goes on at the pilot's pace, or at that of the partners that take part.
pub(crate) struct Steered {
    start: SessionStart,
    session: Session,
    clock: Clock,
    /// The lasting acts, by the page's names for them.
    acts: BTreeMap<String, usize>,
    last_scene: Instant,
    /// Since when a step has waited for partners.
    waiting: Option<Instant>,
}

impl Steered {
    /// A session at its start, which goes on in real time.
    ///
    /// # Errors
    /// If the session cannot be started.
    pub(crate) fn new(start: SessionStart) -> Result<Self, scenarios::Error> {
        let session = start()?;
        let clock = Clock::running(session.view().time());
        Ok(Self { start, session, clock, acts: BTreeMap::new(), last_scene: now(), waiting: None })
    }

    /// Starts the session anew, at the same speed.
    ///
    /// # Errors
    /// If its files have become wrong meanwhile: the session then goes on. One with partners is over: they leave
    /// before those of the next one join.
    pub(crate) fn restart(&mut self) -> Result<(), scenarios::Error> {
        if self.session.has_partners() {
            self.session.end();
        }
        self.session = (self.start)()?;
        self.clock = self.clock.restarted();
        self.acts.clear();
        self.waiting = None;
        Ok(())
    }

    pub(crate) fn session(&self) -> &Session {
        &self.session
    }

    pub(crate) fn clock(&self) -> &Clock {
        &self.clock
    }

    /// Whether nothing happens until the pilot requests it.
    pub(crate) fn rests(&self) -> bool {
        self.clock.is_paused() || self.session.view().end().is_some()
    }

    /// The time until there is something to do, at most `most`.
    pub(crate) fn wait(&self, most: Duration) -> Duration {
        match self.rests() {
            true => most,
            // Its steps take as long as they should.
            false if self.session.has_partners() => Duration::ZERO,
            false => self.clock.wait(self.next(), most.min(FRAME)),
        }
    }

    fn next(&self) -> Duration {
        self.session.view().time() + self.session.step_length()
    }

    /// Performs the steps that are due, until the deadline. Returns the reason if the run cannot go on.
    ///
    /// # Errors
    /// If a record cannot be stored.
    pub(crate) fn go_on(&mut self, shown: &mut ShownRun, deadline: Instant) -> io::Result<Option<String>> {
        let mut failure = None;
        let waited = self.is_waiting();
        while self.is_due() && now() < deadline {
            // One scene per frame is enough.
            let is_slow = !self.session.has_partners() && self.clock.speed().is_some_and(|speed| speed <= 1.0);
            let detail = if is_slow || self.last_scene.elapsed() >= FRAME / 2 { Detail::Scenes } else { Detail::Full };
            match self.session.step(detail) {
                Ok(true) => self.waiting = None,
                Ok(false) => {
                    self.waiting.get_or_insert_with(now);
                    continue;
                }
                Err(error) => {
                    failure = Some(error.reasons());
                    self.session.end();
                }
            }
            if detail == Detail::Scenes {
                self.last_scene = now();
            }
            self.clock.stepped(self.session.view().ticks());
            self.send(shown)?;
        }
        // The rest of a step that waited for partners when they had to leave.
        self.send(shown)?;
        self.clock.arrive(self.session.view().time());
        if self.is_waiting() != waited {
            shown.stir();
        }
        Ok(failure)
    }

    /// Whether a step has waited for partners for long.
    fn is_waiting(&self) -> bool {
        !self.rests() && self.waiting.is_some_and(|since| since.elapsed() >= LONG)
    }

    fn is_due(&self) -> bool {
        let view = self.session.view();
        let is_paced = self.session.has_partners() && self.clock.is_running();
        view.end().is_none() && (is_paced || self.clock.allows(self.next(), view.ticks()))
    }

    fn send(&mut self, shown: &mut ShownRun) -> io::Result<()> {
        self.session.take_records().into_iter().try_for_each(|record| shown.push(record))
    }

    /// Obeys the command, and returns the answer.
    ///
    /// # Errors
    /// If a record cannot be stored.
    pub(crate) fn obey(&mut self, command: Command, shown: &mut ShownRun) -> io::Result<Value> {
        let (time, ticks) = (self.session.view().time(), self.session.view().ticks());
        if matches!(command, Command::Speed { .. }) && self.session.has_partners() {
            return Ok(json!({ "refused": "the others who take part in this run set its pace" }));
        }
        if self.clock.is_paused() && command.is_of_pace() {
            self.session.resume();
            self.waiting = None;
        }
        if self.clock.obey(&command, time, ticks) {
            return Ok(Value::Null);
        }
        let done = match command {
            Command::Act { fault, name } => self.act(fault, name),
            Command::Release { name } => match self.acts.remove(&name) {
                Some(act) => self.session.release(act).map(|()| Value::Null),
                None => Ok(Value::Null),
            },
            Command::Save => Ok(json!({
                "scenario": self.session.saved(),
                "note": self.session.has_partners().then_some(APART),
            })),
            Command::End => {
                self.session.end();
                self.send(shown)?;
                Ok(json!({ "trace_hash": self.session.view().end().map(|end| &end.trace_hash) }))
            }
            _ => Ok(Value::Null),
        };
        Ok(done.unwrap_or_else(|error| json!({ "refused": error.reasons() })))
    }

    /// Performs an act, which replaces the lasting act of the same name.
    fn act(&mut self, fault: toml::Table, name: String) -> Result<Value, scenarios::Error> {
        let lasts = |act: &usize| self.session.lasting().any(|(index, _)| index == *act);
        let act = match self.acts.get(&name).copied().filter(|_| !name.is_empty()).filter(lasts) {
            Some(before) => self.session.replace(before, fault)?,
            None => self.session.act(fault)?,
        };
        self.acts.insert(name, act);
        Ok(json!({ "act": act }))
    }

    /// The lasting acts, and whether a step waits for partners.
    pub(crate) fn describe(&self, frame: &mut Map<String, Value>) {
        frame.insert("waits".to_owned(), self.is_waiting().into());
        frame.insert("lasting".to_owned(), things::lasting(&self.session, &self.acts));
    }
}
