//! Sets of small indices.

use std::ops::RangeInclusive;

/// A set of indices below a limit that is fixed when the set is created. Iteration is in ascending order.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Default)]
pub(crate) struct BitSet {
    words: Box<[u64]>,
}

const BITS: usize = u64::BITS as usize;

impl BitSet {
    /// The empty set of indices below `limit`.
    pub(crate) fn new(limit: usize) -> Self {
        Self { words: vec![0; limit.div_ceil(BITS)].into() }
    }

    pub(crate) fn insert(&mut self, index: usize) {
        self.words[index / BITS] |= 1 << (index % BITS);
    }

    pub(crate) fn remove(&mut self, index: usize) {
        self.words[index / BITS] &= !(1 << (index % BITS));
    }

    pub(crate) fn contains(&self, index: usize) -> bool {
        self.words.get(index / BITS).is_some_and(|word| word & (1 << (index % BITS)) != 0)
    }

    pub(crate) fn clear(&mut self) {
        self.words.fill(0);
    }

    /// The smallest member that is not below `from`.
    pub(crate) fn next_from(&self, from: usize) -> Option<usize> {
        let first = from / BITS;
        let mut masked = self.words.get(first).copied()? & (u64::MAX << (from % BITS));
        let mut index = first;
        while masked == 0 {
            index += 1;
            masked = *self.words.get(index)?;
        }
        Some(index * BITS + masked.trailing_zeros() as usize)
    }

    /// Whether the range contains a member.
    pub(crate) fn any_in(&self, range: RangeInclusive<usize>) -> bool {
        self.next_from(*range.start()).is_some_and(|index| index <= *range.end())
    }

    /// The members in ascending order.
    pub(crate) fn iter(&self) -> impl Iterator<Item = usize> + '_ {
        let mut from = 0;
        std::iter::from_fn(move || {
            let index = self.next_from(from)?;
            from = index + 1;
            Some(index)
        })
    }

    /// The largest member below `limit`.
    pub(crate) fn last_below(&self, limit: usize) -> Option<usize> {
        (0..limit.min(self.words.len() * BITS)).rev().find(|index| self.contains(*index))
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn behaves_like_a_set(changes in prop::collection::vec((0_usize..150, any::<bool>()), 0..60), from in 0_usize..150) {
            let mut set = BitSet::new(150);
            let mut model = BTreeSet::new();
            for (index, insert) in changes {
                if insert {
                    set.insert(index);
                    model.insert(index);
                } else {
                    set.remove(index);
                    model.remove(&index);
                }
            }
            prop_assert!(set.iter().eq(model.iter().copied()));
            prop_assert_eq!(set.next_from(from), model.range(from..).next().copied());
            prop_assert_eq!(set.last_below(from), model.range(..from).next_back().copied());
            prop_assert_eq!(set.any_in(from..=from + 9), model.range(from..=from + 9).next().is_some());
        }
    }
}
