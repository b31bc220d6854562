//! The states that were found: each once, in the order in which they were found, in few bytes.
//!
//! A state is a vector of numbers. It is stored as a binary tree: neighbouring numbers form a pair, neighbouring pairs
//! form a pair, and every pair is stored once. So a state costs the one pair at the top, and what two states have in
//! common is stored once (Blom, Lisser, van de Pol, Weber: *A database approach to distributed state-space
//! generation*, 2011).

/// A pair of numbers.
pub(crate) type Pair = u64;

fn pair(left: u32, right: u32) -> Pair {
    u64::from(left) << 32 | u64::from(right)
}

/// A number for a pair.
const NONE: u32 = u32::MAX;

/// Pairs by number.
#[derive(Debug)]
struct Pairs {
    /// In blocks, so that growing copies nothing.
    blocks: Vec<Vec<Pair>>,
    len: u32,
    /// A hash table with open addressing; its length is a power of two.
    places: Vec<u32>,
}

const BLOCK_BITS: u32 = 12;
const BLOCK: usize = 1 << BLOCK_BITS;

impl Default for Pairs {
    fn default() -> Self {
        Self { blocks: Vec::new(), len: 0, places: vec![NONE; 16] }
    }
}

impl Pairs {
    #[inline]
    fn get(&self, number: u32) -> Pair {
        self.blocks[(number >> BLOCK_BITS) as usize][number as usize & (BLOCK - 1)]
    }

    /// Where the pair is in the hash table, or belongs.
    #[inline]
    fn place(&self, pair: Pair) -> usize {
        let mask = self.places.len() - 1;
        let mut place = (mix(pair) as usize) & mask;
        loop {
            let number = self.places[place];
            if number == NONE || self.get(number) == pair {
                return place;
            }
            place = (place + 1) & mask;
        }
    }

    #[inline]
    fn find(&self, pair: Pair) -> Option<u32> {
        let number = self.places[self.place(pair)];
        (number != NONE).then_some(number)
    }

    /// The number of the pair, and whether it is new.
    fn insert(&mut self, pair: Pair) -> (u32, bool) {
        let place = self.place(pair);
        let known = self.places[place];
        if known != NONE {
            return (known, false);
        }
        let number = self.len;
        if number as usize % BLOCK == 0 {
            self.blocks.push(Vec::with_capacity(BLOCK));
        }
        self.blocks[(number >> BLOCK_BITS) as usize].push(pair);
        self.len += 1;
        self.places[place] = number;
        // Seven eighths full at most.
        if self.len as usize * 8 > self.places.len() * 7 {
            self.grow();
        }
        (number, true)
    }

    #[cold]
    fn grow(&mut self) {
        let mask = 2 * self.places.len() - 1;
        self.places = Vec::new();
        let mut places = vec![NONE; mask + 1];
        for number in 0..self.len {
            let mut place = (mix(self.get(number)) as usize) & mask;
            while places[place] != NONE {
                place = (place + 1) & mask;
            }
            places[place] = number;
        }
        self.places = places;
    }

    fn bytes(&self) -> usize {
        self.blocks.len() * BLOCK * size_of::<Pair>() + self.places.len() * size_of::<u32>()
    }
}

/// Spreads the bits of a pair (the finalizer of SplitMix64).
#[inline]
fn mix(pair: Pair) -> u64 {
    let mut bits = pair.wrapping_mul(0x9E37_79B9_7F4A_7C15);
    bits ^= bits >> 32;
    bits = bits.wrapping_mul(0xD6E8_FEB8_6659_FD93);
    bits ^ bits >> 29
}

/// All states that were found.
#[derive(Debug)]
pub(crate) struct Store {
    /// The length of a vector, rounded up to a power of two.
    width: usize,
    /// For each inner node of the tree, with the root at index 1, its pairs.
    nodes: Vec<Pairs>,
}

/// A state with the numbers of all its pairs: node `n` has the children `2n` and `2n + 1`, and the vector's numbers are
/// the last half.
#[derive(Clone, Debug, Default)]
pub(crate) struct Unfolded(Vec<u32>);

impl Unfolded {
    /// The vector of numbers.
    #[inline]
    pub(crate) fn slots(&self) -> &[u32] {
        &self.0[self.0.len() / 2..]
    }
}

/// A slot of a vector and its new number.
pub(crate) type Change = (u32, u32);

/// What a changed state is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lookup {
    /// It is stored already.
    Known,
    /// It is not, but all its parts are.
    New(Pair),
    /// Some of its parts are new as well.
    Unknown,
}

impl Store {
    /// A store for vectors of this length.
    pub(crate) fn new(slots: usize) -> Self {
        let width = slots.next_power_of_two().max(2);
        Self { width, nodes: (0..width).map(|_| Pairs::default()).collect() }
    }

    pub(crate) fn len(&self) -> u32 {
        self.nodes[1].len
    }

    /// How much memory it takes.
    pub(crate) fn bytes(&self) -> usize {
        self.nodes[1..].iter().map(Pairs::bytes).sum()
    }

