use std::collections::BTreeMap;
use std::io;

use diagnostics::{Error, FileProblems, from_disk};
use proptest::prelude::*;

use super::*;
use crate::{Cell, MAX_CELLS, Point};

/// A valid map, for tests to break.
const YAML: &str = "\
image: floor.pgm
resolution: 0.05
origin: [-1.5, 2.0, 0.0]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196
";

const PGM: &[u8] = b"P2 3 2 255\n0 0 254\n205 254 254\n";

/// Loads `map.yaml` from these files, all in one folder.
fn load(files: &[(&str, &[u8])]) -> Result<OccupancyGrid, Error> {
    let files: BTreeMap<_, _> =
        files.iter().map(|(name, content)| (format!("maps/{name}"), content.to_vec())).collect();
    let read = |path: &Path| {
        let content = path.to_str().and_then(|path| files.get(path));
        content.cloned().ok_or_else(|| io::ErrorKind::NotFound.into())
    };
    load_map(Path::new("maps/map.yaml"), &read)
}

fn load_yaml(yaml: &str) -> Result<OccupancyGrid, Error> {
    load(&[("map.yaml", yaml.as_bytes()), ("floor.pgm", PGM)])
}

fn problems(loaded: Result<OccupancyGrid, Error>) -> FileProblems {
    match loaded {
        Err(Error::Problems(problems)) => problems,
        other => panic!("expected problems, got {other:?}"),
    }
}

/// The diagnostics as they appear without a terminal.
fn rendered(problems: &FileProblems) -> String {
    let mut text = String::new();
    miette::NarratableReportHandler::new().render_report(&mut text, problems).unwrap();
    text
}

#[test]
fn a_grid_begins_with_the_bottom_row_of_the_image() {
    use Cell::{Free, Occupied, Unknown};
    let map = load_yaml(YAML).unwrap();
    assert_eq!(map.cells(), [Unknown, Free, Free, Occupied, Occupied, Free]);
    assert_eq!((map.width(), map.height(), map.resolution_m()), (3, 2, 0.05));
    assert_eq!(map.origin(), pose(-1.5, 2.0, 0.0));
}

#[test]
fn yaw_rotates_the_whole_map() {
    let map = load_yaml(&YAML.replace("2.0, 0.0", "2.0, 1.5707963267948966")).unwrap();
    // The image's x axis now points up: column 2 of row 1 lies 2.5 cells above and 1.5 cells left of the origin.
    let center = map.center(crate::CellIndex { column: 2, row: 1 });
    assert!((center - Point::new(-1.5 - 0.075, 2.0 + 0.125)).norm() < 1e-12, "{center}");
}

#[test]
fn keys_of_other_programs_and_yaml_spellings_are_accepted() {
    let yaml = "# from a SLAM program\n%YAML 1.2\n---\n".replace("%YAML 1.2\n", "")
        + &YAML.replace("negate: 0", "negate: no\nmap_id: 7\nlayers: {a: [1, 2]}");
    assert!(load_yaml(&yaml).is_ok());
    assert!(load_yaml(&YAML.replace("negate: 0", "negate: false")).is_ok());
    assert!(load_yaml(&YAML.replace("resolution: 0.05", "resolution: 5e-2")).is_ok());
    assert!(load_yaml(&YAML.replace("floor.pgm", "'floor.pgm'").replace('\n', "\r\n")).is_ok());
    assert!(load_yaml(&format!("\u{feff}{YAML}")).is_ok());
}

#[test]
fn all_problems_of_a_map_are_reported_at_once() {
    let yaml = "\
image: floor.png        # there is no such file
resolutoin: 0.05
origin: [.nan, here, 0.0]
mode: trinery
negate: 2
occupied_thresh: 0.2
free_thresh: 0.65
";
    insta::assert_snapshot!(rendered(&problems(load_yaml(yaml))));
}

