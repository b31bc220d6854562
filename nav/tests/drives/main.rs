//! Whole drives: a robot of a few lines on a floor drawn in code, run by nothing but scans, odometry and the map.

mod floor;
mod hemmed_in;
mod localization;
mod navigation;
mod rebuilt;
mod unicycle;
