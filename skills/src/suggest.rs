//! What somebody may have meant.

/// `did you mean …?` for the known name nearest to `name`, if one is near enough.
pub(crate) fn did_you_mean<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<String> {
    nearest(name, known).map(|nearest| format!("did you mean `{nearest}`?"))
}

/// The known name nearest to `name`: at most a third of its letters differ.
fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let allowed = (name.chars().count() / 3).max(1);
    let distance = |candidate: &str| strsim::damerau_levenshtein(&name.to_lowercase(), &candidate.to_lowercase());
    let ranked = known.into_iter().map(|candidate| (distance(candidate), candidate));
    ranked.filter(|(distance, _)| *distance <= allowed).min_by_key(|(distance, _)| *distance).map(|(_, name)| name)
}

/// So many names are listed at most.
const MAX_LISTED: usize = 12;

/// The nearest name if there is one, else all of them.
pub(crate) fn nearest_or_all(name: &str, what: &str, known: &[&str]) -> String {
    did_you_mean(name, known.iter().copied()).unwrap_or_else(|| match known {
        [] => format!("there are no {what}"),
        [..] if known.len() <= MAX_LISTED => format!("{what}: {}", known.join(", ")),
        [..] => format!("{what}: {}, …", known[..MAX_LISTED].join(", ")),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_names_are_suggested_and_far_ones_are_not() {
        let known = ["BatteryReader", "Navigation"];
        assert_eq!(nearest("BateryReader", known), Some("BatteryReader"));
        assert_eq!(nearest("navigation", known), Some("Navigation"));
        assert_eq!(nearest("Localization", known), None);
    }
}
