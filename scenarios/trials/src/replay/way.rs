//! The way of a robot in a bag, on the bag's own map.

use bags::{Bag, RobotTopics};
use maps::{OccupancyGrid, Pose};
use ros_messages::Structure;

use super::bag::{BagReader, MAP, ODOMETRY, TopicRole, decoders, of_kind, pose_in};

/// Localization publishes such poses, in the frame of the map.
const LOCALIZED: &str = "geometry_msgs/msg/PoseWithCovarianceStamped";
/// The way has a pose this often, in meters.
const STEP_M: f64 = 0.05;

/// The way of a robot.
#[derive(Debug)]
pub struct Way {
    /// The last published map.
    pub map: OccupancyGrid,
    /// Where the robot was, in the order of the bag; not empty.
    pub places: Vec<WayPlace>,
}

/// Where a robot was.
#[derive(Clone, Copy, Debug)]
pub struct WayPlace {
    /// When the bag received it, in nanoseconds since 1970.
    pub log_ns: i64,
    /// The message's own stamp, if it has one.
    pub stamp_ns: Option<i64>,
    /// By localization or SLAM, in the frame of the map.
    pub pose: Pose,
    /// By odometry alone, in its own frame, if that is known.
    pub odometry: Option<Pose>,
}

/// The way of a robot; none if the bag has no map, or no poses on it. `topics` says which are meant, if that is known.
#[must_use]
pub fn way(bag: &Bag, topics: Option<&RobotTopics>) -> Option<Way> {
    let all = &bag.survey().topics;
    let of = |role, kind, name: Option<&str>| -> Vec<(TopicRole, usize)> {
        let found = of_kind(all, &[kind]).into_iter();
        found.filter(|topic| name.is_none_or(|name| all[*topic].name == name)).map(|topic| (role, topic)).collect()
    };
    let maps = of(TopicRole::Map, MAP, topics.map(|topics| topics.map.as_str()));
    maps.first()?;
    // Of several robots, or several localizations, none is meant.
    let single = |role, kind, name| Some(of(role, kind, name)).filter(|found| found.len() < 2).unwrap_or_default();
    let is_meant =
        |topic: &(TopicRole, usize)| topics.is_none_or(|topics| topics.transforms.contains(&all[topic.1].name));
    let transforms = of(TopicRole::Transforms, super::bag::TRANSFORMS, None).into_iter().filter(is_meant);
    let odometry = topics.and_then(|topics| topics.odometry.as_deref());
    let pose = topics.and_then(|topics| topics.pose.as_deref());
    let roles = maps
        .into_iter()
        .chain(transforms)
        .chain(single(TopicRole::Odometry, ODOMETRY, odometry))
        .chain(single(TopicRole::Pose, LOCALIZED, pose));
    let decoders = decoders(bag, roles.collect()).ok()?;
    let wanted: Vec<usize> = decoders.keys().copied().collect();
    let (mut messages, mut body, mut reader) = (bag.messages(&wanted), Vec::new(), BagReader::default());
    let mut places: Vec<WayPlace> = Vec::new();
    while let Some(head) = messages.next_into(&mut body) {
        let (role, decoder, layout) = &decoders[&head.topic];
        let decoded = decoder.decode(&body);
        let Some(message) = decoded.as_ref().ok().and_then(|value| Structure::of(layout, value)) else { continue };
        let localized = (*role == TopicRole::Pose).then(|| pose_in(message.part("pose.pose")?)).flatten();
        let _ = reader.take(*role, message);
        if *role == TopicRole::Map {
            continue;
        }
        let (Some(pose), odometry) = (reader.pose().or(localized), reader.odometry_pose()) else {
            continue;
        };
        let is_new = |last: &WayPlace| (last.pose.translation.vector - pose.translation.vector).norm() >= STEP_M;
        if places.last().is_none_or(is_new) {
            places.push(WayPlace { log_ns: head.log_ns, stamp_ns: stamp_ns(message), pose, odometry });
        }
    }
    Some(Way { map: reader.map?, places }).filter(|way| !way.places.is_empty())
}

fn stamp_ns(message: Structure<'_>) -> Option<i64> {
    let stamp = message.part("header")?.part("stamp")?;
    // The bag's own definition of a stamp may hold any number.
    Some((stamp.number("sec")? as i64).saturating_mul(1_000_000_000).saturating_add(stamp.number("nanosec")? as i64))
}