#[test]
fn missing_values_and_wrong_types_are_named() {
    insta::assert_snapshot!(problems(load_yaml("")).plain());
    let yaml =
        "image: [floor.pgm]\nresolution: fine\norigin: [0, 0]\nnegate:\noccupied_thresh: '0.65'\nfree_thresh: -1\n";
    insta::assert_snapshot!(problems(load_yaml(yaml)).plain());
    insta::assert_snapshot!(rendered(&problems(load_yaml(""))));
}

#[test]
fn an_unusable_image_is_a_problem_of_the_line_that_names_it() {
    let report = |image: &[u8]| problems(load(&[("map.yaml", YAML.as_bytes()), ("floor.pgm", image)])).plain();
    let huge = format!("P5 {} 2 255\n", MAX_CELLS);
    let reports =
        [b"GIF89a".as_slice(), b"P5 0 2 255\n", b"P5 3 2 255\n123", b"P2 3 2 9\n1 2 3 4 5 x", huge.as_bytes()]
            .map(report);
    insta::assert_snapshot!(reports.concat());
}

#[test]
fn unusable_resolutions_are_refused() {
    let report = |resolution: &str| {
        problems(load_yaml(&YAML.replace("resolution: 0.05", &format!("resolution: {resolution}")))).plain()
    };
    insta::assert_snapshot!(["0", "-0.05", ".nan", ".inf", "1e-9", "5000"].map(report).concat());
}

#[test]
fn text_that_is_not_a_yaml_mapping_is_refused() {
    let report = |yaml: &str| problems(load_yaml(yaml)).plain();
    let twice = YAML.to_owned() + "negate: 1\n";
    let deep = "[".repeat(300);
    let long = "#".repeat(20_000);
    let documents = YAML.to_owned() + "---\nimage: b\n";
    let reports = ["- image\n- resolution\n", "image: \"floor", &twice, &deep, &long, &documents].map(report);
    insta::assert_snapshot!(reports.concat());
}

#[test]
fn deep_nesting_is_refused_without_a_crash() {
    for nest in ["- ", "? ", "- ? ", "? - ", "-\t", "[", "{", "{a: [", "&a - ", "a:\n "] {
        let yaml = nest.repeat(16 * 1024 / nest.len());
        assert!(!problems(load_yaml(&yaml)).problems().is_empty(), "{nest}");
    }
    let steps: String = (0..170).map(|step| " ".repeat(step) + "-\n").collect();
    for nest in [steps.clone(), steps + &" ".repeat(170) + &"- ".repeat(60) + &"[".repeat(250) + &"]".repeat(250)] {
        assert!(!problems(load_yaml(&nest)).problems().is_empty());
    }
}

#[test]
fn a_file_that_is_not_text_is_refused_with_the_position() {
    let report = problems(load(&[("map.yaml", b"image: fl\xffoor.pgm\n")])).plain();
    assert_eq!(report, "maps/map.yaml:1:10: the file is not UTF-8 text\n");
}

#[test]
fn a_missing_yaml_file_is_a_read_error() {
    assert!(matches!(load(&[]), Err(Error::Read { .. })));
}

#[test]
fn saved_maps_are_pairs_of_files() {
    let folder = tempfile::tempdir().unwrap();
    let map = load_yaml(YAML).unwrap();
    for (name, format) in [("a.yaml", ImageFormat::Pgm), ("my \"map\".v2.yaml", ImageFormat::Png)] {
        let path = folder.path().join(name);
        save_map(&map, &path, format).unwrap();
        assert_eq!(load_map(&path, &from_disk).unwrap(), map);
    }
    let nowhere = folder.path().join("a.yaml/folder.yaml");
    let saved = save_map(&map, &nowhere, ImageFormat::Pgm);
    assert!(matches!(saved, Err(crate::Error::File(Error::Write { .. }))));
}

#[test]
fn a_map_without_cells_is_not_saved() {
    let empty = OccupancyGrid::new(0, 4, 0.05, pose(0.0, 0.0, 0.0));
    assert!(matches!(map_files(&empty, "a.pgm", ImageFormat::Pgm), Err(crate::Error::UnsavableSize { .. })));
}

