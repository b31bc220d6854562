//! Results that arrive in any order, taken in the order of the runs.

use std::collections::BTreeMap;

/// Holds results back until those of all earlier runs have arrived.
///
/// It holds as many results as there are ahead of the earliest unfinished run; the code that starts runs limits this by
/// not running too far ahead.
#[derive(Clone, Debug)]
pub struct InOrder<T> {
    next: u64,
    early: BTreeMap<u64, T>,
}

impl<T> InOrder<T> {
    /// An empty queue; `first` is the first run.
    #[must_use]
    pub fn from(first: u64) -> Self {
        Self { next: first, early: BTreeMap::new() }
    }

    /// Adds the result of run `k`. A second result for the same run is an error, and the first one stays.
    pub fn put(&mut self, k: u64, result: T) {
        let fresh = k >= self.next && !self.early.contains_key(&k);
        debug_assert!(fresh, "the result of run {k} arrived twice");
        if fresh {
            self.early.insert(k, result);
        }
    }

    /// The result of the next run with its number, if it has arrived.
    pub fn take(&mut self) -> Option<(u64, T)> {
        let result = self.early.remove(&self.next)?;
        self.next += 1;
        Some((self.next - 1, result))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_come_out_in_the_order_of_the_runs() {
        let mut order = InOrder::from(5);
        order.put(7, 'c');
        order.put(6, 'b');
        assert_eq!((order.take(), order.early.len()), (None, 2));
        order.put(5, 'a');
        let all: Vec<_> = std::iter::from_fn(|| order.take()).collect();
        assert_eq!(all, [(5, 'a'), (6, 'b'), (7, 'c')]);
    }
}
