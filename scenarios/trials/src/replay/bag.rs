//! ROS 2 bags as recorded robots: scans, odometry, poses from SLAM or localization, and a map.
//!
//! A record has the newest odometry at its time. The corrected pose is that odometry in the `map` frame, by the newest
//! correction: a transform from `map` to the odometry's frame, or a published pose.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use bags::{Bag, Definitions};
use maps::{Cell, OccupancyGrid, Pose, pose};
use robot::recorded::{Record, Recording};
use robot::{LaserScan, LaserSpec, RobotModel, VelocityCommand};
use ros_messages::{Decoder, Layout, Structure, Want};

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
const ODOMETRY: &str = "nav_msgs/msg/Odometry";
const TRANSFORMS: &str = "tf2_msgs/msg/TFMessage";
const MAP: &str = "nav_msgs/msg/OccupancyGrid";
const POSES: [&str; 3] = ["geometry_msgs/msg/PoseWithCovarianceStamped", "geometry_msgs/msg/PoseStamped", ODOMETRY];

/// The role of a topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    Scan,
    Odometry,
    Pose,
    Transforms,
    Map,
}

/// Reads the data about a robot in a bag.
///
/// # Errors
/// [`NoRobot`] if it has no scans with odometry, or does not say which of several topics is meant.
pub fn read(bag: &Bag, topics: &Topics) -> Result<RecordedBag, NoRobot> {
    let parts = parts(bag, topics)?;
    let folders: [PathBuf; 0] = [];
    let nothing = |_: &std::path::Path| Err(std::io::ErrorKind::NotFound.into());
    let definitions = Definitions { topics: &bag.survey().topics, folders: &folders, read: &nothing };
    let mut layouts: BTreeMap<usize, (Part, Decoder, Arc<Layout>)> = BTreeMap::new();
    for (part, topic) in parts {
        let layout = definitions.layout(&bag.survey().topics[topic]);
        let layout = layout.map_err(|undefined| NoRobot(undefined.to_string()))?;
        layouts.insert(topic, (part, Decoder::new(&layout, &Want::All), layout));
    }
    let wanted: Vec<usize> = layouts.keys().copied().collect();
    let (mut messages, mut body, mut reader) = (bag.messages(&wanted), Vec::new(), Reader::default());
    while let Some(head) = messages.next_into(&mut body) {
        let (part, decoder, layout) = &layouts[&head.topic];
        let decoded = decoder.decode(&body);
        let message = decoded.as_ref().ok().and_then(|value| Structure::of(layout, value));
        if message.and_then(|message| reader.take(*part, head.log_ns, message)).is_none() {
            reader.left_out += 1;
        }
    }
    let mut notes = [bag.survey().lost.as_slice(), messages.lost()].concat();
    if reader.left_out > 0 {
        notes.push(format!("{} messages are left out: they are damaged or come before the odometry", reader.left_out));
    }
    let Some(laser) = reader.laser.take() else {
        return Err(NoRobot("it has no scan with odometry: neither a topic nor /tf says where the robot was".into()));
    };
    let laser = LaserSpec { period: period(&reader.records), ..laser };
    let model = RobotModel { lasers: vec![laser], ..RobotModel::default() };
    Ok(RecordedBag { recording: Recording::of(model, reader.records), map: reader.map, notes })
}

/// The topics of a bag to read, by their indices.
fn parts(bag: &Bag, topics: &Topics) -> Result<Vec<(Part, usize)>, NoRobot> {
    let all = &bag.survey().topics;
    let mut parts = Vec::new();
    let mut find = |part: Part, named: Option<&String>, kinds: &[&str], choose: bool| {
        let of_kind = |index: &usize| kinds.contains(&all[*index].kind.as_str());
        let found: Vec<usize> = match named {
            Some(name) => (0..all.len()).filter(|index| all[*index].name == *name).collect(),
            None => (0..all.len()).filter(of_kind).collect(),
        };
        let names: Vec<&str> = found.iter().map(|index| all[*index].name.as_str()).collect();
        match (named, found.as_slice()) {
            (Some(name), []) => Err(NoRobot(format!("it has no topic `{name}`"))),
            (Some(name), found) if !found.iter().all(of_kind) => {
                Err(NoRobot(format!("the messages of `{name}` are not {}", kinds.join(" or "))))
            }
            (None, [_, _, ..]) if choose => {
                Err(NoRobot(format!("it has several topics of {}: {}; name one", kinds[0], names.join(", "))))
            }
            (_, found) => {
                parts.extend(found.iter().map(|topic| (part, *topic)));
                Ok(())
            }
        }
    };
    find(Part::Scan, topics.scan.as_ref(), &[SCAN], true)?;
    find(Part::Transforms, None, &[TRANSFORMS], false)?;
    find(Part::Map, None, &[MAP], false)?;
    if topics.pose.is_some() {
        find(Part::Pose, topics.pose.as_ref(), &POSES, true)?;
    }
    let is_pose = |index: usize| topics.pose.as_ref() == Some(&all[index].name);
    let odometries: Vec<usize> =
        (0..all.len()).filter(|index| all[*index].kind == ODOMETRY && !is_pose(*index)).collect();
    match (&topics.odometry, odometries.as_slice()) {
        (None, [one]) => parts.push((Part::Odometry, *one)),
        (named, _) => {
            let mut find = |named: Option<&String>| match named {
                Some(name) => {
                    let index = odometries.iter().find(|index| all[**index].name == *name);
                    index
                        .map(|index| parts.push((Part::Odometry, *index)))
                        .ok_or_else(|| NoRobot(format!("it has no odometry `{name}`")))
                }
                None if odometries.is_empty() => Ok(()),
                None => Err(NoRobot(format!("it has several topics of {ODOMETRY}; name one"))),
            };
            find(named.as_ref())?;
        }
    }
    Ok(parts)
}

