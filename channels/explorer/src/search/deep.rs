//! The search depth first: the state that was found last is expanded next.

use super::{BATCH, End, Expansions, Scratch, Search};
use crate::Progress;
use crate::error::Refused;

impl Search<'_> {
    /// Searches depth first, on a single thread. It remembers from which state each state was found.
    pub(super) fn run_deep(&mut self, progress: &mut dyn FnMut(&Progress)) -> Result<End, Refused> {
        let (mut scratch, mut expansions) = (Scratch::default(), Expansions::default());
        let mut open = vec![(0, 0)];
        let mut origins = vec![0];
        let mut expanded = 0;
        while let Some((number, depth)) = open.pop() {
            self.complete(number, &mut scratch, &mut expansions)?;
            let mut next = number;
            let end = self.take_in(&mut next, &expansions, &mut scratch)?;
            let new = origins.len() as u32..self.store.len();
            origins.resize(self.store.len() as usize, number);
            self.deepest = self.deepest.max(depth);
            if let Some(end) = end {
                self.origins = Some(origins);
                return Ok(end);
            }
            // The successor that was found first is expanded first.
            open.extend(new.rev().map(|found| (found, depth + 1)));
            expanded += 1;
            if expanded % BATCH == 0 {
                let mut now = self.progress();
                now.memory += 4 * origins.capacity() + 16 * open.capacity();
                progress(&now);
                if let Some(limit) = self.reached(&now).filter(|_| !open.is_empty()) {
                    self.origins = Some(origins);
                    return Ok(End::Incomplete(limit));
                }
            }
        }
        // Without a violation, there may be a run in which messages pile up.
        self.origins = Some(origins);
        Ok(End::Complete)
    }
}
