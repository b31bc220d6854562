//! Compares proofs about random systems with enumerations of their runs: `cargo run --release -p steward-monitors
//! --example prove -- 10000`. An optional second argument is the first seed.

#[path = "../tests/support/mod.rs"]
#[expect(dead_code, reason = "shared with the tests")]
mod support;

use std::process::ExitCode;

use support::classes::Topologies;
use support::proofs::{Proofs, check_proof};

#[expect(clippy::print_stdout, reason = "a program that is run manually")]
fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1).map(|argument| argument.parse::<u64>());
    let systems = arguments.next().and_then(Result::ok).unwrap_or(1_000);
    let first = arguments.next().and_then(Result::ok).unwrap_or(0);
    let topologies = Topologies::new();
    let mut proofs = Proofs::default();
    for seed in first..first + systems {
        if let Err(what) = check_proof(&topologies, seed, 5_000, &mut proofs) {
            println!("{what}");
            return ExitCode::FAILURE;
        }
        if (seed + 1 - first).is_multiple_of(1_000) {
            println!("{} systems: {proofs}", seed + 1 - first);
        }
    }
    println!("{systems} systems: {proofs}; none wrong");
    ExitCode::SUCCESS
}
