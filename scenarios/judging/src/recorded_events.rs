//! The events of a recording, for other monitors than those of its run.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use campaigns::Error;
use channels::{ChannelId, Event, EventKind, Flaw, Gap, Topology};
use monitors::{GapMark, WORLD, admit};
use recording::{Ended, Happening, Recording, RecordingError, RunView};

use crate::logged_run::{LoggedRun, NodeOutcome};

/// The events of a recording, one after the other, on the channels of a system: that of the run, or another one with
/// channels between processes of the same names. Records may be missing from a recording, so the numbers of its events
/// are compared with those that should come next, as in an [event log](monitors::EventLog).
pub(crate) struct RecordedEvents {
    path: PathBuf,
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
    /// Step, tick and time of the last event, and the number of the next tick.
    last: (u64, u64, Duration),
    next_tick: u64,
    /// How many messages there have been, with those of the world.
    messages: u64,
    /// Whether a number was another than the next one should be.
    is_incomplete: bool,
}

impl RecordedEvents {
    /// The events from the start of a recording, of which `view` is [that](Recording::begin).
    pub(crate) fn new(path: &Path, recording: Recording, view: RunView, topology: &Arc<Topology>) -> Self {
        let run = view.topology();
        let outer: Vec<ChannelId> = topology.channels().filter(|channel| !topology.is_internal(*channel)).collect();
        let named = |channel: ChannelId| {
            let is_it = |other: &ChannelId| topology.ends(*other) == run.ends(channel);
            // Several channels may have the same name: in the system of the run, each is itself.
            outer.iter().copied().find(|other| *other == channel && is_it(other)).or(outer.iter().copied().find(is_it))
        };
        let channels = run.channels().map(named).collect();
        let mut events = Self {
            path: path.to_owned(),
            recording,
            channels,
            topology: Arc::clone(topology),
            events: VecDeque::new(),
            marks: VecDeque::new(),
            outcomes: Vec::new(),
            truncated: None,
            skipped: 0,
            is_foreign: false,
            last: (0, 0, Duration::ZERO),
            next_tick: 0,
            messages: 0,
            is_incomplete: false,
            view,
        };
        events.take_step();
        events
    }

