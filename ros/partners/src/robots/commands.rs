//! The messages that a simulated robot obeys: commands for its base, and poses for its localization.

use std::time::Duration;

use nav::InitialPose;
use recording::ros::{self, PoseWithCovarianceStamped, Twist, TwistStamped};
use robot::VelocityCommand;
use ros_messages::RosType as _;

/// The largest coordinate, in meters, and the largest covariance of a pose on a map.
pub(super) const LARGEST: f64 = 1e6;

/// The type of commands with a stamp.
const STAMPED: &str = "geometry_msgs/msg/TwistStamped";

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
        let (stamp, Twist { linear, angular }) = if kind == STAMPED {
            let TwistStamped { header, twist } = TwistStamped::decode(message).ok()?;
            (Some(header.stamp.into()), twist)
        } else {
            (None, Twist::decode(message).ok()?)
        };
        let (used, ignored) = ([linear.x, angular.z], [linear.y, linear.z, angular.x, angular.y]);
        used.iter().chain(&ignored).all(|number| number.is_finite()).then_some(Self {
            velocity: VelocityCommand { linear_mps: linear.x, angular_radps: angular.z },
            stamp,
            is_partial: ignored.iter().any(|number| *number != 0.0),
        })
    }

    /// Whether messages of this type are read.
    pub(super) fn is_known(kind: &str) -> bool {
        matches!(kind, "geometry_msgs/msg/Twist" | STAMPED)
    }
}

/// The pose in a `geometry_msgs/msg/PoseWithCovarianceStamped`. `None` if the message is not one, or its pose is not in
/// the plane of the map. Without a frame, it counts as one on the map.
pub(super) fn initial_pose(message: &[u8], map: &str) -> Option<InitialPose> {
    let PoseWithCovarianceStamped { header, pose } = PoseWithCovarianceStamped::decode(message).ok()?;
    let (there, covariance) = (ros::in_plane(&pose.pose), ros::planar_covariance(&pose.covariance));
    let is_on_map = header.frame_id.is_empty() || header.frame_id == map;
    let mut numbers = there.translation.vector.iter().chain(covariance.iter().flatten());
    let is_sound = is_on_map && numbers.all(|number| number.abs() <= LARGEST);
    // Some programs send a covariance of zeros, which means that it is unknown.
    let is_exact = covariance.iter().flatten().all(|number| *number == 0.0);
    (is_sound && there.rotation.re.is_finite())
        .then(|| if is_exact { InitialPose::at(there) } else { InitialPose::near(there, covariance) })
}

#[cfg(test)]
mod tests {
    use recording::ros::{Covariance, Header, PoseWithCovariance, Vector};

    use super::*;

    const TWIST: &str = "geometry_msgs/msg/Twist";

    fn twist(x: f64, y: f64, turn: f64) -> Twist {
        Twist { linear: Vector { x, y, z: 0.0 }, angular: Vector { z: turn, ..Vector::default() } }
    }

    #[test]
    fn commands_are_read_with_and_without_a_stamp() {
        let message = twist(0.3, 0.0, -0.5).encode();
        let velocity = VelocityCommand { linear_mps: 0.3, angular_radps: -0.5 };
        assert_eq!(Command::read(TWIST, &message), Some(Command { velocity, stamp: None, is_partial: false }));
        let header = Header::new(Duration::from_millis(1500), "base");
        let stamped = TwistStamped { header, twist: twist(0.3, 0.1, -0.5) }.encode();
        let stamp = Some(Duration::from_millis(1500));
        let expected = Some(Command { velocity, stamp, is_partial: true });
        assert_eq!(Command::read(STAMPED, &stamped), expected);
    }

    #[test]
    fn what_is_no_command_is_none() {
        let message = twist(0.3, 0.0, 0.0).encode();
        assert!((0..message.len()).all(|length| Command::read(TWIST, &message[..length]).is_none()));
        for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(Command::read(TWIST, &twist(x, 0.0, 0.0).encode()), None, "{x}");
        }
        assert!(!Command::is_known("std_msgs/msg/String") && Command::is_known(TWIST));
    }

    #[test]
    fn a_pose_has_a_covariance_unless_it_is_zero() {
        let there = maps::pose(1.0, -2.0, 2.5);
        let written = |variance: f64| {
            let mut covariance = Covariance::default();
            [0, 7, 35].iter().for_each(|place| covariance.0[*place] = variance);
            let pose = PoseWithCovariance { pose: ros::pose(&there), covariance };
            let header = Header::new(Duration::ZERO, if variance > 0.0 { "map" } else { "" });
            PoseWithCovarianceStamped { header, pose }.encode()
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
