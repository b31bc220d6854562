//! When the robot was at places.

use std::time::Duration;

use maps::Point;

use crate::Place;
use crate::inconsistent::Inconsistent;

/// When the robot was first at each place, by the index of the place in the header.
#[derive(Clone, Debug)]
pub(super) struct Visits {
    /// When it first came to rest there.
    pub(super) reached: Vec<Option<Duration>>,
    /// When it was first there, at rest or on its way.
    pub(super) entered: Vec<Option<Duration>>,
}

impl Visits {
    pub(super) fn of(places: &[Place]) -> Self {
        Self { reached: vec![None; places.len()], entered: vec![None; places.len()] }
    }

    /// Notes the places at which the robot is for the first time.
    pub(super) fn note_position(&mut self, position: &Point, places: &[Place], now: Duration) {
        for (place, entered) in places.iter().zip(&mut self.entered) {
            if entered.is_none() && place.covers(position) {
                *entered = Some(now);
            }
        }
    }

    pub(super) fn reach(&mut self, place: usize, now: Duration) -> Result<(), Inconsistent> {
        *self.reached.get_mut(place).ok_or(Inconsistent)? = Some(now);
        Ok(())
    }
}
