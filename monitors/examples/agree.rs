//! Checks the monitors of random formulas against the oracle: `cargo run --release -p steward-monitors --example agree
//! -- 1000000`.
//!
//! An optional second argument is the first seed.

#[path = "../tests/support/mod.rs"]
mod support;

use std::process::ExitCode;

use support::{Dice, Tally, check, random_formula, random_sequence, topology};

#[expect(clippy::print_stdout, reason = "a program that is run manually")]
fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1).map(|argument| argument.parse::<u64>());
    let pairs = arguments.next().and_then(Result::ok).unwrap_or(10_000);
    let first = arguments.next().and_then(Result::ok).unwrap_or(0);
    let topology = topology();
    let mut tally = Tally::default();
    for seed in first..first + pairs {
        let mut dice = Dice(seed);
        let depth = 1 + seed as u32 % 3;
        let formula = random_formula(&mut dice, &topology, depth);
        let length = dice.roll(12) as usize;
        let sequence = random_sequence(&mut dice, &topology, length);
        if let Err(what) = check(&formula, &sequence, &topology, &mut tally) {
            println!("pair {seed}: {what}\n{formula:#?}\n{sequence:#?}");
            return ExitCode::FAILURE;
        }
        if (seed + 1 - first).is_multiple_of(100_000) {
            println!("{} pairs: {tally:?}", seed + 1 - first);
        }
    }
    println!("{pairs} pairs agree: {tally:?}");
    ExitCode::SUCCESS
}
