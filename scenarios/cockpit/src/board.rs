//! The progress of many runs, shown in browsers.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use serde_json::{Map, Value, json};

use crate::clock::{FRAME, now};
use crate::outlet::Outlet;
use crate::server::{Cockpit, Error};

/// How many of the latest unexpected runs are named.
const NAMED: usize = 50;
/// How long browsers have to learn that it is over.
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

/// A page that shows the progress of many runs and their results so far. Nobody can control anything there.
pub struct Board {
    cockpit: Cockpit,
    outlet: Outlet,
    told: Mutex<Told>,
}

struct Told {
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
        let outlet = Outlet::new();
        outlet.greet(&json!({ "greeting": { "title": title } }));
        let cockpit = Cockpit::board(outlet.clone(), port)?;
        let served = cockpit.clone();
        // The runs go on even if the page cannot be served.
        std::thread::spawn(move || drop(served.serve()));
        let told = Told { begun: now(), last: None, before: 0, unexpected: 0, named: Vec::new() };
        Ok(Self { cockpit, outlet, told: Mutex::new(told) })
    }

    /// The address of the page.
    #[must_use]
    pub fn address(&self) -> String {
        self.cockpit.address_for_viewers()
    }

    /// Shows that `done` of `all` runs are done. `unexpected` names the latest run if it was not as expected; `tallies`
    /// is called only if browsers get an update.
    pub fn show(&self, done: u64, all: u64, unexpected: Option<String>, tallies: impl FnOnce() -> Vec<Tally>) {
        let mut told = self.told.lock().unwrap_or_else(PoisonError::into_inner);
        if told.last.is_none() {
            // Runs from before an interruption say nothing about the present speed.
            (told.begun, told.before) = (now(), done);
        }
        if let Some(name) = unexpected {
            told.unexpected += 1;
            told.named.push(name);
            let surplus = told.named.len().saturating_sub(NAMED);
            told.named.drain(..surplus);
        }
        if done < all && told.last.is_some_and(|last| last.elapsed() < 5 * FRAME) {
            return;
        }
        told.last = Some(now());
        let tally = |Tally { name, happened, of, interval }| json!({ "name": name, "happened": happened, "of": of, "interval": interval });
        let frame = json!({
            "done": done, "all": all, "before": told.before, "elapsed_s": told.begun.elapsed().as_secs_f64(),
            "unexpected": told.unexpected, "named": told.named,
            "tallies": tallies().into_iter().map(tally).collect::<Vec<_>>(),
        });
        if let Value::Object(frame) = frame {
            self.outlet.tell(frame);
        }
    }

    /// Tells browsers that the runs are over, and waits a moment until they know.
    pub fn finish(self) {
        self.outlet.tell(Map::from_iter([("over".to_owned(), true.into())]));
        self.outlet.close();
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
