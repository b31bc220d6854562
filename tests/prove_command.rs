//! `steward prove`: every schedule, and everything that may happen around tree, skills and components.

use std::collections::BTreeSet;

use serde_json::Value;
use tempfile::{TempDir, tempdir};

use crate::steward::{refusal, steward};

/// The results of a proof, which must end with this exit status.
fn proof(status: i32, arguments: &[&str]) -> Value {
    let output = steward(&[&["prove", "--json"], arguments].concat());
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {said}");
    serde_json::from_slice(&output.stdout).expect("the results are JSON")
}

fn results(proof: &Value) -> Vec<(&str, &str)> {
    let properties = proof["properties"].as_array().expect("there are properties");
    properties.iter().filter_map(|it| Some((it["property"].as_str()?, it["result"].as_str()?))).collect()
}

#[test]
fn the_result_is_the_same_on_any_number_of_threads() {
    let of = |threads: &str| {
        let mut proof = proof(0, &["nominal", "--threads", threads]);
        for property in proof["properties"].as_array_mut().expect("there are properties") {
            property["time_s"] = Value::Null;
            property["memory_bytes"] = Value::Null;
        }
        proof
    };
    assert_eq!(of("1"), of("3"));
}

#[test]
fn without_enough_memory_nothing_is_decided() {
    let tight = ["nominal", "--property", "phi1", "--memory", "1", "--set", "execution.tree=nodes"];
    assert_eq!(results(&proof(1, &tight)), [("phi1", "not decided")]);
    let output = steward(&[&["prove"], &tight[..]].concat());
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(said.contains("! phi1 is not decided: memory ran out. It explored "), "{said}");
}

#[test]
fn a_budget_of_states_leaves_a_property_open_and_the_others_are_still_tried() {
    let little = ["nominal", "--states", "40000"];
    let open = proof(1, &little);
    assert_eq!(
        results(&open)[..],
        [("phi1", "not decided"), ("phi2", "not decided"), ("phi3", "not decided"), ("progress", "proved")]
    );
    let phi1 = &open["properties"][0];
    assert_eq!(phi1["limit"], "the limit of visited states was reached");
    let rounds = phi1["rounds"].as_array().expect("rounds");
    let visited: u64 = rounds.iter().filter_map(|round| round["visited_states"].as_u64()).sum();
    assert!(rounds.len() == 1 && (40_000..45_000).contains(&visited), "{phi1}");
    let said = String::from_utf8_lossy(&steward(&[&["prove"], &little[..]].concat()).stdout).into_owned();
    assert!(said.contains("! phi1 is not decided: the limit of visited states was reached. It explored 4"), "{said}");
    assert!(said.contains("`--states` allows more"), "{said}");
}

