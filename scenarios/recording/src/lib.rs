//! A run is a stream of records.
//!
//! The simulation writes the records. Everything that shows, judges or stores a run reads them and nothing else:
//! reports, pictures, animations, pages, the event log, the progress line. A recorded run can therefore be shown again
//! without running it again.
//!
//! # The records
//!
//! 1. A [`Header`]: the scenario and its settings, processes and channels, tree, monitors, faults, map, robot, and the
//!    expected results.
//! 2. A [`Step`] in which nothing has happened yet: the initial state.
//! 3. A [`Step`] for each step of the run: what has changed of the robot; [what has happened](Happening); and, if the
//!    run is to be shown, its [`Details`]: events, and what has changed in tree, skills, components and monitors. A
//!    [`Scene`] (scans, particles, path, other bodies) is present only where a picture may be taken, as decided by a
//!    [`SceneClock`] and the happenings.
//! 4. An [`End`]: why the run ended, the hash of the trace, the final verdicts. An interrupted run has none.
//!
//! A [`RunView`] takes the records one after the other and answers the questions of readers. A [`Follower`] sees the
//! view after each of them: every file, page and picture of a run is made by one.
//!
//! # Units and frames
//!
//! Times are in whole nanoseconds since the start of the run. Lengths are in meters, angles in radians, charges in
//! percent; the suffix of a name gives the unit. Positions and poses are in the `map` frame, except the mounting pose
//! of a laser, which is in `base_link`. Where a record refers to something by a number, the number is its index in the
//! header.
//!
//! # Files
//!
//! [`Writer`] writes the records of a run to a file and [`Recording`] reads them back, bit for bit. The format is
//! binary. Its version ([`FORMAT`]) goes up with every change of a record, and other versions are not read. In detail:
//! a file begins with the eight bytes `STEWREC\n` and the version in four bytes, little-endian. Then come chunks, each
//! with its length in bytes (four bytes, little-endian) and that many bytes: an
//! [LZ4 frame](https://github.com/lz4/lz4/blob/dev/doc/lz4_Frame_format.md) with a checksum of its content. The content
//! of a chunk is whole [`Record`]s in the [postcard](https://postcard.jamesmunns.com/wire-format) encoding of the types
//! documented here: fields in order, without names.
//!
//! A recording in [MCAP](https://mcap.dev) has the records as messages of type `steward_msgs/msg/Records` on the topic
//! `/steward/records`, not compressed, each with the version of the format and a checksum of the records (CRC-32). All
//! its other topics are for other programs. [`Recording`] reads both formats, and an [`Archive`] writes the one
//! of the file's name. It also reads the logs of BehaviorTree.CPP, which contain much less: see [`tree_logs`].
//!
//! ```
//! use std::time::Duration;
//! use recording::{Follower, Recording, RunView, Writer};
//! # use recording::{End, Ended, Header, Step};
//! # let header = Header { scenario: "example".to_owned(), dt: Duration::from_millis(20), ..Header::default() };
//! # let step_at = |time: Duration| Step { time, ..Step::default() };
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("run.rec");
//! # let ended = Ended::TimeLimit(Duration::from_millis(20));
//! # let end = End {
//! #     ended, trace_hash: String::new(), monitors: vec![], skill_errors: vec![], messages_hit: vec![], scene: None,
//! # };
//!
//! let mut view = RunView::new(header, step_at(Duration::ZERO))?;
//! let mut writer = Writer::begin(std::fs::File::create(&path)?, &view)?;
//! view.apply(step_at(Duration::from_millis(20)))?;
//! view.finish(end)?;
//! writer.follow(&view)?;
//! writer.finish()?;
//!
//! let mut recording = Recording::open(&path)?;
//! let mut view = recording.begin()?;
//! while view.end().is_none() {
//!     recording.advance(&mut view)?;
//!     assert_eq!(view.time(), Duration::from_millis(20));
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Values of types from other crates are written as numbers. A pose is x, y, and cosine and sine of the heading. The
//! map is its columns, its rows, the side of a cell, the pose of its lower left corner, and one byte per cell (0 free,
//! 1 occupied, 2 unknown), row by row. The topology is its processes (name, index of the parent process) and its
//! channels (indices of sender and receiver, whether they are synchronous, shapes of the messages). A laser is its
//! name, its pose, the angle of the first beam and the angle between beams, the number of beams, the time between
//! scans, and the shortest and longest range; a scan is its time, the index of its laser, and one range per beam.
//!
//! A [`Judge`] makes the records of events that were recorded elsewhere, such as those of a real robot.
//!
//! This crate also has the hash of a trace ([`TraceHash`]) and the event log ([`EventLogWriter`]), which contains less
//! and is meant for other programs.
//!
//! # Inside
//! `archive` writes a run in the format that a file's name implies. `mcap_file` is the format for other tools: the same
//! chunks of records on a topic, and `topics`, made from the `RunView` alone, in ROS 2 types (`topics/ros`); the crate
//! `mcap` writes the file.

mod archive;
mod carried;
mod chunk;
mod decimals;
mod doubts;
mod end;
mod event_log;
mod evidence;
mod fault_course;
mod file;
mod follower;
mod grounds;
mod header;
mod heard;
mod inconsistent;
mod judge;
mod mcap_file;
mod monitor;
mod monitor_log;
mod navigation;
mod plain;
mod provenance;
mod record;
mod record_store;
mod recording;
pub mod ros;
mod run_comparison;
mod scene_clock;
mod source;
mod step;
mod tally;
mod topics;
mod trace_hash;
mod tree_failure;
mod tree_log;
mod tree_log_writer;
mod tree_run;
mod view;
mod violations_file;
pub mod words;

pub use archive::Archive;
pub use carried::Carried;
pub use decimals::{decimals, length};
pub use doubts::Doubts;
pub use end::{End, Ended, MonitorEnd, SkillError};
pub use event_log::{EventLogWriter, event_line, message_json};
pub use evidence::{Certainty, Evidence, ShownVerdict};
pub use fault_course::{FaultCourse, FaultRecord, UndoneFault};
pub use file::Writer;
pub use follower::Follower;
pub use grounds::Grounds;
pub use header::{
    Argument, Expected, Fault, Header, Machine, MachineState, Monitor, Node, Origin, Place, Premises, RobotBody,
    SettingGroup, SnapshotOccasion, Snapshots, TREE,
};
pub use heard::{HeardLevels, LEVEL};
pub use inconsistent::{Inconsistent, fitting};
pub use judge::Judge;
pub use monitor::{Graph, Location, MonitorState, Transition};
pub use monitor_log::MonitorLog;
pub use navigation::{Navigation, NavigationStatus};
pub use provenance::{InputFile, Provenance, commit, set_commit};
pub use record::{FORMAT, Record, RecordRef};
pub use record_store::RecordStore;
pub use recording::{Recording, RecordingError};
pub use run_comparison::{Agreement, Difference, RunComparison};
pub use scene_clock::SceneClock;
pub use source::{Next, RecordSource, conduct};
pub use step::{Battery, Body, Decision, Detail, Details, EntryValue, Happening, RobotState, Scene, Step, Truth};
pub use tally::{BatteryTally, LocalizationError, Tally};
pub use trace_hash::TraceHash;
pub use tree_failure::{TreeFailure, Unmet};
pub use tree_log_writer::logged_transitions;
pub use tree_logs::{BagTree, LogError};
pub use tree_run::TreeRun;
pub use view::{GivenUp, MonitorView, Moved, RunView, Said, TreeError};
pub use violations_file::{are_violations, write_violations};
