use proptest::prelude::*;

use super::*;
use crate::heading;

fn problems(text: &str) -> FileProblems {
    PlacesFile::parse("house.places.toml", text).expect_err("the file is wrong")
}

fn rendered(problems: &FileProblems) -> String {
    let mut text = String::new();
    miette::NarratableReportHandler::new().render_report(&mut text, problems).unwrap();
    text
}

#[test]
fn points_and_areas_are_read_with_their_defaults() {
    let text = "\
[start]
position_m = [1, -2.5]
heading_deg = 180
[dock]
position_m = [0.0, 0.0]
heading_deg = -90
position_tolerance_m = 0.1
heading_tolerance_deg = 45
[kitchen]
corners_m = [[0, 0], [2, 0], [2, 2], [0, 2]]
";
    let places = PlacesFile::parse("p.toml", text).unwrap().into_places();
    let Some(Place::Point { pose, position_tolerance_m, heading_tolerance_rad }) = places.get("start") else {
        panic!("start is a point");
    };
    assert_eq!((pose.translation.x, pose.translation.y, heading(pose)), (1.0, -2.5, std::f64::consts::PI));
    assert_eq!((*position_tolerance_m, *heading_tolerance_rad), (0.3, 6_f64.to_radians()));
    let Some(Place::Point { position_tolerance_m, heading_tolerance_rad, .. }) = places.get("dock") else {
        panic!("dock is a point");
    };
    assert_eq!((*position_tolerance_m, *heading_tolerance_rad), (0.1, std::f64::consts::FRAC_PI_4));
    assert_eq!(places.get("kitchen").unwrap().goal_position(), Point::new(1.0, 1.0));
}

#[test]
fn problems_with_the_position_of_a_place_can_be_reported_later() {
    let file = PlacesFile::parse("p.toml", "[start]\nheading_deg = 0\nposition_m = [1, 2]\n").unwrap();
    let span = file.span("start").unwrap();
    assert_eq!((span.line(), span.text()), (3, "[1, 2]"));
    assert!(file.span("stop").is_none());
}

#[test]
fn all_problems_of_a_places_file_are_reported_at_once() {
    let text = "\
color = \"blue\"

[start]
position_m = [0.0, nan]
heading_deg = 1000

[RechargingStation]
postion_m = [-7.5, 9.0]
heading_deg = 180
position_tolerance_m = -0.5
heading_tolerance = 10

[Destination]
corners_m = [[0.0, 0.0], [2.0, 2.0], [3.0, 0.0], [0.0, 2.5]]
heading_deg = 90

[line]
corners_m = [[0, 0], [1, 1], [3, 3]]

[horseshoe]
corners_m = [[0, 0], [4, 0], [4, 4], [3.5, 4], [3.5, 0.5], [0.5, 0.5], [0.5, 4], [0, 4]]

[nowhere]
";
    insta::assert_snapshot!(rendered(&problems(text)));
}

#[test]
fn syntax_errors_are_reported_at_once() {
    insta::assert_snapshot!(problems("[start\nposition_m = [0 0]\nheading_deg == 3\n\n[a]\n[a]\nb = 'c\n").plain());
}

#[test]
fn keys_with_a_hundred_thousand_dots_are_refused_without_a_crash() {
    let dots = "a.".repeat(100_000) + "b";
    let table = "{ a = ".repeat(100_000);
    for text in
        [format!("{dots} = 1"), format!("[{dots}]\nc = 1"), format!("x = {{ {dots} = 1 }}"), format!("x = {table}")]
    {
        assert!(problems(&text).plain().contains("recurs"));
    }
}

#[test]
fn an_area_with_too_many_corners_is_refused_quickly() {
    let text = format!("[a]\ncorners_m = [{}]", "[1, 2],".repeat(20_000));
    assert_eq!(problems(&text).problems().len(), 1);
}

