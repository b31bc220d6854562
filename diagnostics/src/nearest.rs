//! Suggestions for misspelled names.

/// Names longer than this, in bytes, are not compared, nor are more than ten times as many names: comparing very many
/// would take too long.
const LONGEST: usize = 100;
const COMPARED: usize = 1000;

/// More names than this are not listed.
const LISTED: usize = 20;

/// At most this many problems of a file get a hint, because each hint compares all names.
pub const MAX_HINTS: usize = 200;

/// The known name that `name` was most likely meant to be: the one with the fewest typing errors, if these affect at
/// most a third of the name's letters. Case does not matter; of equally near names, the first is chosen.
///
/// Names of more than 100 bytes are not compared, and at most 1000 names are.
#[must_use]
pub fn nearest<'k>(name: &str, known: impl IntoIterator<Item = &'k str>) -> Option<&'k str> {
    if name.len() > LONGEST {
        return None;
    }
    let allowed = (name.chars().count() / 3).max(1);
    let name = name.to_lowercase();
    let distance = |known: &str| strsim::damerau_levenshtein(&name, &known.to_lowercase());
    let known = known.into_iter().take(COMPARED).filter(|known| known.len() <= LONGEST);
    let ranked = known.map(|known| (distance(known), known)).filter(|(distance, _)| *distance <= allowed);
    ranked.min_by_key(|(distance, _)| *distance).map(|(_, known)| known)
}

/// `did you mean …?` for the [`nearest`] name, if there is one.
#[must_use]
pub fn did_you_mean<'k>(name: &str, known: impl IntoIterator<Item = &'k str>) -> Option<String> {
    nearest(name, known).map(|nearest| format!("did you mean `{nearest}`?"))
}

/// `did you mean …?` for the [`nearest`] name, or otherwise a list of the known names (`what`), truncated if it is
/// long.
#[must_use]
pub fn nearest_or_all(name: &str, what: &str, known: &[&str]) -> String {
    did_you_mean(name, known.iter().copied()).unwrap_or_else(|| match known {
        [] => format!("there are no {what}"),
        _ => {
            let more = known.len().saturating_sub(LISTED);
            let more = if more > 0 { format!(" and {more} more") } else { String::new() };
            format!("{what}: {}{more}", known[..known.len().min(LISTED)].join(", "))
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn very_long_names_are_not_compared() {
        let long = "n".repeat(1_000_000);
        assert_eq!(nearest(&long, [long.as_str()]), None);
        assert_eq!(nearest("nn", [long.as_str(), "n"]), Some("n"));
    }

    #[test]
    fn near_names_are_suggested_and_distant_ones_are_not() {
        let known = ["BatteryReader", "Navigation"];
        assert_eq!(nearest("BateryReader", known), Some("BatteryReader"));
        assert_eq!(nearest("navigation", known), Some("Navigation"));
        assert_eq!(nearest("Localization", known), None);
        assert_eq!(nearest("abcd", ["abxy"]), None);
        assert_eq!(nearest("bat", ["cat", "bet"]), Some("cat"));
    }

    #[test]
    fn without_a_near_name_all_names_are_listed() {
        assert_eq!(nearest_or_all("aa", "names", &["ab", "b"]), "did you mean `ab`?");
        assert_eq!(nearest_or_all("x", "names", &[]), "there are no names");
        assert_eq!(nearest_or_all("zzz", "names", &["a", "b"]), "names: a, b");
        let many: Vec<String> = (0..30).map(|n| format!("n{n}")).collect();
        let many: Vec<&str> = many.iter().map(String::as_str).collect();
        assert!(nearest_or_all("zzzzzz", "names", &many).ends_with(", n18, n19 and 10 more"));
    }
}
