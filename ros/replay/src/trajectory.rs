//! The trajectory of a robot in a bag, on the map of the bag.

use bags::{Bag, RobotTopics};
use maps::{OccupancyGrid, Pose};
use ros_messages::Structure;

use crate::bag::{BagReader, MAP, ODOMETRY, TRANSFORMS, TopicRole, of_kind, pose_in, visit_messages};

/// The type of poses that localization publishes, in the frame of the map.
const LOCALIZED: &str = "geometry_msgs/msg/PoseWithCovarianceStamped";
/// The distance between points of a trajectory, in meters.
const STEP_M: f64 = 0.05;

/// The trajectory of a robot.
#[derive(Debug)]
pub struct Trajectory {
    /// The last published map.
    pub map: OccupancyGrid,
    /// The points, in the order of the bag. There is at least one.
    pub points: Vec<TrajectoryPoint>,
}

/// A point of a trajectory.
#[derive(Clone, Copy, Debug)]
pub struct TrajectoryPoint {
    /// When its message was recorded, in nanoseconds since 1970.
    pub log_ns: i64,
    /// The message's own stamp, if it has one.
    pub stamp_ns: Option<i64>,
    /// The pose from localization or SLAM, in the frame of the map.
    pub pose: Pose,
    /// The pose from odometry alone, in its own frame, if it is known.
    pub odometry: Option<Pose>,
}

/// The trajectory of a robot; none if the bag has no map, or no poses on the map. `topics` are the topics to read, if
/// they are known.
#[must_use]
pub fn trajectory(bag: &Bag, topics: Option<&RobotTopics>) -> Option<Trajectory> {
    let all = &bag.survey().topics;
    let of = |role, kind, name: Option<&str>| -> Vec<(TopicRole, usize)> {
        let found = of_kind(all, &[kind]).into_iter();
        found.filter(|topic| name.is_none_or(|name| all[*topic].name == name)).map(|topic| (role, topic)).collect()
    };
    let maps = of(TopicRole::Map, MAP, topics.map(|topics| topics.map.as_str()));
    maps.first()?;
    // With several robots, or several localizations, the right topic is unknown, so none is read.
    let single = |role, kind, name| Some(of(role, kind, name)).filter(|found| found.len() < 2).unwrap_or_default();
    let is_wanted =
        |topic: &(TopicRole, usize)| topics.is_none_or(|topics| topics.transforms.contains(&all[topic.1].name));
    let transforms = of(TopicRole::Transforms, TRANSFORMS, None).into_iter().filter(is_wanted);
    let odometry = topics.and_then(|topics| topics.odometry.as_deref());
    let pose = topics.and_then(|topics| topics.pose.as_deref());
    let roles = maps
        .into_iter()
        .chain(transforms)
        .chain(single(TopicRole::Odometry, ODOMETRY, odometry))
        .chain(single(TopicRole::Pose, LOCALIZED, pose));
    let (mut reader, mut points) = (BagReader::default(), Vec::<TrajectoryPoint>::new());
    let visited = visit_messages(bag, roles.collect(), |role, log_ns, message| {
        let Some(message) = message else { return };
        let localized = (role == TopicRole::Pose).then(|| pose_in(message.part("pose.pose")?)).flatten();
        let _ = reader.take(role, message);
        if role == TopicRole::Map {
            return;
        }
        let (Some(pose), odometry) = (reader.pose().or(localized), reader.odometry_pose()) else { return };
        let is_new = |last: &TrajectoryPoint| (last.pose.translation.vector - pose.translation.vector).norm() >= STEP_M;
        if points.last().is_none_or(is_new) {
            points.push(TrajectoryPoint { log_ns, stamp_ns: stamp_ns(message), pose, odometry });
        }
    });
    visited.ok()?;
    Some(Trajectory { map: reader.map?, points }).filter(|trajectory| !trajectory.points.is_empty())
}

fn stamp_ns(message: Structure<'_>) -> Option<i64> {
    let stamp = message.part("header")?.part("stamp")?;
    // By the bag's own definition, a stamp may contain any number.
    Some((stamp.number("sec")? as i64).saturating_mul(1_000_000_000).saturating_add(stamp.number("nanosec")? as i64))
}
