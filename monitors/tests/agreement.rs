//! Every monitor agrees with the oracle on every prefix of random sequences.

use crate::support::{Dice, Tally, check, random_formula, random_sequence, topology};

#[test]
fn monitors_agree_with_the_oracle_on_ten_thousand_random_pairs() {
    let topology = topology();
    let mut tally = Tally::default();
    for seed in 0..10_000 {
        let mut dice = Dice(seed);
        let depth = 1 + seed as u32 % 3;
        let formula = random_formula(&mut dice, &topology, depth);
        let length = dice.roll(12) as usize;
        let sequence = random_sequence(&mut dice, &topology, length);
        if let Err(what) = check(&formula, &sequence, &topology, &mut tally) {
            panic!("pair {seed}: {what}\n{formula:#?}\n{sequence:#?}");
        }
    }
    assert!(tally.graphs > 200 && tally.automata > 5_000 && tally.settled > 1_000, "{tally:?}");
}
