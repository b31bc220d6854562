//! One trip and its result.

use serde::Serialize;

/// The people and boxes on a trip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct About {
    /// How many people.
    pub people: usize,
    /// How many boxes.
    pub boxes: usize,
}

/// The result of a trip.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TripOutcome {
    /// Navigation has reached the goal, and the robot is there.
    Arrived,
    /// Navigation has reached the goal by its estimate, but the robot is elsewhere.
    Elsewhere,
    /// Navigation has given up, with a reason.
    GaveUp,
    /// The robot was still driving at the time limit.
    TimeOver,
}

impl TripOutcome {
    fn words(self) -> &'static str {
        match self {
            Self::Arrived => "arrived",
            Self::Elsewhere => "false arrival",
            Self::GaveUp => "gave up",
            Self::TimeOver => "timed out",
        }
    }
}

/// A trip and its result.
#[derive(Clone, Debug, Serialize)]
pub struct Trip {
    /// The map's name.
    pub map: String,
    /// The file from which the map was read.
    pub map_file: String,
    /// The trip's root seed.
    pub seed: u64,
    /// The people and boxes that could be placed.
    pub about: About,
    /// Where the robot started, in the `map` frame, in meters.
    pub start: [f64; 2],
    /// Its goal.
    pub goal: [f64; 2],
    /// Where it was at the end.
    pub end: [f64; 2],
    /// Whether it arrived without touching a wall, or a person or box that stood still.
    pub good: bool,
    /// The result.
    pub outcome: TripOutcome,
    /// Why navigation gave up, or why it had no path at the time limit; otherwise null.
    pub reason: Option<String>,
    /// How long it took, in seconds.
    pub time_s: f64,
    /// How far the robot drove, in meters.
    pub driven_m: f64,
    /// Length of the shortest path for a robot of its size, in meters, ignoring people.
    pub shortest_m: f64,
    /// Distance from the goal at the end, in meters.
    pub off_m: f64,
    /// Greatest distance between the estimated and the true position, in meters.
    pub localization_max_m: f64,
    /// The contacts with walls, people and boxes, in order.
    pub contacts: Vec<Touched>,
    /// Contacts with walls.
    pub wall_contacts: usize,
    /// Contacts with people and boxes that had stood still for half a second or longer.
    pub standing_contacts: usize,
    /// Contacts with walking people and with boxes that were being pushed.
    pub walking_contacts: usize,
}

/// A contact of the robot's body.
#[derive(Clone, Debug, Serialize)]
pub struct Touched {
    /// When it began, in seconds.
    pub time_s: f64,
    /// What the robot touched; null for walls.
    pub who: Option<String>,
}

impl Trip {
    /// The result in words.
    #[must_use]
    pub fn words(&self) -> String {
        let mut words = self.outcome.words().to_owned();
        if let Some(reason) = &self.reason {
            let joint = if self.outcome == TripOutcome::TimeOver { "; last" } else { "" };
            words += &format!("{joint}: {reason}");
        }
        let contacts = [
            (self.wall_contacts, "walls"),
            (self.standing_contacts, "standing obstacles"),
            (self.walking_contacts, "moving obstacles"),
        ];
        for (count, what) in contacts.into_iter().filter(|(count, _)| *count > 0) {
            words += &format!("; contacts with {what}: {count}");
        }
        words
    }
}
