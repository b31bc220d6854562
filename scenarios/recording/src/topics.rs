//! A run for other tools: topics with ROS 2 types.
//!
//! `docs/src/reference/topics.md` lists them.

mod messages;
mod outlines;
pub(crate) mod output;

use std::collections::BTreeSet;
use std::io::{self, Write};
use std::time::Duration;

use channels::{ChannelId, EventKind, Topology, Verdict};
use maps::{Cell, OccupancyGrid, Point, Pose};
use robot::LaserSpec;
use ros_messages::{Byte, TypeName};

use self::messages::{MessageType, unique};
use self::outlines::Outline;
use self::output::{Output, Topic};
use crate::ros::{self, BASE, Header, KeyValue, MAP, Moment, PointCloud, PoseStamped, Transforms, laser_frame};
use crate::{Happening, Header as RunHeader, MonitorState, MonitorView, Navigation, Place, RunView, Scene};

/// The topics of a run, and what was last written on them.
pub(crate) struct Topics {
    /// None without a robot or a map.
    world: Option<World>,
    /// By the index of the channel in the topology; none for a channel inside a process.
    channels: Vec<Option<(u16, MessageType)>>,
    ticks: Topic<Moment>,
    tree: Topic<ros::Statuses>,
    processes: Topic<ros::Statuses>,
    monitors: Topic<ros::Statuses>,
    navigation: Topic<ros::Text>,
    log: Topic<ros::Log>,
    last: LastWritten,
}

/// What was last written, so that only changes are written.
#[derive(Default)]
struct LastWritten {
    outcomes: Option<Vec<Option<bt::Outcome>>>,
    locations: Option<Vec<Option<String>>>,
    monitors: Option<Vec<MonitorState>>,
    navigation: Option<Navigation>,
}

/// The topics of a robot on a map.
struct World {
    transforms: Topic<Transforms>,
    pose: Topic<PoseStamped>,
    battery: Topic<ros::BatteryState>,
    /// Scans and hits, by laser.
    lasers: Vec<(Topic<ros::LaserScan>, Topic<PointCloud>)>,
    particles: Topic<PointCloud>,
    path: (Topic<ros::Path>, Topic<PointCloud>),
    bodies: OutlineTopics,
}

/// Outlines as markers and as points.
struct OutlineTopics(Topic<ros::Markers>, Topic<PointCloud>);

impl OutlineTopics {
    fn new<W: Write>(name: &str, output: &mut Output<W>) -> io::Result<Self> {
        Ok(Self(output.latched(name)?, output.latched(&format!("{name}/points"))?))
    }

    fn write<W: Write>(
        &self,
        time: Duration,
        frame: &'static str,
        outlines: &[Outline],
        output: &mut Output<W>,
    ) -> io::Result<()> {
        output.write(&self.0, time, &outlines::markers(time, frame, outlines))?;
        output.write(&self.1, time, &outlines::points(time, frame, outlines))
    }
}

impl Topics {
    /// Creates the topics of a run, and writes what stays the same during it.
    pub(crate) fn begin<W: Write>(view: &RunView, output: &mut Output<W>) -> io::Result<Self> {
        let header = view.header();
        // Written once: these topics are latched, and their writers need not be kept.
        if let Some(premises) = &header.premises {
            write_map(&premises.map, output)?;
            let station = premises.station.map(|station| Outline::disc("station", &station, POINT_RADIUS_M));
            let places: Vec<Outline> = premises.places.iter().map(place).chain(station).collect();
            OutlineTopics::new("/places", output)?.write(Duration::ZERO, MAP, &places, output)?;
        }
        Ok(Self {
            world: header.robot.is_some().then(|| World::begin(header, output)).transpose()?,
            channels: channel_topics(view.topology(), output)?,
            ticks: output.topic("/ticks")?,
            tree: output.latched("/tree")?,
            processes: output.latched("/processes")?,
            monitors: output.latched("/monitors")?,
            navigation: output.latched("/navigation")?,
            log: output.latched("/rosout")?,
            last: LastWritten::default(),
        })
    }

    /// Writes what the last step of a run added, and if it `is_due`, also what moves all the time.
    pub(crate) fn follow<W: Write>(&mut self, view: &RunView, is_due: bool, output: &mut Output<W>) -> io::Result<()> {
        self.write_events(view, output)?;
        if view.has_new_states() {
            self.write_states(view, output)?;
        }
        if let Some(world) = &self.world {
            world.follow(view, is_due, output)?;
        }
        for (level, name, text) in view
            .happenings()
            .iter()
            .map(|happening| log_entry(happening, view))
            .chain(view.end().map(|end| (level::INFO, view.header().scenario.clone(), end.ended.to_string())))
        {
            let log = ros::Log { stamp: view.time().into(), level, name, msg: text, ..ros::Log::default() };
            output.write(&self.log, view.time(), &log)?;
        }
        Ok(())
    }

