//! A run is a stream of records.
//!
//! Whatever produces a run writes them: the simulation. Whatever shows, judges or stores a run reads them and nothing
//! else: reports, pictures, animations, pages, the event log, the progress line. So a run that was recorded can be
//! shown again without being run again.
//!
//! # The records
//!
//! 1. A [`Header`]: the scenario and its settings, processes and channels, tree, monitors, faults, map, robot, and what
//!    the run must come to.
//! 2. A [`Step`] in which nothing has happened yet: the state in which the run begins.
//! 3. A [`Step`] for each step of the simulation: how the robot stands; [what has happened](Happening); and, if
//!    somebody wants to see the run, its [`Details`]: events, and what has changed in tree, skills, components and
//!    monitors. A [`Scene`] (scans, particles, path, other bodies) is only where a picture may be taken, which a
//!    [`SceneClock`] and the happenings say.
//! 4. An [`End`]: why it ended, the hash of the trace, what the monitors say. A run that was broken off has none.
//!
//! A [`RunView`] takes them one after the other and answers what readers ask.
//!
//! # Units and frames
//!
//! Times are since the start of the run, in whole nanoseconds. Lengths are in metres, angles in radians, charges in
//! percent; the name of a number says so. Positions and poses are in the `map` frame but for where a laser is mounted,
//! which is in `base_link`. Where a record names something by a number, that is its place in the header.
//!
//! # Files
//!
//! [`Writer`] writes the records of a run to a file and [`Recording`] reads them back, with all their bits. The format
//! is binary; its version ([`FORMAT`]) goes up with every change of a record, and other versions are not read. In
//! detail: a file begins with the eight bytes `STEWREC\n` and the version as four bytes, lowest first. Then come
//! chunks, each with its length in bytes (four bytes, lowest first) and so many bytes of a zlib stream. Unpacked, a
//! chunk holds whole [`Record`]s in the [postcard](https://postcard.jamesmunns.com/wire-format) encoding of the types
//! documented here: fields in their order, without names.
//!
//! ```
//! use std::time::Duration;
//! use recording::{ Record, Recording, Writer};
//! # use std::sync::Arc;
//! # use maps::{OccupancyGrid, pose};
//! # use recording::{End, Ended, Expected, Header, Origin, RobotState, Snapshots, Step};
//! # fn header() -> Header {
//! #     Header {
//! #         version: "0.1.0".to_owned(), scenario: "example".to_owned(), about: String::new(),
//! #         origin: Origin::default(), settings: vec![], seed: 1, tick: Duration::from_secs(1),
//! #         dt: Duration::from_millis(20), unwatched: false, topology: Arc::default(), tree: vec![], skills: vec![],
//! #         components: vec![], monitors: Arc::new([]), faults: vec![],
//! #         map: Arc::new(OccupancyGrid::new(1, 1, 0.05, pose(0.0, 0.0, 0.0))), places: vec![],
//! #         start: pose(0.0, 0.0, 0.0), station: None, destination: None, robot_radius_m: 0.3, lasers: vec![],
//! #         snapshots: Snapshots::default(), expected: Expected::default(),
//! #     }
//! # }
//! # fn step_at(time: Duration) -> Step {
//! #     let here = pose(0.0, 0.0, 0.0);
//! #     let robot = RobotState {
//! #         pose: here, estimate: here, charge_pct: 80.0, charging: false, distance_m: 0.0, collisions: 0,
//! #     };
//! #     Step { time, ticks: 0, overruns: 0, communications: 0, robot, happenings: vec![], details: None }
//! # }
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("run.rec");
//! # let ended = Ended::TimeLimit(Duration::from_millis(20));
//! # let end = End {
//! #     ended, trace_hash: String::new(), monitors: vec![], skill_errors: vec![], messages_hit: vec![], scene: None,
//! # };
//!
//! let mut writer = Writer::begin(std::fs::File::create(&path)?)?;
//! writer.write(&Record::Header(Box::new(header())))?;
//! writer.write(&Record::Step(step_at(Duration::ZERO)))?;
//! writer.write(&Record::Step(step_at(Duration::from_millis(20))))?;
//! writer.write(&Record::End(Box::new(end)))?;
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
//! Values of other crates are written as numbers. A pose is x, y, and cosine and sine of the heading. The map is its
//! columns, its rows, the side of a cell, the pose of its lower left corner, and a byte for each cell (0 free, 1
//! occupied, 2 unknown), row by row. The topology is its processes (name, place of the process that each is part of)
//! and its channels (places of sender and receiver, whether they shake hands, shapes of the messages). A laser is its
//! name, its pose, the angle of the first beam and that from one to the next, the number of beams, the time between
//! scans, and the shortest and longest range; a scan is its time, the place of its laser, and a range for each beam.
//!
//! The hash of a trace ([`TraceHash`]) and the event log ([`EventLogWriter`]), which tells less and is for other
//! programs, are here, too.

mod decimals;
mod end;
mod event_log;
mod file;
mod header;
mod monitor;
mod plain;
mod scene_clock;
mod step;
mod trace_hash;
mod view;

pub use decimals::decimals;
pub use end::{End, Ended, MonitorEnd, SkillError};
pub use event_log::{EventLogWriter, event_line, message_json};
pub use file::{FORMAT, Record, Recording, RecordingError, Writer};
pub use header::{
    Argument, Expected, Fault, Header, Monitor, Node, Origin, Place, SettingGroup, SnapshotOccasion, Snapshots, TREE,
};
pub use monitor::{Graph, Location, MonitorState, Transition};
pub use scene_clock::SceneClock;
pub use step::{Body, BodyShape, Decision, Detail, Details, Happening, Navigation, RobotState, Scene, Step};
pub use trace_hash::TraceHash;
pub use view::{FaultCourse, FaultRecord, GivenUp, Inconsistent, MonitorView, RunView, Tally, TreeError, UndoneFault};