proptest! {
    #[test]
    fn no_changed_byte_makes_parsing_panic(
        changes in proptest::collection::vec((any::<prop::sample::Index>(), "[\\PC\n\\[\\].='\"{}#,]"), 1..12),
    ) {
        let mut text: Vec<char> = include_str!("../../house.places.toml").chars().collect();
        for (place, change) in changes {
            let place = place.index(text.len());
            text.splice(place..=place, change.chars());
        }
        let text: String = text.into_iter().collect();
        if let Err(problems) = PlacesFile::parse("p.toml", &text) {
            prop_assert!(!rendered(&problems).is_empty());
        }
    }

    #[test]
    fn no_text_makes_parsing_panic(text in "(\\PC|[\n\\[\\].=]){0,80}") {
        let _ = PlacesFile::parse("p.toml", &text);
    }
}

#[test]
fn an_area_can_be_a_zone() {
    let text = "
[Lab]
corners_m = [[0, 0], [4, 0], [4, 4], [3.5, 4], [3.5, 0.5], [0.5, 0.5], [0.5, 4], [0, 4]]
keep_out = true

[Corridor]
corners_m = [[5, 0], [9, 0], [9, 2], [5, 2]]
speed_mps = 0.3

[Hall]
corners_m = [[5, 3], [9, 3], [9, 9], [5, 9]]
";
    let places = PlacesFile::parse("p.toml", text).unwrap().into_places();
    let zones: Vec<_> = places.zones().iter().map(|zone| (&*zone.name, zone.keep_out, zone.speed_mps)).collect();
    assert_eq!(zones, [("Corridor", false, Some(0.3)), ("Lab", true, None)]);
    assert!(places.get("Lab").is_some() && places.get("Hall").is_some());
    let [corridor, lab] = places.zones() else { panic!("two zones") };
    let distances = [(6.0, 1.0), (7.0, 3.5), (2.0, 2.0)].map(|(x, y)| corridor.distance_m(&Point::new(x, y)));
    assert_eq!(distances, [0.0, 1.5, 3.0]);
    assert_eq!(lab.distance_m(&Point::new(2.0, 2.0)), 1.5, "between the arms of the U");
    for (wrong, label) in [
        ("speed_mps = 0", "speed_mps"),
        ("keep_out = 1", "keep_out"),
        ("keep_outt = true", "keep_out"),
        ("position_m = [0, 0]", "position_m"),
    ] {
        let text = format!("[a]\ncorners_m = [[5, 3], [9, 3], [9, 9]]\n{wrong}\n");
        assert!(problems(&text).plain().contains(label), "{wrong}");
    }
    assert!(problems("[a]\nposition_m = [0, 0]\nheading_deg = 0\nkeep_out = true\n").plain().contains("keep_out"));
}

#[test]
fn a_heading_that_looks_like_radians_causes_a_warning() {
    let concerns = |heading: &str| {
        let toml = format!("[a]\nposition_m = [0, 0]\nheading_deg = {heading}\n");
        let ini = format!("Version:\n1\nLocations:\na hall 0 0 {heading}\n");
        let [toml, ini] = [("p.toml", toml), ("p.ini", ini)].map(|(name, text)| {
            let file = PlacesFile::parse(name, &text).unwrap();
            file.concerns().iter().map(|concern| (concern.message().to_owned(), concern.offset())).collect::<Vec<_>>()
        });
        assert_eq!((toml.len(), toml.first().map(|one| &one.0)), (ini.len(), ini.first().map(|one| &one.0)));
        assert!(toml.first().is_none_or(|(_, at)| *at == "[a]\nposition_m = [0, 0]\nheading_deg = ".len()));
        toml.len()
    };
    for heading in ["1.57", "3.14", "3.1416", "0.785", "-1.5708", "0.26", "6.283185", "-2.36", "2.0944"] {
        assert_eq!(concerns(heading), 1, "{heading}");
    }
    for heading in ["0", "0.0", "1", "2", "3", "90", "180", "-45", "1.5", "0.5", "3.1", "22.5", "7.85", "0.05", "1.25"]
    {
        assert_eq!(concerns(heading), 0, "{heading}");
    }
}
