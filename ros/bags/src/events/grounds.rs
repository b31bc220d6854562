//! What a source vouches for.

use std::collections::{BTreeMap, VecDeque};

use channels::{ChannelId, Ground};

use crate::mapping::{Compiled, Mapping};
use crate::storage::Survey;

/// On what grounds the messages of channels are known.
pub(super) struct KnownGrounds {
    grounds: BTreeMap<ChannelId, Ground>,
    /// Whether some may be new.
    pub(super) may_be_new: bool,
    new: VecDeque<(ChannelId, Ground)>,
}

impl KnownGrounds {
    pub(super) fn none() -> Self {
        Self { grounds: BTreeMap::new(), may_be_new: true, new: VecDeque::new() }
    }

    /// The next channel of which the source vouches on another ground than before.
    pub(super) fn next(
        &mut self,
        survey: &Survey,
        mapping: &Mapping,
        compiled: &Compiled,
    ) -> Option<(ChannelId, Ground)> {
        if std::mem::take(&mut self.may_be_new) {
            for channel in compiled.topology.channels() {
                let ground = compiled.ground(channel, mapping, survey);
                if self.grounds.get(&channel) != Some(&ground) {
                    self.grounds.insert(channel, ground.clone());
                    self.new.push_back((channel, ground));
                }
            }
        }
        self.new.pop_front()
    }
}
