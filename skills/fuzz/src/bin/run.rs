//! Without coverage, on stable Rust: `cargo run --release --bin run -- 10000000 [SEED]`, in the folder skills/fuzz;
//! with `--features ecmascript`, code for the engine is read and run as well.
//!
//! Each input depends only on its number and the seed, so an input that fails can be reproduced.

use std::time::Instant;

/// An input that takes at least this long counts as a hang.
const HANG_S: u64 = 5;

fn main() {
    let mut arguments = std::env::args().skip(1).map(|argument| argument.parse::<u64>());
    let (Some(Ok(count)), seed) = (arguments.next(), arguments.next()) else {
        eprintln!("usage: run COUNT [SEED]");
        std::process::exit(2);
    };
    let seed = seed.and_then(Result::ok).unwrap_or(1);
    let mut loaded = 0_u64;
    for number in 0..count {
        let text = skills_fuzz::text(seed.wrapping_add(number));
        let started = Instant::now();
        match std::panic::catch_unwind(|| skills_fuzz::exercise(&text)) {
            Ok(ran) if started.elapsed().as_secs() < HANG_S => loaded += u64::from(ran),
            outcome => {
                eprintln!("input {number} of seed {seed}: {:?} in {:?}\n{text}", outcome.is_ok(), started.elapsed());
                std::process::exit(1);
            }
        }
        if (number + 1) % 1_000_000 == 0 {
            println!("{} inputs, {loaded} of them machines", number + 1);
        }
    }
    println!("{count} inputs, {loaded} of them machines; no crash, no hang");
}