    fn write_events<W: Write>(&self, view: &RunView, output: &mut Output<W>) -> io::Result<()> {
        for event in view.events() {
            match &event.kind {
                EventKind::Tick => {
                    output.write(&self.ticks, event.time, &Moment { step: event.step, tick: event.tick })?;
                }
                EventKind::Received { channel, message } => {
                    if let Some((topic, of)) = &self.channels[channel.index()] {
                        output.write_with(*topic, event.time, |cdr| of.write(event, message, cdr))?;
                    }
                }
            }
        }
        Ok(())
    }

    fn write_states<W: Write>(&mut self, view: &RunView, output: &mut Output<W>) -> io::Result<()> {
        let (last, time) = (&mut self.last, view.time());
        let statuses = |status| ros::Statuses { header: Header::new(time, ""), status };
        for outcomes in view.outcomes_before_ticks().iter().map(Vec::as_slice).chain([view.outcomes()]) {
            if last.outcomes.as_deref() != Some(outcomes) {
                last.outcomes = Some(outcomes.to_vec());
                output.write(&self.tree, time, &statuses(nodes(view, outcomes)))?;
            }
        }
        if last.locations.as_deref() != Some(view.locations()) {
            last.locations = Some(view.locations().to_vec());
            output.write(&self.processes, time, &statuses(processes(view)))?;
        }
        // Compared by reference: the view is asked in every step with events, and most of them change nothing.
        let states = || view.monitors().map(|monitor| monitor.state);
        if !last.monitors.as_ref().is_some_and(|last| last.iter().eq(states())) {
            last.monitors = Some(states().cloned().collect());
            output.write(&self.monitors, time, &statuses(view.monitors().map(monitor).collect()))?;
        }
        if last.navigation.as_ref() != view.navigation() {
            last.navigation = view.navigation().cloned();
            let data = view.navigation().map(Navigation::words).unwrap_or_default();
            output.write(&self.navigation, time, &ros::Text { data })?;
        }
        Ok(())
    }
}

/// The nodes of the tree with their last outcomes. The numbers keep apart nodes of the same name.
fn nodes(view: &RunView, outcomes: &[Option<bt::Outcome>]) -> Vec<ros::Status> {
    let nodes = view.header().tree.iter().zip(outcomes).enumerate();
    let nodes = nodes.map(|(number, (node, outcome))| ros::Status {
        level: Byte(if outcome.is_some() { diagnostic::OK } else { diagnostic::STALE }),
        name: format!("{number} {}", node.process),
        message: outcome.map_or("", bt::Outcome::name).to_owned(),
        ..ros::Status::default()
    });
    nodes.collect()
}

/// The skills and components with their locations.
fn processes(view: &RunView) -> Vec<ros::Status> {
    let topology = view.topology();
    let located = topology.processes().zip(view.locations());
    let located = located.filter_map(|(process, location)| Some((topology.name(process), location.as_ref()?)));
    let located = located.map(|(name, location)| ros::Status {
        name: name.to_owned(),
        message: location.clone(),
        ..ros::Status::default()
    });
    located.collect()
}

impl World {
    fn begin<W: Write>(header: &RunHeader, output: &mut Output<W>) -> io::Result<Self> {
        let topic = output.latched("/tf_static")?;
        output.write(&topic, Duration::ZERO, &ros::laser_transforms(header.lasers()))?;
        let body = header.robot.iter().map(|robot| Outline::disc("robot", &Pose::identity(), robot.radius_m));
        OutlineTopics::new("/robot", output)?.write(Duration::ZERO, BASE, &body.collect::<Vec<_>>(), output)?;
        // Some viewers draw nothing but points, so scans are also written as what they hit.
        let mut lasers = Vec::new();
        for laser in header.lasers() {
            let frame = laser_frame(laser);
            lasers.push((output.topic(&format!("/{frame}/scan"))?, output.topic(&format!("/{frame}/points"))?));
        }
        Ok(Self {
            transforms: output.topic("/tf")?,
            pose: output.topic("/estimate")?,
            battery: output.topic("/battery_state")?,
            lasers,
            particles: output.topic("/particles")?,
            path: (output.topic("/path")?, output.topic("/path/points")?),
            bodies: OutlineTopics::new("/bodies", output)?,
        })
    }

