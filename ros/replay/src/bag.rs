//! ROS 2 bags as recorded robots: scans, odometry, poses from SLAM or localization, and a map.
//!
//! A record has the newest odometry at its time. The corrected pose is that odometry in the `map` frame, by the newest
//! correction: a transform from `map` to the odometry's frame, or a published pose.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use bags::{Bag, Definitions, Topic};
use maps::{Cell, OccupancyGrid, Pose, seen_from_above};
use robot::recorded::{Record, Recording};
use robot::{LaserScan, LaserSpec, RobotModel, VelocityCommand};
use ros_messages::{Decoder, Structure, Want};

/// The topics to read. If none is named, it is the only one of its type.
#[derive(Clone, Debug, Default)]
pub struct Topics {
    /// Scans, `sensor_msgs/msg/LaserScan`.
    pub scan: Option<String>,
    /// Odometry, `nav_msgs/msg/Odometry`. Without such a topic, odometry comes from `/tf`.
    pub odometry: Option<String>,
    /// Corrected poses: `PoseStamped`, `PoseWithCovarianceStamped` or `Odometry`. Without such a topic, they come from
    /// `/tf`.
    pub pose: Option<String>,
}

/// Why a bag is not a recorded robot.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{0}")]
pub struct NoRobot(pub String);

/// The data about a robot in a bag.
#[derive(Debug)]
pub struct RecordedBag {
    /// The robot.
    pub recording: Recording,
    /// The last published map, `nav_msgs/msg/OccupancyGrid`.
    pub map: Option<OccupancyGrid>,
    /// Missing or omitted data, in words.
    pub notes: Vec<String>,
}

const SCAN: &str = "sensor_msgs/msg/LaserScan";
pub(crate) const ODOMETRY: &str = "nav_msgs/msg/Odometry";
pub(crate) const TRANSFORMS: &str = "tf2_msgs/msg/TFMessage";
pub(crate) const MAP: &str = "nav_msgs/msg/OccupancyGrid";
const POSES: [&str; 3] = ["geometry_msgs/msg/PoseWithCovarianceStamped", "geometry_msgs/msg/PoseStamped", ODOMETRY];

/// The maximum number of frames. A robot has fewer, but every detected object may have a frame.
const MOST_FRAMES: usize = 1000;

/// The frames of a robot's body.
const BASES: [&str; 2] = ["base_footprint", "base_link"];

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TopicRole {
    Scan,
    Odometry,
    Pose,
    Transforms,
    Map,
}

/// Reads the data about a robot in a bag.
///
/// # Errors
/// [`NoRobot`] if the bag has no scans with odometry, or if `topics` does not select one of several topics.
pub fn read(bag: &Bag, topics: &Topics) -> Result<RecordedBag, NoRobot> {
    let mut reader = BagReader::default();
    let lost = visit_messages(bag, roles(&bag.survey().topics, topics)?, |role, log_ns, message| {
        let taken = message.and_then(|message| reader.take(role, message));
        let is_record = matches!(role, TopicRole::Odometry | TopicRole::Scan);
        if taken.and_then(|()| if is_record { reader.record(log_ns) } else { Some(()) }).is_none() {
            reader.left_out += 1;
        }
    })?;
    let mut notes = [bag.survey().lost.as_slice(), &lost].concat();
    if reader.left_out > 0 {
        notes.push(format!("{} messages are left out: they are damaged or come before the odometry", reader.left_out));
    }
    let Some(laser) = reader.laser.take() else {
        return Err(NoRobot("it has no scan with odometry: neither a topic nor /tf has the pose of the robot".into()));
    };
    let laser = LaserSpec { period: period(&reader.records), ..laser };
    let model = RobotModel { lasers: vec![laser], ..RobotModel::default() };
    Ok(RecordedBag { recording: Recording::of(model, reader.records), map: reader.map, notes })
}

