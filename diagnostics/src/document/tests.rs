use std::time::Duration;

use proptest::prelude::*;
use serde_json::json;

use super::*;
use crate::{Problem, Span, Spanned};

const SCENARIO: &str = "\
name = \"nominal\"
duration_s = 1.5
seed = 7

[battery]
charge_pct = 80

[[faults]]
kind = \"battery\"
charge_pct = 10

[[faults]]
kind = \"drop\"
";

#[derive(Clone, Debug, PartialEq)]
struct Scenario {
    name: String,
    duration: Duration,
    seed: u64,
    charge_pct: f64,
    record: bool,
    faults: Vec<(FaultKind, Option<f64>)>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum FaultKind {
    Battery,
    Drop,
}

fn read(root: Table<'_>) -> Option<Scenario> {
    let name = root.text("name").required();
    let duration = root.seconds("duration_s").required();
    let seed = root.get("seed").or(0);
    let record = root.boolean("record").or(false);
    let battery = root.table("battery");
    let charge_pct = battery.and_then(|battery| battery.number("charge_pct").within(0.0..=100.0).required()).required();
    let faults = root.tables("faults").each(read_fault).or(Vec::new());
    Some(Scenario { name: name?, duration: duration?, seed, charge_pct: charge_pct?, record, faults })
}

fn read_fault(fault: Table<'_>) -> Option<(FaultKind, Option<f64>)> {
    let kind = fault.one_of("kind", &[("battery", FaultKind::Battery), ("drop", FaultKind::Drop)]).required();
    let charge_pct = fault.number("charge_pct").optional();
    Some((kind?, charge_pct))
}

fn load(text: &str, overrides: &[&str]) -> Result<Scenario, FileProblems> {
    let mut document = Document::parse_toml("nominal.toml", text)?;
    document.override_with(overrides.iter().copied())?;
    document.read(read)
}

#[test]
fn typed_values_arrive() {
    let scenario = load(SCENARIO, &[]).unwrap();
    assert_eq!(
        scenario,
        Scenario {
            name: "nominal".into(),
            duration: Duration::from_millis(1500),
            seed: 7,
            charge_pct: 80.0,
            record: false,
            faults: vec![(FaultKind::Battery, Some(10.0)), (FaultKind::Drop, None)],
        }
    );
}

#[test]
fn everything_wrong_is_reported_in_the_order_of_the_file() {
    let text = "\
name = 3
duration_s = -1
sead = 7
record = \"yes\"

[battery]
charge_percent = 80

[[faults]]
kind = \"batery\"
charge_pct = [10]

[[faults]]
charge_pct = 120
when = 3

[robot]
radius_m = 3
";
    insta::assert_snapshot!(load(text, &[]).unwrap_err().plain());
}

#[test]
fn a_text_that_is_not_toml_is_refused_with_advice() {
    let texts = [
        "key",
        "key: 1",
        "key =",
        "key = office",
        "key = my office",
        "key = True",
        "key = \"office",
        "key = office\"",
        "key = \"C:\\maps\"",
        "key = 01",
        "key = 1.2.3",
        "key = 1 other = 2",
        "key = [1 2]",
        "key = [1, 2",
        "key = { a = 1 b = 2 }",
        "key = { a = 1",
        "[table",
        "[[tables]",
        "[table]\n[table]",
        "key = 1\nkey = 2",
        "ключ = 1",
        "= 1",
        "{ \"key\": 1 }",
        "<key/>",
    ];
    let reported = |text: &str| format!("{text}\n{}", Document::parse_toml("a", text).unwrap_err().plain());
    insta::assert_snapshot!(texts.map(reported).join("\n"));
}

#[test]
fn missing_keys_of_a_table_are_one_problem() {
    let read = |text: &str| {
        let document = Document::parse_toml("a.toml", text).unwrap();
        let read = document.read(|root| {
            let (a, b, c) = (root.number("a").required(), root.text("b").required(), root.text("c").required());
            Some((a?, b?, c?))
        });
        read.unwrap_err().plain()
    };
    let all = "a.toml:1:1: `a`, `b` and `c` are missing (add `a`: a number\nadd `b`: a string\nadd `c`: a string)\n";
    assert_eq!(read(""), all);
    assert_eq!(read("a = 1"), "a.toml:1:1: `b` and `c` are missing (add `b`: a string\nadd `c`: a string)\n");
    assert_eq!(read("a = 1\nb = \"\""), "a.toml:1:1: `c` is missing (add `c`: a string)\n");
}

#[test]
fn a_misspelled_key_is_not_also_missing() {
    let problems = load(&SCENARIO.replace("name", "nane"), &[]).unwrap_err().plain();
    assert_eq!(problems, "nominal.toml:1:1: unknown key `nane` (did you mean `name`?)\n");
}

#[test]
fn overrides_replace_values_and_make_tables() {
    let scenario =
        load(SCENARIO, &["battery.charge_pct=35", "faults.1.charge_pct = 5", "name=rainy-day", "record=true"]);
    let scenario = scenario.unwrap();
    assert_eq!((scenario.charge_pct, scenario.faults[1].1), (35.0, Some(5.0)));
    assert_eq!((scenario.name.as_str(), scenario.record), ("rainy-day", true));
    let made = load("duration_s = 1", &["name=\"a b\"", "battery.charge_pct=1", "faults=[{kind='drop'}]"]).unwrap();
    assert_eq!((made.name.as_str(), made.faults), ("a b", vec![(FaultKind::Drop, None)]));
    let quoted = load(SCENARIO, &["\"battery\" . \"charge_pct\" = 5"]).unwrap();
    assert_eq!(quoted.charge_pct, 5.0);
    let unknown = load(SCENARIO, &["battery.\"a.b\"=5"]).unwrap_err().plain();
    assert!(unknown.contains("unknown key `a.b`"), "{unknown}");
}

#[test]
fn malformed_overrides_are_explained() {
    let overrides = [
        "battery",
        "=3",
        "battery..charge_pct=3",
        "battery.charge_pct=",
        "name=\"unclosed",
        "faults=[1,",
        "faults.2.kind=drop",
        "faults.first.kind=drop",
        "name.first=3",
    ];
    insta::assert_snapshot!(load(SCENARIO, &overrides).unwrap_err().plain());
}

#[test]
fn a_wrong_value_from_an_override_is_reported_in_the_override() {
    let problems = load(SCENARIO, &["battery.charge_pct=1O0", "battery.chargepct=3", "seed = -1"]).unwrap_err();
    insta::assert_snapshot!(problems.plain());
}

#[test]
fn values_keep_their_location_for_later() {
    let document = Document::parse_toml("a.toml", "a = [10, [20, 30]]\nb.c = 'x'\n").unwrap();
    let (numbers, text) = document
        .read(|root| {
            let items = root.get::<Vec<Item<'_>>>("a").required()?;
            let numbers: Vec<Spanned<i64>> = items[1].get().ok()?;
            let text = root.table("b").required()?.text("c").spanned().required()?;
            Some((numbers, text))
        })
        .unwrap();
    assert_eq!((numbers[1].value, numbers[1].span.column()), (30, 15));
    assert_eq!((text.value.as_str(), text.span.line()), ("x", 2));
}

#[test]
fn nested_items_are_named() {
    let document = Document::parse_toml("a.toml", "a = [[1, 2], [3, 'x', true]]\n").unwrap();
    let problems = document.read(|root| root.get::<Vec<Vec<f64>>>("a").required()).unwrap_err();
    insta::assert_snapshot!(problems.plain());
}

#[test]
fn numbers_out_of_range_of_their_types_are_refused() {
    let document = Document::parse_toml("a.toml", "a = 99999999999999999999\nb = 1e999\nc = 1e10\nd = 2021-01-01\n");
    let problems = document
        .unwrap()
        .read(|root| {
            let a = root.integer("a").required();
            let b = root.number("b").required();
            let (c, d) = (root.seconds("c").required(), root.text("d").required());
            Some((a?, b?, c?, d?))
        })
        .unwrap_err();
    insta::assert_snapshot!(problems.plain());
}

/// Every root seed that the command line accepts can also be written in a file.
#[test]
fn integers_from_0_have_64_bits() {
    assert_eq!(load(SCENARIO, &["seed=18446744073709551615"]).map(|scenario| scenario.seed).ok(), Some(u64::MAX));
    let problems = load(SCENARIO, &["seed=18446744073709551616"]).expect_err("one too many").plain();
    assert!(problems.contains("`seed` must be an integer of at least 0"), "{problems}");
    let too_long = load(SCENARIO, &["seed=18446744073709551616"]).expect_err("one too many");
    assert_eq!(too_long.problems()[0].label_text(), Some("this is an integer of more than 64 bits"));
}

proptest! {
    #[test]
    fn no_override_makes_reading_panic(text in "[a-z0-9.=\\[\\]{}\"' -]{0,30}") {
        let _ = load(SCENARIO, &[&text]);
        let _ = load(SCENARIO, &[&format!("faults.{text}")]);
    }

    #[test]
    fn a_number_that_is_set_is_read_back_exactly(charge_pct in 0.0..100.0_f64) {
        let scenario = load(SCENARIO, &[&format!("battery.charge_pct={charge_pct:?}")]).unwrap();
        prop_assert_eq!(scenario.charge_pct, charge_pct);
    }
}

#[test]
fn a_document_inherits_what_it_does_not_set_itself() {
    let base = Document::parse_toml("base.toml", SCENARIO).expect("the base is TOML");
    let text = "name = \"short\"\nfaults = []\n[battery]\n";
    let mut document = Document::parse_toml("short.toml", text).expect("the document is TOML");
    document.inherit(base, &[]);
    assert_eq!(document.peek_text("name").map(|name| name.value), Some("short"));
    let scenario = document.read(read).expect("both together are a scenario");
    assert_eq!((scenario.name.as_str(), scenario.seed, scenario.charge_pct), ("short", 7, 80.0));
    assert_eq!(scenario.faults, []);
}

#[test]
fn an_empty_table_means_the_same_in_a_file_and_in_an_assignment() {
    for (text, assignments, is_inherited) in [
        ("battery = {}\n", vec![], false),
        ("", vec!["battery={}"], false),
        ("[battery]\n", vec![], true),
        ("", vec![], true),
    ] {
        let mut document = Document::parse_toml("short.toml", text).expect("the document is TOML");
        let base = Document::parse_toml("base.toml", "[battery]\ncharge_pct = 80.0\n").expect("the base is TOML");
        document.inherit(base, &[]);
        document.override_with(assignments.iter().copied()).expect("an assignment");
        let read = |root: Table<'_>| Some(root.table("battery").optional()?.number("charge_pct").optional().is_some());
        assert_eq!(document.read(read).expect("a table"), is_inherited, "{text}{assignments:?}");
    }
}

#[test]
fn problems_of_a_base_are_shown_in_the_base() {
    let base = Document::parse_toml("base.toml", &SCENARIO.replace("80", "180")).expect("the base is TOML");
    let mut document = Document::parse_toml("short.toml", "nmae = \"short\"\n").expect("the document is TOML");
    document.inherit(base, &[]);
    let problems = document.read(read).expect_err("a misspelled key and a charge of 180 %");
    let spans: Vec<Span> = problems.problems().iter().filter_map(Problem::span).collect();
    let places: Vec<(&str, usize)> = spans.iter().map(|span| (span.source().name(), span.line())).collect();
    assert_eq!(places, [("short.toml", 1), ("base.toml", 6)]);
}

/// Hints must neither compare each name with all others nor list them all.
#[test]
fn many_unknown_keys_are_each_reported() {
    let keys = |name: &str| (0..20_000).map(|n| format!("{name}{n} = 1\n")).collect::<String>();
    let document = Document::parse_toml("many.toml", &(keys("known") + &keys("other"))).unwrap();
    let read = |root: Table<'_>| {
        (0..20_000).map(|n| root.get::<u64>(&format!("known{n}")).required()).collect::<Option<Vec<_>>>()
    };
    assert_eq!(document.read(read).unwrap_err().problems().len(), 20_000);
}

