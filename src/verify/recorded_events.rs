//! The events of a recording, for other monitors than those of its run.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use campaigns::Error;
use channels::{ChannelId, Event, EventKind, Gap, Topology};
use monitors::{GapMark, WORLD, admit};
use recording::{Ended, Happening, Recording, RecordingError, RunView};

use super::logged_run::{LoggedRun, NodeOutcome};
use crate::output::note;

/// The events of a recording, one after the other, on the channels of a system: that of the run, or another one with
/// channels between processes of the same names.
pub(super) struct RecordedEvents {
    recording: Recording,
    view: RunView,
    topology: Arc<Topology>,
    /// By the channel of the run, that of the system; none if the system does not have it.
    channels: Vec<Option<ChannelId>>,
    /// The events of the last step that have not been returned.
    events: VecDeque<Event>,
    marks: VecDeque<GapMark>,
    /// What has become of the nodes of the tree since it was last asked for.
    outcomes: Vec<NodeOutcome>,
    /// Why the recording ends before its run does.
    truncated: Option<RecordingError>,
    skipped: u64,
    is_foreign: bool,
}

impl RecordedEvents {
    /// The events from the start of a recording, of which `view` is [that](Recording::begin).
    pub(super) fn new(recording: Recording, view: RunView, topology: &Arc<Topology>) -> Self {
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
    fn admit(&mut self, event: Event) -> Result<Option<Event>, Error> {
        let EventKind::Received { channel, message } = event.kind else { return Ok(Some(event)) };
        let run = self.view.topology();
        let Some(known) = self.channels[channel.index()] else {
            self.skipped += 1;
            self.is_foreign |= run.ends(channel).0 != WORLD;
            return Ok(None);
        };
        let Event { time, step, .. } = event;
        let message =
            admit(message, self.topology.ends(known), &self.topology.get(known).domain).map_err(|foreign| {
                let message = format!("at {:.2} s, step {step}: {foreign}", time.as_secs_f64());
                Error::refused(message, "name the scenario that the recording is from: `--scenario NAME|FILE`")
            })?;
        Ok(Some(Event { kind: EventKind::Received { channel: known, message }, ..event }))
    }
}

impl LoggedRun for RecordedEvents {
    fn next_event(&mut self) -> Result<Option<Event>, Error> {
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
                Err(error) => {
                    let help = "the recording was changed after it was written: record the run again";
                    return Err(Error::refused(error.to_string(), help));
                }
            }
            if let Some(Ended::CutOff(what)) = self.view.end().map(|end| &end.ended) {
                let extent = format!("at {:.2} s: {what}", self.view.time().as_secs_f64());
                self.truncated = Some(self.recording.truncated(extent));
            }
        }
    }

    fn next_gap_mark(&mut self) -> Option<GapMark> {
        self.marks.pop_front()
    }

    fn take_outcomes(&mut self) -> Vec<NodeOutcome> {
        std::mem::take(&mut self.outcomes)
    }

    fn skipped(&self) -> u64 {
        self.skipped
    }

    /// What is true in the world is in a recording if a property of its run asked for it.
    fn is_foreign(&self) -> bool {
        self.is_foreign
    }

    fn breaks_off(&self) -> bool {
        self.truncated.is_some()
    }

    /// Any message may be missing from there on.
    fn rest(&self) -> (Gap, Option<&'static str>) {
        let why = self.truncated.as_ref().map(ToString::to_string).unwrap_or_default();
        note(&why);
        (Gap::of_anything(why), None)
    }

    fn end(&self) -> Option<Duration> {
        let is_whole = self.view.end().is_some() && self.truncated.is_none();
        is_whole.then(|| self.view.time())
    }

    fn view(&self) -> Option<&RunView> {
        Some(&self.view)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::fs;
    use std::path::Path;

    use ros_messages::{RosMessage as _, RosType as _, messages};

    use super::*;

    messages! {
        Time = "builtin_interfaces/Time" { sec: i32, nanosec: u32 }
        Change = "nav2_msgs/BehaviorTreeStatusChange" {
            timestamp: Time,
            node_name: String,
            uid: u16,
            previous_status: String,
            current_status: String,
        }
        Log = "nav2_msgs/BehaviorTreeLog" { timestamp: Time, event_log: Vec<Change> }
    }

    /// A bag in which a node of Nav2's tree ends without the messages about its success.
    fn write_lossy_bag(path: &Path) {
        let time = |sec| Time { sec, nanosec: 0 };
        let change = |sec, (name, uid, before, after): (&str, u16, &str, &str)| Change {
            timestamp: time(sec),
            node_name: name.to_owned(),
            uid,
            previous_status: before.to_owned(),
            current_status: after.to_owned(),
        };
        let begin = [("Navigate", 1, "IDLE", "RUNNING"), ("ComputePathToPose", 2, "IDLE", "RUNNING")];
        let end = [("ComputePathToPose", 2, "SUCCESS", "IDLE"), ("Navigate", 1, "RUNNING", "SUCCESS")];
        let mut writer = mcap::WriteOptions::new().compression(None).create(fs::File::create(path).unwrap()).unwrap();
        let definition = Log::definition().to_string();
        let schema = writer.add_schema("nav2_msgs/msg/BehaviorTreeLog", "ros2msg", definition.as_bytes()).unwrap();
        let channel_id = writer.add_channel(schema, "/behavior_tree_log", "cdr", &BTreeMap::new()).unwrap();
        for (sec, changes, log_time) in [(1_000_000_000, begin, 1), (1_000_000_003, end, 2)] {
            let log = Log { timestamp: time(sec), event_log: changes.map(|of| change(sec, of)).to_vec() };
            let header = mcap::records::MessageHeader { channel_id, sequence: 0, log_time, publish_time: log_time };
            writer.write_to_known_channel(&header, &log.encode()).unwrap();
        }
        writer.finish().unwrap();
    }

    /// The recording after its last event, for monitors in the system of its run.
    fn read(mut recording: Recording) -> RecordedEvents {
        let start = recording.begin().unwrap();
        let topology = Arc::clone(&start.header().topology);
        let mut events = RecordedEvents::new(recording, start, &topology);
        while events.next_event().unwrap().is_some() {}
        events
    }

    #[test]
    fn monitors_of_other_properties_are_notified_of_each_loss() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bag.mcap");
        write_lossy_bag(&path);
        let tree = "<root BTCPP_format=\"4\" main_tree_to_execute=\"Main\"><BehaviorTree ID=\"Main\">\
                    <Sequence name=\"Navigate\"><ComputePathToPose/></Sequence></BehaviorTree></root>";
        let opened = || Recording::of_bag(&path, &bt::Tree::from_xml("tree.xml", tree).unwrap().into()).unwrap();
        let mut recording = opened();
        let (mut view, mut gaps) = (recording.begin().unwrap(), Vec::new());
        while view.end().is_none() {
            recording.advance(&mut view).unwrap();
            gaps.extend(view.happenings().iter().filter_map(|happening| match happening {
                Happening::Lost(gap) => Some(gap.clone()),
                _ => None,
            }));
        }
        let [gap] = &gaps[..] else { panic!("{gaps:?}") };
        let mut events = read(opened());
        assert_eq!((events.next_gap_mark(), events.next_gap_mark()), (Some(GapMark::Begins(gap.clone())), None));
    }

    #[test]
    fn a_recording_that_was_cut_off_breaks_off_and_has_no_end() {
        let log = Path::new(env!("CARGO_MANIFEST_DIR")).join("bt/logs/tests/captured/fetch.btlog");
        let whole = fs::read(log).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("cut.btlog");
        let start = whole.len() - 9 * 76;
        for length in [whole.len() - 4, start + 4, start, whole.len()] {
            fs::write(&path, &whole[..length]).unwrap();
            let events = read(Recording::open(&path).unwrap());
            let is_cut = !(length - start).is_multiple_of(9);
            assert_eq!((events.breaks_off(), events.end().is_none()), (is_cut, is_cut), "{length}");
        }
    }
}
