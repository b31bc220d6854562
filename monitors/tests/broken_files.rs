//! The parser reads broken property files.

use monitors::SHIPPED;
use monitors::syntax::parse_file;

use crate::cases::demanded;
use crate::support::Dice;

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

/// A position in a text at which a character begins.
fn place(dice: &mut Dice, text: &str) -> usize {
    let mut at = dice.roll(text.len() as u64 + 1) as usize;
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at
}

fn input(dice: &mut Dice) -> String {
    let mut text = match dice.roll(4) {
        0 => (0..dice.roll(60)).map(|_| *dice.pick(&WORDS)).collect::<Vec<_>>().join(" "),
        1 => (0..dice.roll(40)).filter_map(|_| char::from_u32(dice.roll(0x3000) as u32)).collect(),
        _ => dice.pick(&SHIPPED).1.to_owned(),
    };
    for _ in 0..1 + dice.roll(6) {
        let (a, b) = (place(dice, &text), place(dice, &text));
        let (a, b) = (a.min(b), a.max(b));
        match dice.roll(5) {
            0 => text.replace_range(a..b, ""),
            1 => text.insert_str(a, dice.pick::<&str>(&WORDS)),
            2 => {
                let piece = text[a..b].to_owned();
                text.insert_str(b, &piece);
            }
            3 => text.insert_str(a, &dice.pick(&WORDS).repeat(1 + dice.roll(300) as usize)),
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

/// Inputs are the shipped files and others, cut, mixed, repeated and interspersed with tokens and bytes. The parser
/// must terminate on each, its problems must lie inside the text, and accepted text must print and read back as the
/// same tree.
#[test]
#[ignore = "long: INPUTS=10000000 SEED=0 cargo test --release -p steward-monitors broken_files_on_demand -- --ignored --nocapture"]
fn the_parser_reads_broken_files_on_demand() {
    let (inputs, first) = (demanded("INPUTS", 100_000), demanded("SEED", 0));
    let mut accepted = 0_u64;
    for seed in first..first + inputs {
        let text = input(&mut Dice(seed));
        let is_accepted = check(&text).unwrap_or_else(|what| panic!("input {seed}: {what}\n{text:?}"));
        accepted += u64::from(is_accepted);
    }
    println!("{inputs} inputs, {accepted} of them accepted and printed back");
}
