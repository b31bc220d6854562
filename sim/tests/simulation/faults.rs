//! Faults act when they are set, and only then.

mod base;
mod battery;
mod lasers;
mod odometry;
mod traces;
mod world;
