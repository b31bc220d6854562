//! Checks the monitors of random formulas against the definition: `cargo run --release -p steward-monitors --example
//! agree -- 1000000`. The pairs are of seven classes in turn.
//!
//! An optional second argument is the first seed.

#[path = "../tests/support/mod.rs"]
#[expect(dead_code, reason = "shared with the tests")]
mod support;

use std::process::ExitCode;

use support::check::check;
use support::classes::{CLASSES, Topologies};
use support::tally::Tally;

#[expect(clippy::print_stdout, reason = "a program that is run manually")]
fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1).map(|argument| argument.parse::<u64>());
    let pairs = arguments.next().and_then(Result::ok).unwrap_or(10_000);
    let first = arguments.next().and_then(Result::ok).unwrap_or(0);
    let topologies = Topologies::new();
    let mut tallies = CLASSES.map(|class| (class, Tally::default()));
    let seeds = first..first + pairs / CLASSES.len() as u64;
    for seed in seeds.clone() {
        for (class, tally) in &mut tallies {
            let pair = topologies.pair(*class, seed, 12);
            // A verdict is checked on fewer random words than in the tests, and on more pairs.
            if let Err(what) = check(&pair, 5, tally) {
                println!("{class}: {what}\n{pair}");
                return ExitCode::FAILURE;
            }
        }
        if (seed + 1 - first).is_multiple_of(50_000) {
            println!("{} pairs agree …", (seed + 1 - first) * CLASSES.len() as u64);
        }
    }
    for (class, tally) in &tallies {
        println!("{class}: {tally}");
    }
    println!("none of {} verdicts is wrong", tallies.iter().map(|(_, tally)| tally.settled).sum::<u64>());
    ExitCode::SUCCESS
}
