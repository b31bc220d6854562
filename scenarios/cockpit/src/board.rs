//! The progress of many runs in browsers.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use serde_json::{Map, Value, json};

use crate::clock::{FRAME, now};
use crate::outlet::Outlet;
use crate::server::{Cockpit, Error};

/// So many of the latest runs that were not as expected are named.
const NAMED: usize = 50;
/// Browsers have so long to hear that it is over.
const FAREWELL: Duration = Duration::from_secs(10);

/// How often something has happened.
#[derive(Clone, Debug)]
pub struct Tally {
    /// What: the name of a property.
    pub name: String,
    /// In how many runs it happened.
    pub happened: u64,
    /// Of how many.
    pub of: u64,
    /// Between which probabilities that leaves it, with 95 % confidence, if that is known.
    pub interval: Option<[f64; 2]>,
}

/// A page that shows how many runs are done, and what they were like. Nobody can steer anything there.
pub struct Board {
    cockpit: Cockpit,
    outlet: Outlet,
    told: Mutex<Told>,
}

struct Told {
    begun: Instant,
    last: Option<Instant>,
    /// How many runs were done before.
    before: u64,
    unexpected: u64,
    named: Vec<String>,
}

impl Board {
    /// Listens on the loopback address at this port, or at any for 0, and serves the page for as long as the program
    /// runs.
    ///
    /// # Errors
    /// If that port cannot be had.
    pub fn open(title: &str, port: u16) -> Result<Self, Error> {
        let outlet = Outlet::new();
        outlet.greet(&json!({ "greeting": { "title": title } }));
        let cockpit = Cockpit::board(outlet.clone(), port)?;
        let served = cockpit.clone();
        // Runs go on without a page.
        std::thread::spawn(move || drop(served.serve()));
        let told = Told { begun: now(), last: None, before: 0, unexpected: 0, named: Vec::new() };
        Ok(Self { cockpit, outlet, told: Mutex::new(told) })
    }

    /// The address of the page.
    #[must_use]
    pub fn address(&self) -> String {
        self.cockpit.address_for_viewers()
    }

    /// Takes in that so many of all runs are done. `unexpected` names the latest if it was not as expected; `tallies`
    /// are asked for if browsers are to be told.
    pub fn show(&self, done: u64, all: u64, unexpected: Option<String>, tallies: impl FnOnce() -> Vec<Tally>) {
        let mut told = self.told.lock().unwrap_or_else(PoisonError::into_inner);
        if told.last.is_none() {
            // Runs of earlier sittings say nothing of how fast this one is.
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

    /// Tells browsers that there will be no more, and waits a moment until they know.
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
