//! Without coverage, on stable Rust: `cargo run --release --bin run -- load 10000000 [SEED]`, in the folder bt/fuzz;
//! for `load`, also `log`, `groot_client` or `groot_server`.
//!
//! Each input depends only on its number and the seed, so an input that fails can be reproduced.

use bt_fuzz::{Random, groot_client, groot_server, log};

type RandomInput = fn(&mut Random) -> Vec<u8>;
type Exercise = fn(&[u8]);

fn main() {
    let mut arguments = std::env::args().skip(1);
    let (input, exercise): (RandomInput, Exercise) = match arguments.next().as_deref() {
        Some("load") => {
            (|random| bt_fuzz::text(random).into_bytes(), |bytes| bt_fuzz::exercise(&String::from_utf8_lossy(bytes)))
        }
        Some("log") => (log::bytes, log::exercise),
        Some("groot_client") => (groot_client::bytes, groot_client::exercise),
        Some("groot_server") => (groot_server::bytes, groot_server::exercise),
        _ => usage(),
    };
    let mut numbers = arguments.map(|argument| argument.parse::<u64>());
    let (Some(Ok(count)), seed) = (numbers.next(), numbers.next()) else { usage() };
    let seed = seed.and_then(Result::ok).unwrap_or(1);
    for number in 0..count {
        let bytes = input(&mut Random::new(seed.wrapping_add(number)));
        let started = std::time::Instant::now();
        if std::panic::catch_unwind(|| exercise(&bytes)).is_err() {
            eprintln!("input {number} of seed {seed} fails:\n{}", shown(&bytes));
            std::process::exit(1);
        }
        if started.elapsed().as_secs() > 2 {
            eprintln!("input {number} of seed {seed} takes {:?}:\n{}", started.elapsed(), shown(&bytes));
            std::process::exit(1);
        }
        if (number + 1) % 1_000_000 == 0 {
            println!("{} inputs", number + 1);
        }
    }
    println!("{count} inputs, no crash, no hang");
}

/// As text, if it is text.
fn shown(bytes: &[u8]) -> String {
    std::str::from_utf8(bytes).map_or_else(|_| bytes.escape_ascii().to_string(), str::to_owned)
}

fn usage() -> ! {
    eprintln!("usage: run load|log|groot_client|groot_server COUNT [SEED]");
    std::process::exit(2);
}
