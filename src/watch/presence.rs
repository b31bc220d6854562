//! Whether anything is known of a robot at all: a domain or a bridge in which there is nothing satisfies nothing.

use std::cell::Cell;
use std::collections::BTreeSet;
use std::rc::Rc;
use std::time::{Duration, Instant};

use bags::{Received, Source, Survey};
use network::{Error, Live, Publish, Robot};

use crate::moment::moment;
use crate::output::note;

/// How long there may be nothing before that is mentioned.
const LATE: Duration = Duration::from_secs(6);

/// Whether a robot has told anything of itself: a topic, a node, a service.
pub(super) fn is_there(live: &(impl Live + ?Sized)) -> bool {
    !live.survey().topics.is_empty() || *live.robot() != Robot::default()
}

/// A robot of which something is to be known; without that, everything is lost at the end.
pub(super) struct Presence {
    live: Box<dyn Live>,
    is_there: Rc<Cell<bool>>,
    /// What is wrong if nothing is there, and what to do.
    absence: [String; 2],
    since: Instant,
    is_told: bool,
    /// That of the robot, and what is added to it.
    lost: Vec<String>,
    known: usize,
}

impl Presence {
    pub(super) fn new(live: Box<dyn Live>, absence: [String; 2]) -> Self {
        let is_there = Rc::new(Cell::new(is_there(live.as_ref())));
        Self { live, is_there, absence, since: moment(), is_told: false, lost: Vec::new(), known: 0 }
    }

    /// Whether anything was there by now, also when this is gone.
    pub(super) fn is_there(&self) -> Rc<Cell<bool>> {
        Rc::clone(&self.is_there)
    }

    fn look(&mut self) {
        if !self.is_there.get() {
            self.is_there.set(is_there(self.live.as_ref()));
        }
        let new = self.live.lost().get(self.known..).unwrap_or_default();
        self.lost.extend(new.iter().cloned());
        self.known = self.live.lost().len();
    }
}

impl Source for Presence {
    fn receive(&mut self, body: &mut Vec<u8>) -> Received {
        let received = self.live.receive(body);
        self.look();
        if !self.is_there.get() && !self.is_told && self.since.elapsed() >= LATE {
            self.is_told = true;
            let [what, why] = &self.absence;
            note(&format!("{what}. {why}"));
        }
        received
    }

    fn end(&mut self) {
        self.live.end();
        self.look();
        if !self.is_there.get() {
            self.lost.push(self.absence[0].clone());
        }
    }

    fn survey(&self) -> &Survey {
        self.live.survey()
    }

    fn lost(&self) -> &[String] {
        &self.lost
    }

    fn notes(&self) -> &[String] {
        self.live.notes()
    }

    fn counts_losses(&self) -> bool {
        self.live.counts_losses()
    }
}

impl Live for Presence {
    fn name(&self) -> &str {
        self.live.name()
    }

    fn robot(&self) -> &Robot {
        self.live.robot()
    }

    fn only_show(&mut self, topics: BTreeSet<String>) {
        self.live.only_show(topics);
    }

    fn begin(&mut self) -> Result<(), Error> {
        let begun = self.live.begin();
        (self.lost, self.known) = (Vec::new(), 0);
        self.look();
        begun
    }

    fn publisher(&self) -> Option<Publish> {
        self.live.publisher()
    }
}
