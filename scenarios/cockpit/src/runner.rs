//! The thread that drives the run on the page: it advances the run, obeys the pilot, and tells browsers what happens.

use std::io;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use serde_json::{Map, Value, json};

use crate::clock::{Clock, FRAME, now};
use crate::command::Command;
use crate::outlet::Outlet;
use crate::reel::Reel;
use crate::side::{PARTS, Side};
use crate::steered::Steered;

/// A request, and where its answer goes.
pub(crate) struct Request {
    pub(crate) command: Command,
    pub(crate) answer: Box<dyn FnOnce(Value) + Send>,
}

/// Where the records come from.
pub(crate) enum Source {
    Session(Box<Steered>),
    /// One per side.
    Recordings(Vec<Reel>),
}

/// Drives what is shown, on its own thread.
pub(crate) struct Runner {
    source: Source,
    sides: Vec<Side>,
    /// The outlet to the page around several sides, for what they have in common.
    around: Option<Outlet>,
    requests: Receiver<Request>,
    /// The moment of the past that is shown; none while the newest moment is shown.
    past: Option<Duration>,
    /// The pace at which the past is played.
    clock: Clock,
    /// Whether recordings have just been opened: those that are still being written are then followed.
    opens: bool,
    last_frame: Instant,
    /// How far the runs were at the latest request; none once they have gone on and that has been told.
    asked: Option<Duration>,
    /// How far the runs were in the last frame, and whether they were over; none if another frame is due.
    told: Option<(Duration, bool)>,
}

impl Runner {
    /// A session at the present, or recordings that are played from their start.
    pub(crate) fn new(source: Source, sides: Vec<Side>, around: Option<Outlet>, requests: Receiver<Request>) -> Self {
        let is_recorded = matches!(source, Source::Recordings(_));
        let mut runner = Self {
            source,
            sides,
            around,
            requests,
            past: None,
            clock: Clock::running(Duration::ZERO),
            opens: is_recorded,
            last_frame: now(),
            asked: None,
            told: None,
        };
        if is_recorded {
            runner.seek(Duration::ZERO);
        }
        runner
    }

