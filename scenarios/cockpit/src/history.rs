//! A run so far, which can be shown as it was at any time.

use std::io;
use std::time::Duration;

use recording::{Follower, Record, RecordStore, RunView};
use reports::timeline::Timeline;

use crate::frame::Happened;
use crate::moment::Moment;

/// Time between the scenes that are kept.
const SCENES: Duration = Duration::from_millis(500);
/// The maximum number of moments in memory from which the store can be played.
const MARKS: usize = 48;

/// A moment from which the store can be played.
struct Mark {
    moment: Moment,
    /// The next chunk of the store.
    chunk: usize,
}

/// A run so far. Its records are in a temporary file, with a few moments in memory from which they can be played.
pub(crate) struct History {
    newest: Moment,
    timeline: Timeline,
    happened: Vec<Happened>,
    store: RecordStore,
    marks: Vec<Mark>,
    /// How many chunks there are between the moments kept.
    spacing: usize,
    next_scene: Duration,
}

impl History {
    /// A run at its start.
    ///
    /// # Errors
    /// If no temporary file can be made.
    pub(crate) fn begin(start: RunView) -> io::Result<Self> {
        let newest = Moment::start(start);
        Ok(Self {
            timeline: Timeline::new(&newest.view),
            happened: Vec::new(),
            store: RecordStore::new(tempfile::tempfile()?),
            marks: vec![Mark { moment: newest.clone(), chunk: 0 }],
            newest,
            spacing: 1,
            next_scene: Duration::ZERO,
        })
    }

    /// Adds the next record.
    ///
    /// # Errors
    /// If it does not fit, or cannot be stored.
    pub(crate) fn push(&mut self, mut record: Record) -> io::Result<()> {
        self.newest.apply(record.clone()).map_err(io::Error::other)?;
        let view = &self.newest.view;
        if let Record::Step(step) = &mut record {
            let Ok(()) = self.timeline.follow(view);
            self.happened.extend(view.happenings().iter().filter_map(|happening| Happened::of(happening, view)));
            if let Some(details) = step.details.as_mut().filter(|details| details.scene.is_some()) {
                // Most of the bytes of a run are scenes. People do not look at every one of the past.
                if step.time < self.next_scene {
                    details.scene = None;
                } else {
                    self.next_scene = step.time + SCENES;
                }
            }
        }
        let complete = self.store.chunks();
        self.store.push(record.borrowed())?;
        let chunk = self.store.chunks();
        if chunk > complete && chunk.is_multiple_of(self.spacing) {
            self.marks.push(Mark { moment: self.newest.clone(), chunk });
        }
        // Half of the marks are dropped whenever there are too many, so that memory stays bounded and the rest evenly
        // spaced.
        if self.marks.len() > MARKS {
            self.spacing *= 2;
            self.marks.retain(|mark| mark.chunk.is_multiple_of(self.spacing));
        }
        Ok(())
    }

    /// The run now.
    pub(crate) fn newest(&self) -> &Moment {
        &self.newest
    }

    /// The timeline of the whole run.
    pub(crate) fn timeline(&self) -> &Timeline {
        &self.timeline
    }

    /// What happened up to a time.
    pub(crate) fn happened(&self, until: Duration) -> &[Happened] {
        &self.happened[..self.happened.partition_point(|happened| happened.time <= until)]
    }

    /// A playback from the last moment kept before `time`.
    fn playback(&self, time: Duration) -> Playback {
        let after = self.marks.partition_point(|mark| mark.moment.view.time() <= time);
        let mark = &self.marks[after.saturating_sub(1)];
        Playback { moment: mark.moment.clone(), chunk: mark.chunk, records: Vec::new().into_iter() }
    }
}

/// Plays the past of a run.
pub(crate) struct Playback {
    moment: Moment,
    /// The next chunk of the store.
    chunk: usize,
    /// The records before that chunk that are still to be played.
    records: std::vec::IntoIter<Record>,
}

