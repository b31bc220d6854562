//! Faults of odometry and base.

use robot::VelocityCommand;

use crate::faults::kind::{FaultKind, Subsystem};
use crate::faults::{ArgumentDefault, ArgumentDomain, Effect, Parameter};

pub(super) const WHEEL_SLIP: FaultKind = FaultKind {
    name: "wheel_slip",
    subsystem: Subsystem::Motion,
    about: "the wheels slip: the encoders count motion that the robot does not make",
    parameters: &[Parameter::required(
        "share",
        "the share of the wheels' motion that is lost",
        ArgumentDomain::Numbers(0.0, 1.0),
    )],
    example: "at_s = 10\nshare = 0.3\nlasts_s = 20",
    effect: |with| {
        let slip = with.number("share");
        Effect::world(move |faults| faults.base.slip = 1.0 - (1.0 - faults.base.slip) * (1.0 - slip))
    },
    words: |with| format!("the wheels slip: {} % of their motion is lost", 100.0 * with.number("share")),
};

pub(super) const ODOMETRY_BIAS: FaultKind = FaultKind {
    name: "odometry_bias",
    subsystem: Subsystem::Motion,
    about: "odometry reports too much or too little",
    parameters: &[
        Parameter::number("distance", "the error in distance, as a share of it", -1.0, 10.0, 0.0),
        Parameter::number("angle", "the error in angles, as a share of them", -1.0, 10.0, 0.0),
        Parameter::number(
            "deg_per_m",
            "the rotation reported for each meter driven straight, in degrees",
            -360.0,
            360.0,
            0.0,
        ),
    ],
    example: "at_s = 0\ndistance = 0.1\ndeg_per_m = 3",
    effect: |with| {
        let [distance, angle, deg_per_m] = ["distance", "angle", "deg_per_m"].map(|name| with.number(name));
        Effect::world(move |faults| {
            faults.odometry.distance_bias += distance;
            faults.odometry.angle_bias += angle;
            faults.odometry.angle_bias_rad_per_m += deg_per_m.to_radians();
        })
    },
    words: |with| {
        let [distance, angle, deg_per_m] = ["distance", "angle", "deg_per_m"].map(|name| with.number(name));
        format!(
            "odometry reports {:+} % distance, {:+} % angle, {deg_per_m:+}° per meter",
            100.0 * distance,
            100.0 * angle
        )
    },
};

pub(super) const ODOMETRY_FREEZE: FaultKind = FaultKind {
    name: "odometry_freeze",
    subsystem: Subsystem::Motion,
    about: "odometry reports no motion, whatever the wheels do",
    parameters: &[],
    example: "at_s = 10\nlasts_s = 10",
    effect: |_| Effect::world(|faults| faults.odometry.frozen = true),
    words: |_| "odometry is frozen".to_owned(),
};

pub(super) const JOYPAD: FaultKind = FaultKind {
    name: "joypad",
    subsystem: Subsystem::Motion,
    about: "a joypad overrides the velocity commands",
    parameters: &[
        Parameter::number("linear_mps", "forward speed, in m/s", -2.0, 2.0, 0.0),
        Parameter::number("angular_radps", "turning rate, in rad/s, counter-clockwise", -5.0, 5.0, 0.0),
    ],
    example: "near = \"RechargingStation\"\nwithin_m = 1.5\nlinear_mps = -0.4\nlasts_s = 8\ntimes = 1000",
    effect: |with| {
        let command =
            VelocityCommand { linear_mps: with.number("linear_mps"), angular_radps: with.number("angular_radps") };
        Effect::world(move |faults| faults.base.velocity_override = Some(command))
    },
    words: |with| {
        let (linear, angular) = (with.number("linear_mps"), with.number("angular_radps"));
        format!("a joypad overrides the velocity commands with {linear} m/s and {angular} rad/s")
    },
};

pub(super) const WEAK_WHEEL: FaultKind = FaultKind {
    name: "weak_wheel",
    subsystem: Subsystem::Motion,
    about: "a wheel turns more slowly than commanded, so the robot veers",
    parameters: &[
        Parameter {
            name: "wheel",
            about: "which wheel",
            domain: ArgumentDomain::OneOf(&["left", "right"]),
            default: ArgumentDefault::Text("left"),
        },
        Parameter::required("factor", "the share of its speed that remains", ArgumentDomain::Numbers(0.0, 1.0)),
    ],
    example: "at_s = 10\nwheel = \"left\"\nfactor = 0.7",
    effect: |with| {
        let (left, factor) = (with.text("wheel") == "left", with.number("factor"));
        Effect::world(move |faults| {
            let base = &mut faults.base;
            *if left { &mut base.left_wheel_factor } else { &mut base.right_wheel_factor } *= factor;
        })
    },
    words: |with| format!("the {} wheel has {} % of its speed", with.text("wheel"), 100.0 * with.number("factor")),
};

pub(super) const SPEED_LIMIT: FaultKind = FaultKind {
    name: "speed_limit",
    subsystem: Subsystem::Motion,
    about: "the speed of the base is limited, whatever its command",
    parameters: &[Parameter::required("max_mps", "the limit, in m/s", ArgumentDomain::Numbers(0.0, 10.0))],
    example: "at_s = 10\nmax_mps = 0.1",
    effect: |with| {
        let limit = with.number("max_mps");
        Effect::world(move |faults| {
            let lowest = faults.base.speed_limit_mps.map_or(limit, |other| other.min(limit));
            faults.base.speed_limit_mps = Some(lowest);
        })
    },
    words: |with| format!("the speed of the base is limited to {} m/s", with.number("max_mps")),
};

pub(super) const EMERGENCY_STOP: FaultKind = FaultKind {
    name: "emergency_stop",
    subsystem: Subsystem::Motion,
    about: "the emergency stop is pressed: the motors are off",
    parameters: &[],
    example: "at_s = 10\nlasts_s = 30",
    effect: |_| Effect::world(|faults| faults.base.emergency_stop = true),
    words: |_| "the emergency stop is pressed".to_owned(),
};

pub(super) const COMMAND_DELAY: FaultKind = FaultKind {
    name: "command_delay",
    subsystem: Subsystem::Motion,
    about: "velocity commands take effect late",
    parameters: &[Parameter::required("delay_s", "the delay, in seconds", ArgumentDomain::Numbers(0.0, 60.0))],
    example: "at_s = 10\ndelay_s = 0.5",
    effect: |with| {
        let delay = with.seconds("delay_s");
        Effect::world(move |faults| faults.base.command_delay = faults.base.command_delay.max(delay))
    },
    words: |with| format!("velocity commands take effect {} s late", with.number("delay_s")),
};
