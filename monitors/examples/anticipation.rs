//! Checks verdicts against endless words: `cargo run --release -p steward-monitors --example anticipation -- 100000`.
//!
//! For each random formula and each prefix of a random sequence, a verdict is checked on hundreds of random endless
//! words. If there is no verdict, the automaton names an endless word for either outcome, and the definition confirms
//! both. This shows that no verdict is wrong or too early; late ones are counted. An optional second argument is the
//! first seed.

#[path = "../tests/support/mod.rs"]
#[expect(dead_code, reason = "shared with the tests")]
mod support;

use std::process::ExitCode;

use support::check::check;
use support::classes::{Class, Topologies};
use support::tally::Tally;

#[expect(clippy::print_stdout, reason = "a program that is run manually")]
fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1).map(|argument| argument.parse::<u64>());
    let formulas = arguments.next().and_then(Result::ok).unwrap_or(10_000);
    let first = arguments.next().and_then(Result::ok).unwrap_or(0);
    let topologies = Topologies::new();
    for class in [Class::Small, Class::Numbers] {
        let mut tally = Tally::default();
        for seed in first..first + formulas / 2 {
            let pair = topologies.pair(class, seed, 7);
            if let Err(what) = check(&pair, 300, &mut tally) {
                println!("{class}: {what}\n{pair}");
                return ExitCode::FAILURE;
            }
        }
        println!("{class}: {tally}; each checked on 300 random endless words");
    }
    ExitCode::SUCCESS
}