#[test]
fn a_reader_declares_its_keys_without_a_file() {
    let read = |root: Table<'_>| {
        let lasers = root.tables("lasers").each(|laser| laser.text("name").filled("not be empty").required());
        let lasers = lasers.about("The lasers.").optional();
        let beams = root.get::<u64>("beams").about("Beams.").within(2..=5000).default(360);
        let docking = root.table("docking").needs("map").optional();
        let sides = [("left", 1), ("right", 2)];
        let side = docking.map(|docking| docking.one_of("side", &sides).or_first(&sides));
        let names: Vec<_> = root.names("NAME").map(|(name, _)| root.integer(name).optional()).collect();
        let fixed = root.form(!names.is_empty()).map(|root| root.seconds("pause_s").above_0().required());
        (lasers, beams, side, names, fixed)
    };
    let keys = Key::all(read);
    let paths: Vec<&str> = keys.iter().map(|key| key.path.as_str()).collect();
    assert_eq!(paths, ["NAME", "beams", "pause_s", "lasers[]", "lasers[].name", "docking", "docking.side"]);
    let [_, beams, pause, _, name, docking, _] = &keys[..] else { panic!("{keys:?}") };
    assert_eq!(
        (&*beams.about, &*beams.accepts(), beams.default().as_deref()),
        ("Beams.", "an integer from 2 to 5000", Some("360"))
    );
    assert_eq!((&*pause.accepts(), pause.required), ("a number above 0", false));
    assert!(name.required && !docking.required && docking.needs.as_deref() == Some("map"));
    let schema = Key::json_schema("A robot", json!({ "dependentRequired": { "docking": ["map"] } }), &keys);
    insta::assert_snapshot!(format!("{schema:#}"));
}

