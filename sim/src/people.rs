//! People: they walk along routes or follow the robot, wait for a robot in their way, and step aside for it.

mod aside;
mod follower;
mod trail;
mod walker;

pub(crate) use follower::{Follower, follow};
pub(crate) use walker::{Walker, walk};
