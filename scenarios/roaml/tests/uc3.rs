//! The high-level skills of CONVINCE's use case 3, if `STEWARD_UC3` names a checkout of its repository.

use std::collections::BTreeMap;
use std::path::PathBuf;

use roaml::Machine;

/// The skills that cannot be loaded, with locations and reasons.
const REFUSED: [&str; 2] = [
    "IsAtChargingStationSkill.scxml:84:40: no <ros_service_server> is named `/IsAtCurrentPoiSkill/tick`",
    "IsTimerDoneSkill.scxml:9:33: unknown type `boolean`",
];

#[test]
fn the_museum_guides_skills_load() {
    let Some(folder) = std::env::var_os("STEWARD_UC3").map(PathBuf::from) else {
        eprintln!("not run here: STEWARD_UC3 does not name a checkout of CONVINCE's UC3");
        return;
    };
    let files = std::fs::read_dir(folder.join("model-high-level/Skills")).expect("its skills");
    let mut files: Vec<PathBuf> = files.map(|file| file.expect("a file").path()).collect();
    files.sort();
    let mut refused = Vec::new();
    for file in &files {
        let name = file.file_name().expect("a name").to_string_lossy().into_owned();
        let text = std::fs::read_to_string(file).expect("a text");
        if let Err(problems) = Machine::load(&name, &text, &BTreeMap::new(), &[]) {
            refused.push(problems.first().expect("a problem").one_line());
        }
    }
    assert_eq!((files.len(), refused.len()), (64, REFUSED.len()), "{refused:#?}");
    for (reported, expected) in refused.iter().zip(REFUSED) {
        assert!(reported.starts_with(expected), "{reported}");
    }
}
