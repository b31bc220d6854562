//! The motion of doors.

use std::time::Duration;

/// When and how a leaf moves, unless it is [commanded](crate::Simulation::command_door). The obstacle's pose is that of
/// the closed leaf's center; its heading is along the leaf.
#[derive(Clone, Debug, PartialEq)]
pub struct Door {
    /// How it opens.
    pub opening: Opening,
    /// How long it takes to open or to close.
    pub moving: Duration,
    /// The intervals in which it is closed, or closing; at all other times it is open, or opening. If the first begins
    /// at the start of the run, the door is initially closed.
    pub closed: Vec<(Duration, Duration)>,
    /// If set, the intervals repeat with this period, and their times count from the start of each period.
    pub every: Option<Duration>,
}

/// How a leaf opens.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Opening {
    /// It slides along its heading by its own length, as if into the wall.
    #[default]
    Slide,
    /// It turns left, by 90°, about its rear end.
    Left,
    /// It turns right, by 90°, about its rear end.
    Right,
}

impl Door {
    /// Whether it should be closed at a time.
    pub(crate) fn is_closed_at(&self, now: Duration) -> bool {
        let within = match self.every {
            Some(every) if !every.is_zero() => Duration::from_nanos((now.as_nanos() % every.as_nanos()) as u64),
            _ => now,
        };
        self.closed.iter().any(|(from, to)| *from <= within && within < *to)
    }
}
