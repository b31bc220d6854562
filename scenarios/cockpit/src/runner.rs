//! The thread that drives the run on the page: it advances the run, obeys the pilot, and sends browsers what happens.

use std::io;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use recording::RunView;
use serde_json::{Map, Value, json};

use crate::beside::Beside;
use crate::broadcast::Broadcast;
use crate::clock::{Clock, FRAME, now};
use crate::command::Command;
use crate::open_recording::OpenRecording;
use crate::shown_run::{PARTS, ShownRun};
use crate::steered::Steered;

/// A request, and where its answer goes.
pub(crate) struct Request {
    pub(crate) command: Command,
    pub(crate) answer: Box<dyn FnOnce(Value) + Send>,
}

/// Where the records come from.
pub(crate) enum RunSource {
    Session(Box<Steered>),
    /// One per run.
    Recordings(Vec<OpenRecording>),
}

/// Drives what is shown, on its own thread.
pub(crate) struct Runner {
    source: RunSource,
    runs: Vec<ShownRun>,
    /// The broadcast to the page around several runs, for what they have in common, and how they compare.
    around: Option<(Broadcast, Beside)>,
    requests: Receiver<Request>,
    /// The moment of the past that is shown; none while the newest moment is shown.
    past: Option<Duration>,
    /// The pace at which the past is played.
    clock: Clock,
    /// Whether recordings have just been opened: those that are still being written are then followed.
    opens: bool,
    last_frame: Instant,
    /// How far the runs were at the latest request; none once they have gone on and that has been sent.
    asked: Option<Duration>,
    /// How far the runs were in the last frame, and whether they were over; none if another frame is due.
    sent: Option<(Duration, bool)>,
}

impl Runner {
    /// A session at the present, or recordings that are played from their start.
    pub(crate) fn new(
        source: RunSource,
        runs: Vec<ShownRun>,
        around: Option<(Broadcast, Beside)>,
        requests: Receiver<Request>,
    ) -> Self {
        let is_recorded = matches!(source, RunSource::Recordings(_));
        let mut runner = Self {
            source,
            runs,
            around,
            requests,
            past: None,
            clock: Clock::running(Duration::ZERO),
            opens: is_recorded,
            last_frame: now(),
            asked: None,
            sent: None,
        };
        if is_recorded {
            runner.seek(Duration::ZERO);
        }
        runner
    }

