//! A short run in records: a robot drives through a hall to the kitchen, and its battery is read on the way.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use channels::{Capacity, Domain, Event, EventKind, FieldKind, Message, Shape, Topology, Value, Verdict};
use maps::{OccupancyGrid, Point, pose};
use recording::{
    Archive, Battery, Body, Decision, Details, End, Ended, Fault, Follower, Happening, Header, Monitor, MonitorEnd,
    MonitorState, Navigation, NavigationStatus, Node, Place, Premises, RobotBody, RobotState, RunView, Scene, Step,
    TREE, Truth,
};
use robot::{LaserScan, LaserSpec};

/// The duration of a step.
pub(crate) const DT: Duration = Duration::from_millis(20);

/// A reader that reports the battery's level to a skill, which answers the tree.
pub(crate) fn topology() -> Arc<Topology> {
    let mut topology = Topology::default();
    let [reader, skill, tree] = ["BatteryReader", "BatteryLevel", TREE].map(|name| topology.process(name).unwrap());
    let level = Shape::new([("status", FieldKind::symbols(["ok"])), ("level", FieldKind::Real)]);
    topology.channel(reader, skill, Capacity::One, Domain::new([level])).unwrap();
    let answer = Shape::new([("answer", FieldKind::symbols(["success", "failure"]))]);
    topology.channel(skill, tree, Capacity::One, Domain::new([answer])).unwrap();
    Arc::new(topology)
}

/// The reader's message with this level, in percent.
pub(crate) fn level(time: Duration, level_pct: f64) -> Event {
    let channel = topology().channels().next().unwrap();
    let message = Message::new([Value::symbol("ok"), level_pct.into()]);
    Event { step: 1, tick: time.as_secs(), time, kind: EventKind::Received { channel, message } }
}

pub(crate) fn tick(time: Duration) -> Event {
    Event { step: 0, tick: time.as_secs(), time, kind: EventKind::Tick }
}

pub(crate) fn header() -> Header {
    let place = |name: &str, corners: &[[f64; 2]]| Place {
        name: name.to_owned(),
        corners: corners.iter().map(|corner| Point::from(*corner)).collect(),
        tolerance_m: 0.3,
        keep_out: false,
        speed_mps: None,
    };
    let node = |parent, process: &str, is_leaf| Node { parent, process: process.to_owned(), symbol: None, is_leaf };
    let laser = LaserSpec {
        name: "front".to_owned(),
        mount: pose(0.1, 0.0, 0.0),
        angle_min_rad: -1.0,
        angle_increment_rad: 1.0,
        beams: 3,
        period: Duration::from_millis(100),
        range_min_m: 0.1,
        range_max_m: 8.0,
    };
    let monitor = Monitor {
        name: "phi1".to_owned(),
        property: "always …".to_owned(),
        summary: "the level stays high".to_owned(),
        formula: None,
        graph: None,
    };
    Header {
        scenario: "drive".to_owned(),
        seed: 7,
        tick: Duration::from_secs(1),
        dt: DT,
        topology: topology(),
        tree: vec![node(None, "root", false), node(Some(0), "BatteryLevel", true)],
        skills: vec!["BatteryLevel".to_owned()],
        components: vec!["BatteryReader".to_owned()],
        monitors: Arc::new([monitor]),
        faults: vec![Arc::new(fault("the wheels slip"))],
        premises: Some(Premises {
            map: Arc::new(OccupancyGrid::new(20, 10, 0.5, pose(-1.0, -2.0, 0.0))),
            places: vec![
                place("start", &[[0.0, 0.0]]),
                place("hall", &[[1.0, -1.0], [2.0, -1.0], [2.0, 1.0], [1.0, 1.0]]),
                place("kitchen", &[[3.0, 0.0]]),
            ],
            start: pose(0.0, 0.0, 0.0),
            station: None,
            destination: Some("kitchen".to_owned()),
        }),
        robot: Some(RobotBody { radius_m: 0.3, lasers: vec![laser] }),
        ..Header::default()
    }
}

