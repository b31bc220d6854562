//! Limits how much of a program's blackboards is kept: the page and the recording contain every change.

use std::time::Duration;

use groot::{Blackboards, BoardValue, Value};
use recording::{EntryValue, Step};

/// After changes of this many bytes, blackboards are read half as often.
const SHARE: usize = 4 << 20;
/// The size of a change without its key and its value, in bytes.
const PER_CHANGE: usize = 64;
/// The first and the longest interval between readings. After the longest, blackboards are no longer read.
const FIRST: Duration = Duration::from_millis(200);
const LAST: Duration = Duration::from_hours(1);

/// How often blackboards are read. It bounds the size of the changes that are kept.
#[derive(Debug)]
pub(crate) struct BoardBudget {
    period: Option<Duration>,
    used: usize,
    /// The maximum number of entries that were left out of a reading, and whether any value was too long.
    left_out: u64,
    is_shortened: bool,
}

impl Default for BoardBudget {
    fn default() -> Self {
        Self { period: Some(FIRST), used: 0, left_out: 0, is_shortened: false }
    }
}

impl BoardBudget {
    /// The interval between readings; none if blackboards are no longer read.
    pub(crate) fn period(&self) -> Option<Duration> {
        self.period
    }

    /// Ends the readings, since they fail.
    pub(crate) fn give_up(&mut self) {
        self.period = None;
    }

    /// Takes a reading and the step that was made of it. Returns what is left out from now on, in words, if it is more
    /// than before.
    pub(crate) fn take(&mut self, read: &Blackboards, step: &Step) -> Vec<String> {
        let mut notes = Vec::new();
        let mut entries = read.boards.iter().flat_map(|(_, entries)| entries);
        if !self.is_shortened && entries.any(|(_, value)| matches!(value, BoardValue::Long(_))) {
            self.is_shortened = true;
            notes.push("of long values on blackboards, only the length is shown".to_owned());
        }
        if read.left_out > self.left_out {
            notes.push(format!("{} entries of blackboards are not shown: they are too many", read.left_out));
            self.left_out = read.left_out;
        }
        let changes = step.details.iter().flat_map(|details| &details.entries);
        self.used += changes.map(|(_, key, value)| PER_CHANGE + key.len() + size(value.as_ref())).sum::<usize>();
        if self.used > SHARE
            && let Some(period) = self.period
        {
            self.used = 0;
            self.period = Some(period * 2).filter(|period| *period <= LAST);
            notes.push(match self.period {
                Some(period) => format!(
                    "blackboards change much: from here on, they are read every {} s, and what changes in between is not \
                     shown",
                    period.as_secs_f64()
                ),
                None => "blackboards change too much: from here on, they are not shown any more".to_owned(),
            });
        }
        notes
    }
}

fn size(value: Option<&EntryValue>) -> usize {
    match value {
        None | Some(EntryValue::Whole(_) | EntryValue::Real(_)) => 0,
        Some(EntryValue::Text(text) | EntryValue::Other(text)) => text.len(),
        Some(EntryValue::List(items)) => items.iter().map(String::len).sum(),
    }
}

pub(crate) fn entry_value(value: &BoardValue) -> EntryValue {
    let value = match value {
        BoardValue::Whole(value) => value,
        BoardValue::Long(bytes) => return EntryValue::Other(format!("({bytes} bytes)")),
    };
    match value {
        Value::Integer(number) => number.as_i64().map(EntryValue::Whole),
        Value::F32(number) => Some(EntryValue::Real(f64::from(*number))),
        Value::F64(number) => Some(EntryValue::Real(*number)),
        Value::String(text) => text.as_str().map(|text| EntryValue::Text(text.to_owned())),
        _ => None,
    }
    .unwrap_or_else(|| EntryValue::Other(value.to_string()))
}

#[cfg(test)]
mod tests {
    use recording::Details;

    use super::*;

    /// The step of a changed entry of this many bytes.
    fn changed(bytes: usize) -> Step {
        let entries = vec![(0, "map".to_owned(), Some(EntryValue::Text("x".repeat(bytes))))];
        Step { details: Some(Box::new(Details { entries, ..Details::default() })), ..Step::default() }
    }

    #[test]
    fn the_size_of_kept_changes_is_bounded() {
        for bytes in [10, 4000, 1 << 20] {
            let (step, mut budget, mut kept, mut notes) = (changed(bytes), BoardBudget::default(), 0, Vec::new());
            // For a month, or until blackboards are no longer read.
            let (mut time, month) = (Duration::ZERO, Duration::from_hours(24 * 30));
            while let Some(period) = budget.period().filter(|_| time < month) {
                time += period;
                kept += bytes;
                notes.extend(budget.take(&Blackboards::default(), &step));
            }
            assert!(kept < 15 * (SHARE + (1 << 20)), "{kept} of {bytes}");
            assert!(notes.len() <= 15 && notes.iter().all(|text| text.contains("from here on")), "{notes:?}");
            assert_eq!(budget.period().is_none(), bytes == 1 << 20, "{notes:?}");
        }
    }

    #[test]
    fn each_omission_is_noted_once() {
        let long = || vec![("Main".to_owned(), vec![("map".to_owned(), BoardValue::Long(5000))])];
        let read = |left_out| Blackboards { boards: long(), left_out };
        let mut budget = BoardBudget::default();
        assert_eq!(budget.take(&read(0), &Step::default()).len(), 1);
        assert_eq!(budget.take(&read(0), &Step::default()), [""; 0]);
        assert_eq!(
            budget.take(&read(3), &Step::default()),
            ["3 entries of blackboards are not shown: they are too many"]
        );
        assert_eq!(budget.take(&read(2), &Step::default()), [""; 0]);
        assert_eq!(entry_value(&BoardValue::Long(5000)), EntryValue::Other("(5000 bytes)".to_owned()));
    }
}
