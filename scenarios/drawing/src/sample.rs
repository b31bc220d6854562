//! Sample frames, for viewing and for tests.

use std::sync::Arc;
use std::time::Duration;

use maps::{Cell, CellIndex, OccupancyGrid, Point, Pose, Shape, pose};

use super::frame::{
    BatteryHistory, Body, Diagram, Frame, Location, Mark, Monitor, NodeStatus, Place, Scene, Station, Threshold,
    Transition, TreeNode, Verdict,
};
use super::map_picture::MapPicture;

/// A frame of a run on a furnished floor: on the way to the charging station, after a fault.
pub(super) fn frame() -> Frame {
    Frame {
        scenario: "battery_fault".into(),
        seed: Some(7),
        caption: "The level was set to 10 % on the way. phi1 is violated at the first level that BatteryLevel reads."
            .into(),
        time: Duration::from_millis(67_020),
        tick: Some(67),
        scene: Some(scene()),
        battery: Some(battery()),
        tree: paper_tree(),
        monitors: vec![phi1(), phi2()],
    }
}

/// Left, lower edge, width and height, in meters.
type Rectangle = (f64, f64, f64, f64);

const ROOMS: [Rectangle; 7] = [
    (-14.5, 11.0, 6.3, 4.4),
    (-8.2, -6.0, 2.6, 22.0),
    (-5.6, 7.0, 10.6, 4.4),
    (-5.6, -2.2, 11.2, 8.4),
    (6.2, 5.0, 7.8, 6.4),
    (6.2, -2.2, 7.8, 6.2),
    (-14.5, 1.2, 6.3, 1.6),
];

const DOORS: [Rectangle; 6] = [
    (-8.4, 12.4, 0.4, 1.2),
    (-5.8, 8.4, 0.4, 1.2),
    (-5.8, 1.2, 0.4, 1.3),
    (-8.4, 1.5, 0.4, 1.1),
    (4.9, 8.2, 1.6, 1.2),
    (5.4, 0.1, 1.0, 1.2),
];

const FURNITURE: [Rectangle; 9] = [
    (-2.0, 3.0, 1.6, 0.9),
    (1.6, 2.6, 1.2, 1.6),
    (-2.4, -1.8, 1.8, 0.8),
    (2.6, -2.1, 1.4, 0.7),
    (-1.0, 8.9, 2.2, 0.8),
    (9.0, 7.6, 1.6, 1.2),
    (11.4, -1.8, 1.4, 1.0),
    (-13.6, 11.9, 1.0, 1.4),
    (7.0, 1.0, 0.08, 2.0),
];

/// A floor with walls, doorways and furniture.
fn floor() -> OccupancyGrid {
    const RES: f64 = 0.05;
    let mut grid = OccupancyGrid::new(640, 520, RES, pose(-16.0, -8.0, 0.0));
    let mut fill = |(x, y, w, h): Rectangle, cell: Cell| {
        let cells = |from: f64, to: f64, low: f64| {
            (((from - low) / RES).round() as usize)..(((to - low) / RES).round() as usize)
        };
        for row in cells(y, y + h, -8.0) {
            for column in cells(x, x + w, -16.0) {
                grid.set(CellIndex { column, row }, cell);
            }
        }
    };
    for (x, y, w, h) in ROOMS {
        fill((x - 0.15, y - 0.15, w + 0.3, h + 0.3), Cell::Occupied);
    }
    for room in ROOMS {
        fill(room, Cell::Free);
    }
    for (x, y, w, h) in ROOMS {
        fill((x - 0.15, y - 0.15, 0.15, h + 0.3), Cell::Occupied);
        fill((x + w, y - 0.15, 0.15, h + 0.3), Cell::Occupied);
    }
    for door in DOORS {
        fill(door, Cell::Free);
    }
    for piece in FURNITURE {
        fill(piece, Cell::Occupied);
    }
    grid
}

/// The picture of the furnished floor.
pub(super) fn floor_picture() -> Arc<MapPicture> {
    Arc::new(MapPicture::new(&floor()))
}

