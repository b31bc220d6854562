//! The gaps in the messages of channels.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::time::Duration;

use channels::{ChannelId, Flaw, Gap};

use crate::mapping::{CLOCK, Compiled, Mapping};
use crate::storage::Source;

/// The gaps that have been noticed, and which of them have been returned.
#[derive(Default)]
pub(super) struct Gaps {
    /// The channels of messages that were left out, or `None` for anything; those that have been returned.
    pub(super) left_out: BTreeMap<Option<ChannelId>, String>,
    known: BTreeSet<Option<ChannelId>>,
    /// Gaps that end; and the topics, and their entries, whose next message ends some, with when those began.
    pub(super) ending: VecDeque<Gap>,
    interrupted: BTreeMap<(usize, usize), Vec<i64>>,
    /// How many of the messages that the source reports as missing on topics have been returned.
    returned_missing: usize,
}

impl Gaps {
    /// Messages on a channel, or on any, were left out.
    pub(super) fn leave_out(&mut self, channel: Option<ChannelId>, why: impl FnOnce() -> String) {
        if !self.known.contains(&channel) {
            self.left_out.entry(channel).or_insert_with(why);
        }
    }

    /// Messages of an entry are missing since this time. Returns whether that is not part of a gap that began before.
    pub(super) fn interrupt(&mut self, entry: (usize, usize), since_ns: i64) -> bool {
        let begun = self.interrupted.entry(entry).or_default();
        let is_new = begun.iter().all(|begun_ns| *begun_ns > since_ns);
        begun.extend(is_new.then_some(since_ns));
        is_new
    }

    /// A message of an entry ends what was missing before it. Returns how many gaps there were.
    pub(super) fn end(&mut self, entry: (usize, usize)) -> usize {
        self.interrupted.remove(&entry).map_or(0, |begun| begun.len())
    }

    /// The next gap that the caller does not know. A message that does not become an event is noticed when it is read,
    /// which is before any event that it could precede.
    pub(super) fn next(&mut self, source: &dyn Source, mapping: &Mapping, compiled: &Compiled) -> Option<Gap> {
        // Files that are missing may have had messages of any time.
        let lost = source.survey().lost.first().or(source.lost().first());
        let (channel, why) = match lost.filter(|_| !self.known.contains(&None)) {
            Some(lost) => (None, lost.clone()),
            None => match self.left_out.pop_first() {
                Some(gap) => gap,
                None => {
                    self.find_missing(source, mapping, compiled);
                    return self.ending.pop_front();
                }
            },
        };
        self.known.insert(channel);
        Some(Gap { flaw: Flaw::Missing, why, channel, since: None, ends: false })
    }

    /// Where files count other messages than they have, any verdict that has been reached may lack one of them.
    fn find_missing(&mut self, source: &dyn Source, mapping: &Mapping, compiled: &Compiled) {
        let survey = source.survey();
        for (topic, why) in survey.missing.iter().skip(self.returned_missing) {
            self.returned_missing += 1;
            let is_clock = mapping.has_clock() && survey.topics[*topic].name == CLOCK;
            let entries = compiled.entries.get(*topic).into_iter().flatten();
            let entries = entries.filter(|(_, entry)| !entry.as_ref().is_ok_and(|entry| entry.is_lossy));
            let channels = entries.map(|(channel, _)| Some(*channel)).chain(is_clock.then_some(None));
            // One that is missing may belong before all that has come.
            self.ending.extend(channels.map(|channel| Gap {
                flaw: Flaw::Displaced,
                why: why.clone(),
                channel,
                since: Some(Duration::ZERO),
                ends: false,
            }));
        }
    }
}
