//! `steward localize` and `steward map` on the log of a simulated robot.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use flate2::Compression;
use flate2::write::GzEncoder;
use maps::{ImageFormat, Pose, pose};
use nav::{Atlas, LocalizationParameters};
use recording::ros::{self, Header, Transforms};
use robot::recorded::{LogWriter, Record, Recording};
use robot::{LaserSpec, Reading, RobotModel, Streams, VelocityCommand};
use ros_messages::RosMessage;
use sim::{LaserConfig, SimConfig};
use tempfile::{TempDir, tempdir};

use crate::steward::{refusal, steward};

#[path = "../scenarios/trials/benches/accuracy/drive.rs"]
mod drive;

use drive::{Drive, route};

/// A robot with a laser like those of most logs: 180 beams over 180°.
fn model() -> RobotModel {
    let laser = LaserSpec {
        name: "front".to_owned(),
        mount: pose(0.1, 0.0, 0.0),
        angle_min_rad: -std::f64::consts::FRAC_PI_2,
        angle_increment_rad: 1_f64.to_radians(),
        beams: 180,
        period: Duration::from_millis(500),
        range_min_m: 0.1,
        range_max_m: 30.0,
    };
    RobotModel { lasers: vec![laser], ..RobotModel::default() }
}

/// The log of a drive through the house, from its start to the kitchen.
pub(crate) fn log() -> String {
    let map = Arc::new(maps::house::map());
    let atlas = Atlas::new(Arc::clone(&map), &model(), LocalizationParameters::default()).unwrap();
    let places = maps::house::places();
    let ends = ["start", "Destination"].map(|name| places.get(name).unwrap().goal_position());
    let config = SimConfig { model: model(), lasers: LaserConfig { range_sigma_m: 0.01 }, ..SimConfig::default() };
    let mut drive = Drive::along(route(&atlas, &ends).unwrap(), &map, &config, &Streams::new(1)).unwrap();
    let mut log = LogWriter::new("simulated");
    log.param("robot_frontlaser_offset", 0.1);
    log.param("robot_front_laser_max", 30.0);
    let mut readings = Vec::new();
    let mut odometry = None;
    while let Some(truth) = drive.step(&mut readings) {
        for reading in readings.drain(..) {
            match reading {
                Reading::Odometry(latest) => odometry = Some(latest),
                Reading::Scan(scan) => {
                    let odometry = odometry.unwrap();
                    log.odometry(&odometry);
                    log.scan(&scan, &odometry.pose, &truth);
                }
                Reading::Battery(_) => {}
            }
        }
    }
    log.into_text()
}

/// A folder with the log and the map of the house.
struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Self(tempdir().unwrap());
        std::fs::write(folder.path("drive.log"), log()).unwrap();
        maps::save_map(&maps::house::map(), &folder.path("house.yaml"), ImageFormat::Pgm).unwrap();
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn arguments<'a>(&self, arguments: &[&'a str]) -> Vec<std::borrow::Cow<'a, str>> {
        // Names with an extension are files in the folder.
        let in_folder =
            |name: &'a str| match name.contains('.') && Path::new(name).extension().is_some() && !name.starts_with('0')
            {
                true => self.path(name).to_str().unwrap().to_owned().into(),
                false => name.into(),
            };
        arguments.iter().map(|name| in_folder(name)).collect()
    }

    /// Runs a command, which must succeed; returns its stdout and stderr.
    fn run(&self, arguments: &[&str]) -> (String, String) {
        let arguments = self.arguments(arguments);
        let arguments: Vec<&str> = arguments.iter().map(AsRef::as_ref).collect();
        let output = steward(&arguments);
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{said}");
        (String::from_utf8(output.stdout).unwrap(), said)
    }

    fn json(&self, arguments: &[&str]) -> serde_json::Value {
        serde_json::from_str(&self.run(arguments).0).unwrap()
    }

    /// The message of a command that is refused, on one line.
    fn refusal(&self, arguments: &[&str]) -> String {
        let arguments = self.arguments(arguments);
        let arguments: Vec<&str> = arguments.iter().map(AsRef::as_ref).collect();
        refusal(&arguments).split_whitespace().filter(|word| *word != "|").collect::<Vec<_>>().join(" ")
    }
}

/// A bag that is being written.
struct BagWriter<'w> {
    writer: mcap::Writer<std::io::Cursor<&'w mut Vec<u8>>>,
    channels: BTreeMap<&'static str, u16>,
}

impl BagWriter<'_> {
    fn write<T: RosMessage>(&mut self, topic: &'static str, time: Duration, message: &T) {
        let channel_id = *self.channels.entry(topic).or_insert_with(|| {
            let definition = T::definition().to_string();
            let schema = self.writer.add_schema(&T::name().full(), "ros2msg", definition.as_bytes()).unwrap();
            self.writer.add_channel(schema, topic, "cdr", &Default::default()).unwrap()
        });
        let log_time = time.as_nanos() as u64;
        let header = mcap::records::MessageHeader { channel_id, sequence: 0, log_time, publish_time: log_time };
        self.writer.write_to_known_channel(&header, &message.encode()).unwrap();
    }

    fn transform(&mut self, topic: &'static str, time: Duration, frame: &'static str, child: &'static str, at: &Pose) {
        self.write(topic, time, &Transforms { transforms: vec![ros::transform(time, frame, child, at)] });
    }
}