#[test]
fn programs_can_follow_the_progress() {
    let output = steward(&["prove", "nominal", "--property", "phi1", "--progress", "json", "--json"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let first: Value = serde_json::from_str(said.lines().next().expect("a line")).expect("an object");
    assert_eq!((&first["property"], &first["round"], &first["reduced"]), (&"phi1".into(), &1.into(), &false.into()));
    assert!(first["visited_states"].as_u64().is_some_and(|states| states > 0), "{first}");
}

#[test]
fn a_search_may_go_depth_first() {
    let long = ["nominal", "--property", "phi1", "--set", "prove.trips.ticks=10", "--order", "depth"];
    let found = proof(1, &long);
    assert_eq!(results(&found), [("phi1", "violated")]);
    let phi1 = &found["properties"][0];
    assert_eq!((&phi1["as_expected"], &phi1["run"]["replayed"]), (&false.into(), &true.into()));
}

/// All levels of a class would count as the same one, and these properties as proved.
#[test]
fn a_property_that_remembers_a_level_or_computes_with_it_is_refused() {
    let folder = tempdir().expect("a folder");
    let file = folder.path().join("levels.scope");
    let channel = "BatteryReader, BatteryLevel";
    for condition in [
        format!("always (({channel}, m[2] as x and m[2] > 30 and m[2] < 100) implies next ({channel}, m[2] = x))"),
        format!("always not ({channel}, m[2] * 2 > 80 and m[2] * 2 < 100)"),
    ] {
        std::fs::write(&file, format!("property levels := {condition}\n")).expect("room for a file");
        let properties = format!("properties=['{}']", file.display());
        let said = refusal(&["prove", "nominal", "--property", "levels", "--set", &properties, "--set", "prove={}"]);
        assert!(said.contains("the property levels remembers a level or computes with it"), "{said}");
    }
}

#[test]
fn words_fit_80_columns_and_say_what_is_assumed_and_what_happens() {
    let output = steward(&["prove", "nominal"]);
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let table: Vec<&str> = said.lines().skip_while(|line| !line.starts_with("  property")).take(3).collect();
    assert!(table.len() == 3 && table.iter().all(|line| line.chars().count() <= 80), "{said}");
    for words in [
        "The battery starts with 31 to 100 % and loses at most 1 % per tick.",
        "Trips take at most 9 ticks, never fail, and may pass RechargingStation.",
        "phi2 is violated:",
        "the robot comes to RechargingStation",
        "replayed in the channel system: violated at tick",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
}

#[test]
fn junit_has_a_case_per_property() {
    let folder = tempdir().expect("a folder");
    let file = folder.path().join("proofs.xml");
    let path = file.to_str().expect("a path in UTF-8");
    proof(1, &["nominal", "--results", path, "--set", "prove.expect.phi1=violated"]);
    let xml = std::fs::read_to_string(&file).expect("it was written");
    assert!(xml.contains("<testsuite name=\"nominal\" tests=\"4\" failures=\"1\""), "{xml}");
    assert!(xml.contains("phi1 was expected to be violated, and is proved"), "{xml}");
}

/// A machine that counts its ticks has more states than can be searched.
#[test]
fn a_property_that_could_not_be_searched_is_an_error_in_junit_and_json() {
    let (folder, scenario) = planted();
    let machine = folder.path().join("IsOpen.scxml");
    let text = std::fs::read_to_string(&machine).expect("it is there");
    let counts = "<transition event=\"BT.tick\"><assign location=\"n\" expr=\"n + 1\"/>";
    let text = text.replacen("<state", "<datamodel><data id=\"n\" expr=\"0\"/></datamodel>\n<state", 1);
    std::fs::write(&machine, text.replacen("<transition event=\"BT.tick\">", counts, 1)).expect("room for a file");
    let file = folder.path().join("proofs.xml");
    let arguments = ["--set", "prove.properties=['progress', 'all_reached']"];
    let proof = proof(2, &[&[&scenario, "--results", file.to_str().expect("UTF-8")], &arguments[..]].concat());
    assert_eq!(results(&proof), [("progress", "not searched"), ("all_reached", "not searched")]);
    let reason = proof["properties"][0]["reason"].as_str().expect("a reason");
    assert!(reason.contains("65536 states"), "{proof}");
    let xml = std::fs::read_to_string(&file).expect("it was written");
    assert!(xml.contains("tests=\"2\" failures=\"0\" errors=\"2\"") && xml.contains("<error "), "{xml}");
}

#[test]
fn the_reference_has_the_fields_of_results() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/src/reference/prove.md");
    let text = std::fs::read_to_string(file).expect("it is there");
    let tables = text.split("| field | type | meaning |\n| --- | --- | --- |\n").skip(1).map(|rest| {
        let rows = rest.lines().map_while(|line| line.strip_prefix("| `")?.split('`').next());
        rows.map(str::to_owned).collect::<BTreeSet<String>>()
    });
    let proof = proof(0, &["nominal", "--property", "phi3"]);
    let fields = |value: &Value| value.as_object().expect("an object").keys().cloned().collect::<BTreeSet<String>>();
    assert_eq!(tables.collect::<Vec<_>>(), [fields(&proof), fields(&proof["properties"][0])]);
}

/// The messages about `nominal` with these settings, which are refused.
fn refused(set: &[&str]) -> String {
    let set: Vec<&str> = set.iter().flat_map(|set| ["--set", set]).collect();
    refusal(&[&["prove", "nominal"], &set[..]].concat())
}

#[test]
fn assumptions_that_contradict_each_other_are_refused() {
    for (set, said) in [
        (
            &["prove.battery={charge_pct_per_tick=1}"][..],
            "`charge_pct_per_tick` contradicts a battery whose level may jump",
        ),
        (&["prove.battery={start_pct=50}"], "add `drain_pct_per_tick`"),
        (
            &["prove.battery={drain_pct_per_tick=1, start_pct=[60, 50]}"],
            "`start_pct` must be a number from 0 to 100, or",
        ),
        (&["prove.battery.drain_pct_per_tick=101"], "0 is a battery that never drains"),
        (&["prove.faults={count=2}"], "`count` has no effect if no fault may occur"),
        (&["prove.faults={component_crash='Navigaton'}"], "unknown component `Navigaton`"),
        (&["prove.faults={component_crash='Localization'}"], "allow `component_frozen` or"),
        (&["prove.faults={skill_mutant='BatteryLevel: it is tired'}"], "unknown mutant `BatteryLevel: it is tired`"),
        (&["prove.faults={skill_mutant='Battery: it is tired'}"], "unknown skill `Battery`"),
        (&["prove.battery.drain_pct_per_tick=0.00000001"], "has more than six decimals"),
        (&["prove.battery.drain_pct_per_tick=0.0001"], "too many classes of levels"),
        (&["prove.trips.passes='Kitchn'"], "unknown place `Kitchn`"),
        (&["prove.messages={delay_s=2}"], "`delay_s` has no effect if no message may be delayed"),
        (&["prove.messages={lose=1, on=[['BT', 'Navigation']]}"], "there is no channel from BT to Navigation"),
        (&["prove.messages={lose=1, on=[['BTT', 'Navigation']]}"], "unknown process `BTT`"),
        (&["prove.properties='phi1'", "prove.expect={phi3='proved'}"], "`phi3` is not among `prove.properties`"),
        (&["prove.properties='phi4'"], "unknown property `phi4`"),
        (&["prove.components.Arm.machine='a.scxml'"], "unknown component `Arm`"),
    ] {
        let found = refused(set);
        assert!(found.contains(said), "{set:?}: {found}");
    }
    let unknown = refusal(&["prove", "nominal", "--property", "phi9"]);
    assert!(unknown.contains("there is no property `phi9`") && !unknown.contains("has no property"), "{unknown}");
    let without_map = refusal(&["prove", "pick", "--set", "prove.battery={}"]);
    assert!(without_map.contains("`prove.battery` needs a map"), "{without_map}");
}

/// The refusal of one property must not cost the search of another.
#[test]
fn a_property_that_cannot_be_proved_is_refused_before_any_search() {
    let folder = tempdir().expect("a folder");
    let file = folder.path().join("own.scope");
    let text = "property wrong := always not (BatteryReader, BatteryLevel, level < 90)
        timed property late := always ((GoToDestination, Navigation, true)
            implies time_until (Navigation, GoToDestination, true) < 60 s)
        property exact := always not (BatteryReader, BatteryLevel, level < 1.23456789)";
    std::fs::write(&file, text).expect("room for a file");
    let properties = format!("properties=['{}']", file.display());
    let expect = "prove.expect={late='proved', exact='proved'}";
    let output = steward(&["prove", "nominal", "--set", &properties, "--set", expect]);
    assert_eq!(output.status.code(), Some(2));
    assert!(output.stdout.is_empty(), "{}", String::from_utf8_lossy(&output.stdout));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("`late` is a timed property") && said.contains("more than six decimals"), "{said}");
}

#[test]
fn what_cannot_be_proved_is_reported_with_a_remedy() {
    let pick = refusal(&["prove", "pick", "--property", "delivered"]);
    assert!(pick.contains("the property delivered requires something without a time limit"), "{pick}");
    let guide = refusal(&["prove", "guide", "--set", "prove.components={}"]);
    assert!(guide.contains("TourPlanner cannot be explored: it is a program"), "{guide}");
    assert!(guide.contains("prove.components.TourPlanner.answers"), "{guide}");
    let folder = tempdir().expect("a folder");
    let machine = folder.path().join("BatteryLevel.scxml");
    let text = std::fs::read_to_string("skills/machines/BatteryLevel.scxml").expect("it is shipped");
    std::fs::write(&machine, text.replace("_event.data.level >", "2 * _event.data.level >"))
        .expect("room for a machine");
    let said = refused(&[&format!("leaves.BatteryLevel.machine='{}'", machine.display())]);
    assert!(said.contains("the machine computes with a number, which a proof cannot follow"), "{said}");
    assert!(said.contains("BatteryLevel.scxml"), "{said}");
}

/// A tree with a sequence whose condition never holds, and machines with a state and a transition that are never
/// reached.
fn planted() -> (TempDir, String) {
    let folder = tempdir().expect("a folder");
    let machine = |states: &str| {
        format!(
            "<scxml xmlns=\"http://www.w3.org/2005/07/scxml\" version=\"1.0\" datamodel=\"ecmascript\">\n{states}\n\
             </scxml>"
        )
    };
    let says = |event: &str| format!("<send type=\"channel\" target=\"BT\" event=\"{event}\"/>");
    let answers = |id: &str, event: &str| {
        let (on_tick, on_halt) = (says(event), says("halted"));
        format!(
            "<state id=\"{id}\">\n<transition event=\"BT.tick\">{on_tick}</transition>\n\
             <transition event=\"BT.halt\">{on_halt}</transition>\n</state>"
        )
    };
    let knock = answers("here", "success").replacen(
        "<transition",
        "<transition event=\"BT.tick\" cond=\"1 &gt; 2\" target=\"lost\"/>\n<transition",
        1,
    );
    for (name, text) in [
        (
            "planted.toml",
            "tree = \"tree.xml\"\nskills = \".\"\nproperties = []\n[execution]\nmax_time_s = 5\n".to_owned(),
        ),
        (
            "tree.xml",
            "<root BTCPP_format=\"4\"><BehaviorTree ID=\"Door\">\n<Fallback>\n<Sequence>\n<Condition ID=\"IsOpen\"/>\n\
             <Action ID=\"GoIn\"/>\n</Sequence>\n<Action ID=\"Knock\"/>\n</Fallback>\n</BehaviorTree></root>"
                .to_owned(),
        ),
        ("IsOpen.scxml", machine(&answers("closed", "failure"))),
        ("GoIn.scxml", machine(&answers("outside", "success"))),
        ("Knock.scxml", machine(&format!("{knock}\n{}", answers("lost", "failure")))),
    ] {
        std::fs::write(folder.path().join(name), text).expect("room for a file");
    }
    let scenario = folder.path().join("planted.toml").to_str().expect("a path in UTF-8").to_owned();
    (folder, scenario)
}

#[test]
fn unreached_items_are_listed_with_their_locations_even_without_a_property() {
    let (_folder, scenario) = planted();
    for tree in ["execution.tree=whole", "execution.tree=nodes"] {
        let proof = proof(0, &[&scenario, "--set", tree]);
        assert_eq!(results(&proof), [("progress", "proved")]);
        let unreached: Vec<(&str, &str, u64)> = proof["unreached"]
            .as_array()
            .expect("a list")
            .iter()
            .filter_map(|it| Some((it["kind"].as_str()?, it["words"].as_str()?, it["line"].as_u64()?)))
            .collect();
        assert_eq!(
            unreached,
            [
                ("node", "Fallback (0) never fails", 2),
                ("node", "Sequence (1) never succeeds", 3),
                ("node", "IsOpen never succeeds", 4),
                ("node", "GoIn is never ticked", 5),
                ("node", "Knock never fails", 7),
                ("transition", "GoIn: in `outside`, the transition BT.tick stays is never taken", 3),
                ("transition", "GoIn: in `outside`, the transition BT.halt stays is never taken", 4),
                ("transition", "IsOpen: in `closed`, the transition BT.halt stays is never taken", 4),
                ("transition", "Knock: in `here`, the transition BT.tick [1 > 2] -> lost is never taken", 3),
                ("transition", "Knock: in `here`, the transition BT.halt stays is never taken", 5),
                ("state", "Knock: the state `lost` is never entered", 7),
            ],
            "{tree}"
        );
    }
    let words = |arguments: &[&str]| {
        let output = steward(&[&["prove", &scenario], arguments].concat());
        (output.status.code(), String::from_utf8_lossy(&output.stdout).into_owned())
    };
    let counted = words(&[]).1;
    assert!(counted.contains("never reached: 5 answers of nodes, 1 state, 5 transitions (--unreached"), "{counted}");
    let (status, listed) = words(&["--unreached", "--set", "prove.expect.all_reached=proved"]);
    assert!(listed.contains("tree.xml:5: GoIn is never ticked"), "{listed}");
    assert!(listed.contains("! all_reached was expected to be proved, and is violated"), "{listed}");
    assert_eq!(status, Some(1));
    assert_eq!(words(&["--set", "prove.expect.all_reached=violated"]).0, Some(0));
}

#[test]
fn a_property_that_nothing_can_violate_is_proved_without_a_word_about_ticks() {
    let (_folder, scenario) = planted();
    let fails = "(Knock, BT, m[1] = <failure>)";
    let set = format!("expect.satisfied.w='always (fresh {fails} implies time_until {fails} < 2)'");
    let proof = proof(0, &[&scenario, "--set", &set]);
    assert_eq!(results(&proof), [("w", "proved"), ("progress", "proved")]);
    let w = &proof["properties"][0];
    assert_eq!((&w["states"], &w["vacuous"]), (&1.into(), &Value::Null), "{w:#}");
    let said = String::from_utf8_lossy(&steward(&["prove", &scenario, "--set", &set]).stdout).into_owned();
    assert!(said.contains("  w ") && !said.contains("vacuous"), "{said}");
}

#[test]
fn a_machine_that_counts_forever_is_named() {
    let (folder, scenario) = planted();
    let knock = std::fs::read_to_string(folder.path().join("Knock.scxml")).expect("a machine");
    let counts = "<datamodel><data id=\"count\" expr=\"0\"/></datamodel>\n<state id=\"here\">";
    let knock = knock.replacen("<state id=\"here\">", counts, 1).replacen(
        "<transition event=\"BT.tick\"><send",
        "<transition event=\"BT.tick\"><assign location=\"count\" expr=\"count + 1\"/><send",
        1,
    );
    std::fs::write(folder.path().join("Knock.scxml"), knock).expect("room for a machine");
    let said = refusal(&["prove", &scenario]);
    assert!(said.contains("Knock has more than 65536 states: something in it may grow forever"), "{said}");
}

#[test]
fn messages_that_pile_up_leave_a_property_undecided_and_violate_progress() {
    let (folder, scenario) = planted();
    let attributes = "version=\"1.0\" datamodel=\"ecmascript\" name=\"Knock\"";
    // It fails 45 times, leaves a delayed event behind each time, and then succeeds.
    let knock = format!(
        "<scxml xmlns=\"http://www.w3.org/2005/07/scxml\" {attributes}>\
         <datamodel><data id=\"n\" expr=\"0\"/></datamodel><state id=\"here\">\
         <transition event=\"BT.tick\" cond=\"n &lt; 45\"><assign location=\"n\" expr=\"n + 1\"/>\
         <send event=\"late\" delay=\"1000s\"/><send type=\"channel\" target=\"BT\" event=\"failure\"/></transition>\
         <transition event=\"BT.tick\"><send type=\"channel\" target=\"BT\" event=\"success\"/></transition>\
         <transition event=\"BT.halt\"><send type=\"channel\" target=\"BT\" event=\"halted\"/></transition>\
         </state></scxml>"
    );
    std::fs::write(folder.path().join("Knock.scxml"), knock).expect("room for a machine");
    let fails = ["--set", "expect.satisfied.fails='always not (Knock, BT, m[1] = <success>)'"];
    let piled_up = proof(1, &[&[scenario.as_str()][..], &fails[..]].concat());
    assert_eq!(results(&piled_up), [("fails", "endless"), ("progress", "endless")]);
    for property in piled_up["properties"].as_array().expect("there are properties") {
        assert_eq!((&property["as_expected"], &property["run"]["replayed"]), (&false.into(), &true.into()));
        assert_eq!(property["run"]["decided_at_tick"], 32);
    }
    assert_eq!(piled_up["errors"], Value::Array(Vec::new()), "the leaf answers each tick");
    let output = steward(&[&["prove", scenario.as_str()][..], &fails[..]].concat());
    let said = String::from_utf8_lossy(&output.stdout).split_whitespace().collect::<Vec<_>>().join(" ");
    let which = "(more than 32 delayed events are waiting in Knock, and what follows is not searched)";
    for said_once in [
        "! fails is not decided: messages pile up without end, and what follows is not searched",
        &format!("fails is not decided: messages pile up without end {which}:"),
        &format!("progress is violated: messages pile up without end {which}:"),
    ] {
        assert!(said.contains(said_once), "{said_once}: {said}");
    }
    // Only what is violated can be expected.
    let fails_is = ["--property", "fails", "--set", "prove.expect.fails=violated"];
    proof(1, &[&[scenario.as_str()][..], &fails[..], &fails_is[..]].concat());
    let progress_is = ["--property", "progress", "--set", "prove.expect.progress=violated"];
    proof(0, &[&[scenario.as_str()][..], &fails[..], &progress_is[..]].concat());
}

#[test]
fn a_livelock_is_a_run_that_goes_around_in_circles() {
    let (folder, scenario) = planted();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("room for a file");
    write("Echo.toml", "[services.say]\nrequest = {}\nreply = {}\n");
    let scxml = "<scxml xmlns=\"http://www.w3.org/2005/07/scxml\" version=\"1.0\" datamodel=\"ecmascript\">";
    write(
        "Echo.scxml",
        &format!(
            "{scxml}<state id=\"here\"><transition event=\"say\"><send type=\"channel\" \
             targetexpr=\"_event.origin\" event=\"ok\"/></transition></state></scxml>"
        ),
    );
    let say = "<send type=\"channel\" target=\"Echo\" event=\"say\"/>";
    write(
        "Knock.scxml",
        &format!(
            "{scxml}<state id=\"here\"><transition event=\"BT.tick\">{say}<send type=\"channel\" target=\"BT\" \
             event=\"success\"/></transition><transition event=\"BT.halt\"/><transition event=\"Echo.*\">{say}\
             </transition></state></scxml>"
        ),
    );
    let at = |name: &str| folder.path().join(name).display().to_string();
    let components = &format!("components.Echo={{machine='{}', interface='{}'}}", at("Echo.scxml"), at("Echo.toml"));
    let endless = proof(1, &[&scenario, "--set", components]);
    assert_eq!(results(&endless), [("progress", "livelock")], "{endless:#}");
    let run = &endless["properties"][0]["run"];
    assert_eq!(run["replayed"], true);
    assert!(run["steps"].as_array().is_some_and(|steps| steps.iter().any(|step| step["repeats"] == true)), "{run:#}");
    proof(0, &[&scenario, "--set", components, "--set", "prove.expect.progress=violated"]);
    let said = String::from_utf8_lossy(&steward(&["prove", &scenario, "--set", components]).stdout).into_owned();
    assert!(said.contains("progress is violated: processes communicate forever within a tick"), "{said}");
    assert!(said.contains("  over and over:\n    Knock → Echo  [<say>"), "{said}");
}

#[test]
fn a_proof_names_the_errors_in_the_runs_that_it_explored() {
    // The property is proved although a leaf does not confirm its halt in time: the result mentions both.
    let name = "nav2/halted_early_fixed";
    for tree in ["execution.tree=whole", "execution.tree=nodes"] {
        let proof = proof(0, &[name, "--set", tree]);
        assert_eq!(results(&proof), [("stands_still", "proved"), ("progress", "proved")]);
        let error = &proof["errors"][0];
        assert_eq!(error["place"], "FollowPath (node 2)");
        assert_eq!(error["message"], "FollowPath did not confirm that it has halted within 2 s");
        assert_eq!(proof["errors"].as_array().map(Vec::len), Some(1), "each is named once");
    }
    let words = String::from_utf8(steward(&["prove", name]).stdout).expect("text");
    assert!(words.contains("some of the runs contain errors"), "{words}");
    assert_eq!(proof(0, &["nominal"])["errors"], Value::Array(Vec::new()));
}

#[test]
fn faults_of_the_catalogue_may_occur_in_a_proof() {
    let mistake = "FollowPath: the transition in `halting` on `ControllerServer.follow_path.accepted` is removed";
    let faults = format!("prove.faults={{skill_mutant='{mistake}'}}");
    let proof = proof(1, &["nav2/halted_early_fixed", "--property", "stands_still", "--set", &faults]);
    let words = format!("At any time, 1 fault may begin, and end again: {mistake}.");
    let assumed = proof["assumptions"].as_array().expect("sentences").iter().filter_map(Value::as_str);
    assert_eq!(assumed.filter(|it| *it == words).count(), 1, "{proof:#}");
    let run = &proof["properties"][0]["run"];
    assert_eq!(run["replayed"], true);
    let steps = run["steps"].as_array().expect("steps");
    assert!(steps.iter().any(|it| it["environment"] == mistake), "{run:#}");
    // The run can be written and followed: the command fails if that does not give the same verdict.
    let folder = tempdir().expect("a folder");
    let out = folder.path().to_str().expect("a path in UTF-8");
    self::proof(1, &["nav2/halted_early_fixed", "--property", "stands_still", "--set", &faults, "--out", out]);
    let schedule = std::fs::read_to_string(folder.path().join("stands_still/schedule.toml")).expect("a schedule");
    assert!(schedule.contains(&format!("begins = {{ skill_mutant = \"{mistake}\" }}")), "{schedule}");
    // A server that hangs or restarts does no harm.
    for fault in ["component_frozen", "component_crash"] {
        let faults = format!("prove.faults={{{fault}='ControllerServer'}}");
        self::proof(0, &["nav2/halted_early_fixed", "--property", "stands_still", "--set", &faults]);
    }
}

#[test]
#[ignore = "long: .ci/run runs it"]
fn mutants_that_survive_are_mistakes_that_no_property_detects() {
    let scenario = "nav2/halted_early_fixed";
    // One of them has no end; all others need fewer states.
    let all = proof(0, &[scenario, "--mutants", "--states", "100000"]);
    let mutants = all["mutants"].as_array().expect("mutants");
    let of = |result: &str| mutants.iter().filter(|it| it["result"] == result).collect::<Vec<_>>();
    let counts = ["killed", "changes nothing", "survives"].map(|result| of(result).len());
    assert!(counts[0] >= 5 && counts[1] > 20 && counts[2] > 5, "{counts:?}");
    // All mutants of the skill, and some of the tree.
    let listed = steward(&["skill", "mutants", "skills/machines/nav2/FollowPathFixed.scxml"]).stdout;
    let count = mutants.iter().filter(|it| it["skill"] == "FollowPath").count();
    assert_eq!(String::from_utf8_lossy(&listed).lines().count(), count);
    assert!(mutants.iter().any(|it| it["skill"].is_null()), "{mutants:?}");
    // Each equals the same mistake in the file.
    let folder = tempdir().expect("a folder");
    let text = std::fs::read_to_string("skills/machines/nav2/FollowPathFixed.scxml").expect("it is shipped");
    let mistakes = skills::mutations("FollowPathFixed.scxml", &text).expect("a machine");
    let of_skill = mutants.iter().filter(|it| it["skill"] == "FollowPath");
    for (mutant, mistake) in of_skill.zip(&mistakes).step_by(9) {
        assert_eq!(mutant["mutant"], mistake.to_string());
        let file = folder.path().join("Mutant.scxml");
        let mutated = skills::mutate("FollowPathFixed.scxml", &text, mistake).expect("a mutant");
        std::fs::write(&file, mutated).expect("room for a file");
        let machine = format!("leaves.FollowPath.machine='{}'", file.display());
        let output = steward(&["prove", scenario, "--set", &machine, "--json"]);
        let is_noticed = output.status.code() != Some(0);
        let survives = ["survives", "changes nothing"].iter().any(|result| mutant["result"] == *result);
        assert_eq!(is_noticed, !survives, "{mistake}");
    }
}
