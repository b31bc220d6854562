//! Velocity commands in transit from the software to the base.

use std::collections::VecDeque;
use std::time::Duration;

use robot::VelocityCommand;

/// The software's commands, which take effect at once unless a fault delays them.
#[derive(Clone, Debug, Default)]
pub(crate) struct CommandDelay {
    /// The last command of the software.
    latest: VelocityCommand,
    /// The last command that has arrived.
    arrived: VelocityCommand,
    /// The commands in transit, oldest first, each with the first step in which it could take effect.
    under_way: VecDeque<(Duration, VelocityCommand)>,
}

impl CommandDelay {
    pub(crate) fn send(&mut self, command: VelocityCommand) {
        self.latest = command;
    }

    /// The command in effect in the step that ends at `now`. Call this once per step.
    pub(crate) fn receive(&mut self, now: Duration, delay: Duration) -> VelocityCommand {
        if delay.is_zero() {
            self.under_way.clear();
            self.arrived = self.latest;
            return self.arrived;
        }
        if self.under_way.back().map_or(self.arrived, |(_, command)| *command) != self.latest {
            self.under_way.push_back((now, self.latest));
        }
        while let Some((_, command)) = self.under_way.pop_front_if(|(sent, _)| now.saturating_sub(*sent) >= delay) {
            self.arrived = command;
        }
        self.arrived
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The forward speeds of the commands that arrive in steps of 20 ms, given the speeds sent before each step and the
    /// delays in milliseconds.
    fn arrivals(sent: &[(f64, u64)]) -> Vec<f64> {
        let mut commands = CommandDelay::default();
        let mut step = |(step, (linear_mps, delay_ms)): (usize, &(f64, u64))| {
            commands.send(VelocityCommand { linear_mps: *linear_mps, angular_radps: 0.0 });
            commands.receive(Duration::from_millis(20 * (step as u64 + 1)), Duration::from_millis(*delay_ms)).linear_mps
        };
        sent.iter().enumerate().map(&mut step).collect()
    }

    #[test]
    fn without_a_delay_each_command_takes_effect_at_once() {
        assert_eq!(arrivals(&[(0.1, 0), (0.2, 0), (0.2, 0), (0.0, 0)]), [0.1, 0.2, 0.2, 0.0]);
    }

    #[test]
    fn a_delay_shifts_all_commands_by_whole_steps() {
        let at = |delay_ms| [0.1, 0.2, 0.3, 0.3, 0.3, 0.0, 0.0].map(|speed| (speed, delay_ms));
        assert_eq!(arrivals(&at(40)), [0.0, 0.0, 0.1, 0.2, 0.3, 0.3, 0.3]);
        assert_eq!(arrivals(&at(25)), arrivals(&at(40)));
    }

    #[test]
    fn commands_sent_before_a_delay_stay_until_the_first_delayed_one_arrives() {
        let sent = [(0.1, 0), (0.2, 40), (0.3, 40), (0.4, 40), (0.5, 40), (0.6, 0), (0.6, 40)];
        assert_eq!(arrivals(&sent), [0.1, 0.1, 0.1, 0.2, 0.3, 0.6, 0.6]);
    }
}
