//! One trip, and what came of it.

use serde::Serialize;

/// Who and what is about on a trip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct About {
    /// How many people.
    pub people: usize,
    /// How many boxes.
    pub boxes: usize,
}

/// What came of a trip.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The robot is at its goal, and knows it.
    Arrived,
    /// The robot believes that it is at its goal, and is not.
    Elsewhere,
    /// Navigation has given up, with a reason.
    GaveUp,
    /// The robot was still under way when time was over.
    TimeOver,
}

impl Outcome {
    fn words(self) -> &'static str {
        match self {
            Self::Arrived => "arrived",
            Self::Elsewhere => "believes to have arrived, elsewhere",
            Self::GaveUp => "gave up",
            Self::TimeOver => "still under way when time was over",
        }
    }
}

/// A trip and what came of it.
#[derive(Clone, Debug, Serialize)]
pub struct Trip {
    /// The map's name.
    pub map: String,
    /// The file that the map was read from.
    pub map_file: String,
    /// The trip's root seed.
    pub seed: u64,
    /// Who and what found a place.
    pub about: About,
    /// Where the robot started, in the `map` frame, in metres.
    pub start: [f64; 2],
    /// Where it was to go.
    pub goal: [f64; 2],
    /// Where it was in the end.
    pub end: [f64; 2],
    /// Whether it arrived and touched neither a wall nor anybody or anything that stood still.
    pub good: bool,
    /// What came of it.
    pub outcome: Outcome,
    /// Why navigation gave up, or why it had no way when time was over; null if it did not, or had one.
    pub reason: Option<String>,
    /// How long it took, in seconds.
    pub time_s: f64,
    /// How far the robot drove, in metres.
    pub driven_m: f64,
    /// Length of the shortest way that a robot of its size can take, in metres, people or not.
    pub shortest_m: f64,
    /// How far the robot was from its goal in the end, in metres.
    pub off_m: f64,
    /// How far the estimated position was from the true one at worst, in metres.
    pub localization_max_m: f64,
    /// The contacts begun with walls, people and boxes, in order.
    pub contacts: Vec<Touched>,
    /// Contacts begun with walls.
    pub wall_contacts: usize,
    /// Contacts begun with people and boxes that had stood still for half a second or longer.
    pub standing_contacts: usize,
    /// Contacts begun with people who walked and boxes that were being pushed.
    pub walking_contacts: usize,
}

/// A contact of the robot's body.
#[derive(Clone, Debug, Serialize)]
pub struct Touched {
    /// When it began, in seconds.
    pub time_s: f64,
    /// With whom or what; null for walls.
    pub who: Option<String>,
}

impl Trip {
    /// What came of it, in words.
    #[must_use]
    pub fn words(&self) -> String {
        let mut words = self.outcome.words().to_owned();
        if let Some(reason) = &self.reason {
            let joint = if self.outcome == Outcome::TimeOver { "; last" } else { "" };
            words += &format!("{joint}: {reason}");
        }
        let contacts = [
            (self.wall_contacts, "walls"),
            (self.standing_contacts, "what stood"),
            (self.walking_contacts, "what moved"),
        ];
        for (count, what) in contacts.into_iter().filter(|(count, _)| *count > 0) {
            words += &format!("; contacts with {what}: {count}");
        }
        words
    }
}
