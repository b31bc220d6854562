//! The meaning of the locations of monitors.

/// The meaning of a monitor's location, by its name in the monitor's graph; none if the name is self-explanatory, or is
/// not one of ours.
///
/// ```
/// assert_eq!(monitors::location_meaning("C2"), Some("awaits the answer"));
/// assert_eq!(monitors::location_meaning("parked"), None);
/// ```
#[must_use]
pub fn location_meaning(name: &str) -> Option<&'static str> {
    let kind = name.split_once(' ').map_or(name, |(kind, _)| kind);
    let numbered = |letter: char| kind.strip_prefix(letter).is_some_and(|number| number.parse::<usize>().is_ok());
    Some(match kind {
        "I" => "rests",
        "I1" => "is on the way",
        "C1" => "checks a message",
        "S" => "starts the clock",
        "C2" => "awaits the answer",
        "A" => "checks it",
        "K" => "checks whether to start again",
        "T" => "checks the clock",
        _ if numbered('q') => "is undecided",
        _ if numbered('t') => "checks a tick",
        _ if numbered('c') => "checks a message",
        _ => return None,
    })
}
