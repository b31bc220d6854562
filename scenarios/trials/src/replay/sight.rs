//! Where a robot is while it runs, on its own map: what a page shows of it.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::Path;
use std::sync::Arc;

use bags::{Definitions, Head, RobotTopics, Survey};
use maps::{OccupancyGrid, Point, Pose};
use robot::LaserSpec;
use ros_messages::{Decoder, Layout, Structure, Want};

use super::bag::{BagReader, TopicRole, frame, pose_in};

/// What some topics have told last.
pub struct Sight {
    topics: RobotTopics,
    /// For each topic of the survey, how it is read, if it is.
    read: Vec<Option<(Use, Decoder, Arc<Layout>)>>,
    reader: BagReader,
    /// From localization, without odometry.
    localized: Option<Pose>,
    path: Vec<Point>,
    /// What could not be read, in words: the first of each topic.
    unread: BTreeMap<usize, String>,
}

/// What a topic is read for.
#[derive(Clone, Copy)]
enum Use {
    Role(TopicRole),
    Path,
}

impl Sight {
    /// Nothing has been told.
    #[must_use]
    pub fn new(topics: RobotTopics) -> Self {
        let (read, reader, path, unread) = (Vec::new(), BagReader::default(), Vec::new(), BTreeMap::new());
        Self { topics, read, reader, localized: None, path, unread }
    }

    /// Takes a message, if it is on one of the topics. Returns whether it was.
    pub fn take(&mut self, head: Head, body: &[u8], survey: &Survey) -> bool {
        while self.read.len() < survey.topics.len() {
            let made = self.reading(self.read.len(), survey);
            self.read.push(made);
        }
        let Some((what, decoder, layout)) = &self.read[head.topic] else { return false };
        let decoded = decoder.decode(body);
        let taken = match (what, decoded.as_ref().ok().and_then(|value| Structure::of(layout, value))) {
            (_, None) => None,
            (Use::Path, Some(message)) => path(message, &self.reader).map(|path| self.path = path),
            (Use::Role(role), Some(message)) => {
                if *role == TopicRole::Pose {
                    let pose = message.part("pose.pose").or_else(|| message.part("pose")).and_then(pose_in);
                    self.localized = pose.or(self.localized);
                }
                self.reader.take(*role, message)
            }
        };
        // A pose or a scan that comes before odometry is no fault.
        if taken.is_none() && matches!(what, Use::Role(TopicRole::Map) | Use::Path) {
            let name = &survey.topics[head.topic].name;
            self.unread.entry(head.topic).or_insert_with(|| format!("{name} cannot be shown: it makes no sense"));
        }
        true
    }

    /// How a topic is read, if it is.
    fn reading(&mut self, index: usize, survey: &Survey) -> Option<(Use, Decoder, Arc<Layout>)> {
        let topic = &survey.topics[index];
        let RobotTopics { map, pose, odometry, scan, path } = &self.topics;
        let is = |name: &Option<String>| name.as_ref() == Some(&topic.name);
        let what = match () {
            () if topic.name == *map => Use::Role(TopicRole::Map),
            () if is(pose) => Use::Role(TopicRole::Pose),
            () if is(odometry) => Use::Role(TopicRole::Odometry),
            () if is(scan) => Use::Role(TopicRole::Scan),
            () if is(path) => Use::Path,
            () if RobotTopics::TRANSFORMS.contains(&topic.name.as_str()) => Use::Role(TopicRole::Transforms),
            () => return None,
        };
        let nothing = |_: &Path| Err(ErrorKind::NotFound.into());
        match (Definitions { survey, folders: &[], read: &nothing }).layout(topic) {
            Ok(layout) => Some((what, Decoder::new(&layout, &Want::All), layout)),
            Err(undefined) => {
                self.unread.insert(index, format!("{} cannot be shown: {undefined}", topic.name));
                None
            }
        }
    }

    /// The map, if there is one.
    #[must_use]
    pub fn map(&self) -> Option<&OccupancyGrid> {
        self.reader.map.as_ref()
    }

    /// Whether all has been told that a picture begins with: the map, the robot on it, and its laser.
    #[must_use]
    pub fn is_complete(&mut self) -> bool {
        self.map().is_some() && self.pose().is_some() && (self.topics.scan.is_none() || self.laser().is_some())
    }

    /// The robot, in the frame of the map.
    #[must_use]
    pub fn pose(&mut self) -> Option<Pose> {
        self.reader.pose().or(self.localized)
    }

    /// Its laser, once there was a scan.
    #[must_use]
    pub fn laser(&self) -> Option<&LaserSpec> {
        self.reader.laser.as_ref()
    }

    /// The ranges of the last scan that has not been returned, in meters.
    pub fn next_scan(&mut self) -> Option<Vec<f32>> {
        self.reader.ranges_m.take()
    }

    /// The path that it follows, in the frame of the map.
    #[must_use]
    pub fn path(&self) -> &[Point] {
        &self.path
    }

    /// What cannot be shown, in words.
    pub fn unread(&self) -> impl Iterator<Item = &str> {
        self.unread.values().map(String::as_str)
    }
}

/// The positions of a path, in the frame of the map.
fn path(message: Structure<'_>, reader: &BagReader) -> Option<Vec<Point>> {
    let own = frame(message.part("header")?.text("frame_id")?);
    let onto_map = if own == "map" { Pose::identity() } else { reader.pose_of(&own, "map")? };
    let poses = message.parts("poses").into_iter().map(|stamped| Some(onto_map * pose_in(stamped.part("pose")?)?));
    poses.map(|pose| Some(pose?.translation.vector.into())).collect()
}
