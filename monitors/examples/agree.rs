//! Checks the monitors of random formulas against the oracle: `cargo run --release -p steward-monitors --example agree
//! -- 1000000`. Every second pair has many fields and extreme numbers.
//!
//! An optional second argument is the first seed.

#[path = "../tests/support/mod.rs"]
mod support;

use std::process::ExitCode;

use support::{Dice, Tally, check, check_numbers, numbers, random_formula, random_sequence, topology};

#[expect(clippy::print_stdout, reason = "a program that is run manually")]
fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1).map(|argument| argument.parse::<u64>());
    let pairs = arguments.next().and_then(Result::ok).unwrap_or(10_000);
    let first = arguments.next().and_then(Result::ok).unwrap_or(0);
    let (small, large) = (topology(), numbers::topology());
    // A verdict is checked on fewer random words than in the tests, and on more pairs.
    let mut tally = Tally { words: 5, ..Tally::default() };
    for seed in first..first + pairs {
        let agrees = if seed % 2 == 0 {
            let mut dice = Dice(seed);
            let formula = random_formula(&mut dice, &small, 1 + seed as u32 % 3);
            let length = dice.roll(12) as usize;
            let sequence = random_sequence(&mut dice, &small, length);
            let pair = || format!("\n{formula:#?}\n{sequence:#?}");
            check(&formula, &sequence, &small, &mut tally).map_err(|what| format!("pair {seed}: {what}{}", pair()))
        } else {
            check_numbers(seed, &large, &mut tally)
        };
        if let Err(what) = agrees {
            println!("{what}");
            return ExitCode::FAILURE;
        }
        if (seed + 1 - first).is_multiple_of(100_000) {
            println!("{} pairs: {tally:?}", seed + 1 - first);
        }
    }
    println!("{pairs} pairs agree: {tally:?}");
    ExitCode::SUCCESS
}
