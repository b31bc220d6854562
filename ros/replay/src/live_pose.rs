//! The pose of a running robot on its own map, for a live page.

use std::collections::{BTreeMap, VecDeque};
use std::io::ErrorKind;
use std::path::Path;
use std::sync::Arc;

use bags::{Definitions, Head, RobotTopics, Survey};
use maps::{OccupancyGrid, Point, Pose};
use robot::LaserSpec;
use ros_messages::{Decoder, Layout, Structure, Want};

use crate::bag::{BagReader, TopicRole, frame, pose_in};

/// The current pose, scan and path of a running robot, from the last messages of its topics.
pub struct LivePose {
    topics: RobotTopics,
    /// For each topic of the survey, how it is read; none for other topics.
    read: Vec<Option<(Use, Decoder, Arc<Layout>)>>,
    reader: BagReader,
    /// The pose from localization, without odometry.
    localized: Option<Pose>,
    path: Vec<Point>,
    /// Why a topic could not be read, in words: the first reason for each topic.
    unread: BTreeMap<usize, String>,
    /// The samples that have not been returned yet.
    samples: VecDeque<PoseSample>,
    /// Whether a page has begun. It keeps the map of its beginning.
    has_begun: bool,
}

/// The pose of a robot at a time, with the data received since the sample before.
pub struct PoseSample {
    /// When the last message was received, in nanoseconds since 1970.
    pub log_ns: i64,
    /// The pose of the robot, in the frame of the map.
    pub pose: Pose,
    /// The ranges of a scan, in meters, one for each beam of the [laser](LivePose::laser).
    pub scan: Option<Vec<f32>>,
    /// The path that the robot follows, in the frame of the map.
    pub path: Vec<Point>,
}

/// The shortest time between samples, in nanoseconds, and the maximum number of samples that are kept.
const SAMPLE_PERIOD_NS: i64 = 100_000_000;
const MOST_SAMPLES: usize = 1000;

/// The purpose for which a topic is read.
#[derive(Clone, Copy)]
enum Use {
    Role(TopicRole),
    Path,
}

impl LivePose {
    /// No message has been received yet.
    #[must_use]
    pub fn new(topics: RobotTopics) -> Self {
        let (read, reader, path, unread) = (Vec::new(), BagReader::default(), Vec::new(), BTreeMap::new());
        let (samples, has_begun) = (VecDeque::new(), false);
        Self { topics, read, reader, localized: None, path, unread, samples, has_begun }
    }

    /// Takes a message if it is on one of the topics.
    pub fn take(&mut self, head: Head, body: &[u8], survey: &Survey) {
        while self.read.len() < survey.topics.len() {
            let reading = self.reading(self.read.len(), survey);
            self.read.push(reading);
        }
        let Some((what, decoder, layout)) = &self.read[head.topic] else { return };
        if self.has_begun && matches!(what, Use::Role(TopicRole::Map)) {
            return;
        }
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
        // A pose, a scan or a path that arrives before the transforms is not an error.
        if taken.is_none() && matches!(what, Use::Role(TopicRole::Map)) {
            let name = &survey.topics[head.topic].name;
            self.unread.entry(head.topic).or_insert_with(|| format!("{name} cannot be shown: it makes no sense"));
        }
        let is_due = self.samples.back().is_none_or(|last| head.log_ns.saturating_sub(last.log_ns) >= SAMPLE_PERIOD_NS);
        if let Some(pose) = self.pose().filter(|_| is_due) {
            let (scan, path) = (self.reader.ranges_m.take(), self.path.clone());
            if self.samples.len() == MOST_SAMPLES {
                self.samples.pop_front();
            }
            self.samples.push_back(PoseSample { log_ns: head.log_ns, pose, scan, path });
        }
    }

    /// The last sample until a time, in nanoseconds since 1970, with the last scan; none without new samples.
    pub fn sample(&mut self, until_ns: i64) -> Option<PoseSample> {
        let (mut last, mut scan) = (None, None);
        while let Some(sample) = self.samples.pop_front_if(|sample| sample.log_ns <= until_ns) {
            scan = sample.scan.clone().or(scan);
            last = Some(sample);
        }
        Some(PoseSample { scan, ..last? })
    }

    /// Begins a page with the current map, robot and laser.
    pub fn begin(&mut self) {
        self.has_begun = true;
    }

    /// How a topic is read; none if it is not.
    fn reading(&mut self, index: usize, survey: &Survey) -> Option<(Use, Decoder, Arc<Layout>)> {
        let topic = &survey.topics[index];
        let RobotTopics { map, pose, odometry, scan, path, transforms } = &self.topics;
        let is = |name: &Option<String>| name.as_ref() == Some(&topic.name);
        let what = match () {
            () if topic.name == *map => Use::Role(TopicRole::Map),
            () if is(pose) => Use::Role(TopicRole::Pose),
            () if is(odometry) => Use::Role(TopicRole::Odometry),
            () if is(scan) => Use::Role(TopicRole::Scan),
            () if is(path) => Use::Path,
            () if transforms.contains(&topic.name) => Use::Role(TopicRole::Transforms),
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

    /// The data at the beginning of a page that has not been received yet, in words.
    #[must_use]
    pub fn missing(&mut self) -> Option<&'static str> {
        if self.map().is_none() {
            Some("no map has come: the page does not show where the robot is")
        } else if self.pose().is_none() {
            Some("where the robot is on its map is not known: no message has its pose")
        } else if self.topics.scan.is_some() && self.laser().is_none() {
            Some("no scan has come of which it is known where the laser is: the page shows none")
        } else {
            None
        }
    }

    /// The pose of the robot, in the frame of the map.
    #[must_use]
    pub fn pose(&mut self) -> Option<Pose> {
        let by_localization = self.topics.pose.is_some().then(|| self.reader.corrected()).flatten();
        by_localization.or_else(|| self.reader.pose()).or(self.localized)
    }

    /// The laser of the robot; none before the first scan.
    #[must_use]
    pub fn laser(&self) -> Option<&LaserSpec> {
        self.reader.laser.as_ref()
    }

    /// Why topics cannot be shown, in words.
    pub fn unread(&self) -> impl Iterator<Item = &str> {
        self.unread.values().map(String::as_str)
    }
}

/// The positions of a path, in the frame of the map.
fn path(message: Structure<'_>, reader: &BagReader) -> Option<Vec<Point>> {
    let (own, poses) = (frame(message.part("header")?.text("frame_id")?), message.parts("poses"));
    let is_own = own == "map" || poses.is_empty();
    let onto_map = if is_own { Pose::identity() } else { reader.pose_of(&own, "map")? };
    let poses = poses.into_iter().map(|stamped| Some(onto_map * pose_in(stamped.part("pose")?)?));
    poses.map(|pose| Some(pose?.translation.vector.into())).collect()
}