/// A color image means what its shades mean, as in ROS.
#[test]
fn the_cells_do_not_depend_on_the_kind_of_image() {
    let gray = load_yaml(YAML).unwrap();
    let shades = [0_u8, 0, 254, 205, 254, 254];
    let raw = [b"P6 3 2 255\n".as_slice(), shades.map(|shade| [shade; 3]).as_flattened()].concat();
    // The rows of a BMP begin with the lowest, in blue, green and red, and are filled up to a multiple of four bytes.
    let mut bmp = [b"BM".as_slice(), &78_u32.to_le_bytes(), &[0; 4], &54_u32.to_le_bytes()].concat();
    bmp.extend([40_u32, 3, 2, 24 << 16 | 1, 0, 24, 0, 0, 0, 0].map(u32::to_le_bytes).as_flattened());
    for row in [&shades[3..], &shades[..3]] {
        bmp.extend(row.iter().flat_map(|shade| [*shade; 3]).chain([0; 3]));
    }
    for image in [raw, bmp] {
        assert_eq!(load(&[("map.yaml", YAML.as_bytes()), ("floor.pgm", &image)]).unwrap(), gray);
    }
}

fn any_cell() -> impl Strategy<Value = Cell> {
    prop_oneof![Just(Cell::Free), Just(Cell::Occupied), Just(Cell::Unknown)]
}

fn any_grid() -> impl Strategy<Value = OccupancyGrid> {
    let size = (1_usize..20, 1_usize..20, 0.001..2.0, -1e3..1e3, -1e3..1e3, -3.1..3.1);
    size.prop_flat_map(|(width, height, resolution_m, x_m, y_m, yaw_rad)| {
        let cells = proptest::collection::vec(any_cell(), width * height);
        let origin = pose(x_m, y_m, yaw_rad);
        cells.prop_map(move |cells| OccupancyGrid::from_cells(width, height, resolution_m, origin, cells))
    })
}

proptest! {
    #[test]
    fn a_saved_map_loads_back_equal(grid in any_grid(), png in any::<bool>(), name in "\\PC{1,12}") {
        let format = if png { ImageFormat::Png } else { ImageFormat::Pgm };
        let name = name.replace('/', "_");
        let files = map_files(&grid, &name, format).unwrap();
        let loaded = load(&[("map.yaml", files.yaml.as_bytes()), (&name, &files.image)]).unwrap();
        prop_assert_eq!(loaded.cells(), grid.cells());
        prop_assert_eq!((loaded.width(), loaded.resolution_m()), (grid.width(), grid.resolution_m()));
        prop_assert_eq!(loaded.origin().translation, grid.origin().translation);
        prop_assert!(loaded.origin().rotation.angle_to(&grid.origin().rotation).abs() < 1e-15);
    }

    #[test]
    fn no_changed_byte_makes_loading_panic(
        png in any::<bool>(),
        changes in proptest::collection::vec((any::<bool>(), any::<prop::sample::Index>(), any::<u8>()), 1..8),
        cut in any::<prop::sample::Index>(),
    ) {
        let grid = load_yaml(YAML).unwrap();
        let format = if png { ImageFormat::Png } else { ImageFormat::Pgm };
        let files = map_files(&grid, "floor.pgm", format).unwrap();
        let (mut yaml, mut image) = (files.yaml.into_bytes(), files.image);
        for (in_yaml, place, byte) in changes {
            let bytes = if in_yaml { &mut yaml } else { &mut image };
            let place = place.index(bytes.len());
            bytes[place] = byte;
        }
        let whole = image.len();
        for image in [&image[..cut.index(whole)], &image] {
            if let Err(Error::Problems(problems)) = load(&[("map.yaml", &yaml), ("floor.pgm", image)]) {
                prop_assert!(!rendered(&problems).is_empty());
            }
        }
    }

    #[test]
    fn no_bytes_make_loading_panic(yaml in "\\PC{0,80}", image in proptest::collection::vec(any::<u8>(), 0..60)) {
        let magic = [b"P5 ".as_slice(), &image].concat();
        let _ = load(&[("map.yaml", yaml.as_bytes()), ("floor.pgm", &magic)]);
        let _ = load(&[("map.yaml", YAML.as_bytes()), ("floor.pgm", &magic)]);
    }
}