    /// Runs until no more requests can come.
    pub(crate) fn run(mut self) {
        self.send();
        loop {
            match self.requests.recv_timeout(self.wait()) {
                Ok(Request { command, answer }) => {
                    let done = self.obey(command);
                    answer(done.unwrap_or_else(|error| refused(&error.to_string())));
                    self.runs.iter_mut().for_each(ShownRun::stir);
                    (self.opens, self.sent, self.asked) = (false, None, Some(self.end()));
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return,
            }
            if let Err(error) = self.go_on().and_then(|()| self.play()) {
                self.fail(&error.to_string());
            }
            if self.last_frame.elapsed() >= self.gap() {
                self.send();
            }
        }
    }

    /// The time between the last frame and the next. What follows a request is sent sooner: a person waits for it.
    fn gap(&self) -> Duration {
        if self.asked.is_some_and(|then| self.end() > then) { FRAME / 4 } else { FRAME }
    }

    /// The time until something has to be done.
    fn wait(&self) -> Duration {
        let source = match &self.source {
            RunSource::Session(steered) => steered.wait(PARTS),
            RunSource::Recordings(recordings) => {
                recordings.iter().map(|recording| recording.wait(PARTS)).min().unwrap_or(PARTS)
            }
        };
        let plays = self.past.is_some() && !self.clock.is_paused();
        let jumps = self.runs.iter().any(ShownRun::jumps);
        let frame =
            if self.has_update() || plays { self.gap().saturating_sub(self.last_frame.elapsed()) } else { PARTS };
        if jumps { Duration::ZERO } else { source.min(frame) }
    }

    /// Lets the source go on for at most half the time of a frame.
    fn go_on(&mut self) -> io::Result<()> {
        let deadline = now() + FRAME / 2;
        if let RunSource::Recordings(recordings) = &mut self.source
            && let Some(start) = recordings[0].next_run()
        {
            self.runs[0].restart(start, Some(&recordings[0].name), None)?;
            (self.past, self.sent) = (None, None);
        }
        let failures: Vec<String> = match &mut self.source {
            RunSource::Session(steered) => steered.go_on(&mut self.runs[0], deadline)?.into_iter().collect(),
            RunSource::Recordings(recordings) => {
                let mut failures = Vec::new();
                for (index, (recording, run)) in recordings.iter_mut().zip(&mut self.runs).enumerate() {
                    let note = |view: &RunView| self.around.iter_mut().for_each(|(_, beside)| beside.note(index, view));
                    failures.extend(recording.read(run, deadline, note));
                }
                failures
            }
        };
        self.align();
        if self.grows() && std::mem::take(&mut self.opens) {
            self.follow();
        }
        failures.iter().for_each(|reason| self.fail(reason));
        Ok(())
    }

    /// Shows several runs as they compare by now.
    fn align(&mut self) {
        let Some((_, beside)) = &self.around else { return };
        let mut is_moved = false;
        for (index, (run, delay)) in self.runs.iter_mut().zip(beside.delays()).enumerate() {
            is_moved |= run.set_delay(delay);
            run.set_differing(beside.differing(index));
        }
        if let Some(time) = self.past.filter(|_| is_moved) {
            self.seek(time.min(self.end()));
        }
    }

    /// Plays the past for at most half the time of a frame.
    fn play(&mut self) -> io::Result<()> {
        let (end, deadline) = (self.end(), now() + FRAME / 2);
        let Some(time) = &mut self.past else { return Ok(()) };
        if self.clock.is_running() {
            *time = self.clock.target().min(end);
        }
        let mut is_there = true;
        for run in &mut self.runs {
            is_there &= run.play(*time, deadline)?;
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
        let ticks = |runs: &[ShownRun]| runs.iter().map(|run| run.shown().ticks()).max().unwrap_or(0);
        while self.clock.allows(*time, ticks(&self.runs)) && now() < deadline {
            let mut next = None;
            for run in &mut self.runs {
                let other = run.next_time()?;
                next = [next, other].into_iter().flatten().min();
            }
            let Some(next) = next else {
                self.arrive();
                break;
            };
            *time = next;
            for run in &mut self.runs {
                run.play(next, deadline + FRAME)?;
            }
            self.clock.stepped(ticks(&self.runs));
        }
        Ok(())
    }

    /// Called when the past has been played to its end.
    fn arrive(&mut self) {
        match &self.source {
            RunSource::Recordings(_) if self.is_over() => self.clock.hold(),
            // The rest has not been read yet.
            RunSource::Recordings(_) if !self.grows() => self.clock = self.clock.at(self.end()),
            _ => self.follow(),
        }
        self.runs.iter_mut().for_each(ShownRun::stir);
    }

    /// How far the runs are.
    fn end(&self) -> Duration {
        self.runs.iter().map(ShownRun::end).max().unwrap_or_default()
    }

    /// Whether a recording is still being written, and everything there has been read.
    fn grows(&self) -> bool {
        let RunSource::Recordings(recordings) = &self.source else { return false };
        recordings.iter().any(OpenRecording::grows)
            && recordings.iter().all(|recording| recording.grows() || recording.has_ended())
    }

    /// Whether nothing will be added to the recordings.
    fn is_over(&self) -> bool {
        matches!(&self.source, RunSource::Recordings(recordings) if recordings.iter().all(OpenRecording::has_ended))
    }

    /// Shows the past.
    fn seek(&mut self, time: Duration) {
        self.clock = match &self.source {
            RunSource::Session(steered) if self.past.is_none() => steered.clock().held(time),
            _ => self.clock.at(time),
        };
        self.past = Some(time);
        self.runs.iter_mut().for_each(|run| run.seek(time));
    }

    /// Shows the present.
    fn follow(&mut self) {
        self.past = None;
        self.runs.iter_mut().for_each(ShownRun::follow);
    }

    /// Carries out the pilot's request, and returns the answer.
    fn obey(&mut self, command: Command) -> io::Result<Value> {
        let (end, is_recorded) = (self.end(), matches!(self.source, RunSource::Recordings(_)));
        match command {
            Command::Seek { time } => match Duration::try_from_secs_f64(time) {
                Ok(time) if time < end || self.is_over() => self.seek(time.min(end)),
                Ok(_) => self.follow(),
                Err(_) => return Ok(refused(&format!("{time:?} s is no time in a run"))),
            },
            Command::Now => self.follow(),
            Command::Unfold { node, side, open } => {
                let known = self.runs.get(side).and_then(|run| run.newest().header().tree.get(node));
                if let Some(name) = known.map(|node| node.process.clone()) {
                    self.runs.iter_mut().for_each(|run| run.unfold(&name, open));
                }
            }
            Command::Align { on } => match &mut self.around {
                Some((_, beside)) => {
                    beside.aligns = on;
                    self.align();
                }
                None => return Ok(refused("there is one run, and nothing to align it with")),
            },
            Command::Report => {
                return Ok(match self.runs.first().and_then(ShownRun::report) {
                    Some(page) => json!({ "page": page }),
                    None => refused("there is a report once the run has ended"),
                });
            }
            // At the present, the pace of a session is that of the session itself.
            command if command.is_of_pace() && (is_recorded || self.past.is_some()) => self.pace(&command),
            _ if is_recorded => return Ok(refused("a recording cannot be changed")),
            Command::Act { .. } if self.past.is_some() => {
                return Ok(refused("the past cannot be changed; go back to now"));
            }
            command => {
                let RunSource::Session(steered) = &mut self.source else { return Ok(Value::Null) };
                if !matches!(command, Command::Restart) {
                    return steered.obey(command, &mut self.runs[0]);
                }
                if let Err(error) = steered.restart() {
                    return Ok(refused(&error.reasons()));
                }
                let session = steered.session();
                self.runs[0].restart(session.view().clone(), None, Some(session.scenario()))?;
                self.past = None;
            }
        }
        Ok(Value::Null)
    }

    /// Changes the pace at which the past is played.
    fn pace(&mut self, command: &Command) {
        let end = self.end();
        let time = self.past.unwrap_or(end);
        let starts_over = matches!(command, Command::Resume) && time >= end && self.is_over();
        let time = if starts_over { Duration::ZERO } else { time };
        let ticks = self.runs.iter().map(|run| run.shown().ticks()).max();
        if self.past != Some(time) {
            self.seek(time);
        }
        self.clock.obey(command, time, ticks.unwrap_or(0));
    }

    /// Whether what is shown does not change.
    fn rests(&self) -> bool {
        match &self.source {
            _ if self.past.is_some() => self.clock.is_paused(),
            RunSource::Session(steered) => steered.rests(),
            RunSource::Recordings(_) => self.is_over(),
        }
    }

    fn has_update(&self) -> bool {
        self.sent.is_none() || self.runs.iter().any(ShownRun::has_update)
    }

    /// Sends what is new.
    fn send(&mut self) {
        let (end, over, rests) = (self.end(), self.is_over(), self.rests());
        // While its past is shown, the page gets now and then how far a run is.
        if self.sent != Some((end, over)) && self.last_frame.elapsed() >= PARTS {
            self.sent = None;
        }
        if !self.has_update() {
            return;
        }
        if self.sent.is_none() {
            self.runs.iter_mut().for_each(ShownRun::stir);
        }
        let clock = match &self.source {
            RunSource::Session(steered) if self.past.is_none() => steered.clock(),
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
        if let RunSource::Session(steered) = &self.source {
            steered.describe(&mut common);
        }
        for run in &mut self.runs {
            run.send(&common, rests);
        }
        if let Some((broadcast, beside)) = &self.around {
            common.insert("beside".to_owned(), beside.describe(over));
            broadcast.send(common);
        }
        (self.last_frame, self.sent) = (now(), Some((end, over)));
        self.asked = self.asked.filter(|then| *then == end);
    }

    fn fail(&self, reason: &str) {
        let failed = Map::from_iter([("failed".to_owned(), reason.into())]);
        self.around.iter().for_each(|(broadcast, _)| broadcast.send(failed.clone()));
        self.runs.iter().for_each(|run| run.send_alone(failed.clone()));
    }
}

/// The answer to a refused request.
fn refused(reason: &str) -> Value {
    json!({ "refused": reason })
}
