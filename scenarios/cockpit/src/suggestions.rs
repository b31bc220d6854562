//! The initial contents of a fault's form: names of this run, not those of another one.

use diagnostics::document::Referent;
use recording::{Header, Place, RunView, decimals};
use scenarios::faults::{ArgumentDomain, FaultKind, Parameter, Subsystem};
use scenarios::scenario::Scenario;
use toml::{Table, Value};

/// The names in this run that a parameter may have; none if they are not known. Only a session has a scenario.
pub(crate) fn names(
    kind: &FaultKind,
    parameter: &Parameter,
    view: &RunView,
    scenario: Option<&Scenario>,
) -> Vec<String> {
    let header = view.header();
    let ArgumentDomain::Name(what) = parameter.domain else { return Vec::new() };
    match what {
        _ if kind.subsystem == Subsystem::Devices => {
            scenario.and_then(|scenario| scenario.devices_for(kind)).unwrap_or_default()
        }
        Referent::Component => header.components.clone(),
        Referent::Leaf => header.skills.clone(),
        Referent::Laser => header.lasers().iter().map(|laser| laser.name.clone()).collect(),
        Referent::Process => {
            let mut names: Vec<String> = channels(header).flat_map(|ends| ends.map(str::to_owned)).collect();
            names.sort();
            names.dedup();
            names
        }
        _ => Vec::new(),
    }
}

/// The places that a parameter may be, by name: poses in their middle, as the form takes them.
pub(crate) fn places(parameter: &Parameter, view: &RunView) -> Vec<(String, String)> {
    let is_pose = matches!(parameter.domain, ArgumentDomain::Pose);
    let places = view.header().places().iter().filter(|place| is_pose && !place.corners.is_empty());
    let pose = |place: &Place| {
        let sum = |axis: usize| place.corners.iter().map(|corner| corner[axis]).sum::<f64>();
        let [x, y] = [0, 1].map(|axis| decimals(sum(axis) / place.corners.len() as f64, 2));
        (place.name.clone(), format!("[{x}, {y}, 0]"))
    };
    places.map(pose).collect()
}

/// The entries of a fault's form: its example if that has names of this run, and otherwise its numbers and this run's
/// names. Points are picked on the map.
pub(crate) fn entries(kind: &FaultKind, view: &RunView, scenario: Option<&Scenario>) -> Table {
    let example: Table = kind.example.parse().unwrap_or_default();
    let written = |key: &str| example.get(key).and_then(Value::as_str).unwrap_or_default();
    let named = || kind.parameters.iter().map(|parameter| (parameter.name, names(kind, parameter, view, scenario)));
    let mut named = named().filter(|(_, names)| !names.is_empty()).peekable();
    let mut ends = channels(view.header()).filter(|_| example.contains_key("from")).peekable();
    let first_ends = ends.peek().copied();
    let has_channel = first_ends.is_none() || ends.any(|ends| ends == [written("from"), written("to")]);
    let is_of_this_run = has_channel
        && named.peek().is_some()
        && named.all(|(key, names)| names.iter().any(|name| name == written(key)));
    let own = |parameter: &Parameter| match (parameter.name, first_ends) {
        ("from", Some([from, _])) => Some(from.to_owned()),
        ("to", Some([_, to])) => Some(to.to_owned()),
        _ => names(kind, parameter, view, scenario).into_iter().next(),
    };
    let entry = |parameter: &Parameter| match parameter.domain {
        ArgumentDomain::Point | ArgumentDomain::Pose | ArgumentDomain::Points => None,
        ArgumentDomain::Text | ArgumentDomain::Name(_) if !is_of_this_run => own(parameter).map(Value::String),
        _ => example.get(parameter.name).cloned(),
    };
    kind.parameters.iter().filter_map(|parameter| Some((parameter.name.to_owned(), entry(parameter)?))).collect()
}

/// The sender and the receiver of each channel between processes.
fn channels(header: &Header) -> impl Iterator<Item = [&str; 2]> {
    let topology = &header.topology;
    let visible = topology.channels().filter(|channel| !topology.is_internal(*channel));
    visible.map(|channel| <[&str; 2]>::from(topology.ends(channel)))
}

#[cfg(test)]
mod tests {
    use runs::Session;
    use scenarios::faults::KINDS;
    use scenarios::scenario::find;

    use super::*;

    #[test]
    fn forms_contain_only_names_of_this_run() {
        for scenario in ["nominal", "parcel", "errand"] {
            let session = Session::new(&find::find(scenario).unwrap(), &[], None).unwrap();
            let (view, played) = (session.view(), Some(session.scenario()));
            let mut filled = 0;
            for kind in KINDS {
                let entries = entries(kind, view, played);
                for parameter in kind.parameters {
                    let names = names(kind, parameter, view, played);
                    let Some(entry) = entries.get(parameter.name).and_then(Value::as_str) else { continue };
                    assert!(names.is_empty() || names.contains(&entry.to_owned()), "{scenario}: {} {entry}", kind.name);
                    filled += usize::from(!names.is_empty());
                }
                if let (Some(from), Some(to)) = (entries.get("from"), entries.get("to")) {
                    let ends = [from.as_str().unwrap(), to.as_str().unwrap()];
                    assert!(channels(view.header()).any(|known| known == ends), "{scenario}: {ends:?}");
                }
                assert!(!entries.contains_key("at") && !entries.contains_key("route"), "{}", kind.name);
            }
            assert!(filled > 10, "{scenario}: {filled}");
        }
    }

    #[test]
    fn suggestions_are_places_for_poses_and_devices_that_can_suffer() {
        let suggested = |scenario: &str, kind: &str| {
            let session = Session::new(&find::find(scenario).unwrap(), &[], None).unwrap();
            let kind = KINDS.iter().find(|known| known.name == kind).unwrap();
            let [parameter, ..] = kind.parameters else { panic!("it has parameters") };
            let places = places(parameter, session.view()).into_iter().map(|(name, _)| name);
            (names(kind, parameter, session.view(), Some(session.scenario())), places.collect::<Vec<_>>())
        };
        let (names, places) = suggested("nominal", "kidnap");
        assert!(names.is_empty() && places.contains(&"RechargingStation".to_owned()), "{places:?}");
        assert_eq!(suggested("nominal", "box_dropped"), (vec![], vec![]));
        assert_eq!(suggested("parcel", "box_dropped"), (vec!["Tray".to_owned()], vec![]));
    }
}
