//! Recorded robots: logs and bags, with their problems.

use std::path::Path;

use bags::Bag;
use campaigns::Error;
use clap::Args;
use maps::OccupancyGrid;
use replay::bag::{RecordedBag, Topics, read};
use robot::recorded::{Recording, RecordingError};

use crate::output::note;

/// The topics of a bag to use.
#[derive(Debug, Args)]
pub(crate) struct TopicArgs {
    /// For a bag with several topics of sensor_msgs/msg/LaserScan: the scans
    #[arg(long, value_name = "TOPIC")]
    scan_topic: Option<String>,
    /// For a bag with several topics of nav_msgs/msg/Odometry: the odometry; that of /tf if there is none
    #[arg(long, value_name = "TOPIC")]
    odometry_topic: Option<String>,
    /// For a bag: the correct poses, PoseStamped, PoseWithCovarianceStamped or Odometry [default: those of /tf]
    #[arg(long, value_name = "TOPIC")]
    pose_topic: Option<String>,
}

/// A recorded robot, and the map if it comes with one.
pub(crate) struct Log {
    pub(crate) recording: Recording,
    pub(crate) map: Option<OccupancyGrid>,
}

/// Reads a log or a bag, and prints its problems on stderr.
pub(crate) fn open_log(path: &Path, topics: &TopicArgs) -> Result<Log, Error> {
    if bags::is_bag(path) {
        return open_bag(path, topics);
    }
    let help = "a log is a text file in CARMEN's format, plain or gzipped, with ODOM and FLASER lines, or a ROS 2 bag";
    let name = path.display();
    let bytes = diagnostics::from_disk_or_pipe(path)
        .map_err(|error| Error::refused(format!("cannot read the log {name}: {error}"), help))?;
    let recording = Recording::read(&bytes).map_err(|error| {
        let complaints = match &error {
            RecordingError::NoScans { complaints } | RecordingError::Unusable { complaints, .. } => {
                complaints.as_slice()
            }
            _ => &[],
        };
        complaints.iter().for_each(|complaint| note(&format!("{name}: {complaint}")));
        Error::refused(format!("{name}: {error}"), help)
    })?;
    recording.complaints().iter().for_each(|complaint| note(&format!("{name}: {complaint}")));
    Ok(Log { recording, map: None })
}

fn open_bag(path: &Path, topics: &TopicArgs) -> Result<Log, Error> {
    let bag = Bag::open(path).map_err(|error| Error::refused(error.to_string(), error.help()))?;
    let TopicArgs { scan_topic: scan, odometry_topic: odometry, pose_topic: pose } = topics;
    let topics = Topics { scan: scan.clone(), odometry: odometry.clone(), pose: pose.clone() };
    let RecordedBag { recording, map, notes } = read(&bag, &topics).map_err(|error| {
        let help = format!(
            "`steward verify --list {}` shows the topics; `--scan-topic`, `--odometry-topic` and \
                            `--pose-topic` name them",
            path.display()
        );
        Error::refused(format!("{}: {error}", path.display()), help)
    })?;
    notes.iter().for_each(|text| note(text));
    if recording.corrected_scans().next().is_none() {
        let message = format!("{} does not have the robot's true poses", path.display());
        let help = "name a topic with poses on the map (`--pose-topic`), or record /tf with the frame `map`";
        return Err(Error::refused(message, help));
    }
    Ok(Log { recording, map })
}