fn scene() -> Scene {
    let robot = pose(-7.0, 5.5, 1.62);
    Scene {
        map: floor_picture(),
        robot,
        robot_radius_m: 0.3,
        estimate: Some(pose(-6.98, 5.52, 1.6)),
        path: (0..=40)
            .map(|i| f64::from(i) / 40.0)
            .map(|t| Point::new(-7.0 + 0.5 * t * t - t * 0.9, 5.5 + 3.5 * t))
            .collect(),
        laser_hits: laser_hits(&floor(), &robot),
        particles: cloud(&robot, 800),
        trail: trail(),
        start: Some(pose(0.0, 0.0, 0.0)),
        station: Some(Station { pose: pose(-7.5, 9.0, std::f64::consts::PI), label: "charging station".into() }),
        destination: Some(Place {
            label: "destination".into(),
            corners: [(-13.2, 14.9), (-10.0, 14.7), (-10.2, 12.2), (-13.2, 12.4)]
                .map(|(x, y)| Point::new(x, y))
                .to_vec(),
            keep_out: false,
        }),
        places: vec![Place { label: "lobby".into(), corners: vec![Point::new(3.0, -2.0)], keep_out: false }],
        faults: vec![Mark {
            position: Point::new(-6.95, 4.2),
            label: "level set to 10 %".into(),
            short: "level".into(),
        }],
        violations: vec![Mark { position: Point::new(-6.7, 3.0), label: "phi1 violated".into(), short: "phi1".into() }],
        bodies: vec![
            Body { shape: Shape::Disc { radius_m: 0.28 }, pose: pose(-6.6, -1.0, 0.0), label: "person".into() },
            Body {
                shape: Shape::Box { length_m: 1.1, width_m: 0.12 },
                pose: pose(5.8, 0.7, std::f64::consts::FRAC_PI_2),
                label: String::new(),
            },
        ],
        speeches: Vec::new(),
    }
}

/// A path across the floor, with a point every few centimeters.
fn trail() -> Vec<Point> {
    const CORNERS: [(f64, f64); 8] =
        [(0.0, 0.0), (-1.6, 0.5), (-3.2, 1.0), (-4.6, 1.6), (-6.0, 1.8), (-6.9, 2.6), (-7.0, 4.0), (-7.0, 5.5)];
    let corners = CORNERS.map(|(x, y)| Point::new(x, y));
    let legs = corners.windows(2).flat_map(|leg| (0..12).map(|i| leg[0] + (leg[1] - leg[0]) * (f64::from(i) / 12.0)));
    legs.collect()
}

/// Where 240 beams around the robot end, found by stepping along them.
pub(super) fn laser_hits(grid: &OccupancyGrid, robot: &Pose) -> Vec<Point> {
    let mut hits = Vec::new();
    for beam in 0..240 {
        let turn = nalgebra::UnitComplex::new(f64::from(beam) * 0.026_18);
        let direction = turn * nalgebra::Vector2::new(1.0, 0.0);
        let hit = (10..400).map(|step| robot * (Point::origin() + direction * (f64::from(step) * 0.025)));
        let mut hit =
            hit.filter(|point| grid.index_of(point).and_then(|index| grid.cell(index)) == Some(Cell::Occupied));
        hits.extend(hit.next());
    }
    hits
}

/// A cloud of particles around a pose, the same every time.
pub(super) fn cloud(robot: &Pose, count: usize) -> Vec<Point> {
    let mut chance = Chance::new(12_345);
    let mut bell = || chance.centered() + chance.centered() + chance.centered();
    (0..count)
        .map(|_| {
            let offset = nalgebra::Vector2::new(bell(), bell());
            robot * Point::from(offset * 0.5)
        })
        .collect()
}

fn battery() -> BatteryHistory {
    let history = (0..=670).map(|i| {
        let time_s = f64::from(i) * 0.1;
        let level = if time_s < 58.0 { 41.0 - 0.05 * time_s } else { 10.0 - 0.05 * (time_s - 58.0) };
        (Duration::from_secs_f64(time_s), level)
    });
    BatteryHistory {
        history: history.collect(),
        level_pct: 9.6,
        charging: false,
        thresholds: vec![
            Threshold { level_pct: 30.0, label: "recharge".into(), critical: false },
            Threshold { level_pct: 20.0, label: "unsafe".into(), critical: true },
        ],
        faults: vec![(Duration::from_secs(58), "fault: level set to 10 %".into())],
    }
}

/// A tree from (parent, label, status) lines.
pub(super) fn tree(nodes: &[(Option<usize>, &str, NodeStatus)]) -> Vec<TreeNode> {
    nodes.iter().map(|&(parent, label, status)| TreeNode { parent, label: label.into(), status }).collect()
}

