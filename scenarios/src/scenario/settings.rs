//! The settings of robot, world and execution, as their readers declare them, with their values.

use diagnostics::document::{Document, Key};
use recording::SettingGroup;

use super::execution::Execution;
use super::robot::read_sim;
use super::world::{MAP, read_world};

/// The settings of a scenario that are in effect, whether it sets them or not: a group per table.
pub(super) fn in_effect(document: &Document) -> Vec<SettingGroup> {
    let keys = document.in_effect(|root| {
        Execution::read(root);
        if root.has(MAP) {
            read_sim(root);
            read_world(root);
        }
    });
    let row = |key: &Key| {
        let value = key.value.as_deref().unwrap_or_default();
        (key.about.clone(), format!("{} = {value}", key.split().1))
    };
    let groups = keys.chunk_by(|key, next| key.split().0 == next.split().0);
    groups
        .map(|keys| SettingGroup { title: keys[0].split().0.to_owned(), rows: keys.iter().map(row).collect() })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::ScenarioFile;
    use crate::files::Files;

    #[test]
    fn settings_in_effect_are_the_files_its_bases_and_defaults() {
        let text = "base = \"errand\"\n[[people]]\nat = [1, 2]\nfollows = true\n[robot]\nradius_m = 0.25\n";
        let file = ScenarioFile::parse("a.toml", text, &Files::shipped(), ["battery.initial_pct=35"]).unwrap();
        let value = |group: &str, about: &str| {
            let group = file.settings.iter().find(|known| known.title == group);
            let (_, value) = group?.rows.iter().find(|(known, _)| known.starts_with(about))?;
            Some(value.as_str())
        };
        assert_eq!(value("robot", "Radius of the body, in meters"), Some("radius_m = 0.25"));
        assert_eq!(value("robot.docking", "How long the robot must be at rest"), Some("rest_s = 1"));
        assert_eq!(value("battery", "Charge at the start, in percent"), Some("initial_pct = 35"));
        assert_eq!(value("people.0", "With `follows`: the distance"), Some("distance_m = 1.2"));
        assert_eq!(value("people.0", "The points to which"), None);
        assert_eq!(value("execution", "Time between ticks"), Some("tick_s = 1"));
        let mapless = "tree = \"trees/pick.xml\"\nskills = \"skills/pick\"\n";
        let mapless = ScenarioFile::parse("b.toml", mapless, &Files::shipped(), []).unwrap();
        assert_eq!(mapless.settings.iter().map(|group| &*group.title).collect::<Vec<_>>(), ["execution"]);
    }
}