    /// Runs until no more requests can come.
    pub(crate) fn run(mut self) {
        self.tell();
        loop {
            match self.requests.recv_timeout(self.wait()) {
                Ok(Request { command, answer }) => {
                    let done = self.obey(command);
                    answer(done.unwrap_or_else(|error| refused(&error.to_string())));
                    self.sides.iter_mut().for_each(Side::stir);
                    (self.opens, self.told, self.asked) = (false, None, Some(self.end()));
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return,
            }
            if let Err(error) = self.go_on().and_then(|()| self.play()) {
                self.fail(&error.to_string());
            }
            if self.last_frame.elapsed() >= self.gap() {
                self.tell();
            }
        }
    }

    /// The time between the last frame and the next. What follows a request is told sooner: a person waits for it.
    fn gap(&self) -> Duration {
        if self.asked.is_some_and(|then| self.end() > then) { FRAME / 4 } else { FRAME }
    }

    /// The time until something has to be done.
    fn wait(&self) -> Duration {
        let source = match &self.source {
            Source::Session(steered) => steered.wait(PARTS),
            Source::Recordings(reels) => reels.iter().map(|reel| reel.wait(PARTS)).min().unwrap_or(PARTS),
        };
        let plays = self.past.is_some() && !self.clock.is_paused();
        let jumps = self.sides.iter().any(Side::jumps);
        let frame = if self.has_news() || plays { self.gap().saturating_sub(self.last_frame.elapsed()) } else { PARTS };
        if jumps { Duration::ZERO } else { source.min(frame) }
    }

    /// Lets the source go on for at most half the time of a frame.
    fn go_on(&mut self) -> io::Result<()> {
        let deadline = now() + FRAME / 2;
        let failures: Vec<String> = match &mut self.source {
            Source::Session(steered) => steered.go_on(&mut self.sides[0], deadline)?.into_iter().collect(),
            Source::Recordings(reels) => {
                let read = reels.iter_mut().zip(&mut self.sides);
                read.filter_map(|(reel, side)| reel.read(side, deadline)).collect()
            }
        };
        if self.grows() && std::mem::take(&mut self.opens) {
            self.follow();
        }
        failures.iter().for_each(|reason| self.fail(reason));
        Ok(())
    }

    /// Plays the past for at most half the time of a frame.
    fn play(&mut self) -> io::Result<()> {
        let (end, deadline) = (self.end(), now() + FRAME / 2);
        let Some(time) = &mut self.past else { return Ok(()) };
        if self.clock.is_running() {
            *time = self.clock.target().min(end);
        }
        let mut is_there = true;
        for side in &mut self.sides {
            is_there &= side.play(*time, deadline)?;
        }
        if !is_there {
            // A moment that takes longer to reach is played from there, without catching up.
            self.clock = self.clock.at(*time);
            return Ok(());
        }
        if self.clock.is_running() {
            if *time >= end {
                self.arrive();
            }
            return Ok(());
        }
        let ticks = |sides: &[Side]| sides.iter().map(|side| side.shown().ticks()).max().unwrap_or(0);
        while self.clock.allows(*time, ticks(&self.sides)) && now() < deadline {
            let mut next = None;
            for side in &mut self.sides {
                let other = side.next_time()?;
                next = [next, other].into_iter().flatten().min();
            }
            let Some(next) = next else {
                self.arrive();
                break;
            };
            *time = next;
            for side in &mut self.sides {
                side.play(next, deadline + FRAME)?;
            }
            self.clock.stepped(ticks(&self.sides));
        }
        Ok(())
    }

    /// Called when the past has been played to its end.
    fn arrive(&mut self) {
        match &self.source {
            Source::Recordings(_) if self.is_over() => self.clock.hold(),
            // The rest has not been read yet.
            Source::Recordings(_) if !self.grows() => self.clock = self.clock.at(self.end()),
            _ => self.follow(),
        }
        self.sides.iter_mut().for_each(Side::stir);
    }

    /// How far the runs are.
    fn end(&self) -> Duration {
        self.sides.iter().map(|side| side.newest().time()).max().unwrap_or_default()
    }

    /// Whether a recording is still being written, and everything there has been read.
    fn grows(&self) -> bool {
        let Source::Recordings(reels) = &self.source else { return false };
        reels.iter().any(Reel::grows) && reels.iter().all(|reel| reel.grows() || reel.has_ended())
    }

    /// Whether nothing will be added to the recordings.
    fn is_over(&self) -> bool {
        matches!(&self.source, Source::Recordings(reels) if reels.iter().all(Reel::has_ended))
    }

    /// Shows the past.
    fn seek(&mut self, time: Duration) {
        self.clock = match &self.source {
            Source::Session(steered) if self.past.is_none() => steered.clock().held(time),
            _ => self.clock.at(time),
        };
        self.past = Some(time);
        self.sides.iter_mut().for_each(|side| side.seek(time));
    }

    /// Shows the present.
    fn follow(&mut self) {
        self.past = None;
        self.sides.iter_mut().for_each(Side::follow);
    }

    /// Does what the pilot asks, and returns the answer.
    fn obey(&mut self, command: Command) -> io::Result<Value> {
        let (end, is_recorded) = (self.end(), matches!(self.source, Source::Recordings(_)));
        match command {
            Command::Seek { time } => match Duration::try_from_secs_f64(time) {
                Ok(time) if time < end || self.is_over() => self.seek(time.min(end)),
                Ok(_) => self.follow(),
                Err(error) => return Ok(refused(&error.to_string())),
            },
            Command::Now => self.follow(),
            command if is_recorded || self.past.is_some() && command.is_of_pace() => {
                let time = self.past.unwrap_or(end);
                let starts_over = matches!(command, Command::Resume) && time >= end && self.is_over();
                let time = if starts_over { Duration::ZERO } else { time };
                let ticks = self.sides.iter().map(|side| side.shown().ticks()).max();
                if !command.is_of_pace() {
                    return Ok(refused("a recording cannot be changed"));
                }
                if self.past != Some(time) {
                    self.seek(time);
                }
                self.clock.obey(&command, time, ticks.unwrap_or(0));
            }
            Command::Act { .. } if self.past.is_some() => {
                return Ok(refused("the past cannot be changed; go back to now"));
            }
            command => {
                let Source::Session(steered) = &mut self.source else { return Ok(Value::Null) };
                return steered.obey(command, &mut self.sides[0]);
            }
        }
        Ok(Value::Null)
    }

    /// Whether what is shown does not change.
    fn rests(&self) -> bool {
        match &self.source {
            _ if self.past.is_some() => self.clock.is_paused(),
            Source::Session(steered) => steered.rests(),
            Source::Recordings(_) => self.is_over(),
        }
    }

    fn has_news(&self) -> bool {
        self.told.is_none() || self.sides.iter().any(Side::has_news)
    }

    /// Sends what is new.
    fn tell(&mut self) {
        let (end, over, rests) = (self.end(), self.is_over(), self.rests());
        // While its past is shown, the page is told now and then how far a run is.
        if self.told != Some((end, over)) && self.last_frame.elapsed() >= PARTS {
            self.told = None;
        }
        if !self.has_news() {
            return;
        }
        if self.told.is_none() {
            self.sides.iter_mut().for_each(Side::stir);
        }
        let clock = match &self.source {
            Source::Session(steered) if self.past.is_none() => steered.clock(),
            _ => &self.clock,
        };
        let mut common = Map::from_iter([
            ("paused".to_owned(), rests.into()),
            ("speed".to_owned(), json!(clock.speed())),
            ("at".to_owned(), self.past.unwrap_or(end).as_secs_f64().into()),
            ("to".to_owned(), end.as_secs_f64().into()),
            ("past".to_owned(), self.past.is_some().into()),
            ("grows".to_owned(), (!over).into()),
        ]);
        if let Source::Session(steered) = &self.source {
            steered.describe(&mut common);
        }
        for side in &mut self.sides {
            side.tell(&common, rests);
        }
        if let Some(outlet) = &self.around {
            outlet.tell(common);
        }
        (self.last_frame, self.told) = (now(), Some((end, over)));
        self.asked = self.asked.filter(|then| *then == end);
    }

    fn fail(&self, reason: &str) {
        let failed = Map::from_iter([("failed".to_owned(), reason.into())]);
        self.around.iter().for_each(|outlet| outlet.tell(failed.clone()));
        self.sides.iter().for_each(|side| side.say(failed.clone()));
    }
}

/// The answer to a refused request.
fn refused(reason: &str) -> Value {
    json!({ "refused": reason })
}