/// The paper's tree while the robot drives to the charging station.
pub(super) fn paper_tree() -> Vec<TreeNode> {
    use NodeStatus::{Failure, NotTicked, Running};
    tree(&[
        (None, "→", Running),
        (Some(0), "?", Running),
        (Some(1), "→", Failure),
        (Some(2), "BatteryLevel", Failure),
        (Some(2), "BatteryNotCharging", NotTicked),
        (Some(1), "→", Running),
        (Some(5), "?", Running),
        (Some(6), "AtRechargingStation", Failure),
        (Some(6), "GotoRechargingStation", Running),
        (Some(5), "WaitForUser", NotTicked),
        (Some(0), "?", NotTicked),
        (Some(10), "AtDestination", NotTicked),
        (Some(10), "GoToDestination", NotTicked),
    ])
}

/// A tree of about forty nodes, five levels deep.
pub(super) fn large_tree() -> Vec<TreeNode> {
    let statuses = [NodeStatus::Success, NodeStatus::Failure, NodeStatus::Running, NodeStatus::NotTicked];
    let mut nodes = vec![TreeNode { parent: None, label: "→".into(), status: NodeStatus::Running }];
    for branch in 0..4 {
        let top = nodes.len();
        nodes.push(TreeNode { parent: Some(0), label: "?".into(), status: statuses[branch] });
        nodes.push(TreeNode { parent: Some(top), label: "Inverter".into(), status: statuses[branch] });
        nodes.push(TreeNode { parent: Some(top + 1), label: "→".into(), status: statuses[branch] });
        for leaf in 0..6 {
            let label = format!("Condition{branch}{leaf}OfTheRobot");
            let parent = Some(if leaf < 4 { top + 2 } else { top });
            nodes.push(TreeNode { parent, label, status: statuses[(branch + leaf) % 4] });
        }
    }
    nodes
}

/// A diagram from the names of its locations (those with a `!` are errors) and its transitions.
pub(super) fn diagram(names: &[&str], active: usize, transitions: &[(usize, usize, &str)]) -> Diagram {
    Diagram {
        locations: names
            .iter()
            .map(|name| Location {
                name: name.trim_end_matches('!').into(),
                about: about(name).into(),
                error: name.ends_with('!'),
            })
            .collect(),
        initial: 0,
        active,
        transitions: transitions
            .iter()
            .map(|&(from, to, label)| Transition { from, to, label: label.into() })
            .collect(),
    }
}

/// The meaning of a location whose name is not self-explanatory.
fn about(name: &str) -> &'static str {
    match name {
        "I" => "rests",
        "C2" => "awaits the answer",
        "T" => "checks the clock",
        _ => "",
    }
}

/// The safety monitor, violated.
pub(super) fn phi1() -> Monitor {
    Monitor {
        name: "phi1".into(),
        description: "the level read is never below 20 %".into(),
        verdict: Verdict::Violated,
        note: "tick 67".into(),
        diagram: diagram(&["idle", "get", "failure!"], 2, &[(0, 1, "a level is read"), (1, 0, "≥ 20"), (1, 2, "< 20")]),
    }
}

/// The response monitor.
pub(super) fn phi2() -> Monitor {
    Monitor {
        name: "phi2".into(),
        description: "below 30 % on the way, it heads for the station in time".into(),
        verdict: Verdict::HoldsSoFar,
        note: String::new(),
        diagram: diagram(
            &["I", "I1", "C1", "S", "C2", "T", "Err!"],
            0,
            &[
                (0, 1, "running"),
                (1, 2, "level"),
                (2, 1, "> 30"),
                (2, 3, "≤ 30"),
                (3, 4, "timer := θ"),
                (4, 0, "start for the station"),
                (4, 5, "tick"),
                (5, 4, "timer > 0"),
                (5, 6, "timer = 0"),
            ],
        ),
    }
}

/// A moment at which there is hardly anything to show.
pub(super) fn empty_frame() -> Frame {
    let grid = OccupancyGrid::new(0, 0, 0.05, pose(0.0, 0.0, 0.0));
    Frame {
        scenario: String::new(),
        seed: Some(0),
        caption: String::new(),
        time: Duration::ZERO,
        tick: Some(0),
        scene: Some(Scene {
            estimate: Some(pose(0.0, 0.0, f64::INFINITY)),
            laser_hits: vec![Point::new(f64::NAN, 0.0)],
            trail: vec![Point::new(1e300, 0.0)],
            destination: Some(Place { label: "nowhere".into(), corners: Vec::new(), keep_out: false }),
            ..Scene::new(Arc::new(MapPicture::new(&grid)), pose(f64::NAN, f64::NAN, f64::NAN), 0.3)
        }),
        battery: Some(BatteryHistory { level_pct: f64::NAN, ..BatteryHistory::default() }),
        tree: tree(&[(Some(3), "Alone", NodeStatus::NotTicked)]),
        monitors: Vec::new(),
    }
}

