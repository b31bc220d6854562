//! Faults of the robot's surroundings.

use std::time::Duration;

use maps::{Point, Pose, Shape, pose};
use sim::{Manners, ObstacleConfig, ObstacleMotion, Pauses, RouteEnd, Walk};

use crate::faults::kind::{FaultKind, Subsystem};
use crate::faults::{ArgumentDomain, Effect, Parameter};

const AT: Parameter = Parameter::required("at", "the pose of its center", ArgumentDomain::Pose);
const POINT: Parameter = Parameter::required("at", "its first point", ArgumentDomain::Point);
const ROUTE: Parameter = Parameter::required("route", "its further points, in order", ArgumentDomain::Points);

fn appears(name: String, shape: Shape, pose: Pose, motion: ObstacleMotion) -> Effect {
    let body = ObstacleConfig { name, shape, pose, motion };
    Effect::world(move |faults| faults.bodies.push(body.clone()))
}

fn on_the_way(waypoints: &[Point], speed_mps: f64) -> ObstacleMotion {
    ObstacleMotion::Route { waypoints: waypoints.to_vec(), speed_mps, end: RouteEnd::BackAndForth }
}

/// The route of a person who waits for the robot.
fn strolls(waypoints: &[Point], speed_mps: f64) -> ObstacleMotion {
    let walk = Walk {
        waypoints: waypoints.to_vec(),
        speed_mps,
        end: RouteEnd::BackAndForth,
        sets_out: Duration::ZERO,
        pause: Duration::ZERO,
        pauses: Pauses::default(),
        manners: Some(Manners::default()),
    };
    ObstacleMotion::Person(walk)
}

fn position(pose: &Pose) -> String {
    spot(&pose.translation.vector.into())
}

fn spot(point: &Point) -> String {
    format!("({:.2}, {:.2}) m", point.x, point.y)
}

pub(super) const DOOR: FaultKind = FaultKind {
    name: "door_closes",
    subsystem: Subsystem::World,
    about: "a door closes",
    parameters: &[AT, Parameter::number("width_m", "the width of the doorway, in meters", 0.1, 20.0, 1.0)],
    example: "at_s = 10\nat = [4.0, 3.0, 90]\nwidth_m = 1.0\nlasts_s = 60",
    effect: |with| {
        let shape = Shape::Box { length_m: with.number("width_m"), width_m: 0.08 };
        appears(format!("door at {}", position(&with.pose("at"))), shape, with.pose("at"), ObstacleMotion::Fixed)
    },
    words: |with| format!("the door at {} closes", position(&with.pose("at"))),
};

pub(super) const OBSTACLE: FaultKind = FaultKind {
    name: "obstacle_appears",
    subsystem: Subsystem::World,
    about: "a box stands in the way",
    parameters: &[
        AT,
        Parameter::number("length_m", "its length along its heading, in meters", 0.05, 20.0, 0.6),
        Parameter::number("width_m", "its width, in meters", 0.05, 20.0, 0.4),
    ],
    example: "at_s = 10\nat = [4.0, 3.0, 0]",
    effect: |with| {
        let shape = Shape::Box { length_m: with.number("length_m"), width_m: with.number("width_m") };
        appears(format!("box at {}", position(&with.pose("at"))), shape, with.pose("at"), ObstacleMotion::Fixed)
    },
    words: |with| format!("a box stands at {}", position(&with.pose("at"))),
};

pub(super) const MOVING_OBSTACLE: FaultKind = FaultKind {
    name: "obstacle_moves",
    subsystem: Subsystem::World,
    about: "a trolley moves back and forth and never yields",
    parameters: &[POINT, ROUTE, Parameter::number("speed_mps", "its speed, in m/s", 0.0, 5.0, 0.3)],
    example: "at_s = 10\nat = [4.0, 3.0]\nroute = [[6.0, 3.0]]\nspeed_mps = 0.3",
    effect: |with| {
        let at = with.point("at");
        let shape = Shape::Box { length_m: 0.7, width_m: 0.5 };
        let motion = on_the_way(with.points("route"), with.number("speed_mps"));
        appears(format!("trolley from {}", spot(&at)), shape, pose(at.x, at.y, 0.0), motion)
    },
    words: |with| format!("a trolley moves back and forth from {}", spot(&with.point("at"))),
};

pub(super) const PEOPLE: FaultKind = FaultKind {
    name: "people",
    subsystem: Subsystem::World,
    about: "people walk back and forth, one behind another",
    parameters: &[
        POINT,
        ROUTE,
        Parameter::number("speed_mps", "their walking speed, in m/s", 0.0, 3.0, 0.8),
        Parameter::whole("count", "how many", 0, 50, 3),
        Parameter::flag("gives_way", "whether they wait for the robot instead of walking into it"),
    ],
    example: "at_s = 10\nat = [4.0, 3.0]\nroute = [[6.0, 3.0]]\ncount = 3",
    effect: |with| {
        let (at, route, speed_mps) = (with.point("at"), with.points("route"), with.number("speed_mps"));
        let first = route.first().copied().unwrap_or(at);
        let (count, gives_way) = (with.whole("count"), with.flag("gives_way"));
        let people: Vec<ObstacleConfig> = (0..count)
            .map(|number| {
                let start = at + (first - at) * (number as f64 / count as f64);
                ObstacleConfig {
                    name: format!("person {} from {}", number + 1, spot(&at)),
                    shape: Shape::Disc { radius_m: 0.25 },
                    pose: pose(start.x, start.y, 0.0),
                    motion: if gives_way {
                        strolls(&[route, &[at]].concat(), speed_mps)
                    } else {
                        on_the_way(&[route, &[at]].concat(), speed_mps)
                    },
                }
            })
            .collect();
        Effect::world(move |faults| faults.bodies.extend(people.iter().cloned()))
    },
    words: |with| {
        let (from, yields) = (spot(&with.point("at")), with.flag("gives_way"));
        match with.whole("count") {
            1 => format!("a person walks back and forth from {from}{}", if yields { ", and yields" } else { "" }),
            count => {
                format!("{count} people walk back and forth from {from}{}", if yields { ", and yield" } else { "" })
            }
        }
    },
};

pub(super) const STATION_OCCUPIED: FaultKind = FaultKind {
    name: "station_occupied",
    subsystem: Subsystem::World,
    about: "another robot stands at the charging station",
    parameters: &[AT],
    example: "at_s = 0\nat = [1.0, 1.0, 90]",
    effect: |with| {
        let shape = Shape::Disc { radius_m: 0.3 };
        appears("another robot".to_owned(), shape, with.pose("at"), ObstacleMotion::Fixed)
    },
    words: |with| format!("another robot stands at the charging station, at {}", position(&with.pose("at"))),
};

pub(super) const STATION_MOVED: FaultKind = FaultKind {
    name: "station_moved",
    subsystem: Subsystem::World,
    about: "the charging station has been moved without the software's knowledge",
    parameters: &[Parameter::required(
        "to",
        "its new position, and the heading of a docked robot",
        ArgumentDomain::Pose,
    )],
    example: "at_s = 0\nto = [3.0, 1.0, 90]",
    effect: |with| {
        let to = with.pose("to");
        Effect::world(move |faults| faults.station = Some(to))
    },
    words: |with| format!("the charging station is now at {}", position(&with.pose("to"))),
};