    fn follow<W: Write>(&self, view: &RunView, is_due: bool, output: &mut Output<W>) -> io::Result<()> {
        let (robot, changes, time) = (view.robot(), view.robot_changes(), view.time());
        if let Some(pose) = robot.pose().filter(|_| is_due || changes.pose().is_some()) {
            let transforms = vec![ros::transform(time, MAP, BASE, &pose)];
            output.write(&self.transforms, time, &Transforms { transforms })?;
        }
        if let Some(pose) = robot.estimate.filter(|_| is_due || changes.estimate.is_some()) {
            output.write(&self.pose, time, &ros::pose_stamped(time, MAP, &pose))?;
        }
        if let Some(battery) = robot.battery.filter(|_| is_due || changes.battery.is_some()) {
            output.write(&self.battery, time, &ros::battery_state(time, battery.charge_pct, battery.charging))?;
        }
        match view.new_scene() {
            Some(scene) => self.write_scene(time, scene, view.header().lasers(), output),
            None => Ok(()),
        }
    }

    fn write_scene<W: Write>(
        &self,
        time: Duration,
        scene: &Scene,
        lasers: &[LaserSpec],
        output: &mut Output<W>,
    ) -> io::Result<()> {
        for scan in &scene.scans {
            let (laser, (ranges, hits)) = (&lasers[scan.laser], &self.lasers[scan.laser]);
            output.write(ranges, time, &ros::laser_scan(laser, scan))?;
            output.write(hits, time, &ros::point_cloud(scan.time, BASE, scan.hits(laser, &Pose::identity())))?;
        }
        output.write(&self.particles, time, &ros::point_cloud(time, MAP, scene.particles.iter().copied()))?;
        let pose = |point: &Point| ros::pose_stamped(time, MAP, &maps::pose(point.x, point.y, 0.0));
        let path = ros::Path { header: Header::new(time, MAP), poses: scene.path.iter().map(pose).collect() };
        output.write(&self.path.0, time, &path)?;
        output.write(&self.path.1, time, &ros::point_cloud(time, MAP, scene.path.iter().copied()))?;
        let bodies: Vec<Outline> = scene.bodies.iter().map(Outline::of_body).collect();
        self.bodies.write(time, MAP, &bodies, output)
    }
}

/// The radius at which a place without an area is drawn.
const POINT_RADIUS_M: f64 = 0.15;

fn place(place: &Place) -> Outline {
    match place.corners[..] {
        [point] => Outline::disc(&place.name, &maps::pose(point.x, point.y, 0.0), POINT_RADIUS_M),
        _ => Outline::new(&place.name, place.corners.clone()),
    }
}

/// The name with everything but letters and digits replaced by underscores.
fn token(name: &str) -> String {
    name.chars().map(|letter| if letter.is_ascii_alphanumeric() { letter } else { '_' }).collect()
}

/// The topics of the channels that are visible outside their process.
fn channel_topics<W: Write>(
    topology: &Topology,
    output: &mut Output<W>,
) -> io::Result<Vec<Option<(u16, MessageType)>>> {
    let (mut taken, mut types) = (BTreeSet::new(), BTreeSet::new());
    let mut topic = |channel: ChannelId| -> io::Result<_> {
        if topology.is_internal(channel) {
            return Ok(None);
        }
        let (from, to) = topology.ends(channel);
        let names = unique(&format!("{}/{}", token(from), token(to)), &mut taken);
        let of = MessageType::new(&topology.get(channel).domain);
        let type_name: String = names.replace('/', "To").split('_').map(capitalized).collect();
        let type_name = TypeName::new(Some("steward_msgs"), &unique(&type_name, &mut types));
        let id = output.channel(&format!("/channels/{names}"), &type_name, &of.definition())?;
        Ok(Some((id, of)))
    };
    topology.channels().map(&mut topic).collect()
}

fn capitalized(word: &str) -> String {
    let mut letters = word.chars();
    letters.next().map(|first| first.to_ascii_uppercase()).into_iter().chain(letters).collect()
}

