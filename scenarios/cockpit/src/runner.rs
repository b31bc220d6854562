//! The thread of the run: performs steps in time, does what the pilot asks, and tells what happens.

use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use recording::Detail;
use reports::timeline::Timeline;
use scenarios::scenario::STEP;
use scenarios::session::Session;
use serde_json::{Value, json};
use tokio::sync::broadcast;

use crate::command::Command;
use crate::frame::{self, News};
use crate::things;

/// Time between frames.
const FRAME: Duration = Duration::from_millis(40);
/// Time between drawings of what takes longer: cards and time axis.
const PARTS: Duration = Duration::from_millis(1000);
/// So many of the latest messages and happenings are shown to a browser that comes later.
const REMEMBERED: usize = 400;

/// A text for browsers.
pub(crate) type Frame = Arc<str>;

/// What a browser must know that joins a run, or has missed frames.
#[derive(Default)]
pub(crate) struct Present {
    /// What does not change.
    pub(crate) greeting: Option<Frame>,
    /// The latest value of everything else, by its key.
    latest: BTreeMap<String, Value>,
}

impl Present {
    fn take(&mut self, frame: &Value) {
        for (key, value) in frame.as_object().into_iter().flatten() {
            match (key.as_str(), value, self.latest.get_mut(key)) {
                ("messages" | "happenings", Value::Array(new), Some(Value::Array(known))) => {
                    known.extend(new.iter().cloned());
                    known.drain(..known.len().saturating_sub(REMEMBERED));
                }
                _ => drop(self.latest.insert(key.clone(), value.clone())),
            }
        }
    }

    /// A frame with everything.
    pub(crate) fn frame(&self) -> Frame {
        let mut all = json!(self.latest);
        all["anew"] = true.into();
        all.to_string().into()
    }
}

/// What the thread of the run shares with the server.
#[derive(Clone)]
pub(crate) struct Outlet {
    pub(crate) frames: broadcast::Sender<Frame>,
    pub(crate) present: Arc<Mutex<Present>>,
}

impl Outlet {
    fn tell(&self, frame: &Value) {
        let mut present = self.present.lock().unwrap_or_else(PoisonError::into_inner);
        present.take(frame);
        // Nobody may be listening.
        let _ = self.frames.send(frame.to_string().into());
    }
}

/// A request, and where its answer goes.
pub(crate) struct Request {
    pub(crate) command: Command,
    pub(crate) answer: Box<dyn FnOnce(Value) + Send>,
}

/// How fast the run goes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Pace {
    Paused,
    /// To the next step.
    Step,
    /// To the tick with this number.
    Tick(u64),
    Running,
}

/// The run on its thread.
pub(crate) struct Runner {
    session: Session,
    timeline: Timeline,
    requests: Receiver<Request>,
    outlet: Outlet,
    pace: Pace,
    /// How many times faster than time passes; none as fast as it goes.
    speed: Option<f64>,
    /// The lasting acts, by the page's names for them.
    acts: BTreeMap<String, usize>,
    news: News,
    /// When the run was where it was, on the clock.
    since: (Instant, Duration),
    last_frame: Instant,
    last_parts: Instant,
    /// Whether anything has happened since the last frame or drawing.
    is_new: bool,
    parts_are_old: bool,
}

impl Runner {
    /// A run at its start, which goes on at the pace of the clock.
    pub(crate) fn new(session: Session, requests: Receiver<Request>, outlet: Outlet) -> Self {
        let now = clock();
        let timeline = Timeline::new(session.view());
        let greeting = frame::greeting(session.view()).to_string().into();
        outlet.present.lock().unwrap_or_else(PoisonError::into_inner).greeting = Some(greeting);
        Self {
            since: (now, session.view().time()),
            session,
            timeline,
            requests,
            outlet,
            pace: Pace::Running,
            speed: Some(1.0),
            acts: BTreeMap::new(),
            news: News::at_start(),
            last_frame: now,
            last_parts: now,
            is_new: true,
            parts_are_old: true,
        }
    }

    /// Runs until nobody can ask for anything any more.
    pub(crate) fn run(mut self) {
        self.tell(true);
        loop {
            match self.requests.recv_timeout(self.pause()) {
                Ok(request) => self.obey(request),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return,
            }
            self.go_on();
            self.tell(false);
        }
    }

    /// How long nothing has to be done.
    fn pause(&self) -> Duration {
        let due = match (self.pace, self.speed) {
            _ if self.session.view().end().is_some() => PARTS,
            (Pace::Paused, _) => PARTS,
            (Pace::Step | Pace::Tick(_), _) | (_, None) => Duration::ZERO,
            (Pace::Running, Some(_)) => {
                let next = self.session.view().time() + STEP;
                next.saturating_sub(self.target()).div_f64(self.speed.unwrap_or(1.0)).min(FRAME)
            }
        };
        if self.is_new { due.min(FRAME.saturating_sub(clock() - self.last_frame)) } else { due }
    }

