//! The progress of many runs, shown in browsers.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use serde_json::{Map, Value, json};

use crate::broadcast::Broadcast;
use crate::clock::{FRAME, now};
use crate::server::{Cockpit, Error};

/// How many of the latest unexpected runs are named.
const NAMED: usize = 50;
/// How long browsers have to receive the last frame.
const FAREWELL: Duration = Duration::from_secs(10);

/// How often something happened.
#[derive(Clone, Debug)]
pub struct Tally {
    /// The name of the property.
    pub name: String,
    /// In how many runs it happened.
    pub happened: u64,
    /// The number of runs counted.
    pub of: u64,
    /// The 95 % confidence interval of its probability, if that is known.
    pub interval: Option<[f64; 2]>,
}

/// A page that shows the progress of many runs and their results so far. It has no controls.
pub struct Board {
    cockpit: Cockpit,
    broadcast: Broadcast,
    so_far: Mutex<SoFar>,
}

struct SoFar {
    begun: Instant,
    last: Option<Instant>,
    /// How many runs were already done at the start.
    before: u64,
    unexpected: u64,
    named: Vec<String>,
}

impl Board {
    /// Listens on the loopback address at this port (0 for any free port), and serves the page until the program ends.
    ///
    /// # Errors
    /// If the port is not available.
    pub fn open(title: &str, port: u16) -> Result<Self, Error> {
        let broadcast = Broadcast::new();
        broadcast.greet(&json!({ "greeting": { "title": title } }));
        let cockpit = Cockpit::board(broadcast.clone(), port)?;
        let served = cockpit.clone();
        // The runs go on even if the page cannot be served.
        std::thread::spawn(move || drop(served.serve()));
        let so_far = SoFar { begun: now(), last: None, before: 0, unexpected: 0, named: Vec::new() };
        Ok(Self { cockpit, broadcast, so_far: Mutex::new(so_far) })
    }

    /// The address of the page.
    #[must_use]
    pub fn address(&self) -> String {
        self.cockpit.address_for_viewers()
    }

    /// Shows that `done` of `all` runs are done. `unexpected` names the latest run if it was not as expected; `tallies`
    /// is called only if browsers get an update.
    pub fn show(&self, done: u64, all: u64, unexpected: Option<String>, tallies: impl FnOnce() -> Vec<Tally>) {
        let mut so_far = self.so_far.lock().unwrap_or_else(PoisonError::into_inner);
        if so_far.last.is_none() {
            // Runs from before an interruption do not count for the present speed.
            (so_far.begun, so_far.before) = (now(), done);
        }
        if let Some(name) = unexpected {
            so_far.unexpected += 1;
            so_far.named.push(name);
            let surplus = so_far.named.len().saturating_sub(NAMED);
            so_far.named.drain(..surplus);
        }
        if done < all && so_far.last.is_some_and(|last| last.elapsed() < 5 * FRAME) {
            return;
        }
        so_far.last = Some(now());
        let tally = |Tally { name, happened, of, interval }| json!({ "name": name, "happened": happened, "of": of, "interval": interval });
        let frame = json!({
            "done": done, "all": all, "before": so_far.before, "elapsed_s": so_far.begun.elapsed().as_secs_f64(),
            "unexpected": so_far.unexpected, "named": so_far.named,
            "tallies": tallies().into_iter().map(tally).collect::<Vec<_>>(),
        });
        if let Value::Object(frame) = frame {
            self.broadcast.send(frame);
        }
    }

    /// Informs browsers that the runs are over, and waits a moment until they have received it.
    pub fn finish(self) {
        self.broadcast.send(Map::from_iter([("over".to_owned(), true.into())]));
        self.broadcast.close();
        let begun = now();
        while self.cockpit.has_viewers() && begun.elapsed() < FAREWELL {
            pause();
        }
    }
}

#[expect(clippy::disallowed_methods, reason = "all runs are done")]
fn pause() {
    std::thread::sleep(FRAME);
}
