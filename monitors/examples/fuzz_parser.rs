//! Feeds the parser broken property files: `cargo run --release -p steward-monitors --example fuzz_parser -- 10000000`.
//!
//! Inputs are the shipped files and others, cut, mixed, repeated and interspersed with tokens and bytes. The parser
//! must terminate on each, its problems must lie inside the text, and accepted text must print and read back as the
//! same tree. An optional second argument is the first seed. This needs no nightly compiler; it exits with 1 at the
//! first failure.

use std::process::ExitCode;
use std::time::Instant;

use monitors::SHIPPED;
use monitors::syntax::parse_file;

/// The tokens to insert.
const WORDS: [&str; 56] = [
    "const",
    "property",
    "true",
    "false",
    "not",
    "next",
    "always",
    "eventually",
    "until",
    "and",
    "or",
    "implies",
    "time_until",
    ":=",
    "=",
    "!=",
    "<",
    "<=",
    ">",
    ">=",
    "(",
    ")",
    "[",
    "]",
    ",",
    ".",
    ";",
    "m[1]",
    "m.level",
    "<ok>",
    "⟨ok⟩",
    "θ",
    "≤",
    "≠",
    "¬",
    "□",
    "◇",
    "→",
    "==",
    "&&",
    "\"text\"",
    "\"",
    "\\",
    "//",
    "\n",
    " ",
    "10",
    "-3",
    "2.5",
    "1e9",
    "30 s",
    "ms",
    "p",
    "alway",
    "propery",
    "\u{0}",
];

/// Pseudo-random numbers that are the same everywhere (SplitMix64).
struct Dice(u64);

impl Dice {
    fn roll(&mut self, sides: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) % sides.max(1) as u64) as usize
    }
}

/// A position in a text at which a character begins.
fn place(dice: &mut Dice, text: &str) -> usize {
    let mut at = dice.roll(text.len() + 1);
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at
}

fn input(dice: &mut Dice) -> String {
    let mut text = match dice.roll(4) {
        0 => (0..dice.roll(60)).map(|_| WORDS[dice.roll(WORDS.len())]).collect::<Vec<_>>().join(" "),
        1 => (0..dice.roll(40)).filter_map(|_| char::from_u32(dice.roll(0x3000) as u32)).collect(),
        _ => SHIPPED[dice.roll(SHIPPED.len())].1.to_owned(),
    };
    for _ in 0..1 + dice.roll(6) {
        let (a, b) = (place(dice, &text), place(dice, &text));
        let (a, b) = (a.min(b), a.max(b));
        match dice.roll(5) {
            0 => text.replace_range(a..b, ""),
            1 => text.insert_str(a, WORDS[dice.roll(WORDS.len())]),
            2 => {
                let piece = text[a..b].to_owned();
                text.insert_str(b, &piece);
            }
            3 => text.insert_str(a, &WORDS[dice.roll(WORDS.len())].repeat(1 + dice.roll(300))),
            _ => {
                let piece = text[a..b].to_owned();
                text.replace_range(a..b, &piece.chars().rev().collect::<String>());
            }
        }
        let mut longest = text.len().min(4_000);
        while !text.is_char_boundary(longest) {
            longest -= 1;
        }
        text.truncate(longest);
    }
    text
}

fn check(text: &str) -> Result<bool, String> {
    let parsed = parse_file(text);
    for problem in &parsed.problems {
        if problem.offset() > text.len() {
            return Err(format!("a problem outside the text: {problem}"));
        }
    }
    if parsed.problems.iter().any(diagnostics::Problem::is_error) {
        return Ok(false);
    }
    let again = parse_file(&parsed.file.to_string());
    if again.file != parsed.file || !again.problems.is_empty() {
        return Err(format!("prints as {:?} and reads back as another tree", parsed.file.to_string()));
    }
    Ok(!parsed.file.items.is_empty())
}

#[expect(
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "a program that is run manually and prints its run time"
)]
fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1).map(|argument| argument.parse::<u64>());
    let inputs = arguments.next().and_then(Result::ok).unwrap_or(100_000);
    let first = arguments.next().and_then(Result::ok).unwrap_or(0);
    let (start, mut accepted) = (Instant::now(), 0_u64);
    for seed in first..first + inputs {
        let text = input(&mut Dice(seed));
        match check(&text) {
            Ok(is_accepted) => accepted += u64::from(is_accepted),
            Err(what) => {
                println!("input {seed}: {what}\n{text:?}");
                return ExitCode::FAILURE;
            }
        }
    }
    println!("{inputs} inputs, {accepted} of them accepted and printed back, {:.0} s", start.elapsed().as_secs_f64());
    ExitCode::SUCCESS
}