/// Writes the map as a grid, as an image, and as points.
fn write_map<W: Write>(map: &OccupancyGrid, output: &mut Output<W>) -> io::Result<()> {
    let header = Header::new(Duration::ZERO, MAP);
    let topic = output.latched("/map")?;
    output.write(&topic, Duration::ZERO, &ros::occupancy_grid(map))?;
    let gray = |cell: &Cell| match cell {
        Cell::Free => 254,
        Cell::Occupied => 0,
        Cell::Unknown => 205,
    };
    // The first row of an image is the top one.
    let rows = map.cells().chunks(map.width().max(1)).rev();
    let mut data = Vec::with_capacity(3 * map.cells().len());
    rows.flatten().for_each(|cell| data.extend([gray(cell); 3]));
    // Viewers would interpret an image with one number per pixel as distances.
    let (width, height, encoding) = (map.width() as u32, map.height() as u32, "rgb8".to_owned());
    let image = ros::Image { header, height, width, encoding, is_bigendian: 0, step: 3 * width, data };
    let topic = output.latched("/map/image")?;
    output.write(&topic, Duration::ZERO, &image)?;
    let cells = map.cells().iter().enumerate().filter(|(_, cell)| **cell == Cell::Occupied);
    let centers =
        cells.map(|(place, _)| map.center(maps::CellIndex { column: place % map.width(), row: place / map.width() }));
    let topic = output.latched("/map/points")?;
    output.write(&topic, Duration::ZERO, &ros::point_cloud(Duration::ZERO, MAP, centers))
}

/// The values of a diagnostic status's `level`.
mod diagnostic {
    pub(super) const OK: u8 = 0;
    pub(super) const WARN: u8 = 1;
    pub(super) const ERROR: u8 = 2;
    pub(super) const STALE: u8 = 3;
}

/// The values of a log's `level`.
pub(crate) mod level {
    pub(crate) const INFO: u8 = 20;
    pub(crate) const WARN: u8 = 30;
    pub(crate) const ERROR: u8 = 40;
}

/// A property, its outcome if the run ends now, and the reason.
fn monitor(monitor: MonitorView<'_>) -> ros::Status {
    let outcome = monitor.outcome();
    let level = match outcome {
        monitors::Outcome::Satisfied => diagnostic::OK,
        monitors::Outcome::Inconclusive => diagnostic::WARN,
        monitors::Outcome::Violated => diagnostic::ERROR,
    };
    let verdict = match monitor.state.verdict {
        Verdict::True => "true",
        Verdict::False => "false",
        Verdict::Inconclusive => "inconclusive",
    };
    // The status has the outcome if the run ended now, which may still change; `verdict` is what is certain.
    let decided = monitor.decision.map(|decision| ("tick", decision.event.tick.to_string()));
    let witness = monitor.decision.and_then(|decision| decision.witness.as_ref());
    let values = [
        ("verdict", verdict.to_owned()),
        ("location", monitor.state.location.clone()),
        ("property", monitor.about.property.clone()),
    ];
    let values = values.into_iter().chain(decided).chain(witness.map(|witness| ("witness", witness.to_string())));
    ros::Status {
        level: Byte(level),
        name: monitor.name().to_owned(),
        message: outcome.name().to_owned(),
        hardware_id: String::new(),
        values: values.map(|(key, value)| KeyValue { key: key.to_owned(), value }).collect(),
    }
}

/// What happened: its severity, whom it concerns, and a description.
fn log_entry(happening: &Happening, view: &RunView) -> (u8, String, String) {
    let (level, name) = match happening {
        Happening::FaultAdded(_) | Happening::FaultEnded { .. } => (level::INFO, "fault"),
        Happening::FaultBegan { .. } | Happening::FaultLeftUndone { .. } => (level::WARN, "fault"),
        Happening::TreeError { node, .. } => (level::ERROR, view.header().tree[*node].process.as_str()),
        Happening::GivenUp { .. } => (level::WARN, "navigation"),
        Happening::Verdict { monitor, decision } => {
            let level = if decision.verdict == Verdict::False { level::ERROR } else { level::INFO };
            (level, view.monitor(*monitor).about.name.as_str())
        }
        Happening::Said { by, .. } => {
            let by = view.topology().processes().nth(*by).map(|process| view.topology().name(process));
            (level::INFO, by.unwrap_or_default())
        }
        Happening::Moved { .. } => (level::INFO, "environment"),
        Happening::Lost(_) => (level::WARN, "recording"),
        Happening::Resumed(_) => (level::INFO, "recording"),
        Happening::Arrival { .. } => (level::INFO, "robot"),
    };
    let mut words = happening.words(view);
    if let Happening::Verdict { decision, .. } = happening {
        if view.header().knows_ticks() {
            words += &format!(" at tick {}", decision.event.tick);
            words.extend(decision.witness.iter().map(|witness| format!("\n{witness}")));
        } else {
            words.extend(decision.witness.iter().map(|witness| format!("\n{witness:#}")));
        }
    }
    (level, name.to_owned(), words)
}