/// The same drive as a bag: with topics for odometry and truth, or only with transforms.
pub(crate) fn bag(log: &str, map: &maps::OccupancyGrid, transforms_alone: bool) -> Vec<u8> {
    let mut bytes = Vec::new();
    let writer = mcap::WriteOptions::new().compression(None).create(std::io::Cursor::new(&mut bytes)).unwrap();
    let mut bag = BagWriter { writer, channels: BTreeMap::new() };
    bag.transform("/tf_static", Duration::ZERO, "base_link", "laser", &pose(0.1, 0.0, 0.0));
    bag.write("/map", Duration::ZERO, &ros::occupancy_grid(map));
    let laser = model().lasers.remove(0);
    for Record { time, odometry, velocity, scan, corrected, .. } in Recording::read(log.as_bytes()).unwrap().records() {
        let time = *time;
        if transforms_alone {
            bag.transform("/tf", time, "odom", "base_link", odometry);
        } else {
            let VelocityCommand { linear_mps, angular_radps } = *velocity;
            let reading = robot::Odometry { time, pose: *odometry, linear_mps, angular_radps };
            bag.write("/odom", time, &ros::odometry(&reading));
        }
        let (Some(scan), Some(corrected)) = (scan, corrected) else { continue };
        if transforms_alone {
            bag.transform("/tf", time, "map", "odom", &(corrected * odometry.inverse()));
        } else {
            bag.write("/truth", time, &ros::pose_stamped(time, "map", corrected));
        }
        let header = Header::new(time, "laser");
        bag.write("/scan", time, &ros::LaserScan { header, ..ros::laser_scan(&laser, scan) });
    }
    bag.writer.finish().unwrap();
    drop(bag);
    bytes
}

#[test]
fn a_robot_is_localized_in_a_bag_as_in_a_log() {
    let folder = Folder::new();
    let topics = ["--pose-topic", "/truth"];
    let of_log = folder.json(&["localize", "--map", "house.yaml", "--log", "drive.log", "--json"]);
    for (name, transforms_alone, topics) in [("drive.mcap", false, &topics[..]), ("transforms.mcap", true, &[])] {
        std::fs::write(folder.path(name), bag(&log(), &maps::house::map(), transforms_alone)).unwrap();
        // The map, too, comes from the bag.
        let of_bag = folder.json(&[&["localize", "--log", name, "--json"], topics].concat());
        assert_eq!(of_bag["scans"], of_log["scans"], "{name}");
        for (key, most) in [("median_m", 0.005), ("rmse_m", 0.005), ("driven_m", 0.01)] {
            let [of_bag, of_log] = [&of_bag, &of_log].map(|result| result[key].as_f64().unwrap());
            assert!((of_bag - of_log).abs() < most, "{name}: {key}: {of_bag} and {of_log}");
        }
    }
    let (said, _) = folder.run(&[&["map", "--log", "drive.mcap", "--out", "made.yaml"], &topics[..]].concat());
    assert!(said.contains("cells of 0.05 m from"), "{said}");
    let said = folder.refusal(&["localize", "--log", "drive.mcap"]);
    assert!(said.contains("does not have the robot's true poses") && said.contains("--pose-topic"), "{said}");
    let said = folder.refusal(&["localize", "--log", "drive.mcap", "--scan-topic", "/odom"]);
    assert!(said.contains("the messages of `/odom` are not sensor_msgs/msg/LaserScan"), "{said}");
}

#[test]
fn the_page_of_a_bag_shows_its_map_and_where_a_property_was_violated() {
    let folder = Folder::new();
    std::fs::write(folder.path("drive.mcap"), bag(&log(), &maps::house::map(), true)).unwrap();
    let mapping =
        "[[messages]]\ntopic = \"/scan\"\nfrom = \"Laser\"\nto = \"Robot\"\nfields = { range_m = \"range_max\" }\n";
    std::fs::write(folder.path("mapping.toml"), mapping).unwrap();
    std::fs::write(folder.path("far.scope"), "property far := always not (Laser, Robot, range_m > 20)\n").unwrap();
    let path = |name: &str| folder.path(name).display().to_string();
    let [bag, mapping, property] = ["drive.mcap", "mapping.toml", "far.scope"].map(path);
    let command = ["verify", &bag, "--map-channels", &mapping, "--property", &property, "--out", &path("out")];
    assert_eq!(steward(&command).status.code(), Some(1));
    let page = std::fs::read_to_string(folder.path("out/report.html")).unwrap();
    for words in ["Where the robot went", "by odometry alone", "<dt>where</dt>"] {
        assert!(page.contains(words), "{words}");
    }
}

const BAD_ODOMETRY: [&str; 4] = ["--odometry-drift", "5%", "--odometry-noise", "0.05"];