impl Playback {
    /// The playback that is closest before `time`: `present`, or one at a moment kept.
    pub(crate) fn towards(time: Duration, present: Option<Self>, history: &History) -> Self {
        let other = history.playback(time);
        let is_nearer = |present: &Self| (other.time()..=time).contains(&present.time());
        present.filter(is_nearer).unwrap_or(other)
    }

    /// The moment that it has reached.
    pub(crate) fn moment(&self) -> &Moment {
        &self.moment
    }

    fn time(&self) -> Duration {
        self.moment.view.time()
    }

    /// The time of the next record, if there is one.
    ///
    /// # Errors
    /// If the store cannot be read.
    pub(crate) fn next_time(&mut self, history: &mut History) -> io::Result<Option<Duration>> {
        if self.records.as_slice().is_empty() {
            self.records = history.store.read(self.chunk)?.into_iter();
            self.chunk += usize::from(!self.records.as_slice().is_empty());
        }
        Ok(self.records.as_slice().first().map(|record| match record {
            Record::Step(step) => step.time,
            Record::Header(_) | Record::End(_) => self.time(),
        }))
    }

    /// Goes on to the next record, if there is one in memory. Returns whether it is a step.
    ///
    /// # Errors
    /// If it does not fit.
    pub(crate) fn advance(&mut self) -> io::Result<bool> {
        let Some(record) = self.records.next() else { return Ok(false) };
        let is_step = matches!(record, Record::Step(_));
        self.moment.apply(record).map_err(io::Error::other)?;
        Ok(is_step)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use recording::Detail;
    use runs::Session;
    use scenarios::scenario::find;

    use super::*;
    use crate::frame::{self, Update};

    /// What the page gets for a moment, without what may differ: only some scenes are kept, the battery's curve has
    /// other points, and points of the trail may occur twice.
    fn shown(moment: &Moment, timeline: &Timeline, history: &History) -> [serde_json::Value; 2] {
        let update = Update::anew(moment, history.happened(moment.view.time()));
        let mut shown = [frame::state(&moment.view, &BTreeSet::new(), update), frame::parts(&moment.view, timeline)];
        assert!(shown[0]["scene"].take().is_object());
        assert!(shown[1]["course"].take().is_object());
        let trail: Vec<f64> = serde_json::from_value(shown[1]["trail"].take()).unwrap();
        let mut trail: Vec<&[f64]> = trail.chunks(2).collect();
        trail.dedup();
        shown[1]["trail"] = serde_json::json!(trail);
        shown
    }

    #[test]
    fn the_past_is_shown_as_it_was() {
        let mut session = Session::new(&find::find("battery_fault").unwrap(), &[], None).unwrap();
        let mut history = History::begin(session.view().clone()).unwrap();
        let mut then = Vec::new();
        for number in 0_usize.. {
            if number.is_multiple_of(101) || session.view().end().is_some() {
                then.push((history.newest.view.time(), shown(&history.newest, &history.timeline, &history)));
            }
            if session.view().end().is_some() {
                break;
            }
            if session.view().time() >= Duration::from_secs(30) {
                session.end();
            } else {
                session.step(Detail::Scenes).unwrap();
            }
            session.take_records().into_iter().for_each(|record| history.push(record).unwrap());
        }
        assert!(then.len() > 10 && history.marks.len() > 2, "{} marks", history.marks.len());
        let mut player = None;
        // Once backward, then once forward.
        for (time, was) in then.iter().rev().chain(&then) {
            let mut there = Playback::towards(*time, player, &history);
            while there.next_time(&mut history).unwrap().is_some_and(|next| next <= *time) {
                there.advance().unwrap();
            }
            let view = &there.moment.view;
            let is = shown(&there.moment, &history.timeline.until(view), &history);
            for (is, was) in is.iter().zip(was) {
                for (key, was) in was.as_object().unwrap() {
                    assert_eq!(is[key], *was, "{key} at {time:?}");
                }
            }
            player = Some(there);
        }
    }
}