/// Visits all messages on these topics, in order: the role of the topic, when the message was recorded, and the message
/// unless it cannot be decoded. Returns what was lost, in words.
pub(crate) fn visit_messages(
    bag: &Bag,
    roles: Vec<(TopicRole, usize)>,
    mut visit: impl FnMut(TopicRole, i64, Option<Structure<'_>>),
) -> Result<Vec<String>, NoRobot> {
    let all = &bag.survey().topics;
    // Only definitions in the bag and built-in ones: all these types are common.
    let nothing = |_: &std::path::Path| Err(std::io::ErrorKind::NotFound.into());
    let definitions = Definitions { survey: bag.survey(), folders: &[], read: &nothing };
    let mut decoders = BTreeMap::new();
    for (role, topic) in roles {
        let layout = definitions.layout(&all[topic]);
        let layout = layout.map_err(|undefined| NoRobot(undefined.to_string()))?;
        decoders.insert(topic, (role, Decoder::new(&layout, &Want::All), layout));
    }
    let wanted: Vec<usize> = decoders.keys().copied().collect();
    let (mut messages, mut body) = (bag.messages(&wanted), Vec::new());
    while let Some(head) = messages.next_into(&mut body) {
        let (role, decoder, layout) = &decoders[&head.topic];
        let decoded = decoder.decode(&body);
        visit(*role, head.log_ns, decoded.as_ref().ok().and_then(|value| Structure::of(layout, value)));
    }
    Ok(messages.lost().to_vec())
}

/// The roles of the topics to read.
fn roles(all: &[Topic], topics: &Topics) -> Result<Vec<(TopicRole, usize)>, NoRobot> {
    let mut roles = Vec::new();
    let mut add = |role, found: Vec<usize>| roles.extend(found.into_iter().map(|topic| (role, topic)));
    let scans = match &topics.scan {
        Some(name) => named(all, name, &[SCAN])?,
        None => at_most_one(all, of_kind(all, &[SCAN]))?,
    };
    add(TopicRole::Scan, scans);
    // There may be several topics of these types: `/tf` and `/tf_static`, and maps, of which the last one counts.
    add(TopicRole::Transforms, of_kind(all, &[TRANSFORMS]));
    add(TopicRole::Map, of_kind(all, &[MAP]));
    if let Some(name) = &topics.pose {
        add(TopicRole::Pose, named(all, name, &POSES)?);
    }
    // Poses of type `Odometry` are corrections, not the odometry that they correct.
    let mut odometries = of_kind(all, &[ODOMETRY]);
    odometries.retain(|topic| topics.pose.as_ref() != Some(&all[*topic].name));
    let odometries = match &topics.odometry {
        Some(name) => match odometries.into_iter().find(|topic| all[*topic].name == *name) {
            Some(topic) => vec![topic],
            None => return Err(NoRobot(format!("it has no odometry `{name}`"))),
        },
        None => at_most_one(all, odometries)?,
    };
    add(TopicRole::Odometry, odometries);
    Ok(roles)
}

pub(crate) fn of_kind(all: &[Topic], kinds: &[&str]) -> Vec<usize> {
    (0..all.len()).filter(|topic| kinds.contains(&all[*topic].kind.as_str())).collect()
}

/// The topics with a name. In a bag, a name may have several types.
fn named(all: &[Topic], name: &str, kinds: &[&str]) -> Result<Vec<usize>, NoRobot> {
    let found: Vec<usize> = (0..all.len()).filter(|topic| all[*topic].name == name).collect();
    if found.is_empty() {
        return Err(NoRobot(format!("it has no topic `{name}`")));
    }
    if !found.iter().all(|topic| kinds.contains(&all[*topic].kind.as_str())) {
        return Err(NoRobot(format!("the messages of `{name}` are not {}", kinds.join(" or "))));
    }
    Ok(found)
}

fn at_most_one(all: &[Topic], found: Vec<usize>) -> Result<Vec<usize>, NoRobot> {
    let [first, _, ..] = found.as_slice() else { return Ok(found) };
    let names: Vec<&str> = found.iter().map(|topic| all[*topic].name.as_str()).collect();
    Err(NoRobot(format!("it has several topics of {}: {}; name one", all[*first].kind, names.join(", "))))
}

/// The data read so far.
#[derive(Default)]
pub(crate) struct BagReader {
    /// Each frame's parent frame, and its pose in the parent.
    frames: BTreeMap<String, (String, Pose)>,
    /// The frames of odometry and of the robot.
    names: Option<(String, String)>,
    odometry: Option<(Pose, VelocityCommand)>,
    /// The odometry's frame in the map, from published poses.
    correction: Option<Pose>,
    pub(crate) laser: Option<LaserSpec>,
    /// The scan read last, until it is part of a record.
    pub(crate) ranges_m: Option<Vec<f32>>,
    pub(crate) map: Option<OccupancyGrid>,
    start_ns: Option<i64>,
    last: Duration,
    records: Vec<Record>,
    left_out: usize,
}

impl BagReader {
    /// Takes a message; none if it cannot be used.
    pub(crate) fn take(&mut self, role: TopicRole, message: Structure<'_>) -> Option<()> {
        match role {
            TopicRole::Transforms => {
                for transform in message.parts("transforms") {
                    let parent = frame(transform.part("header")?.text("frame_id")?);
                    let child = frame(transform.text("child_frame_id")?);
                    let to = transform.part("transform")?;
                    let pose = plane(to.part("translation")?, to.part("rotation")?)?;
                    if self.frames.len() < MOST_FRAMES || self.frames.contains_key(&child) {
                        self.frames.insert(child, (parent, pose));
                    }
                }
            }
            TopicRole::Map => self.map = Some(grid(message)?),
            TopicRole::Odometry => self.take_odometry(message)?,
            TopicRole::Pose => {
                let at = message.part("pose.pose").or_else(|| message.part("pose"))?;
                let (odometry, _) = self.odometry()?;
                self.correction = Some(pose_in(at)? * odometry.inverse());
            }
            TopicRole::Scan => {
                self.odometry()?;
                self.ranges_m = Some(self.scan(message)?);
            }
        }
        Some(())
    }

    fn take_odometry(&mut self, message: Structure<'_>) -> Option<()> {
        self.names = Some((frame(message.part("header")?.text("frame_id")?), frame(message.text("child_frame_id")?)));
        let twist = message.part("twist.twist")?;
        let (linear, angular) = (twist.part("linear")?.number("x")?, twist.part("angular")?.number("z")?);
        let velocity = VelocityCommand { linear_mps: linear, angular_radps: angular };
        self.odometry = Some((pose_in(message.part("pose.pose")?)?, velocity));
        Some(())
    }

    fn record(&mut self, log_ns: i64) -> Option<()> {
        let since = log_ns.saturating_sub(*self.start_ns.get_or_insert(log_ns)).max(0);
        let time = Duration::from_nanos(since.unsigned_abs()).max(self.last);
        self.last = time;
        let (odometry, velocity) = self.odometry()?;
        let scan = self.ranges_m.take().map(|ranges_m| Arc::new(LaserScan { time, laser: 0, ranges_m }));
        let corrected = self.corrected().filter(|_| scan.is_some());
        let line = self.records.len() + 1;
        self.records.push(Record { line, time, odometry, velocity, scan, corrected });
        Some(())
    }

    /// The newest odometry in the `map` frame, by the newest correction.
    pub(crate) fn corrected(&mut self) -> Option<Pose> {
        let (odometry, _) = self.odometry()?;
        let correction = self.correction.or_else(|| self.pose_of(&self.names.as_ref()?.0, "map"))?;
        Some(correction * odometry)
    }

    /// The newest pose of the robot in the `map` frame, by the transforms or by odometry with the newest correction.
    pub(crate) fn pose(&mut self) -> Option<Pose> {
        let by_transforms = BASES.iter().find_map(|base| self.pose_of(base, "map"));
        by_transforms.or_else(|| self.corrected())
    }

    /// The newest odometry in its own frame.
    pub(crate) fn odometry_pose(&mut self) -> Option<Pose> {
        self.odometry().map(|(pose, _)| pose)
    }

    /// The newest odometry, from its topic or from the transforms.
    fn odometry(&mut self) -> Option<(Pose, VelocityCommand)> {
        if self.odometry.is_some() {
            return self.odometry;
        }
        let base = BASES.into_iter().find(|base| self.pose_of(base, "odom").is_some())?;
        self.names = Some(("odom".to_owned(), base.to_owned()));
        Some((self.pose_of(base, "odom")?, VelocityCommand { linear_mps: 0.0, angular_radps: 0.0 }))
    }

    /// The pose of a frame in a frame above it.
    pub(crate) fn pose_of(&self, child: &str, above: &str) -> Option<Pose> {
        let (mut at, mut found) = (child, Pose::identity());
        for _ in 0..self.frames.len() {
            let (parent, in_parent) = self.frames.get(at)?;
            (at, found) = (parent, in_parent * found);
            if at == above {
                return Some(found);
            }
        }
        None
    }

    /// The ranges of a scan; the first scan determines the laser's properties.
    fn scan(&mut self, message: Structure<'_>) -> Option<Vec<f32>> {
        let ranges = message.numbers("ranges")?;
        let number = |name: &str| message.number(name);
        let (range_min_m, range_max_m) = (number("range_min")?, number("range_max")?);
        let (first, step) = (number("angle_min")?, number("angle_increment")?);
        // Beams must be in counterclockwise order; a laser that is mounted upside down has them in the opposite order.
        let (is_reversed, last) = (step < 0.0, first + step * ranges.len().saturating_sub(1) as f64);
        if self.laser.is_none() {
            let frame = frame(message.part("header")?.text("frame_id")?);
            let base = &self.names.as_ref()?.1;
            let mount = if frame == *base { Some(Pose::identity()) } else { self.pose_of(&frame, base) };
            // The laser may be attached to `base_link` while odometry moves another frame.
            let mount = mount.or_else(|| self.pose_of(&frame, "base_link"))?;
            self.laser = Some(LaserSpec {
                name: "front".to_owned(),
                mount,
                angle_min_rad: if is_reversed { last } else { first },
                angle_increment_rad: step.abs(),
                beams: ranges.len(),
                period: Duration::ZERO,
                range_min_m,
                range_max_m,
            });
        }
        let laser = self.laser.as_ref().filter(|laser| laser.beams == ranges.len())?;
        let clipped = |range_m: f64| match range_m {
            range_m if range_m >= laser.range_max_m => f32::INFINITY,
            range_m if range_m < laser.range_min_m => f32::NEG_INFINITY,
            range_m => range_m as f32,
        };
        let ranges = ranges.into_iter().map(clipped);
        Some(if is_reversed { ranges.rev().collect() } else { ranges.collect() })
    }
}

/// A frame's name. In ROS 1, names could begin with a slash.
pub(crate) fn frame(name: &str) -> String {
    name.trim_start_matches('/').to_owned()
}

pub(crate) fn pose_in(message: Structure<'_>) -> Option<Pose> {
    plane(message.part("position")?, message.part("orientation")?)
}

/// A position with a quaternion, projected onto the plane.
fn plane(position: Structure<'_>, rotation: Structure<'_>) -> Option<Pose> {
    let [x, y, z, w] = ["x", "y", "z", "w"].map(|name| rotation.number(name));
    let found = seen_from_above([position.number("x")?, position.number("y")?], [x?, y?, z?, w?]);
    let numbers = [found.translation.x, found.translation.y, found.rotation.re];
    numbers.iter().all(|number| number.is_finite()).then_some(found)
}

fn grid(message: Structure<'_>) -> Option<OccupancyGrid> {
    let info = message.part("info")?;
    let (width, height) = (info.number("width")? as usize, info.number("height")? as usize);
    let (side, origin) = (info.number("resolution")?, pose_in(info.part("origin")?)?);
    let cells: Vec<Cell> = message.numbers("data")?.into_iter().map(cell).collect();
    let is_sound =
        side > 0.0 && side.is_finite() && width.checked_mul(height) == Some(cells.len()) && !cells.is_empty();
    is_sound.then(|| OccupancyGrid::from_cells(width, height, side, origin, cells))
}

/// A cell for an occupancy in percent, with the thresholds of `map_server`.
fn cell(occupied_pct: f64) -> Cell {
    match occupied_pct {
        65.0..=100.0 => Cell::Occupied,
        0.0..=25.0 => Cell::Free,
        _ => Cell::Unknown,
    }
}

/// The mean time between scans.
fn period(records: &[Record]) -> Duration {
    let mut scans = records.iter().filter(|record| record.scan.is_some()).map(|record| record.time);
    let first = scans.next().unwrap_or_default();
    let (last, count) = scans.fold((first, 0_u32), |(_, count), time| (time, count.saturating_add(1)));
    (last - first) / count.max(1)
}
