//! A run on the page: what is known about it, which moment is shown, and who is sent.

use std::collections::BTreeSet;
use std::io;
use std::time::{Duration, Instant};

use recording::{Record, RunView};
use reports::html::live;
use scenarios::scenario::Scenario;
use serde_json::{Map, Value};

use crate::broadcast::Broadcast;
use crate::clock::now;
use crate::frame::{self, Update};
use crate::history::{History, Playback};

/// Time between drawings of what takes longer: verdicts and the time axis.
pub(crate) const PARTS: Duration = Duration::from_millis(1000);

/// A run on the page.
pub(crate) struct ShownRun {
    history: History,
    broadcast: Broadcast,
    /// Plays the past; none while the newest moment is shown.
    playback: Option<Playback>,
    /// Whether the playback is jumping to another moment: browsers do not see what is in between.
    jumps: bool,
    update: Update,
    /// The opened nodes of the tree, which are shown with all their children.
    opened: BTreeSet<usize>,
    /// How long after the start of the page it begins.
    delay: Duration,
    /// The node of its tree that first gave another result than in another run.
    differing: Option<usize>,
    /// Whether anything is new since the last frame or drawing.
    is_new: bool,
    parts_are_old: bool,
    last_parts: Instant,
}

impl ShownRun {
    /// A run. `file` is the recording that it comes from, or `scenario` what a session plays.
    pub(crate) fn new(history: History, broadcast: Broadcast, file: Option<&str>, scenario: Option<&Scenario>) -> Self {
        broadcast.greet(&frame::greeting(&history.newest().view, file, scenario));
        let mut shown = Self {
            history,
            broadcast,
            playback: None,
            jumps: false,
            update: Update::default(),
            opened: BTreeSet::new(),
            delay: Duration::ZERO,
            differing: None,
            is_new: true,
            parts_are_old: true,
            last_parts: now(),
        };
        shown.show_anew();
        shown
    }

    /// Shows another run from its start; the rest is as in [`new`](Self::new).
    ///
    /// # Errors
    /// If no temporary file can be made.
    pub(crate) fn restart(
        &mut self,
        start: RunView,
        file: Option<&str>,
        scenario: Option<&Scenario>,
    ) -> io::Result<()> {
        *self = Self::new(History::begin(start)?, self.broadcast.clone(), file, scenario);
        Ok(())
    }

    /// The page of the report of a run that has ended.
    pub(crate) fn report(&self) -> Option<String> {
        live::report(self.newest(), self.history.timeline())
    }

    /// Adds the next record.
    ///
    /// # Errors
    /// If it does not fit, or cannot be stored.
    pub(crate) fn push(&mut self, record: Record) -> io::Result<()> {
        let is_step = matches!(record, Record::Step(_));
        self.history.push(record)?;
        if self.playback.is_none() {
            if is_step {
                self.update.note(&self.history.newest().view);
            }
            (self.is_new, self.parts_are_old) = (true, true);
        }
        Ok(())
    }

    /// The run now.
    pub(crate) fn newest(&self) -> &RunView {
        &self.history.newest().view
    }

    /// The moment that is shown.
    pub(crate) fn shown(&self) -> &RunView {
        self.playback.as_ref().map_or(self.newest(), |playback| &playback.moment().view)
    }

    fn show_anew(&mut self) {
        let moment = self.playback.as_ref().map_or(self.history.newest(), Playback::moment);
        self.update = Update::anew(moment, self.history.happened(moment.view.time()));
        (self.is_new, self.parts_are_old) = (true, true);
    }

    /// Shows the newest moment again.
    pub(crate) fn follow(&mut self) {
        if self.playback.take().is_some() {
            self.jumps = false;
            self.show_anew();
        }
    }

    /// Sets how long after the start of the page it begins. Times of the page contain this delay. Returns whether it is
    /// another one than before.
    pub(crate) fn set_delay(&mut self, delay: Duration) -> bool {
        std::mem::replace(&mut self.delay, delay) != delay
    }

    /// Marks the node of its tree that first gave another result than in another run.
    pub(crate) fn set_differing(&mut self, node: Option<usize>) {
        if self.differing != node {
            self.differing = node;
            self.update.stir();
            self.is_new = true;
        }
    }