/// The data read so far.
#[derive(Default)]
struct Reader {
    /// Each frame's parent frame, and its pose in the parent.
    frames: BTreeMap<String, (String, Pose)>,
    /// The frames of odometry and of the robot.
    names: Option<(String, String)>,
    odometry: Option<(Pose, VelocityCommand)>,
    /// The odometry's frame in the map, from published poses.
    correction: Option<Pose>,
    laser: Option<LaserSpec>,
    map: Option<OccupancyGrid>,
    start_ns: Option<i64>,
    last: Duration,
    records: Vec<Record>,
    left_out: usize,
}

impl Reader {
    /// Takes a message; none if it cannot be used.
    fn take(&mut self, part: Part, log_ns: i64, message: Structure<'_>) -> Option<()> {
        match part {
            Part::Transforms => {
                for transform in message.parts("transforms") {
                    let parent = frame(transform.part("header")?.text("frame_id")?);
                    let child = frame(transform.text("child_frame_id")?);
                    let to = transform.part("transform")?;
                    self.frames.insert(child, (parent, plane(to.part("translation")?, to.part("rotation")?)?));
                }
            }
            Part::Map => self.map = Some(grid(message)?),
            Part::Odometry => {
                self.names =
                    Some((frame(message.part("header")?.text("frame_id")?), frame(message.text("child_frame_id")?)));
                let twist = message.part("twist.twist")?;
                let (linear, angular) = (twist.part("linear")?.number("x")?, twist.part("angular")?.number("z")?);
                let velocity = VelocityCommand { linear_mps: linear, angular_radps: angular };
                self.odometry = Some((pose_in(message.part("pose.pose")?)?, velocity));
                self.record(log_ns, None)?;
            }
            Part::Pose => {
                let at = message.part("pose.pose").or_else(|| message.part("pose"))?;
                let (odometry, _) = self.odometry()?;
                self.correction = Some(pose_in(at)? * odometry.inverse());
            }
            Part::Scan => {
                self.odometry()?;
                let scan = self.scan(message)?;
                self.record(log_ns, Some(scan))?;
            }
        }
        Some(())
    }

    fn record(&mut self, log_ns: i64, ranges_m: Option<Vec<f32>>) -> Option<()> {
        let since = log_ns.saturating_sub(*self.start_ns.get_or_insert(log_ns)).max(0);
        let time = Duration::from_nanos(since.unsigned_abs()).max(self.last);
        self.last = time;
        let (odometry, velocity) = self.odometry()?;
        let correction = self.correction.or_else(|| self.pose_of(&self.names.as_ref()?.0, "map"));
        let scan = ranges_m.map(|ranges_m| Arc::new(LaserScan { time, laser: 0, ranges_m }));
        let corrected = correction.filter(|_| scan.is_some()).map(|correction| correction * odometry);
        let line = self.records.len() + 1;
        self.records.push(Record { line, time, odometry, velocity, scan, corrected });
        Some(())
    }

    /// The newest odometry, from its topic or from the transforms.
    fn odometry(&mut self) -> Option<(Pose, VelocityCommand)> {
        if self.odometry.is_some() {
            return self.odometry;
        }
        let base = ["base_footprint", "base_link"].into_iter().find(|base| self.pose_of(base, "odom").is_some())?;
        self.names = Some(("odom".to_owned(), base.to_owned()));
        Some((self.pose_of(base, "odom")?, VelocityCommand { linear_mps: 0.0, angular_radps: 0.0 }))
    }

    /// The pose of a frame in a frame above it.
    fn pose_of(&self, child: &str, above: &str) -> Option<Pose> {
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
        let heard = |range_m: f64| match range_m {
            range_m if range_m >= laser.range_max_m => f32::INFINITY,
            range_m if range_m < laser.range_min_m => f32::NEG_INFINITY,
            range_m => range_m as f32,
        };
        let ranges = ranges.into_iter().map(heard);
        Some(if is_reversed { ranges.rev().collect() } else { ranges.collect() })
    }
}

/// A frame's name. In ROS 1, names could begin with a slash.
fn frame(name: &str) -> String {
    name.trim_start_matches('/').to_owned()
}

fn pose_in(message: Structure<'_>) -> Option<Pose> {
    plane(message.part("position")?, message.part("orientation")?)
}

/// A position with a quaternion, seen from above.
fn plane(position: Structure<'_>, rotation: Structure<'_>) -> Option<Pose> {
    let [x, y, z, w] = ["x", "y", "z", "w"].map(|name| rotation.number(name));
    let (x, y, z, w) = (x?, y?, z?, w?);
    let heading = libm::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z));
    let found = pose(position.number("x")?, position.number("y")?, heading);
    let numbers = [found.translation.x, found.translation.y, heading];
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