    /// Where the run ought to be now.
    fn target(&self) -> Duration {
        let (at, time) = self.since;
        time + (clock() - at).mul_f64(self.speed.unwrap_or(1.0))
    }

    /// Performs the steps that are due, for at most the time of a frame.
    fn go_on(&mut self) {
        let began = clock();
        while clock() - began < FRAME && self.is_due() {
            // A scene for each frame is enough.
            let is_shown = self.speed.is_some_and(|speed| speed <= 1.0) || clock() - self.last_frame >= FRAME / 2;
            let stepped = self.session.step(if is_shown { Detail::Scenes } else { Detail::Full });
            self.timeline.follow(self.session.view());
            self.news.note(self.session.view());
            (self.is_new, self.parts_are_old) = (true, true);
            if let Err(error) = stepped {
                self.outlet.tell(&json!({ "failed": error.reasons() }));
                self.session.end();
            }
            let ticks = self.session.view().ticks();
            if self.pace == Pace::Step || matches!(self.pace, Pace::Tick(tick) if ticks >= tick) {
                self.pace = Pace::Paused;
            }
        }
        // A run that cannot keep up goes on from where it is instead of running after the clock.
        if self.target() > self.session.view().time() + 10 * STEP {
            self.since = (clock(), self.session.view().time());
        }
    }

    fn is_due(&self) -> bool {
        let view = self.session.view();
        view.end().is_none()
            && match self.pace {
                Pace::Paused => false,
                Pace::Step => true,
                Pace::Tick(tick) => view.ticks() < tick,
                Pace::Running => self.speed.is_none() || view.time() + STEP <= self.target(),
            }
    }

    /// Does what the pilot asks.
    fn obey(&mut self, Request { command, answer }: Request) {
        self.since = (clock(), self.session.view().time());
        self.is_new = true;
        let done = match command {
            Command::Pause => self.set_pace(Pace::Paused),
            Command::Resume => self.set_pace(Pace::Running),
            Command::Step => self.set_pace(Pace::Step),
            Command::Tick => self.set_pace(Pace::Tick(self.session.view().ticks() + 1)),
            Command::Speed { times } => {
                self.speed = times.map(|times| times.clamp(0.1, 1000.0));
                Ok(Value::Null)
            }
            Command::Act { fault, name } => self.act(fault, name),
            Command::Release { name } => match self.acts.remove(&name) {
                Some(act) => self.session.release(act).map(|()| Value::Null),
                None => Ok(Value::Null),
            },
            Command::Save => Ok(json!({ "scenario": self.session.saved() })),
            Command::End => {
                self.session.end();
                Ok(json!({ "trace_hash": self.session.view().end().map(|end| &end.trace_hash) }))
            }
        };
        answer(done.unwrap_or_else(|error| json!({ "refused": error.reasons() })));
    }

    /// Does something; in place of what lasts under the same name.
    fn act(&mut self, fault: toml::Table, name: String) -> Result<Value, scenarios::Error> {
        let lasts = |act: &usize| self.session.lasting().any(|(index, _)| index == *act);
        let act = match self.acts.get(&name).copied().filter(|_| !name.is_empty()).filter(lasts) {
            Some(before) => self.session.replace(before, fault)?,
            None => self.session.act(fault)?,
        };
        self.acts.insert(name, act);
        Ok(json!({ "act": act }))
    }

    fn set_pace(&mut self, pace: Pace) -> Result<Value, scenarios::Error> {
        self.pace = pace;
        Ok(Value::Null)
    }

    /// Tells what has happened, if it is time.
    fn tell(&mut self, at_once: bool) {
        let now = clock();
        let rests = self.pace == Pace::Paused || self.session.view().end().is_some();
        if self.is_new && (at_once || now - self.last_frame >= FRAME) {
            let news = std::mem::take(&mut self.news);
            let decided = news.decided;
            let mut frame = frame::state(self.session.view(), news);
            frame["paused"] = rests.into();
            frame["speed"] = json!(self.speed);
            frame["lasting"] = things::lasting(&self.session, &self.acts);
            self.outlet.tell(&frame);
            (self.last_frame, self.is_new) = (now, false);
            // A violation is told the moment it happens.
            if decided {
                self.last_parts = now.checked_sub(PARTS).unwrap_or(now);
            }
        }
        if self.parts_are_old && (at_once || rests || now - self.last_parts >= PARTS) {
            self.outlet.tell(&frame::parts(self.session.view(), &self.timeline));
            (self.last_parts, self.parts_are_old) = (clock(), false);
        }
    }
}

/// The time on the clock, which paces the run and does not enter it.
#[expect(clippy::disallowed_methods, reason = "what is shown to a person keeps pace with the clock")]
fn clock() -> Instant {
    Instant::now()
}
