//! The messages that a simulated robot obeys: commands for its base, and poses for its localization.

use std::time::Duration;

use maps::seen_from_above;
use nav::InitialPose;
use robot::VelocityCommand;
use ros_messages::{CdrReader, Mismatch};

/// The largest coordinate, in meters, and the largest covariance of a pose on a map.
pub(super) const LARGEST: f64 = 1e6;

/// A message for the base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Command {
    pub(super) velocity: VelocityCommand,
    /// The stamp, if messages of this type have one.
    pub(super) stamp: Option<Duration>,
    /// Whether it contains velocities that the base ignores: sideways, up, roll or pitch.
    pub(super) is_partial: bool,
}

impl Command {
    /// Reads a message of one of the [known](Self::is_known) types. `None` if it is too short, or has numbers that are
    /// not finite.
    pub(super) fn read(kind: &str, message: &[u8]) -> Option<Self> {
        let is_stamped = kind == "geometry_msgs/msg/TwistStamped";
        let read = || -> Result<_, Mismatch> {
            let mut reader = CdrReader::new(message)?;
            let stamp = if is_stamped { Some(header(&mut reader)?.0) } else { None };
            Ok((stamp, reals::<6>(&mut reader)?))
        };
        let (stamp, numbers) = read().ok()?;
        let [linear_mps, y, z, roll, pitch, angular_radps] = numbers;
        numbers.iter().all(|number| number.is_finite()).then_some(Self {
            velocity: VelocityCommand { linear_mps, angular_radps },
            stamp,
            is_partial: [y, z, roll, pitch].iter().any(|number| *number != 0.0),
        })
    }

    /// Whether messages of this type are read.
    pub(super) fn is_known(kind: &str) -> bool {
        matches!(kind, "geometry_msgs/msg/Twist" | "geometry_msgs/msg/TwistStamped")
    }
}

/// The pose in a `geometry_msgs/msg/PoseWithCovarianceStamped`. `None` if the message is not one, or its pose is not in
/// the plane of the map. Without a frame, it counts as one on the map.
pub(super) fn initial_pose(message: &[u8], map: &str) -> Option<InitialPose> {
    let read = || -> Result<_, Mismatch> {
        let mut reader = CdrReader::new(message)?;
        let (_, frame) = header(&mut reader)?;
        Ok((frame, reals::<7>(&mut reader)?, reals::<36>(&mut reader)?))
    };
    let (frame, [x, y, _, a, b, c, w], covariance) = read().ok()?;
    let is_on_map = frame.is_empty() || frame == map.as_bytes();
    let covariance = [0, 1, 5].map(|row| [0, 1, 5].map(|column| covariance[6 * row + column]));
    let is_sound = is_on_map && [x, y].iter().chain(covariance.iter().flatten()).all(|number| number.abs() <= LARGEST);
    // Some programs send a covariance of zeros, which means that it is unknown.
    let is_exact = covariance.iter().flatten().all(|number| *number == 0.0);
    let there = seen_from_above([x, y], [a, b, c, w]);
    (is_sound && there.rotation.re.is_finite())
        .then(|| if is_exact { InitialPose::at(there) } else { InitialPose::near(there, covariance) })
}

/// Reads a `std_msgs/msg/Header`. Returns its stamp and its frame.
pub(super) fn header<'b>(reader: &mut CdrReader<'b>) -> Result<(Duration, &'b [u8]), Mismatch> {
    let (s, ns) = (i32::from_le_bytes(reader.number()?), u32::from_le_bytes(reader.number()?));
    let frame = reader.string(None)?;
    Ok((Duration::new(u64::try_from(s).unwrap_or_default(), ns), frame))
}

pub(super) fn reals<const COUNT: usize>(reader: &mut CdrReader<'_>) -> Result<[f64; COUNT], Mismatch> {
    let mut numbers = [0.0; COUNT];
    for number in &mut numbers {
        *number = f64::from_le_bytes(reader.number()?);
    }
    Ok(numbers)
}

#[cfg(test)]
mod tests {
    use recording::ros::{Covariance, Header, PoseWithCovariance, PoseWithCovarianceStamped, Twist, Vector};
    use ros_messages::{CdrWriter, RosType};

    use super::*;

    const TWIST: &str = "geometry_msgs/msg/Twist";

    fn bytes(write: impl FnOnce(&mut CdrWriter)) -> Vec<u8> {
        let mut cdr = CdrWriter::reusing(Vec::new());
        write(&mut cdr);
        cdr.bytes()
    }

    fn twist(x: f64, y: f64, turn: f64) -> Twist {
        Twist { linear: Vector { x, y, z: 0.0 }, angular: Vector { z: turn, ..Vector::default() } }
    }

    #[test]
    fn commands_are_read_with_and_without_a_stamp() {
        let message = bytes(|cdr| twist(0.3, 0.0, -0.5).write(cdr));
        let velocity = VelocityCommand { linear_mps: 0.3, angular_radps: -0.5 };
        assert_eq!(Command::read(TWIST, &message), Some(Command { velocity, stamp: None, is_partial: false }));
        let stamped = bytes(|cdr| {
            Header::new(Duration::from_millis(1500), "base").write(cdr);
            twist(0.3, 0.1, -0.5).write(cdr);
        });
        let stamp = Some(Duration::from_millis(1500));
        let expected = Some(Command { velocity, stamp, is_partial: true });
        assert_eq!(Command::read("geometry_msgs/msg/TwistStamped", &stamped), expected);
    }

    #[test]
    fn what_is_no_command_is_none() {
        let message = bytes(|cdr| twist(0.3, 0.0, 0.0).write(cdr));
        assert!((0..message.len()).all(|length| Command::read(TWIST, &message[..length]).is_none()));
        for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(Command::read(TWIST, &bytes(|cdr| twist(x, 0.0, 0.0).write(cdr))), None, "{x}");
        }
        assert!(!Command::is_known("std_msgs/msg/String") && Command::is_known(TWIST));
    }

    #[test]
    fn a_pose_has_a_covariance_unless_it_is_zero() {
        let there = maps::pose(1.0, -2.0, 2.5);
        let written = |variance: f64| {
            let mut covariance = Covariance::default();
            [0, 7, 35].iter().for_each(|place| covariance.0[*place] = variance);
            let pose = PoseWithCovariance { pose: (&there).into(), covariance };
            let header = Header::new(Duration::ZERO, if variance > 0.0 { "map" } else { "" });
            bytes(|cdr| PoseWithCovarianceStamped { header, pose }.write(cdr))
        };
        for (variance, expected_m2) in [(0.25, 0.25), (0.0, 2.5e-3)] {
            let Some(InitialPose::Near { pose, covariance }) = initial_pose(&written(variance), "map") else {
                panic!()
            };
            assert!((pose.inverse() * there).translation.vector.norm() < 1e-9);
            assert!((maps::heading(&pose) - 2.5).abs() < 1e-9);
            assert_eq!(covariance[(1, 1)], expected_m2);
        }
        assert_eq!(initial_pose(&written(f64::NAN), "map"), None);
        assert_eq!(initial_pose(&written(0.25), "r1/map"), None);
    }
}
