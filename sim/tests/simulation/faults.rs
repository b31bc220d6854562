//! What goes wrong when it is told to, and only then.

mod base;
mod battery;
mod lasers;
mod odometry;
mod traces;
mod world;
