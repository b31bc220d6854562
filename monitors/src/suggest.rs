//! What somebody may have meant.

/// The known name nearest to `name`: at most a third of its letters differ.
pub(crate) fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let allowed = (name.chars().count() / 3).max(1);
    let distance = |candidate: &str| strsim::damerau_levenshtein(&name.to_lowercase(), &candidate.to_lowercase());
    let ranked = known.into_iter().map(|candidate| (distance(candidate), candidate));
    ranked.filter(|(distance, _)| *distance <= allowed).min_by_key(|(distance, _)| *distance).map(|(_, name)| name)
}

/// `did you mean …?` for the nearest name if there is one, else the list of all of them.
pub(crate) fn nearest_or_all(name: &str, what: &str, known: &[&str]) -> String {
    match (nearest(name, known.iter().copied()), known) {
        (Some(nearest), _) => format!("did you mean `{nearest}`?"),
        (None, []) => format!("there are no {what}"),
        (None, _) => format!("{what}: {}", known.join(", ")),
    }
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
        assert_eq!(nearest("abcd", ["abxy"]), None);
        assert_eq!(nearest_or_all("x", "names", &[]), "there are no names");
        assert_eq!(nearest_or_all("zzz", "names", &["a", "b"]), "names: a, b");
    }
}
