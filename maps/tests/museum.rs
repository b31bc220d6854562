//! The museum's map and places keep the properties that scenarios rely on.

use std::path::Path;

use maps::{ImageFormat, PlacesFile, load_map, map_files, museum, save_map};

fn read(path: &Path) -> std::io::Result<Vec<u8>> {
    std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join(path))
}

#[test]
fn the_committed_map_is_what_the_generator_draws() {
    if std::env::var_os("STEWARD_BLESS").is_some() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(museum::YAML_NAME);
        return save_map(&museum::draw(), &path, ImageFormat::Pgm).unwrap();
    }
    let drawn = map_files(&museum::draw(), "museum.pgm", ImageFormat::Pgm).unwrap();
    let is_committed = |name: &str, content: &[u8]| read(Path::new(name)).unwrap() == content;
    let advice = "run `STEWARD_BLESS=1 cargo test -p steward-maps`";
    let is_up_to_date = is_committed("museum.yaml", drawn.yaml.as_bytes()) && is_committed("museum.pgm", &drawn.image);
    assert!(is_up_to_date, "the map's files are out of date: {advice}");
    assert_eq!(load_map(Path::new(museum::YAML_NAME), &read).unwrap(), museum::draw());
}

#[test]
fn there_is_room_at_every_place() {
    let places = PlacesFile::load(Path::new("museum.places.toml"), &read).unwrap().into_places();
    let map = museum::draw();
    for (name, place) in places.iter() {
        assert!(map.has_room(&place.goal_position(), 0.6), "{name} is cramped");
    }
    assert_eq!(places.iter().count(), 7);
}