pub(crate) fn fault(words: &str) -> Fault {
    Fault { kind: "slip".to_owned(), momentary: false, words: words.to_owned(), arguments: Vec::new() }
}

/// The robot at this place on its way, with an error of localization of half a meter.
pub(crate) fn robot(x_m: f64, charge_pct: f64) -> RobotState {
    RobotState {
        truth: Some(Truth { pose: pose(x_m, 0.0, 0.0), distance_m: x_m, collisions: 0 }),
        estimate: Some(pose(x_m + 0.3, 0.4, 0.0)),
        battery: Some(Battery { charge_pct, charging: false }),
    }
}

/// The run: half a meter per second, a percent per second.
pub(crate) fn steps() -> Vec<Step> {
    (0..=300).map(step).collect()
}

fn step(number: u32) -> Step {
    let time = number * DT;
    let (x_m, charge_pct) = (time.as_secs_f64() / 2.0, 80.0 - time.as_secs_f64());
    let mut happenings = Vec::new();
    let mut details = Details::default();
    if number == 1 {
        happenings.push(Happening::Arrival { place: 0 });
    }
    if number == 0 {
        details.monitors = vec![(0, MonitorState { location: "idle".to_owned(), ..MonitorState::default() })];
    }
    if number % 50 == 10 {
        details.events = vec![tick(time), level(time, charge_pct)];
        details.outcomes = vec![(1, Some(bt::Outcome::Answered(bt::Status::Running)))];
        details.scene = Some(Arc::new(scene(time)));
        let reason = Some(format!("since step {number}"));
        details.navigation = Some(Navigation { status: NavigationStatus::Moving, reason, recovery: None });
    }
    if number == 100 {
        let position = Some(Point::new(x_m, 0.0));
        happenings.push(Happening::FaultBegan { fault: 0, time, tick: Some(1), position });
    }
    if number == 200 {
        let decision = Decision { verdict: Verdict::False, event: level(time, charge_pct), witness: None };
        happenings.extend([Happening::FaultEnded { fault: 0, time }, Happening::Verdict { monitor: 0, decision }]);
    }
    if number == 300 {
        happenings.push(Happening::Arrival { place: 2 });
    }
    let ticks = u64::from(number / 50);
    let details = Some(Box::new(details));
    Step { time, ticks, overruns: 0, communications: ticks, robot: robot(x_m, charge_pct), happenings, details }
}

fn scene(time: Duration) -> Scene {
    let scan = LaserScan { time, laser: 0, ranges_m: vec![1.0, f32::INFINITY, 2.5] };
    let person =
        Body { name: "person".to_owned(), shape: maps::Shape::Disc { radius_m: 0.2 }, pose: pose(1.0, 1.0, 0.5) };
    Scene {
        scans: vec![Arc::new(scan)],
        particles: vec![Point::new(0.25, -0.5)],
        path: vec![Point::new(0.0, 0.0), Point::new(3.0, 0.0)],
        bodies: vec![person],
        speeches: vec!["excuse me".to_owned()],
    }
}

pub(crate) fn end() -> End {
    End {
        ended: Ended::TimeLimit(300 * DT),
        trace_hash: "abc".to_owned(),
        monitors: vec![MonitorEnd::default()],
        skill_errors: Vec::new(),
        messages_hit: vec![None],
        scene: None,
    }
}

/// The run at its start.
pub(crate) fn start() -> RunView {
    RunView::new(header(), steps().swap_remove(0)).unwrap()
}

/// The run up to this step.
pub(crate) fn until(number: usize) -> RunView {
    let mut view = start();
    steps().drain(1..=number).for_each(|step| view.apply(step).unwrap());
    view
}

/// Writes the run to a file.
pub(crate) fn record(path: &Path) {
    let mut view = start();
    let mut archive = Archive::begin(path, &view).unwrap();
    let last = steps().len() - 1;
    for (number, step) in steps().into_iter().enumerate().skip(1) {
        view.apply(step).unwrap();
        if number == last {
            view.finish(end()).unwrap();
        }
        archive.follow(&view).unwrap();
    }
    archive.finish().unwrap();
}
