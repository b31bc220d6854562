//! Commands that a base can follow.

use robot::{Odometry, RobotModel, VelocityCommand};

/// If the wheels' motion differs from the command by more than this, the command was not followed, in m/s and rad/s.
const NOT_FOLLOWED_MPS: f64 = 0.15;
const NOT_FOLLOWED_RADPS: f64 = 0.4;

/// Speeds are averaged over this time, in seconds: those of encoders are noisy, and unaveraged ones would keep the
/// robot from starting.
const AVERAGED_S: f64 = 0.2;

/// Turns desired velocities into commands, like Nav2's velocity smoother.
///
/// The robot accelerates no faster than it can, from its last command or the actual motion of its wheels, whichever is
/// slower, and stays on the desired arc meanwhile. Slowing down is never delayed: the base brakes as hard as it can.
#[derive(Clone, Debug)]
pub(crate) struct VelocitySmoother {
    max_linear_mps: f64,
    max_angular_radps: f64,
    max_linear_acceleration_mps2: f64,
    max_angular_acceleration_radps2: f64,
    command: VelocityCommand,
    /// The recent averages of commands and of wheel motion.
    commanded: VelocityCommand,
    done: VelocityCommand,
}

impl VelocitySmoother {
    /// For a robot at rest.
    pub(crate) fn new(model: &RobotModel) -> Self {
        Self {
            max_linear_mps: model.max_linear_mps,
            max_angular_radps: model.max_angular_radps,
            max_linear_acceleration_mps2: model.max_linear_acceleration_mps2,
            max_angular_acceleration_radps2: model.max_angular_acceleration_radps2,
            command: VelocityCommand::STOP,
            commanded: VelocityCommand::STOP,
            done: VelocityCommand::STOP,
        }
    }

    /// The last command.
    pub(crate) fn command(&self) -> VelocityCommand {
        self.command
    }

    /// The forward speed of the robot, in m/s: the commanded one, or more while it is still slowing down.
    pub(crate) fn speed_mps(&self) -> f64 {
        self.command.linear_mps.max(self.done.linear_mps)
    }

    /// Advances by `dt_s` seconds towards the desired velocity.
    pub(crate) fn step(&mut self, wanted: VelocityCommand, odometry: &Odometry, dt_s: f64) -> VelocityCommand {
        self.average(odometry, dt_s);
        let VelocityCommand { linear_mps, angular_radps } = self.command;
        let linear_step = self.max_linear_acceleration_mps2 * dt_s;
        let angular_step = self.max_angular_acceleration_radps2 * dt_s;
        let linear_excess = self.done.linear_mps - self.commanded.linear_mps;
        let angular_excess = self.done.angular_radps - self.commanded.angular_radps;
        let linear_is = followed(linear_mps, linear_excess, NOT_FOLLOWED_MPS);
        let angular_is = followed(angular_radps, angular_excess, NOT_FOLLOWED_RADPS);
        let driving = wanted.linear_mps.clamp(-self.max_linear_mps, self.max_linear_mps);
        let linear = towards(driving, linear_mps, linear_is, linear_step);
        // A robot that still accelerates turns less, so that it stays on the arc that was found to be free.
        let share = if wanted.linear_mps == 0.0 { 1.0 } else { linear / wanted.linear_mps };
        let turning = (wanted.angular_radps * share).clamp(-self.max_angular_radps, self.max_angular_radps);
        let angular = towards(turning, angular_radps, angular_is, angular_step);
        self.command = VelocityCommand { linear_mps: linear, angular_radps: angular };
        self.command
    }

    fn average(&mut self, odometry: &Odometry, dt_s: f64) {
        let share = (dt_s / AVERAGED_S).min(1.0);
        let averaged = |average: VelocityCommand, linear_mps: f64, angular_radps: f64| VelocityCommand {
            linear_mps: average.linear_mps + (linear_mps - average.linear_mps) * share,
            angular_radps: average.angular_radps + (angular_radps - average.angular_radps) * share,
        };
        self.commanded = averaged(self.commanded, self.command.linear_mps, self.command.angular_radps);
        let is_known = odometry.linear_mps.is_finite() && odometry.angular_radps.is_finite();
        self.done =
            if is_known { averaged(self.done, odometry.linear_mps, odometry.angular_radps) } else { self.commanded };
    }
}

/// The effective velocity of a command: the command, unless the wheels do something else.
fn followed(command: f64, excess: f64, tolerated: f64) -> f64 {
    if excess.abs() > tolerated { command + excess } else { command }
}

