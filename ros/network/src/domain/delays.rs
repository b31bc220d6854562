//! When messages were due: as soon after they were sent as the fastest messages of their participant arrive.
//!
//! A message is late if it had to be sent again, if it had to wait until one before it was sent again, or if the
//! receiving process was paused.

use std::collections::BTreeMap;

use super::exchange::{Prefix, Sample, prefix};

/// How much longer than others a message may take, and so how exactly its due time is known. With best effort, nothing
/// is sent again.
const JITTER_NS: i64 = 50_000_000;
const JITTER_OF_BEST_EFFORT_NS: i64 = 250_000_000;

/// For how long the fastest message of a participant counts, at least. Its clock may be set.
const WINDOW_NS: i64 = 10_000_000_000;

/// The most participants whose delays are remembered.
const MOST: usize = 10_000;

/// The delay between a participant's stamps and the reception here. It includes the difference of the clocks.
#[derive(Debug, Default)]
pub(super) struct Delays(BTreeMap<Prefix, Least>);

/// The least delay since the beginning of a window, and that of the window before.
#[derive(Clone, Copy, Debug)]
struct Least {
    since_ns: i64,
    now_ns: i64,
    before_ns: i64,
}

impl Delays {
    /// The earliest time at which a sample may have been due. The previous one of its writer was due at `last_ns`.
    pub(super) fn due_ns(&mut self, sample: &Sample, last_ns: i64, is_reliable: bool) -> i64 {
        let (received_ns, of) = (sample.received_ns, prefix(&sample.writer));
        let expected_ns = sample.sent_ns.and_then(|sent_ns| {
            let delay_ns = received_ns.saturating_sub(sent_ns);
            let least_ns = self.least(of, delay_ns, received_ns);
            Some(sent_ns.saturating_add(least_ns?))
        });
        let jitter_ns = if is_reliable { JITTER_NS } else { JITTER_OF_BEST_EFFORT_NS };
        let since_ns = match expected_ns {
            Some(expected_ns) if received_ns.saturating_sub(expected_ns) > jitter_ns || sample.by_ns.is_some() => {
                expected_ns.saturating_sub(JITTER_NS)
            }
            None if sample.by_ns.is_some() => i64::MIN,
            None => sample.stalled_ns.unwrap_or(received_ns),
            // It may have been held back by this process.
            Some(_) => received_ns,
        };
        since_ns.max(last_ns).min(received_ns)
    }

    /// The least delay of a participant before this one. None before the first.
    fn least(&mut self, of: Prefix, delay_ns: i64, at_ns: i64) -> Option<i64> {
        if self.0.len() >= MOST {
            self.0.clear();
        }
        let Some(least) = self.0.get_mut(&of) else {
            self.0.insert(of, Least { since_ns: at_ns, now_ns: delay_ns, before_ns: delay_ns });
            return None;
        };
        if at_ns.saturating_sub(least.since_ns) > WINDOW_NS {
            *least = Least { since_ns: at_ns, now_ns: delay_ns, before_ns: least.now_ns };
        }
        least.now_ns = least.now_ns.min(delay_ns);
        Some(least.now_ns.min(least.before_ns))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: i64 = 1_000_000;

    fn sample(sent_ms: Option<i64>, received_ms: i64, by_ms: Option<i64>) -> Sample {
        let (received_ns, sent_ns, by_ns) = (received_ms * MS, sent_ms.map(|ms| ms * MS), by_ms.map(|ms| ms * MS));
        let (topic, writer, body) = ("rt/a".into(), [1; 16], Vec::new());
        Sample { topic, writer, number: 1, received_ns, sent_ns, by_ns, stalled_ns: None, body }
    }

    fn due_ms(delays: &mut Delays, sample: &Sample, last_ms: i64) -> i64 {
        delays.due_ns(sample, last_ms * MS, true) / MS
    }

    #[test]
    fn a_message_was_due_when_others_would_have_arrived() {
        // Its clock is 7 s behind.
        let mut delays = Delays::default();
        assert_eq!(due_ms(&mut delays, &sample(Some(3000), 10_003, None), 0), 10_003);
        assert_eq!(due_ms(&mut delays, &sample(Some(3100), 10_101, None), 10_003), 10_101);
        assert_eq!(due_ms(&mut delays, &sample(Some(3200), 10_500, None), 10_101), 10_201 - 50);
        // It follows the one before it.
        assert_eq!(due_ms(&mut delays, &sample(Some(3550), 10_900, None), 10_540), 10_540);
        // A later message was received before it: it had to be sent again.
        assert_eq!(due_ms(&mut delays, &sample(Some(4000), 11_020, Some(11_004)), 10_900), 11_001 - 50);
        // Its clock is set back by an hour. For a while, the due times of messages are not known.
        let mut due = |s: i64| {
            let sample = sample(Some(s * 1000 - 3_600_000), s * 1000, None);
            due_ms(&mut delays, &sample, s * 1000 - 900) - s * 1000
        };
        let due: Vec<i64> = (12..42).map(&mut due).collect();
        assert_eq!((due[0], due[29]), (-900, 0), "{due:?}");
    }

    #[test]
    fn without_stamps_the_order_of_messages_shows_when_one_was_due() {
        let mut delays = Delays::default();
        assert_eq!(due_ms(&mut delays, &sample(None, 10_000, None), 9000), 10_000);
        assert_eq!(due_ms(&mut delays, &sample(None, 11_000, Some(10_900)), 10_000), 10_000);
        // The process was paused.
        let stalled = Sample { stalled_ns: Some(12_000 * MS), ..sample(None, 15_000, None) };
        assert_eq!(due_ms(&mut delays, &stalled, 11_000), 12_000);
    }
}
