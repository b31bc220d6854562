//! Checks verdicts against endless words: `cargo run --release -p steward-monitors --example anticipation -- 100000`.
//!
//! For each random formula and each prefix of a random sequence, a verdict is checked on hundreds of random endless
//! words. If there is no verdict, the automaton names an endless word for either outcome, and the oracle confirms both.
//! This shows that no verdict is wrong or too early; late ones are counted. Beside each formula, another
//! one compares many fields with extreme numbers. An optional second argument is the first seed.

#[path = "../tests/support/mod.rs"]
mod support;

use std::process::ExitCode;

use support::{Dice, Tally, check, check_numbers, numbers, random_formula, random_sequence, topology};

#[expect(clippy::print_stdout, reason = "a program that is run manually")]
fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1).map(|argument| argument.parse::<u64>());
    let formulas = arguments.next().and_then(Result::ok).unwrap_or(10_000);
    let first = arguments.next().and_then(Result::ok).unwrap_or(0);
    let (topology, large) = (topology(), numbers::topology());
    let mut tally = Tally { words: 300, ..Tally::default() };
    for seed in first..first + formulas {
        let mut dice = Dice(seed.wrapping_mul(0x1000_0001));
        let formula = random_formula(&mut dice, &topology, 1 + seed as u32 % 4);
        let length = dice.roll(7) as usize;
        let sequence = random_sequence(&mut dice, &topology, length);
        let agrees = check(&formula, &sequence, &topology, &mut tally)
            .map_err(|what| format!("formula {seed}: {what}\n{}\n{sequence:#?}", formula.text(&topology)))
            .and_then(|()| check_numbers(seed, &large, &mut tally));
        if let Err(what) = agrees {
            println!("{what}");
            return ExitCode::FAILURE;
        }
    }
    println!("{} formulas, {} prefixes: none too early, none wrong", 2 * formulas, tally.prefixes);
    let Tally { graphs, automata, progressions, .. } = tally;
    println!("{graphs} by program graphs, {automata} by automata, {progressions} by progression");
    println!("{} verdicts, each on {} random endless words", tally.settled, tally.words);
    println!("{} outcomes were open because of endless words alone", tally.endless);
    println!("late at {} prefixes with an automaton, at {} with progression instead", tally.delayed, tally.late);
    ExitCode::SUCCESS
}
