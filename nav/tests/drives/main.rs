//! Whole drives: a minimal robot on a floor drawn in code, controlled only by scans, odometry and the map.

mod floor;
mod hemmed_in;
mod localization;
mod navigation;
mod rebuilt;
mod unicycle;