    /// How far the run is, as a time of the page.
    pub(crate) fn end(&self) -> Duration {
        self.newest().time() + self.delay
    }

    /// Starts a jump to a time of the page; [`play`](Self::play) completes it.
    pub(crate) fn seek(&mut self, time: Duration) {
        let time = time.saturating_sub(self.delay);
        self.playback = Some(Playback::towards(time, self.playback.take(), &self.history));
        self.jumps = true;
    }

    /// The time of the page of the next record of the past; none at the end, or while the newest moment is shown.
    ///
    /// # Errors
    /// If the store cannot be read.
    pub(crate) fn next_time(&mut self) -> io::Result<Option<Duration>> {
        let next = self.playback.as_mut().map_or(Ok(None), |playback| playback.next_time(&mut self.history))?;
        Ok(next.map(|next| next + self.delay))
    }

    /// Plays the past up to a time of the page, but stops at the `deadline`. Returns whether it got there.
    ///
    /// # Errors
    /// If the store cannot be read.
    pub(crate) fn play(&mut self, time: Duration, deadline: Instant) -> io::Result<bool> {
        let Some(playback) = &mut self.playback else { return Ok(true) };
        let has_begun = time >= self.delay;
        let time = time.saturating_sub(self.delay);
        while has_begun && playback.next_time(&mut self.history)?.is_some_and(|next| next <= time) {
            if now() >= deadline {
                return Ok(false);
            }
            let is_step = playback.advance()?;
            if !self.jumps {
                if is_step {
                    self.update.note(&playback.moment().view);
                }
                (self.is_new, self.parts_are_old) = (true, true);
            }
        }
        if std::mem::take(&mut self.jumps) {
            self.show_anew();
        }
        Ok(true)
    }

    /// Whether it is jumping to another moment.
    pub(crate) fn jumps(&self) -> bool {
        self.jumps
    }

    /// Shows all children of the node of the tree with this name, or no longer.
    pub(crate) fn unfold(&mut self, name: &str, open: bool) {
        let Some(node) = self.newest().header().tree.iter().position(|node| node.process == name) else { return };
        self.opened.remove(&node);
        if open {
            self.opened.insert(node);
        }
        self.update.stir();
        self.is_new = true;
    }

    /// Makes sure that the next frame is sent, even without new records.
    pub(crate) fn stir(&mut self) {
        self.is_new = true;
    }

    /// Whether there is something to send.
    pub(crate) fn has_update(&self) -> bool {
        !self.jumps && (self.is_new || self.parts_are_old)
    }

    /// Sends what is shown, and what is `common` to all runs. What takes longer to draw is sent now and then, but
    /// immediately if the run `rests`.
    pub(crate) fn send(&mut self, common: &Map<String, Value>, rests: bool) {
        if self.jumps {
            return;
        }
        let mut frame = Map::new();
        let mut is_due = rests || self.last_parts.elapsed() >= PARTS;
        if std::mem::take(&mut self.is_new) {
            let update = std::mem::take(&mut self.update);
            // A violation is shown as soon as it happens.
            is_due |= update.decided;
            let opened: BTreeSet<usize> = self.opened.iter().copied().chain(self.differing).collect();
            add(&mut frame, frame::state(self.shown(), &opened, update));
            frame.extend(common.clone());
            frame.insert("differing".to_owned(), self.differing.into());
            frame.insert("delay".to_owned(), self.delay.as_secs_f64().into());
        }
        if is_due && std::mem::take(&mut self.parts_are_old) {
            add(&mut frame, self.parts());
            self.last_parts = now();
        }
        if !frame.is_empty() {
            self.broadcast.send(frame);
        }
    }

    fn parts(&self) -> Value {
        match &self.playback {
            None => frame::parts(self.newest(), self.history.timeline()),
            Some(_) => frame::parts(self.shown(), &self.history.timeline().until(self.shown())),
        }
    }

    /// Sends something else.
    pub(crate) fn send_alone(&self, what: Map<String, Value>) {
        self.broadcast.send(what);
    }
}

/// Adds the entries of an object.
fn add(frame: &mut Map<String, Value>, more: Value) {
    if let Value::Object(more) = more {
        frame.extend(more);
    }
}
