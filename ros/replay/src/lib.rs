//! Recorded and running robots as data: poses, scans and maps from the messages of ROS 2.
//!
//! A robot in a bag becomes a [`Recording`](robot::recorded::Recording), like one in a log: `robot` reads logs in
//! CARMEN's format, which need no ROS. A robot that runs gives its pose as its messages arrive.
//!
//! # Inside
//! [`bag`] reads scans, odometry, corrected poses and the map of a robot in a bag. [`trajectory`] is where it was, and
//! [`live_pose`] where a running robot is, for pages and pictures. [`mapping`] makes a map from the scans of a recorded
//! robot.

pub mod bag;
pub mod live_pose;
pub mod mapping;
pub mod trajectory;
