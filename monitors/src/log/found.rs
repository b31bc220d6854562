//! The contents of a line of a log.

use std::time::Duration;

use channels::{ChannelId, Flaw, Gap, Message};

/// Where a gap in the messages of a log begins, or where those of a channel end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum GapMark {
    /// A gap begins.
    Begins(Gap),
    /// The gaps of this channel that end are over.
    Ends(ChannelId),
}

#[derive(Default)]
pub(super) struct Found<'a> {
    pub(super) step: Option<u64>,
    pub(super) tick: Option<u64>,
    pub(super) time: Option<Duration>,
    pub(super) from: Option<&'a [u8]>,
    pub(super) to: Option<&'a [u8]>,
    pub(super) generated: bool,
    pub(super) message: Option<Message>,
    pub(super) world: Option<u64>,
    /// How many lines before it begin or end gaps.
    pub(super) marks: Option<u64>,
    /// Whether it is the line with the end of the run.
    pub(super) is_end: bool,
    /// In a box, since hardly any line has it.
    pub(super) gap: Option<Box<FoundGap<'a>>>,
}

impl<'a> Found<'a> {
    pub(super) fn gap(&mut self) -> &mut FoundGap<'a> {
        self.gap.get_or_insert_default()
    }
}

/// What a line contains about a gap.
#[derive(Debug, Default)]
pub(super) struct FoundGap<'a> {
    pub(super) missing: Option<String>,
    pub(super) flaw: Flaw,
    pub(super) since: Option<Duration>,
    pub(super) on: Option<[&'a [u8]; 2]>,
    pub(super) ends: bool,
    pub(super) resumed: Option<[&'a [u8]; 2]>,
}

impl FoundGap<'_> {
    /// Where the gap begins or ends, if the line marks that. One that ends, in a channel that is not `known`, is none.
    pub(super) fn mark(&mut self, mut known: impl FnMut(&[u8], &[u8]) -> Option<ChannelId>) -> Option<GapMark> {
        if let Some([from, to]) = self.resumed {
            return known(from, to).map(GapMark::Ends);
        }
        let anything = Gap { flaw: self.flaw, since: self.since, ..Gap::of_anything(self.missing.take()?) };
        let channel = self.on.map(|[from, to]| known(from, to));
        match channel {
            None => Some(GapMark::Begins(anything)),
            Some(None) => (!self.ends).then_some(GapMark::Begins(anything)),
            Some(channel) => Some(GapMark::Begins(Gap { channel, ends: self.ends, ..anything })),
        }
    }
}
