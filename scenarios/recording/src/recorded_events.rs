//! The events of a recording, for other monitors than those of its run.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use channels::{ChannelId, Event, EventKind, Gap, Topology};
use monitors::{ForeignMessage, GapMark, WORLD, admit};

use crate::{Ended, Happening, Recording, RecordingError, RunView};

/// Why there are no more events.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordedEventsError {
    /// The recording cannot be read further.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// A message that its channel cannot carry in the system of the monitors.
    #[error("at {:.2} s, step {step}: {message}", time.as_secs_f64())]
    Foreign {
        /// When it was received.
        time: Duration,
        /// The number of its step.
        step: u64,
        /// The message.
        message: ForeignMessage,
    },
}

/// The events of a recording, one after the other, on the channels of a system: that of the run, or another one with
/// channels between processes of the same names. It has the same methods as an [event log](monitors::EventLog).
#[derive(Debug)]
pub struct RecordedEvents {
    recording: Recording,
    view: RunView,
    topology: Arc<Topology>,
    /// By the channel of the run, that of the system; none if the system does not have it.
    channels: Vec<Option<ChannelId>>,
    /// The events of the last step that have not been returned.
    events: VecDeque<Event>,
    marks: VecDeque<GapMark>,
    /// What has become of the nodes of the tree since it was last asked for.
    outcomes: Vec<(usize, Option<bt::Outcome>)>,
    /// Why the recording ends before its run does.
    truncated: Option<RecordingError>,
    skipped: u64,
    is_foreign: bool,
}

impl RecordedEvents {
    /// The events from the start of a recording, of which `view` is [that](Recording::begin).
    #[must_use]
    pub fn new(recording: Recording, view: RunView, topology: &Arc<Topology>) -> Self {
        let run = view.topology();
        let outer: Vec<ChannelId> = topology.channels().filter(|channel| !topology.is_internal(*channel)).collect();
        let named = |channel: ChannelId| {
            let is_it = |other: &ChannelId| topology.ends(*other) == run.ends(channel);
            // Several channels may have the same name: in the system of the run, each is itself.
            outer.iter().copied().find(|other| *other == channel && is_it(other)).or(outer.iter().copied().find(is_it))
        };
        let channels = run.channels().map(named).collect();
        let mut events = Self {
            recording,
            channels,
            topology: Arc::clone(topology),
            events: VecDeque::new(),
            marks: VecDeque::new(),
            outcomes: Vec::new(),
            truncated: None,
            skipped: 0,
            is_foreign: false,
            view,
        };
        events.take_step();
        events
    }

    /// The run as far as it has been read.
    #[must_use]
    pub fn view(&self) -> &RunView {
        &self.view
    }

    /// The next event; `None` at the end of the recording.
    ///
    /// # Errors
    /// [`RecordedEventsError`].
    pub fn next_event(&mut self) -> Result<Option<Event>, RecordedEventsError> {
        loop {
            if let Some(event) = self.events.pop_front() {
                match self.admit(event)? {
                    None => continue,
                    event => return Ok(event),
                }
            }
            if self.view.end().is_some() || self.truncated.is_some() {
                return Ok(None);
            }
            match self.recording.advance(&mut self.view) {
                Ok(()) => self.take_step(),
                Err(error @ RecordingError::Truncated { .. }) => self.truncated = Some(error),
                Err(error) => return Err(error.into()),
            }
            if let Some(Ended::CutOff(what)) = self.view.end().map(|end| &end.ended) {
                let extent = format!("at {:.2} s: {what}", self.view.time().as_secs_f64());
                self.truncated = Some(self.recording.truncated(extent));
            }
        }
    }

    /// Takes the events and gaps of the current step.
    fn take_step(&mut self) {
        self.events.extend(self.view.events().iter().cloned());
        self.outcomes.extend(self.view.step().details.iter().flat_map(|details| &details.outcomes).copied());
        for happening in self.view.happenings() {
            let channel_of = |channel: ChannelId| self.channels[channel.index()];
            self.marks.extend(match happening {
                Happening::Lost(gap) => match gap.channel.map(channel_of) {
                    None => Some(GapMark::Begins(gap.clone())),
                    Some(Some(channel)) => Some(GapMark::Begins(Gap { channel: Some(channel), ..gap.clone() })),
                    // A gap that ends, in a channel that the system does not have, is none.
                    Some(None) => {
                        let anywhere = Gap { channel: None, ..gap.clone() };
                        (!gap.ends).then_some(GapMark::Begins(anywhere))
                    }
                },
                Happening::Resumed(channel) => channel_of(*channel).map(GapMark::Ends),
                _ => None,
            });
        }
    }

    /// The event in the system of the monitors; none if that does not have its channel.
    fn admit(&mut self, event: Event) -> Result<Option<Event>, RecordedEventsError> {
        let EventKind::Received { channel, message } = event.kind else { return Ok(Some(event)) };
        let run = self.view.topology();
        let Some(known) = self.channels[channel.index()] else {
            self.skipped += 1;
            self.is_foreign |= run.ends(channel).0 != WORLD;
            return Ok(None);
        };
        let Event { time, step, .. } = event;
        let message = admit(message, self.topology.ends(known), &self.topology.get(known).domain)
            .map_err(|message| RecordedEventsError::Foreign { time, step, message })?;
        Ok(Some(Event { kind: EventKind::Received { channel: known, message }, ..event }))
    }

    /// Where the next gap before the last event, or at the end, begins or ends.
    pub fn next_gap_mark(&mut self) -> Option<GapMark> {
        self.marks.pop_front()
    }

    /// What has become of the nodes of the tree up to the last event, since the last call.
    pub fn take_outcomes(&mut self) -> Vec<(usize, Option<bt::Outcome>)> {
        std::mem::take(&mut self.outcomes)
    }

    /// The number of messages skipped because the system does not have their channels.
    #[must_use]
    pub fn skipped(&self) -> u64 {
        self.skipped
    }

    /// Whether one of these shows that the recording is of another system: what is true in the world is in a recording
    /// if a property of its run asked for it.
    #[must_use]
    pub fn is_foreign(&self) -> bool {
        self.is_foreign
    }

    /// Why the recording ends before its run does; none if it does not, or its end has not been read.
    #[must_use]
    pub fn truncated(&self) -> Option<&RecordingError> {
        self.truncated.as_ref()
    }

    /// When the run ended, if its end has been read.
    #[must_use]
    pub fn end(&self) -> Option<Duration> {
        let is_whole = self.view.end().is_some() && self.truncated.is_none();
        is_whole.then(|| self.view.time())
    }
}