/// The speed nearest to the desired one that is at most one step faster than the slower of the other two.
fn towards(wanted: f64, command: f64, actual: f64, step: f64) -> f64 {
    let along = wanted.signum();
    let slower = (command * along).min(actual * along).max(0.0);
    wanted.clamp(-slower - step, slower + step)
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use maps::Pose;
    use proptest::prelude::*;

    use super::*;

    const DT_S: f64 = 0.02;

    fn odometry(linear_mps: f64, angular_radps: f64) -> Odometry {
        Odometry { time: Duration::ZERO, pose: Pose::identity(), linear_mps, angular_radps }
    }

    /// A smoother of a robot that has followed this command for a while.
    fn driving(commanded: VelocityCommand) -> VelocitySmoother {
        let mut smoother = VelocitySmoother::new(&RobotModel::default());
        for _ in 0..200 {
            let VelocityCommand { linear_mps, angular_radps } = smoother.command();
            smoother.step(commanded, &odometry(linear_mps, angular_radps), DT_S);
        }
        smoother
    }

    #[test]
    fn a_robot_accelerates_within_its_limits_but_stops_at_once() {
        let model = RobotModel::default();
        let wanted = VelocityCommand { linear_mps: 0.4, angular_radps: -0.5 };
        let mut smoother = VelocitySmoother::new(&model);
        let first = smoother.step(wanted, &odometry(0.0, 0.0), DT_S);
        let step_mps = model.max_linear_acceleration_mps2 * DT_S;
        assert!((first.linear_mps - step_mps).abs() < 1e-12 && first.angular_radps < 0.0, "{first:?}");
        let mut smoother = driving(wanted);
        assert_eq!(smoother.command(), wanted);
        assert_eq!(smoother.step(VelocityCommand::STOP, &odometry(0.4, -0.5), DT_S), VelocityCommand::STOP);
    }

    #[test]
    fn a_stopping_robot_is_not_commanded_to_continue_while_it_still_rolls() {
        let mut smoother = driving(VelocityCommand { linear_mps: 0.45, angular_radps: 0.0 });
        let mut rolls_mps: f64 = 0.45;
        let turning = VelocityCommand { linear_mps: 0.0, angular_radps: -0.9 };
        while rolls_mps > 0.0 {
            let command = smoother.step(turning, &odometry(rolls_mps, smoother.command().angular_radps), DT_S);
            assert!(
                command.linear_mps.abs() < 1e-12,
                "commanded to drive at {command:?} while it rolls at {rolls_mps}"
            );
            assert!(smoother.speed_mps() > 0.0);
            rolls_mps -= 0.5 * DT_S;
        }
    }

    #[test]
    fn a_blocked_robot_does_not_leap_when_it_is_released() {
        let mut smoother = driving(VelocityCommand { linear_mps: 0.45, angular_radps: 0.0 });
        let wanted = smoother.command();
        let held: Vec<f64> = (0..100).map(|_| smoother.step(wanted, &odometry(0.0, 0.0), DT_S).linear_mps).collect();
        assert!(held[50..].iter().all(|command| *command < 0.25), "{held:?}");
        assert!(held[50..].iter().any(|command| *command > 0.0), "it goes on trying");
    }

    #[test]
    fn an_accelerating_robot_stays_on_the_desired_arc() {
        let mut smoother = VelocitySmoother::new(&RobotModel::default());
        for _ in 0..200 {
            let VelocityCommand { linear_mps, angular_radps } = smoother.command();
            let wanted = VelocityCommand { linear_mps: 0.4, angular_radps: 0.3 };
            let command = smoother.step(wanted, &odometry(linear_mps, angular_radps), DT_S);
            assert!((command.angular_radps - 0.75 * command.linear_mps).abs() < 1e-12, "{command:?}");
        }
        assert!((smoother.command().linear_mps - 0.4).abs() < 1e-12);
    }

    #[test]
    fn nan_speeds_and_steps_without_time_are_harmless() {
        let mut smoother = driving(VelocityCommand { linear_mps: 0.4, angular_radps: 0.0 });
        let wanted = smoother.command();
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(smoother.step(wanted, &odometry(bad, 0.0), DT_S), wanted);
            assert_eq!(smoother.step(wanted, &odometry(0.4, bad), 0.0), wanted);
        }
        assert_eq!(smoother.step(wanted, &odometry(0.4, 0.0), DT_S), wanted);
        assert!((smoother.speed_mps() - 0.4).abs() < 1e-9);
    }

    proptest! {
        #[test]
        fn commands_never_exceed_or_reverse_the_wanted_velocity(
            steps in prop::collection::vec((-0.45_f64..0.45, -1.0_f64..1.0, -0.6_f64..0.6, -1.5_f64..1.5), 1..60),
        ) {
            let mut smoother = VelocitySmoother::new(&RobotModel::default());
            for (linear_mps, angular_radps, rolls_mps, turns_radps) in steps {
                let wanted = VelocityCommand { linear_mps, angular_radps };
                let command = smoother.step(wanted, &odometry(rolls_mps, turns_radps), DT_S);
                for (command, wanted) in [(command.linear_mps, linear_mps), (command.angular_radps, angular_radps)] {
                    prop_assert!(command * wanted >= 0.0 && command.abs() <= wanted.abs());
                }
            }
        }
    }
}
