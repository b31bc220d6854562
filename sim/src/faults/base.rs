//! Faults of the base and its encoders.

use std::time::Duration;

use robot::VelocityCommand;

/// Faults of the wheels' encoders. Biases add to those of [`OdometryConfig`](crate::OdometryConfig).
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct OdometryFaults {
    /// Systematic error of the distance, as a fraction of it: 0.01 reports 1 % too much. Default 0.
    pub distance_bias: f64,
    /// Systematic error of the angle, as a fraction of it. Default 0.
    pub angle_bias: f64,
    /// Excess angle reported per meter driven, in rad/m. Default 0.
    pub angle_bias_rad_per_m: f64,
    /// The encoders count nothing: readings have new times, the same pose and zero speed. Afterwards they continue from
    /// there; motion during the fault is lost. Default false.
    pub frozen: bool,
}

/// Faults of the base: motors and wheels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaseFaults {
    /// A joypad that overrides the software's velocity commands while it is held, without delay. The limits of the
    /// drive, an empty battery and an emergency stop apply to it, too. Default none.
    pub velocity_override: Option<VelocityCommand>,
    /// Share of the wheels' motion that slips, although the encoders count it: the robot drives and turns by 1 − `slip`
    /// of the wheels' motion. From 0 to 1, where the wheels spin in place. Default 0.
    pub slip: f64,
    /// Ratio of the left wheel's actual motion to the intended one: the robot pulls to the side of the weaker wheel.
    /// The encoders measure the actual motion. From 0 to 2. Default 1.
    pub left_wheel_factor: f64,
    /// The same for the right wheel. Default 1.
    pub right_wheel_factor: f64,
    /// Limit of the forward and backward speed, in m/s, if below the model's. The robot brakes to it as fast as it can;
    /// turning rates are not limited. At least 0. Default none.
    pub speed_limit_mps: Option<f64>,
    /// The motors are off and the brakes hold: the robot stands still from the next step on, regardless of its speed.
    /// Afterwards it starts from rest. Default false.
    pub emergency_stop: bool,
    /// The delay of commands, rounded up to whole steps. Until the first delayed command takes effect, the last earlier
    /// command remains in effect. When the fault ends, the newest command takes effect at once. Default 0.
    pub command_delay: Duration,
}

impl Default for BaseFaults {
    fn default() -> Self {
        Self {
            velocity_override: None,
            slip: 0.0,
            left_wheel_factor: 1.0,
            right_wheel_factor: 1.0,
            speed_limit_mps: None,
            emergency_stop: false,
            command_delay: Duration::ZERO,
        }
    }
}
