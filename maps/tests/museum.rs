//! The museum's map and places keep the properties that scenarios rely on.

mod plan;

use std::path::Path;

use diagnostics::from_disk;
use maps::{PlacesFile, load_map};

use plan::MUSEUM;

#[test]
fn the_committed_map_is_what_the_generator_draws() {
    MUSEUM.compare_files("museum");
}

#[test]
fn there_is_room_at_every_place() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let places = PlacesFile::load(&folder.join("museum.places.toml"), &from_disk).unwrap().into_places();
    let map = load_map(&folder.join("museum.yaml"), &from_disk).unwrap();
    for (name, place) in places.iter() {
        assert!(map.has_room(&place.goal_position(), 0.6), "{name} is cramped");
    }
    assert_eq!(places.iter().count(), 7);
}
