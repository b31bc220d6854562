//! Faults of the laser scanners.

use diagnostics::document::Referent;
use sim::{LaserFault, LaserTrouble};

use crate::faults::kind::{FaultKind, Subsystem};
use crate::faults::{ArgumentDefault, ArgumentDomain, Arguments, Effect, Parameter};

/// The affected laser: the one with this name on the robot, or all.
const LASER: Parameter = Parameter {
    name: "laser",
    about: "which laser of the robot, by its name, or `all`",
    domain: ArgumentDomain::Name(Referent::Laser),
    default: ArgumentDefault::Text("all"),
};

fn trouble(with: &Arguments, trouble: LaserTrouble) -> Effect {
    let laser = Some(with.text("laser")).filter(|name| *name != "all").map(str::to_owned);
    let fault = LaserFault { laser, trouble };
    Effect::world(move |faults| faults.lasers.push(fault.clone()))
}

/// The lasers that a fault affects, as the subject of a sentence.
fn who(with: &Arguments) -> String {
    match with.text("laser") {
        "all" => "all lasers".to_owned(),
        name => format!("the {name} laser"),
    }
}

pub(super) const DEAD: FaultKind = FaultKind {
    name: "laser_dead",
    subsystem: Subsystem::Lasers,
    about: "a laser sends no scans",
    parameters: &[LASER],
    example: "at_s = 10\nlaser = \"front\"",
    effect: |with| trouble(with, LaserTrouble::Dead),
    words: |with| format!("no more scans from {}", who(with)),
};

pub(super) const DROPOUT: FaultKind = FaultKind {
    name: "laser_dropout",
    subsystem: Subsystem::Lasers,
    about: "a share of the beams gets no echo",
    parameters: &[LASER, Parameter::required("share", "the share of the beams", ArgumentDomain::Numbers(0.0, 1.0))],
    example: "at_s = 10\nshare = 0.5",
    effect: |with| trouble(with, LaserTrouble::Dropout { probability: with.number("share") }),
    words: |with| format!("{} % of the beams of {} get no echo", 100.0 * with.number("share"), who(with)),
};

pub(super) const STUCK: FaultKind = FaultKind {
    name: "laser_stuck",
    subsystem: Subsystem::Lasers,
    about: "a laser repeats its last scan",
    parameters: &[LASER],
    example: "at_s = 10\nlasts_s = 20",
    effect: |with| trouble(with, LaserTrouble::Stuck),
    words: |with| format!("the same scan repeatedly from {}", who(with)),
};

pub(super) const NOISE: FaultKind = FaultKind {
    name: "laser_noise",
    subsystem: Subsystem::Lasers,
    about: "the ranges are noisy",
    parameters: &[
        LASER,
        Parameter::required("sigma_m", "standard deviation of a range, in meters", ArgumentDomain::Numbers(0.0, 10.0)),
    ],
    example: "at_s = 0\nsigma_m = 0.3",
    effect: |with| trouble(with, LaserTrouble::Noise { sigma_m: with.number("sigma_m") }),
    words: |with| format!("noise of σ = {} m on the ranges of {}", with.number("sigma_m"), who(with)),
};

pub(super) const RANGE_LIMIT: FaultKind = FaultKind {
    name: "laser_range_limit",
    subsystem: Subsystem::Lasers,
    about: "a laser has a limited range: fog, dust, a dirty window",
    parameters: &[LASER, Parameter::required("max_m", "the range, in meters", ArgumentDomain::Numbers(0.01, 1e3))],
    example: "at_s = 0\nmax_m = 1.5",
    effect: |with| trouble(with, LaserTrouble::RangeLimit { max_m: with.number("max_m") }),
    words: |with| format!("the range of {} is limited to {} m", who(with), with.number("max_m")),
};

pub(super) const MOUNT: FaultKind = FaultKind {
    name: "laser_mount_error",
    subsystem: Subsystem::Lasers,
    about: "a laser is not mounted where the software assumes",
    parameters: &[
        LASER,
        Parameter::number("x_m", "the error forward, in meters", -1.0, 1.0, 0.0),
        Parameter::number("y_m", "the error to the left, in meters", -1.0, 1.0, 0.0),
        Parameter::number("turn_deg", "the rotation to the left, in degrees", -180.0, 180.0, 0.0),
    ],
    example: "at_s = 0\nlaser = \"front\"\nturn_deg = 5",
    effect: |with| {
        let (x_m, y_m, yaw_rad) = (with.number("x_m"), with.number("y_m"), with.radians("turn_deg"));
        trouble(with, LaserTrouble::Mount { x_m, y_m, yaw_rad })
    },
    words: |with| {
        let [x, y, turn] = ["x_m", "y_m", "turn_deg"].map(|name| with.number(name));
        format!("a mounting error of {x} m, {y} m and {turn}° of {}", who(with))
    },
};

pub(super) const GHOST: FaultKind = FaultKind {
    name: "laser_ghost",
    subsystem: Subsystem::Lasers,
    about: "a laser sees an object that does not exist, always in the same direction",
    parameters: &[
        LASER,
        Parameter::number("distance_m", "its apparent distance, in meters", 0.0, 1e3, 0.8),
        Parameter::number("bearing_deg", "its direction from the laser, in degrees", -180.0, 180.0, 0.0),
        Parameter::number("width_deg", "its width, in degrees", 0.0, 360.0, 30.0),
    ],
    example: "at_s = 10\nlaser = \"front\"\ndistance_m = 0.8\nlasts_s = 30",
    effect: |with| {
        let (bearing_rad, width_rad) = (with.radians("bearing_deg"), with.radians("width_deg"));
        trouble(with, LaserTrouble::Ghost { distance_m: with.number("distance_m"), bearing_rad, width_rad })
    },
    words: |with| format!("a ghost at {} m in the scans of {}", with.number("distance_m"), who(with)),
};
