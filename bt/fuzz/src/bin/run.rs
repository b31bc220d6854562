//! Without coverage, on stable Rust: `cargo run --release --bin run -- 10000000 [SEED]`, in the folder bt/fuzz.
//!
//! Each input depends only on its number and the seed, so an input that fails can be reproduced.

fn main() {
    let mut arguments = std::env::args().skip(1).map(|argument| argument.parse::<u64>());
    let (Some(Ok(count)), seed) = (arguments.next(), arguments.next()) else {
        eprintln!("usage: run COUNT [SEED]");
        std::process::exit(2);
    };
    let seed = seed.and_then(Result::ok).unwrap_or(1);
    for number in 0..count {
        let text = bt_fuzz::text(&mut bt_fuzz::Random::new(seed.wrapping_add(number)));
        let started = std::time::Instant::now();
        if std::panic::catch_unwind(|| bt_fuzz::exercise(&text)).is_err() {
            eprintln!("input {number} of seed {seed} fails:\n{text}");
            std::process::exit(1);
        }
        if started.elapsed().as_secs() > 2 {
            eprintln!("input {number} of seed {seed} takes {:?}:\n{text}", started.elapsed());
            std::process::exit(1);
        }
        if (number + 1) % 1_000_000 == 0 {
            println!("{} inputs", number + 1);
        }
    }
    println!("{count} inputs, no crash, no hang");
}
