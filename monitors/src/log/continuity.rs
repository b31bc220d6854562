//! Whether the lines of a log follow each other.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use channels::{Flaw, Gap};

use super::found::{Found, GapMark};
use crate::WORLD;

/// The numbers of the last events, and where lines are missing or come again.
#[derive(Debug)]
pub(super) struct Continuity {
    /// The number of the last line.
    pub(super) line: u64,
    /// Step, tick and time of the last event.
    pub(super) last: (u64, u64, Duration),
    next_tick: u64,
    /// How many messages of the world have come, and when a line last gave their number.
    of_world: u64,
    counted: Duration,
    /// How many lines begin or end gaps.
    marks: u64,
    /// The gaps that the log names, and the first places where lines are missing, or come again.
    pub(super) gaps: VecDeque<GapMark>,
    /// Of these places, by whether lines come again there: since when verdicts may be wrong, if not from there on.
    noticed: BTreeMap<bool, Option<Duration>>,
    /// Whether the log has ticks: it does not give 0 as their period.
    pub(super) has_ticks: bool,
}

impl Continuity {
    /// Before the first line.
    pub(super) fn start() -> Self {
        Self {
            line: 0,
            last: (0, 0, Duration::ZERO),
            next_tick: 0,
            of_world: 0,
            counted: Duration::ZERO,
            marks: 0,
            gaps: VecDeque::new(),
            noticed: BTreeMap::new(),
            has_ticks: true,
        }
    }

    /// A line begins or ends a gap; `None` if only in a channel that is not read.
    pub(super) fn mark(&mut self, mark: Option<GapMark>) {
        self.marks += 1;
        self.gaps.extend(mark);
    }

    /// Notes the numbers of an event. Returns whether none goes back.
    pub(super) fn note(&mut self, (step, tick, time): (u64, u64, Duration), found: &Found<'_>) -> bool {
        // Each is compared by itself: a step can never be later at an earlier time.
        let last = std::mem::replace(&mut self.last, (step, tick, time));
        if step < last.0 || tick < last.1 || time < last.2 {
            return false;
        }
        // A message is a step; a tick is none, and neither is what is true in the world.
        let is_of_world = found.from == Some(WORLD.as_bytes());
        self.of_world += u64::from(is_of_world);
        let next_step = if found.generated || is_of_world { last.0 } else { last.0.saturating_add(1) };
        let (next_tick, is_next_tick) = match found.generated {
            true => (self.next_tick, tick == self.next_tick),
            false => (self.next_tick.saturating_sub(1), tick <= self.next_tick.saturating_sub(1)),
        };
        if step != next_step {
            self.doubt(("step", step, next_step));
        } else if !is_next_tick {
            self.doubt(("tick", tick, next_tick));
        }
        self.compare_world(found.world);
        if found.world.is_some() || self.of_world == 0 {
            self.counted = time;
        }
        if found.generated || !is_next_tick {
            self.next_tick = tick.saturating_add(1);
        }
        true
    }

    /// Compares the numbers that the line with the end of the run repeats with those of the last events.
    pub(super) fn finish(&mut self, found: &Found<'_>) {
        match (found.step, found.tick) {
            (Some(count), _) if count != self.last.0 => self.doubt(("step", count, self.last.0)),
            (_, Some(count)) if count.checked_add(1) != Some(self.next_tick) => {
                self.doubt(("tick", count, self.next_tick.saturating_sub(1)));
            }
            _ => {}
        }
        self.compare_world(found.world);
        if let Some(count) = found.marks.filter(|count| *count != self.marks) {
            self.doubt_since(Some(Duration::ZERO), ("gap", count, self.marks));
        }
    }

    /// Notes that a number is another than the next one should be.
    fn doubt(&mut self, numbers: (&str, u64, u64)) {
        self.doubt_since(self.doubted_since(), numbers);
    }

    /// Since when anything may be missing, if lines are missing now and that is not from here on: the first tick comes
    /// before all messages but those of the world.
    pub(super) fn doubted_since(&self) -> Option<Duration> {
        (self.has_ticks && self.next_tick == 0).then_some(Duration::ZERO)
    }

    /// Compares how many messages of the world there are with those that have come. One that is missing may belong
    /// anywhere after the last line with that number.
    fn compare_world(&mut self, count: Option<u64>) {
        let Some(count) = count else { return };
        if count != self.of_world {
            self.doubt_since(Some(self.counted), ("the world's message", count, self.of_world));
        }
        self.of_world = count;
    }

    /// Notes the first number of its kind that is another than the next one should be, and what that means.
    fn doubt_since(&mut self, since: Option<Duration>, (what, found, next): (&str, u64, u64)) {
        let is_again = found < next;
        let is_known = |known: &Option<Duration>| since.is_none_or(|since| known.is_some_and(|known| known <= since));
        if self.noticed.get(&is_again).is_some_and(is_known) {
            return;
        }
        self.noticed.insert(is_again, since);
        let (flaw, lines) = match (is_again, since) {
            (true, _) => (Flaw::Mixed, "lines come again at"),
            // Verdicts that were reached at that very time may be wrong, too.
            (false, Some(_)) => (Flaw::Displaced, "lines are missing before"),
            (false, None) => (Flaw::Missing, "lines are missing before"),
        };
        // Only the last line can name the next number, that of a first tick which has not come.
        let wrong = if found == next {
            format!("{what} {found} is missing")
        } else {
            format!("{what} {found} comes where {next} should")
        };
        let why = format!("{lines} line {} of the log: {wrong}", self.line);
        self.gaps.push_back(GapMark::Begins(Gap { flaw, since, ..Gap::of_anything(why) }));
    }
}