    fn take_step(&mut self) {
        self.events.extend(self.view.events().iter().cloned());
        self.outcomes.extend(self.view.step().details.iter().flat_map(|details| &details.outcomes).copied());
        for happening in self.view.happenings() {
            let channel_of = |channel: ChannelId| self.channels[channel.index()];
            self.marks.extend(match happening {
                Happening::Lost(gap) => match gap.channel.map(channel_of) {
                    None => Some(GapMark::Begins(gap.clone())),
                    Some(Some(channel)) => Some(GapMark::Begins(Gap { channel: Some(channel), ..gap.clone() })),
                    // A temporary gap in a channel that the system lacks does not matter.
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

    /// Compares the numbers of an event with those that should come next. A message is a step; a tick is none, and
    /// neither is what is true in the world.
    fn compare(&mut self, event: &Event) -> Result<(), Error> {
        let (step, tick, time) = self.last;
        if event.step < step || event.tick < tick || event.time < time || event.time > self.view.time() {
            return Err(changed(&format!("{} is damaged: it goes back in time", self.path.display())));
        }
        let (next_step, is_next_tick) = match event.kind {
            EventKind::Tick => (step, event.tick == self.next_tick),
            EventKind::Received { channel, .. } => {
                let is_of_world = self.view.topology().ends(channel).0 == WORLD;
                (
                    if is_of_world { step } else { step.saturating_add(1) },
                    event.tick <= self.next_tick.saturating_sub(1),
                )
            }
        };
        if event.step != next_step {
            self.miss(&format!("step {} comes where {next_step} should", event.step));
        } else if !is_next_tick {
            self.miss(&format!("tick {} comes where {} should", event.tick, self.next_tick));
        }
        self.last = (event.step, event.tick, event.time);
        self.messages += u64::from(event.kind != EventKind::Tick);
        if event.kind == EventKind::Tick || !is_next_tick {
            self.next_tick = event.tick.saturating_add(1);
        }
        Ok(())
    }

    /// Notes once that records are missing. Before the first tick, that is from the start.
    fn miss(&mut self, wrong: &str) {
        if std::mem::replace(&mut self.is_incomplete, true) {
            return;
        }
        let since = (self.view.header().knows_ticks() && self.next_tick == 0).then_some(Duration::ZERO);
        let flaw = if since.is_some() { Flaw::Displaced } else { Flaw::Missing };
        let why = format!("records are missing from the recording: {wrong}");
        self.marks.push_back(GapMark::Begins(Gap { flaw, since, ..Gap::of_anything(why) }));
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
                let at = format!("{}: at {:.2} s, step {step}", self.path.display(), time.as_secs_f64());
                Error::refused(format!("{at}: {foreign}"), "leave `--scenario` out, or name the one of the recording")
            })?;
        Ok(Some(Event { kind: EventKind::Received { channel: known, message }, ..event }))
    }
}

fn changed(message: &str) -> Error {
    Error::refused(message, "the recording was changed after it was written: record the run again")
}

impl LoggedRun for RecordedEvents {
    fn next_event(&mut self) -> Result<Option<Event>, Error> {
        loop {
            if let Some(event) = self.events.pop_front() {
                self.compare(&event)?;
                match self.admit(event)? {
                    None => continue,
                    event => return Ok(event),
                }
            }
            // A simulation does not count what is true in the world; records made from events count it as messages.
            let count = self.view.communications();
            if self.view.end().is_some() && ![self.last.0, self.messages].contains(&count) {
                self.miss(&format!("step {count} is missing"));
            }
            if self.view.end().is_some() || self.truncated.is_some() {
                return Ok(None);
            }
            match self.recording.advance(&mut self.view) {
                Ok(()) => self.take_step(),
                Err(error @ RecordingError::Truncated { .. }) => self.truncated = Some(error),
                Err(error) => return Err(changed(&error.to_string())),
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
    fn rest(&self) -> (Gap, bool) {
        (Gap::of_anything(self.truncated.as_ref().map(ToString::to_string).unwrap_or_default()), false)
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

    use channels::{Capacity, Domain, FieldKind, Message, Shape, Value};
    use recording::{Doubts, Follower as _, Judge, Origin, Writer};
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

    /// A recording of ticks and messages, without the record of the event at one place. `change` may change the others.
    fn write_run(path: &Path, without: Option<usize>, change: impl Fn(usize, &mut Event)) {
        let mut topology = Topology::default();
        let [from, to] = ["Meter", "Reader"].map(|name| topology.process(name).unwrap());
        let domain = Domain::new([Shape::new([("level", FieldKind::Real)])]);
        let channel = topology.channel(from, to, Capacity::One, domain).unwrap();
        let topology = Arc::new(topology);
        let message = || EventKind::Received { channel, message: Message::new([Value::Real(1.0)]) };
        let events =
            [(0, 0, EventKind::Tick), (1, 0, message()), (2, 0, message()), (2, 1, EventKind::Tick), (3, 1, message())];
        let (tick, doubts) = (Duration::from_secs(1), Doubts::new(&[], &topology));
        let (mut judge, header, start) =
            Judge::begin(Default::default(), Origin::default(), &topology, tick, &[], doubts);
        let mut view = RunView::new(header, start).unwrap();
        let mut writer = Writer::begin(Vec::new(), &view).unwrap();
        for (place, (step, tick, kind)) in events.into_iter().enumerate() {
            let time = Duration::from_secs(place as u64);
            let mut step = judge.step(Event { step, tick, time, kind }, &mut []);
            step.details.iter_mut().flat_map(|details| &mut details.events).for_each(|event| change(place, event));
            view.apply(step).unwrap();
            if without != Some(place) {
                writer.follow(&view).unwrap();
            }
        }
        view.apply(judge.quiet(view.time())).unwrap();
        view.finish(judge.finish(&[])).unwrap();
        writer.follow(&view).unwrap();
        fs::write(path, writer.finish().unwrap()).unwrap();
    }

    #[test]
    fn a_record_that_is_missing_leaves_a_gap() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.rec");
        for without in [None, Some(0), Some(1), Some(2), Some(3), Some(4)] {
            write_run(&path, without, |_, _| {});
            let mut events = read(Recording::open(&path).unwrap());
            let gaps: Vec<GapMark> = std::iter::from_fn(|| events.next_gap_mark()).collect();
            match (without, &gaps[..]) {
                (None, []) => {}
                // Without the first tick, anything may be missing from the start.
                (Some(place), [GapMark::Begins(Gap { since, why, .. })]) => {
                    assert_eq!(since.is_some(), place == 0, "{why}");
                    assert!(why.starts_with("records are missing from the recording: "), "{why}");
                }
                _ => panic!("without {without:?}: {gaps:?}"),
            }
        }
    }

    #[test]
    fn a_recording_whose_events_go_back_in_time_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.rec");
        for (place, time) in [(2, Duration::ZERO), (2, Duration::from_secs(9))] {
            write_run(&path, None, |other, event| {
                if other == place {
                    event.time = time;
                }
            });
            let mut recording = Recording::open(&path).unwrap();
            let start = recording.begin().unwrap();
            let topology = Arc::clone(&start.header().topology);
            let mut events = RecordedEvents::new(&path, recording, start, &topology);
            let refused = loop {
                match events.next_event() {
                    Ok(Some(_)) => {}
                    Ok(None) => panic!("it is not refused"),
                    Err(error) => break error.to_string(),
                }
            };
            assert!(refused.contains("run.rec is damaged: it goes back in time"), "{refused}");
        }
    }

    /// The recording after its last event, for monitors in the system of its run.
    fn read(mut recording: Recording) -> RecordedEvents {
        let start = recording.begin().unwrap();
        let topology = Arc::clone(&start.header().topology);
        let mut events = RecordedEvents::new(Path::new("run"), recording, start, &topology);
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
        let log = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../bt/logs/tests/captured/fetch.btlog");
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