#[test]
fn numbers_in_quotes_and_modes_in_capitals_are_read_as_nav2_reads_them() {
    let plain = load_yaml(YAML).unwrap();
    let quoted = YAML
        .replace("0.05", "\"0.05\"")
        .replace("[-1.5, 2.0, 0.0]", "['-1.5', 2.0, '0.0']")
        .replace("negate: 0", "negate: '0'")
        .replace("0.65", "'0.65'")
        .replace("0.196", "\"0.196\"");
    assert_eq!(load_yaml(&quoted).unwrap(), plain);
    for mode in ["Trinary", "TRINARY", "trinary"] {
        assert_eq!(load_yaml(&format!("{YAML}mode: {mode}\n")).unwrap(), plain);
    }
    for wrong in ["resolution: 'five'", "resolution: '0,05'", "resolution: '-1'", "resolution: 'NaN'"] {
        assert!(load_yaml(&YAML.replace("resolution: 0.05", wrong)).is_err(), "{wrong}");
    }
    assert!(load_yaml(&format!("{YAML}mode: trinity\n")).is_err());
}

#[test]
fn a_map_that_newer_releases_of_nav2_read_differently_causes_a_warning() {
    let concerns = |yaml: &str, image: &[u8]| {
        let read = |path: &Path| match path.extension() {
            Some(ending) if ending == "yaml" => Ok(yaml.as_bytes().to_vec()),
            _ => Ok(image.to_vec()),
        };
        let (_, concerns) = load_map_with_concerns(Path::new("map.yaml"), &read).unwrap();
        assert!(!concerns.iter().any(Problem::is_error));
        concerns.iter().map(Problem::one_line).collect::<Vec<_>>()
    };
    let none: [&str; 0] = [];
    assert_eq!(concerns(YAML, PGM), none);
    // A BMP of 32 bits with a mask for alpha: unknown floor, opaque.
    let bitmap = |alpha_mask: u32| {
        let mut bmp = [b"BM".as_slice(), &154_u32.to_le_bytes(), &[0; 4], &122_u32.to_le_bytes()].concat();
        let fields = [108, 4, 2, 32 << 16 | 1, 3, 32, 0, 0, 0, 0, 0x00ff_0000, 0xff00, 0xff, alpha_mask];
        bmp.extend(fields.map(u32::to_le_bytes).as_flattened());
        bmp.extend([0; 52]);
        bmp.extend([[205, 205, 205, 255]; 8].as_flattened());
        bmp
    };
    assert_eq!(concerns(YAML, &bitmap(0)), none);
    let [warning] = &concerns(YAML, &bitmap(0xff00_0000))[..] else { panic!("one warning") };
    let wanted = "map.yaml:1:8: 8 cells are free in ROS 1 and in Nav2 up to Jazzy 1.3.6, but unknown in later releases";
    assert!(warning.starts_with(wanted) && warning.contains("save the image without alpha"), "{warning}");
    let wide = YAML.replace("0.65", "1.0").replace("0.196", "0.0");
    let [occupied] = &concerns(&wide, PGM)[..] else { panic!("one warning") };
    assert!(occupied.contains("2 cells are unknown") && occupied.contains("choose thresholds"), "{occupied}");
    let [scattered] = &concerns(&wide, b"P2 3 2 255\n0 254 0\n0 254 0\n")[..] else { panic!("one warning") };
    assert!(scattered.contains("4 cells are unknown"), "{scattered}");
    assert_eq!(concerns(&wide.replace("1.0", "0.99"), PGM), none);
}