    /// The state with this number.
    pub(crate) fn unfold(&self, number: u32, state: &mut Unfolded) {
        state.0.resize(2 * self.width, 0);
        state.0[1] = number;
        for node in 1..self.width {
            let pair = self.nodes[node].get(state.0[node]);
            state.0[2 * node] = (pair >> 32) as u32;
            state.0[2 * node + 1] = pair as u32;
        }
    }

    /// Looks up the state that differs from `from` in these slots.
    pub(crate) fn look_up(&self, from: &Unfolded, changes: &[Change], scratch: &mut Scratch) -> Lookup {
        match scratch.fold(from, changes, |node, pair| self.nodes[node].find(pair)) {
            None => Lookup::Unknown,
            Some(top) => self.find(top).map_or(Lookup::New(top), |_| Lookup::Known),
        }
    }

    /// The number of the state with this top, if it is stored.
    pub(crate) fn find(&self, top: Pair) -> Option<u32> {
        self.nodes[1].find(top)
    }

    /// The number of the state that differs from `from` in these slots, if it is stored.
    pub(crate) fn number(&self, from: &Unfolded, changes: &[Change], scratch: &mut Scratch) -> Option<u32> {
        self.find(scratch.fold(from, changes, |node, pair| self.nodes[node].find(pair))?)
    }

    /// Stores the state whose parts are all known already; its number, and whether it is new.
    pub(crate) fn insert_top(&mut self, top: Pair) -> (u32, bool) {
        self.nodes[1].insert(top)
    }

    /// Stores the state that differs from `from` in these slots; its number, and whether it is new.
    pub(crate) fn insert(&mut self, from: &Unfolded, changes: &[Change], scratch: &mut Scratch) -> (u32, bool) {
        let top = scratch.fold(from, changes, |node, pair| Some(self.nodes[node].insert(pair).0));
        self.nodes[1].insert(top.expect("every pair has a number now"))
    }

    /// Stores a vector; its number, and whether it is new.
    pub(crate) fn insert_slots(&mut self, slots: &[u32]) -> (u32, bool) {
        let blank = Unfolded(vec![0; 2 * self.width]);
        let changes: Vec<Change> =
            (0..self.width as u32).map(|slot| (slot, slots.get(slot as usize).copied().unwrap_or(0))).collect();
        self.insert(&blank, &changes, &mut Scratch::default())
    }
}

/// Working memory for changed states.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    state: Vec<u32>,
    level: Vec<u32>,
    above: Vec<u32>,
}

impl Scratch {
    /// The pair at the top of the state that differs from `from` in these slots, given the `number` of each changed
    /// pair below: of a node, and its new pair.
    #[inline]
    fn fold(
        &mut self,
        from: &Unfolded,
        changes: &[Change],
        mut number: impl FnMut(usize, Pair) -> Option<u32>,
    ) -> Option<Pair> {
        let Self { state, level, above } = self;
        state.clone_from(&from.0);
        let width = state.len() / 2;
        level.clear();
        for (slot, value) in changes {
            let leaf = width + *slot as usize;
            state[leaf] = *value;
            push_once(level, leaf as u32 / 2);
        }
        while level.first().is_some_and(|node| *node > 1) {
            above.clear();
            for node in level.iter() {
                let at = *node as usize;
                state[at] = number(at, pair(state[2 * at], state[2 * at + 1]))?;
                push_once(above, node / 2);
            }
            std::mem::swap(level, above);
        }
        Some(pair(state[2], state[3]))
    }
}

fn push_once(nodes: &mut Vec<u32>, node: u32) {
    if !nodes.contains(&node) {
        nodes.push(node);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_state_is_stored_once_and_read_back() {
        let mut store = Store::new(5);
        let mut scratch = Scratch::default();
        let (first, is_new) = store.insert_slots(&[1, 2, 3, 4, 5]);
        assert!(is_new && store.insert_slots(&[1, 2, 3, 4, 5]) == (first, false));
        let mut state = Unfolded::default();
        store.unfold(first, &mut state);
        assert_eq!(store.look_up(&state, &[(1, 2)], &mut scratch), Lookup::Known);
        assert_eq!(store.look_up(&state, &[(1, 7)], &mut scratch), Lookup::Unknown);
        let (second, _) = store.insert(&state, &[(1, 7), (4, 9)], &mut scratch);
        store.unfold(second, &mut state);
        assert_eq!(state.slots()[..5], [1, 7, 3, 4, 9]);
        assert!(matches!(store.look_up(&state, &[(4, 5)], &mut scratch), Lookup::New(_)));
    }

    #[test]
    fn a_hundred_thousand_states_keep_their_numbers() {
        let mut store = Store::new(3);
        let vector = |number: u32| [number % 7, number / 7 % 101, number / 707];
        for number in 0..100_000 {
            assert_eq!(store.insert_slots(&vector(number)), (number, true));
        }
        let mut state = Unfolded::default();
        for number in (0..100_000).rev() {
            assert_eq!(store.insert_slots(&vector(number)), (number, false));
            store.unfold(number, &mut state);
            assert_eq!(state.slots()[..3], vector(number));
        }
    }
}
