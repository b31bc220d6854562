//! How a door moves.

use std::time::Duration;

/// How a leaf moves, and when. The obstacle's pose is that of the closed leaf's middle, its heading along the leaf.
#[derive(Clone, Debug, PartialEq)]
pub struct Door {
    /// Which way it opens.
    pub opening: Opening,
    /// How long it takes to open or to close.
    pub moving: Duration,
    /// From when to when it is closed, or closing; at all other times it is open, or opening. Where the first begins at
    /// the start of the run, the door is closed then.
    pub closed: Vec<(Duration, Duration)>,
    /// The times are those since the start of a round of this length, if there is one.
    pub every: Option<Duration>,
}

/// Which way a leaf opens.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Opening {
    /// It slides along its heading by its own length, as if into the wall.
    #[default]
    Slide,
    /// It turns to the left, by 90°, about its end at the back of its heading.
    Left,
    /// It turns to the right, by 90°, about its end at the back of its heading.
    Right,
}

impl Door {
    /// Whether it is to be closed at a time.
    pub(crate) fn is_closed_at(&self, now: Duration) -> bool {
        let within = match self.every {
            Some(every) if !every.is_zero() => Duration::from_nanos((now.as_nanos() % every.as_nanos()) as u64),
            _ => now,
        };
        self.closed.iter().any(|(from, to)| *from <= within && within < *to)
    }
}