/// A run with only a tree and skills, without a map.
pub(super) fn mapless_frame() -> Frame {
    Frame { scenario: "mapless".into(), scene: None, battery: None, ..frame() }
}

/// Charging, after an hour with several faults and with bad localization.
pub(super) fn charging_frame() -> Frame {
    let mut frame = frame();
    let level = |time_s: u64| match time_s {
        0..1200 => 88.0 - 0.05 * time_s as f64,
        1200..1300 => 28.0 - 0.05 * (time_s - 1200) as f64,
        1300..2900 => 23.0 + 0.048 * (time_s - 1300) as f64,
        _ => (55.0 - 0.02 * (time_s - 2900) as f64).max(0.0),
    };
    frame.scenario = "charging".into();
    frame.caption = "Docked at the charging station.".into();
    frame.time = Duration::from_secs(3500);
    let battery = frame.battery.as_mut().expect("the sample has one");
    battery.history = (0..=3500).map(|time_s| (Duration::from_secs(time_s), level(time_s))).collect();
    battery.level_pct = level(3500);
    battery.charging = true;
    battery.faults = [(1180, "first"), (1200, "level set to 28 %"), (1230, "third"), (2900, "level set to 55 %")]
        .map(|(time_s, label)| (Duration::from_secs(time_s), label.to_owned()))
        .to_vec();
    let scene = frame.scene.as_mut().expect("the sample has one");
    scene.robot = pose(-7.5, 9.0, std::f64::consts::PI);
    scene.estimate = Some(pose(-6.9, 8.2, 2.6));
    scene.path.clear();
    frame.monitors[0].verdict = Verdict::Satisfied;
    frame.monitors[0].diagram.active = 0;
    frame.monitors[1].verdict = Verdict::Inconclusive;
    frame.monitors[1].note = "start for the station still open".into();
    frame.monitors[1].diagram.active = 4;
    frame
}

/// Names and labels of all lengths, some with markup; a large tree; and a diagram with everything that diagrams can
/// contain.
pub(super) fn crowded_frame() -> Frame {
    let mut frame = frame();
    let long = "a very long name that nobody would choose, but somebody will <b>&amp; \"quote\" 漢字";
    frame.scenario = long.repeat(3);
    frame.caption = long.repeat(6);
    frame.tree = large_tree();
    for node in frame.tree.iter_mut().step_by(5) {
        node.label = long.into();
    }
    let scene = frame.scene.as_mut().expect("the sample has one");
    scene.bodies[1].label = long.into();
    scene.speeches = vec![long.repeat(3), "Hello!".into()];
    for fault in 0..4 {
        let position = Point::new(-6.9 + 0.05 * f64::from(fault), 4.2);
        scene.faults.push(Mark { position, label: format!("fault {fault}: {long}"), short: format!("fault {fault}") });
    }
    let battery = frame.battery.as_mut().expect("the sample has one");
    battery.thresholds[0].label = long.into();
    battery.faults[0].1 = long.into();
    frame.monitors = vec![everything(), phi2()];
    frame.monitors[1].name = long.into();
    frame.monitors[1].description = long.into();
    frame.monitors[1].note = long.into();
    frame
}

/// A diagram with loops, skips, returns, and several transitions between the same locations.
pub(super) fn everything() -> Monitor {
    Monitor {
        name: "everything".into(),
        description: "loops, skips, returns".into(),
        verdict: Verdict::HoldsSoFar,
        note: String::new(),
        diagram: diagram(
            &["start", "waiting", "a location with a long name", "d", "never reached", "error!"],
            1,
            &[
                (0, 1, "go"),
                (0, 1, "go at once"),
                (1, 1, "tick"),
                (1, 2, "< 20"),
                (2, 1, "back"),
                (2, 2, "again"),
                (0, 2, "skip"),
                (0, 3, "skip more"),
                (2, 3, "on"),
                (3, 0, "over"),
                (3, 3, "tick"),
                (3, 5, "timeout"),
                (5, 5, "any"),
                (4, 9, "to nowhere"),
            ],
        ),
    }
}

/// Reproducible pseudorandom numbers for tests (a linear congruential generator).
pub(super) struct Chance(u32);

impl Chance {
    pub(super) fn new(seed: u32) -> Self {
        Self(seed)
    }

    /// A number below `bound`.
    pub(super) fn below(&mut self, bound: usize) -> usize {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as usize % bound
    }

    /// A number from −0.5 to 0.5.
    pub(super) fn centered(&mut self) -> f64 {
        self.below(1 << 24) as f64 / f64::from(1 << 24) - 0.5
    }
}
