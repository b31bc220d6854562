//! The records of runs as they are made, for a page.

use std::convert::Infallible;
use std::sync::mpsc::{Receiver, Sender, channel};

use recording::{Follower, Record, RunView};

/// Sends the records of runs, one run after the other, to [a page](crate::Cockpit::follow), which stores them in a
/// temporary file. They wait in memory until it has done so. Once no page receives them, they are discarded.
#[derive(Clone, Debug)]
pub struct Feed(Sender<Record>);

impl Feed {
    /// A feed, and its other end, for the page.
    #[must_use]
    pub fn new() -> (Self, Receiver<Record>) {
        let (feed, records) = channel();
        (Self(feed), records)
    }

    /// Begins a run, after the end of the one before. Its steps must have [details](recording::Details).
    pub fn begin(&self, start: &RunView) {
        self.send(Record::Header(Box::new(start.header().clone())));
        self.send(Record::Step(start.step().clone()));
    }

    fn send(&self, record: Record) {
        // An error means that the page has ended.
        let _ = self.0.send(record);
    }
}

impl Follower for Feed {
    type Error = Infallible;

    fn follow(&mut self, view: &RunView) -> Result<(), Infallible> {
        self.send(Record::Step(view.step().clone()));
        view.end().into_iter().for_each(|end| self.send(Record::End(Box::new(end.clone()))));
        Ok(())
    }
}