#[test]
fn a_recorded_robot_is_localized_with_bad_odometry() {
    let folder = Folder::new();
    let out = folder.path("out");
    let command = ["localize", "--map", "house.yaml", "--log", "drive.log", "--json", "--out", out.to_str().unwrap()];
    let result = folder.json(&[&command[..], &BAD_ODOMETRY].concat());
    let number = |key: &str| result[key].as_f64().unwrap();
    assert!(number("median_m") < 0.02 && number("rmse_m") < 0.03 && number("max_m") < 0.2, "{result}");
    assert!(number("median_rad") < 0.005 && number("rmse_rad") < 0.01, "{result}");
    assert!(result["lost"].as_array().unwrap().is_empty() && number("converged_at_s") < 1.0, "{result}");
    let csv = std::fs::read_to_string(out.join("trajectories.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + number("scans") as usize);
    assert!(std::fs::read(out.join("trajectories.png")).unwrap().starts_with(b"\x89PNG"));
}

#[test]
fn global_localization_finds_the_robot_and_is_reproducible_by_seed() {
    let folder = Folder::new();
    let command = ["localize", "--map", "house.yaml", "--log", "drive.log", "--json", "--global"];
    let result = folder.json(&[&command[..], &BAD_ODOMETRY].concat());
    assert!(result["converged_after_m"].as_f64().unwrap() < 15.0, "{result}");
    assert!(result["lost"].as_array().unwrap().is_empty(), "{result}");
    assert_eq!(folder.json(&[&command[..], &BAD_ODOMETRY].concat()), result);
    assert_ne!(folder.json(&[&command[..], &BAD_ODOMETRY, &["--seed", "2"]].concat())["rmse_m"], result["rmse_m"]);
    let starts = folder.json(&[&command[..], &["--starts", "3"]].concat());
    assert_eq!((starts["starts"].as_array().unwrap().len(), starts["found"].as_u64()), (3, Some(3)), "{starts}");
}

#[test]
fn a_map_made_of_a_log_is_accurate_enough_for_localization() {
    let folder = Folder::new();
    let (said, _) = folder.run(&["map", "--log", "drive.log", "--out", "made.yaml"]);
    assert!(said.contains("cells of 0.05 m from"), "{said}");
    let result =
        folder.json(&[&["localize", "--map", "made.yaml", "--log", "drive.log", "--json"], &BAD_ODOMETRY[..]].concat());
    // The map's cells measure 0.05 m.
    assert!(result["median_m"].as_f64().unwrap() < 0.05 && result["lost"].as_array().unwrap().is_empty(), "{result}");
}

#[test]
fn a_map_of_another_place_is_refused() {
    let folder = Folder::new();
    let mut hall = maps::OccupancyGrid::new(400, 400, 0.1, pose(-20.0, -20.0, 0.0));
    (0..160_000).for_each(|i| hall.set(maps::CellIndex { column: i % 400, row: i / 400 }, maps::Cell::Free));
    maps::save_map(&hall, &folder.path("hall.yaml"), ImageFormat::Pgm).unwrap();
    let said = folder.refusal(&["localize", "--map", "hall.yaml", "--log", "drive.log"]);
    assert!(said.contains("does not fit the log") && said.contains("100 % of which are on free floor, 0 %"), "{said}");
}

#[test]
fn damaged_logs_are_used_as_far_as_is_safe_and_reported_by_line() {
    let folder = Folder::new();
    let text = log();
    let whole = folder.json(&["localize", "--map", "house.yaml", "--log", "drive.log", "--json"]);
    let broken = text.replacen("FLASER 180", "FLASER 181", 1);
    std::fs::write(folder.path("broken.log"), &broken[..broken.len() - 40]).unwrap();
    let (said, notes) = folder.run(&["localize", "--map", "house.yaml", "--log", "broken.log", "--json"]);
    let scans = serde_json::from_str::<serde_json::Value>(&said).unwrap()["scans"].as_u64().unwrap();
    assert_eq!(scans + 2, whole["scans"].as_u64().unwrap(), "all but the broken ones");
    assert!(notes.contains("line 4: this FLASER should have 192 fields, but has 191"), "{notes}");
    assert!(notes.contains("the log is truncated within this line"), "{notes}");
    let mut packed = GzEncoder::new(Vec::new(), Compression::fast());
    packed.write_all(text.as_bytes()).unwrap();
    let packed = packed.finish().unwrap();
    std::fs::write(folder.path("half.log.gz"), &packed[..packed.len() / 2]).unwrap();
    let (_, notes) = folder.run(&["localize", "--map", "house.yaml", "--log", "half.log.gz"]);
    assert!(notes.contains("the compressed file is truncated here"), "{notes}");
    let mut damaged = packed;
    let last = damaged.len() - 6;
    damaged[last] ^= 1;
    std::fs::write(folder.path("damaged.log.gz"), damaged).unwrap();
    assert!(folder.refusal(&["localize", "--map", "house.yaml", "--log", "damaged.log.gz"]).contains("is damaged"));
    assert!(folder.refusal(&["map", "--log", "house.yaml"]).contains("not a CARMEN log"));
    assert!(folder.refusal(&["map", "--log", "missing.log"]).contains("cannot read the log"));
}
