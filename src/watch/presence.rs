//! Whether anything is known of a robot at all: an empty domain or bridge satisfies no property.

use std::cell::Cell;
use std::collections::BTreeSet;
use std::rc::Rc;
use std::time::{Duration, Instant};

use bags::{Account, Received, Source};
use network::{Error, Live, Publish, Robot};

use crate::moment::moment;
use crate::output::note;

/// How long there may be nothing before a note.
const LATE: Duration = Duration::from_secs(6);

/// Whether anything is known of a robot: a topic, a node or a service.
pub(super) fn is_there(live: &(impl Live + ?Sized)) -> bool {
    !live.survey().topics.is_empty() || *live.robot() != Robot::default()
}

/// A robot of which something must be known. Otherwise, all its messages count as lost at the end.
pub(super) struct Presence {
    live: Box<dyn Live>,
    is_there: Rc<Cell<bool>>,
    /// The problem if nothing is known, and its likely reasons.
    absence: [String; 2],
    since: Instant,
    is_noted: bool,
    /// The losses of the robot, and its absence.
    lost: Vec<String>,
    /// How many of the robot's losses are among them.
    known: usize,
}

impl Presence {
    pub(super) fn new(live: Box<dyn Live>, absence: [String; 2]) -> Self {
        let is_there = Rc::new(Cell::new(is_there(live.as_ref())));
        Self { live, is_there, absence, since: moment(), is_noted: false, lost: Vec::new(), known: 0 }
    }

    /// Whether anything has been known by now. The cell outlives this source.
    pub(super) fn is_there(&self) -> Rc<Cell<bool>> {
        Rc::clone(&self.is_there)
    }

    fn update(&mut self) {
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
        self.update();
        if !self.is_there.get() && !self.is_noted && self.since.elapsed() >= LATE {
            self.is_noted = true;
            let [what, why] = &self.absence;
            note(&format!("{what}. {why}"));
        }
        received
    }

    fn end(&mut self) {
        self.live.end();
        self.update();
        if !self.is_there.get() {
            self.lost.push(self.absence[0].clone());
        }
    }

    fn account(&self) -> Account<'_> {
        Account { lost: &self.lost, ..self.live.account() }
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
        self.update();
        begun
    }

    fn status_publisher(&self) -> Option<Publish> {
        self.live.status_publisher()
    }
}
