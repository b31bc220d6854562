//! What can be wrong with the base and its encoders.

use std::time::Duration;

use robot::VelocityCommand;

/// What can be wrong with the wheels' encoders. Biases add to those of [`OdometryConfig`](crate::OdometryConfig).
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct OdometryFaults {
    /// Systematic error of the distance, as a fraction of it: 0.01 reports 1 % too much. Default 0.
    pub distance_bias: f64,
    /// Systematic error of the angle, as a fraction of it. Default 0.
    pub angle_bias: f64,
    /// Angle reported too much for each metre driven, in rad/m. Default 0.
    pub angle_bias_rad_per_m: f64,
    /// The encoders count nothing: readings come with new times, the same pose and no speed. When they count again they
    /// go on from there; what was driven meanwhile is lost. Default false.
    pub frozen: bool,
}

/// What can be wrong with the base: motors and wheels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaseFaults {
    /// A joypad that overrides the software's velocity commands as long as it is held, without delay. The limits of the
    /// drive, an empty battery and an emergency stop apply to it too. Default none.
    pub velocity_override: Option<VelocityCommand>,
    /// Share of the wheels' motion that the floor does not see while the encoders count it: the robot drives and turns by
    /// 1 − `slip` of what the wheels roll. From 0 to 1, where the wheels spin on the spot. Default 0.
    pub slip: f64,
    /// Share of what the left wheel should turn that it turns: the robot pulls to the side of the weaker wheel. The
    /// encoders see what it does. From 0 to 2. Default 1.
    pub left_wheel_factor: f64,
    /// The same of the right wheel. Default 1.
    pub right_wheel_factor: f64,
    /// Largest forward and backward speed, in m/s, if less than the model's. The robot brakes down to it as fast as it
    /// can; turning rates are not limited. At least 0. Default none.
    pub speed_limit_mps: Option<f64>,
    /// The motors are off and the brakes hold: the robot stands from the next step on, however fast it was. When it ends,
    /// the robot starts from rest. Default false.
    pub emergency_stop: bool,
    /// By how much later commands take effect, rounded up to whole steps. Until the first of them does, the base goes by
    /// the last command that came before the fault. When it ends, the newest command takes effect at once. Default 0.
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
