//! Readings that the robot's software has not read yet.

use bevy_ecs::prelude::*;
use robot::Reading;

/// Readings that have not been read yet, oldest first.
#[derive(Resource, Default)]
pub(crate) struct Readings(Vec<Reading>);

impl Readings {
    pub(crate) fn push(&mut self, reading: Reading) {
        self.0.push(reading);
    }

    pub(crate) fn extend(&mut self, readings: impl IntoIterator<Item = Reading>) {
        self.0.extend(readings);
    }

    pub(crate) fn hand_over(&mut self, readings: &mut Vec<Reading>) {
        readings.append(&mut self.0);
    }
}
