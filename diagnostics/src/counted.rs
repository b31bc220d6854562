//! Counts with their nouns.

use std::fmt::Display;

/// A count with its noun: `1 tick`, `3 ticks`, `2 properties`.
pub fn counted(count: impl Display, noun: &str) -> String {
    let count = count.to_string();
    let plural = || match noun.strip_suffix('y').zip(Some("ies")).or(noun.strip_suffix('f').zip(Some("ves"))) {
        Some((stem, ending)) => format!("{stem}{ending}"),
        None => format!("{noun}s"),
    };
    if count == "1" { format!("1 {noun}") } else { format!("{count} {}", plural()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_is_singular_and_nouns_have_their_plurals() {
        let counts = [counted(1, "run"), counted(0, "run"), counted(2, "property"), counted(3, "leaf")];
        assert_eq!(counts, ["1 run", "0 runs", "2 properties", "3 leaves"]);
    }
}
