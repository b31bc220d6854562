//! What rooms must not use, and why: ARCHITECTURE.md has these rules as a table.

use super::rooms::Rooms;

/// A rule about rooms. Together with its reason it is a row of the table.
pub(super) enum Never {
    /// None of these rooms uses any of those, directly or through others.
    Reach(Names, Names),
    /// These rooms use no others than those, directly or through others.
    ReachOthersThan(Names, Names),
    /// Only these rooms depend on those packages directly, and each of them does.
    DependUnless(Names, Names),
}

/// Names of rooms, or of other packages, as the code uses them.
type Names = &'static [&'static str];

use Never::{DependUnless, Reach, ReachOthersThan};

pub(super) const RULES: &[(Never, &str)] = &[
    (ReachOthersThan(&["batch", "channels", "diagnostics", "rasters"], &[]), "each can be used and tested alone"),
    (ReachOthersThan(&["explorer"], &["channels"]), "a proof rests on the rules of channel systems alone"),
    (
        ReachOthersThan(&["bt", "monitors", "skills"], &["channels", "diagnostics"]),
        "they know no robot and not each other",
    ),
    (ReachOthersThan(&["ros_messages"], &["diagnostics"]), "messages are read without ROS and without channels"),
    (ReachOthersThan(&["drawing"], &["diagnostics", "maps", "rasters"]), "a picture is made of plain data"),
    (Reach(&["nav"], &["channels", "sim"]), "it serves any robot, and never sees the truth"),
    (Reach(&["sim"], &["channels", "components", "nav"]), "it stands in for hardware, whatever drives it"),
    (Reach(&["replay"], &["nav", "sim"]), "what a robot has sent does not depend on what is done with it"),
    (Reach(&["devices", "interfaces", "programs", "remote"], &["network", "robot"]), "the world is exchangeable"),
    (
        Reach(&["bags", "groot", "network", "replay", "tree_logs"], &["monitors", "recording"]),
        "a source judges nothing",
    ),
    (Reach(&["recording", "reports"], &["nav", "runs", "scenarios", "sim", "skills"]), "pages are made from records"),
    (Reach(&["proofs", "runs", "scenarios"], &["drawing", "network"]), "a run draws nothing and opens no socket"),
    (Reach(&["checks"], &["cockpit", "editor", "network"]), "files are checked without an editor and without a robot"),
    (Reach(&["judging"], &["cockpit", "network"]), "it judges what any source gives"),
    (Reach(&["trials"], &["bt", "monitors", "scenarios", "skills"]), "navigation is measured without a tree"),
    (Reach(&["partners"], &["campaigns", "cockpit", "reports"]), "what takes part in a run does not show it"),
    (DependUnless(&["runs", "scenarios", "trials"], &["sim"]), "the others see a robot or its records"),
    (
        DependUnless(&["steward"], &["cockpit", "judging", "language_server", "partners", "proofs", "trials"]),
        "each serves commands",
    ),
    (DependUnless(&["language_server"], &["editor"]), "files are checked and judged without an editor"),
    (DependUnless(&["judging", "steward"], &["groot"]), "trees do not depend on who shows them"),
    (DependUnless(&["partners", "steward"], &["network"]), "the others know no middleware"),
    (DependUnless(&["network"], &["rustdds"]), "DDS runs in a process of its own"),
];

impl Never {
    /// The rule as a sentence in Markdown.
    pub(super) fn sentence(&self) -> String {
        match *self {
            Reach(rooms, others) => {
                format!("{} never {} {}", listed(rooms, "and"), reach(rooms), listed(others, "or"))
            }
            ReachOthersThan(rooms, others) => {
                let but = if others.is_empty() { String::new() } else { format!(" but {}", listed(others, "and")) };
                format!("{} {} no room{but}", listed(rooms, "and"), reach(rooms))
            }
            DependUnless(rooms, packages) => {
                let depend = if rooms.len() == 1 { "depends" } else { "depend" };
                format!("only {} {depend} on {}", listed(rooms, "and"), listed(packages, "or"))
            }
        }
    }

    /// The dependencies that break the rule, and those that it names but that do not exist.
    fn breaches(&self, rooms: &Rooms) -> Vec<String> {
        let mut breaches = Vec::new();
        match *self {
            Reach(from, others) | ReachOthersThan(from, others) => {
                let is_never = matches!(self, Reach(..));
                for room in from {
                    let reached = rooms.reached(room).into_iter();
                    let wrong = reached.filter(|reached| others.contains(reached) == is_never);
                    breaches.extend(wrong.map(|reached| format!("{room} reaches {reached}")));
                }
            }
            DependUnless(users, packages) => {
                for package in packages {
                    let found = rooms.users(package);
                    if found != users {
                        breaches.push(format!("{found:?} depend on {package}"));
                    }
                }
            }
        }
        breaches
    }

    /// The rooms that the rule names.
    fn rooms(&self) -> Vec<&'static str> {
        match *self {
            Reach(rooms, others) | ReachOthersThan(rooms, others) => [rooms, others].concat(),
            DependUnless(rooms, _) => rooms.to_vec(),
        }
    }
}

fn reach(rooms: Names) -> &'static str {
    if rooms.len() == 1 { "reaches" } else { "reach" }
}

/// Names in a sentence: `a`, `b` and `c`.
fn listed(names: Names, conjunction: &str) -> String {
    let names: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    match &names[..] {
        [] => String::new(),
        [name] => name.clone(),
        [others @ .., last] => format!("{} {conjunction} {last}", others.join(", ")),
    }
}

#[test]
fn no_room_reaches_what_it_must_not() {
    let rooms = Rooms::read();
    for (never, reason) in RULES {
        let sentence = never.sentence();
        assert!(never.rooms().iter().all(|room| rooms.contains(room)), "an unknown room: {sentence}");
        let breaches = never.breaches(&rooms);
        assert!(breaches.is_empty(), "{sentence}, since {reason}: {breaches:#?}");
    }
}