#[test]
fn keys_with_their_values_in_effect_are_those_of_the_file_and_the_defaults_that_its_reader_takes() {
    let text = "seed = 7\n[[lasers]]\nbeams = 9\n[[lasers]]\nmount = { x_m = 1.5 }\n[motor]\nmax_mps = 2\n";
    let document = Document::parse_toml("a.toml", text).unwrap();
    let lasers = |laser: Table<'_>| {
        let mount = laser.table("mount").map(|mount| mount.number("x_m").default(0.0)).optional();
        Some((laser.get::<u64>("beams").about("Beams.").default(360), mount))
    };
    let read = |root: Table<'_>| {
        let motor = root.table("motor").optional()?;
        let limit = motor.number("max_mps").default(1.0);
        // A default may depend on another value.
        let battery = root.table("battery").optional().map(|battery| battery.number("full_pct").default(50.0 * limit));
        let doors = root.tables("doors").each(|door| Some(door.number("width_m").default(1.0))).optional();
        let lasers = root.tables("lasers").each(lasers).optional();
        Some((battery, doors, lasers, root.get::<u64>("seed").required(), root.text("name").optional()))
    };
    document.read(read).unwrap();
    let keys = document.in_effect(read);
    let shown: Vec<String> = keys.iter().map(|key| format!("{} = {}", key.path, key.value.as_ref().unwrap())).collect();
    assert_eq!(
        shown,
        [
            "seed = 7",
            "motor.max_mps = 2",
            "battery.full_pct = 100",
            "lasers.0.beams = 9",
            "lasers.0.mount.x_m = 0",
            "lasers.1.beams = 360",
            "lasers.1.mount.x_m = 1.5"
        ]
    );
    assert_eq!(keys[3].about, "Beams.");
}

#[test]
fn forms_and_names_in_a_file_are_those_that_it_has() {
    let document = Document::parse_toml("a.toml", "zebra = 1\nknown = 2\napple = 3\n").unwrap();
    let problems = document.read(|root| {
        root.know("known");
        assert_eq!(root.names("NAME").map(|(name, _)| name).collect::<Vec<_>>(), ["apple", "zebra"]);
        let as_written = root.names_as_written("NAME");
        assert_eq!(as_written.iter().map(|(name, _)| *name).collect::<Vec<_>>(), ["zebra", "apple"]);
        assert!(root.form(false).is_none() && root.find("apple.b").is_none());
        assert_eq!(root.find("apple").map(Span::line), Some(3));
        root.form(true)?.integer("apple").required()
    });
    assert_eq!(problems.unwrap_err().plain(), "a.toml:1:1: unknown key `zebra` (known here: `apple`, `known`)\n");
}
