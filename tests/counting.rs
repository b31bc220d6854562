//! What counts at the end of a tick and at the end of a run: ticks that end late, errors, and what never came.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use tempfile::tempdir;

use crate::steward::{refusal, report, steward};

/// A condition that fails at its third tick, and an action that never confirms that it has halted.
const TREE: &str = r#"<root BTCPP_format="4" main_tree_to_execute="Main">
  <BehaviorTree ID="Main"> <ReactiveSequence> <Clear/> <Move/> </ReactiveSequence> </BehaviorTree>
  <TreeNodesModel> <Condition ID="Clear" editable="true"/> <Action ID="Move" editable="true"/> </TreeNodesModel>
</root>"#;
const CLEAR: &str = r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" name="Clear" initial="idle">
  <datamodel> <data id="ticks" expr="0"/> </datamodel>
  <state id="idle">
    <transition event="BT.tick" target="asked"/>
    <transition event="BT.halt"> <send type="channel" target="BT" event="halted"/> </transition>
  </state>
  <state id="asked">
    <onentry> <assign location="ticks" expr="ticks + 1"/> </onentry>
    <transition cond="ticks == 3" target="idle"> <send type="channel" target="BT" event="failure"/> </transition>
    <transition target="idle"> <send type="channel" target="BT" event="success"/> </transition>
  </state>
</scxml>"#;
const MOVE: &str = r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" name="Move" initial="idle">
  <state id="idle">
    <transition event="BT.tick"> <send type="channel" target="BT" event="running"/> </transition>
    <transition event="BT.halt" target="idle"/>
  </state>
</scxml>"#;

/// An application of these files, with these additional lines in its scenario.
fn application(folder: &Path, properties: &str, lines: &str) -> PathBuf {
    fs::create_dir_all(folder.join("skills")).unwrap();
    for (name, text) in
        [("tree.xml", TREE), ("skills/Clear.scxml", CLEAR), ("skills/Move.scxml", MOVE), ("p.scope", properties)]
    {
        fs::write(folder.join(name), text).unwrap();
    }
    let scenario = folder.join("scenario.toml");
    let text = format!("tree = \"tree.xml\"\nskills = \"skills\"\nproperties = [\"p.scope\"]\n{lines}\n");
    fs::write(&scenario, text).unwrap();
    scenario
}

const FINE: &str = "property fine := always true\n";

/// A halt is given up after 2 s, which is when a tick is due, or after a time at which none is.
#[test]
fn a_tick_that_ends_as_its_time_is_up_is_not_lost() {
    for (form, tick_s, failed_at_s) in [("whole", 1.0, 4.02), ("nodes", 1.0, 4.02), ("whole", 0.7, 3.42)] {
        let folder = tempdir().unwrap();
        let lines = format!("execution = {{ max_time_s = 6, tree = \"{form}\", tick_s = {tick_s} }}");
        let scenario = application(folder.path(), FINE, &lines);
        let (out, log) = (folder.path().join("out"), folder.path().join("log.jsonl"));
        let found = report(scenario.to_str().unwrap(), &out, &["--record", log.to_str().unwrap()]);
        let context = format!("as {form}, every {tick_s} s: {found:#}");
        assert_eq!(
            (&found["tree_failure"]["label"], &found["tree_failure"]["time_s"]),
            (&json!("Clear"), &json!(failed_at_s)),
            "{context}"
        );
        let errors = found["tree_errors"].as_array().unwrap();
        assert_eq!(errors.len(), 1, "{context}");
        assert_eq!(errors[0]["message"], "Move did not confirm that it has halted within 2 s", "{context}");
        assert_eq!(found["outcome"], "not_as_expected", "{context}");
        let page = fs::read_to_string(out.join("report.html")).unwrap();
        assert!(!page.contains("never failed"), "{context}");
        let log = fs::read_to_string(log).unwrap();
        let lines = log.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
        let failed: Vec<Value> = lines.filter(|line| line["tree"]["0 ReactiveSequence"] == "failure").collect();
        assert_eq!(failed.len(), 1, "{context}\n{log}");
        assert_eq!(
            (&failed[0]["time_s"], &failed[0]["tree"]["2 Move"]),
            (&json!(failed_at_s), &json!("halted")),
            "{context}"
        );
    }
}

#[test]
fn an_error_that_is_not_named_makes_a_run_not_as_expected() {
    let folder = tempdir().unwrap();
    let scenario = application(folder.path(), FINE, "execution.max_time_s = 6");
    let scenario = scenario.to_str().unwrap();
    let out = folder.path().join("out");
    let run = |set: &[&str]| {
        let set = set.iter().flat_map(|set| ["--set", set]);
        let fixed = ["run", scenario, "--no-snapshots", "--out", out.to_str().unwrap()];
        let output = steward(&fixed.into_iter().chain(set).collect::<Vec<_>>());
        (output.status.code(), String::from_utf8_lossy(&output.stdout).into_owned())
    };
    let (status, said) = run(&[]);
    assert_eq!(status, Some(1), "{said}");
    let error = "there was an error in the tree node Move: Move did not confirm that it has halted within 2 s";
    assert!(said.contains("NOT as expected") && said.contains(&format!("! {error}")), "{said}");
    let (status, said) = run(&["expect.errors=[\"Move\"]"]);
    assert!(status == Some(0) && said.contains("as expected"), "{said}");
    let (status, said) = run(&["expect.errors=[\"Move\", \"Clear\"]"]);
    assert!(status == Some(1) && said.contains("! an error in Clear was expected, and there was none"), "{said}");
    // Clear's machine cannot evaluate this.
    let machine = folder.path().join("skills/Clear.scxml");
    fs::write(&machine, CLEAR.replace("expr=\"ticks + 1\"", "expr=\"ticks + _event.data.missing.level\"")).unwrap();
    let (status, said) = run(&[]);
    assert!(status == Some(1) && said.contains("! there was an error in the skill Clear: "), "{said}");
    let (status, said) = run(&["expect.errors=[\"Clear\"]"]);
    assert_eq!(status, Some(0), "{said}");
    let said = refusal(&["run", scenario, "--set", "expect.errors=[\"Mvoe\"]"]);
    assert!(said.contains("unknown skill, component or tree node `Mvoe`") && said.contains("`Move`"), "{said}");
}

/// What never came, what has a deadline after the end, and what is forbidden and did not come.
const PENDING: &str = "property arrives := eventually (Move, BT, m[1] = <success>)
property soon := always ((BT, Move, m[1] = <halt>) implies (time_until ((Move, BT, m[1] = <halted>)) <= 1000))
property never := not eventually (Move, BT, m[1] = <success>)
";

#[test]
fn what_never_came_is_violated_if_the_end_of_the_run_is_the_end() {
    let folder = tempdir().unwrap();
    let scenario = application(folder.path(), PENDING, "execution.max_time_s = 6\nexpect.errors = [\"Move\"]");
    let (scenario, out) = (scenario.to_str().unwrap(), folder.path().join("out"));
    let record = folder.path().join("run.rec");
    let verdicts = |report: &Value| {
        let monitors = report["monitors"].as_array().unwrap().clone();
        monitors.into_iter().map(|monitor| monitor["verdict"].as_str().unwrap().to_owned()).collect::<Vec<_>>()
    };
    let open = report(scenario, &out, &["--no-snapshots"]);
    assert_eq!(verdicts(&open), ["inconclusive", "inconclusive", "satisfied"]);
    assert_eq!(open["outcome"], "as_expected");
    for final_for in ["true", "[\"arrives\"]", "\"arrives\""] {
        let set = format!("stop.final_for={final_for}");
        let found = report(scenario, &out, &["--set", &set, "--record", record.to_str().unwrap()]);
        assert_eq!(verdicts(&found), ["violated", "inconclusive", "satisfied"], "{final_for}");
        assert_eq!(found["outcome"], "not_as_expected");
        let arrives = &found["monitors"][0];
        assert_eq!((&arrives["time_s"], &arrives["tick"]), (&json!(6.0), &json!(5)));
        assert!(arrives["witness"]["missing"].as_str().unwrap().contains("Move"), "{arrives}");
        assert_eq!(found["trace_hash"], open["trace_hash"]);
        // The recording has it, and its page.
        let again = folder.path().join("again");
        let output = steward(&["report", record.to_str().unwrap(), "--out", again.to_str().unwrap()]);
        assert!(matches!(output.status.code(), Some(0 | 1)), "{}", String::from_utf8_lossy(&output.stderr));
        let read: Value = serde_json::from_slice(&fs::read(again.join("report.json")).unwrap()).unwrap();
        assert_eq!(read["monitors"], found["monitors"]);
        let page = fs::read_to_string(again.join("report.html")).unwrap();
        assert!(page.contains("The run ended, and nothing comes after its end: "), "{final_for}");
    }
    let set = ["--set", "stop.final_for=true", "--set", "expect.arrives=\"violated\""];
    assert_eq!(report(scenario, &out, &set)["outcome"], "as_expected");
    // An interrupted run, and one that ends for another reason, are told apart by what ended them.
    let early =
        ["--set", "stop.final_for=true", "--set", "stop.on_violation=\"never\"", "--set", "execution.max_time_s=3"];
    assert_eq!(verdicts(&report(scenario, &out, &early))[0], "violated");
    let said = refusal(&["run", scenario, "--set", "stop.final_for=\"arives\""]);
    assert!(said.contains("unknown property `arives`"), "{said}");
}

#[test]
fn what_is_open_is_shown_as_large_as_what_is_violated() {
    let folder = tempdir().unwrap();
    application(folder.path(), PENDING, "execution.max_time_s = 6\nexpect.errors = [\"Move\"]");
    let campaign = |name: &str, set: &str| {
        let file = folder.path().join(format!("{name}.toml"));
        fs::write(&file, format!("scenario = \"scenario.toml\"\nruns = 3\nset = [{set}]\n")).unwrap();
        let out = folder.path().join(name);
        let output = steward(&["campaign", file.to_str().unwrap(), "--out", out.to_str().unwrap()]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let summary: Value = serde_json::from_slice(&fs::read(out.join("summary.json")).unwrap()).unwrap();
        (out, summary, String::from_utf8_lossy(&output.stdout).into_owned())
    };
    let (before, summary, said) = campaign("open", "");
    assert!(said.contains("arrives   violated in 0 of 3: 0.0000"), "{said}");
    assert!(said.contains("          inconclusive in 3 of 3: 1.0000 (95 %: "), "{said}");
    let arrives = &summary["properties"][0];
    assert_eq!((&arrives["inconclusive"], &arrives["inconclusive_rate"]), (&json!(3), &json!(1.0)));
    let page = fs::read_to_string(before.join("report.html")).unwrap();
    assert_eq!(page.matches("inconclusive: something was still pending at the end").count(), 2, "two properties");
    let (after, summary, _) = campaign("final", "\"stop.final_for=true\", \"expect.arrives='violated'\"");
    assert_eq!(summary["properties"][0]["count"], json!({ "happened": 3, "runs": 3 }));
    assert_eq!(summary["outcomes"]["as_expected"], 3);
    let output = steward(&["campaign", "compare", before.to_str().unwrap(), after.to_str().unwrap()]);
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(said.contains("  violated in 0 of 3 (0.00 %) before, 3 of 3 (100.00 %) after"), "{said}");
    assert!(said.contains("  inconclusive in 3 of 3 (100.00 %) before, 0 of 3 (0.00 %) after"), "{said}");
}

/// Each with whether its condition occurs in a run of 1.5 s, in which Clear never fails, and in one of 6 s.
const CONDITIONS: [(&str, [bool; 2]); 7] = [
    ("always (fresh (Move, BT, m[1] = <success>) implies not (Clear, BT, m[1] = <failure>))", [false, false]),
    ("always (fresh (Move, BT, m[1] = <running>) implies not (Clear, BT, m[1] = <failure>))", [true, true]),
    ("always (previous (Move, BT, m[1] = <success>) implies (Move, BT, m[1] = <running>))", [false, false]),
    ("always (previous (Move, BT, m[1] = <running>) implies (Move, BT, m[1] = <running>))", [true, true]),
    ("always (not (Clear, BT, m[1] = <success>) implies not (Move, BT, m[1] = <success>))", [false, true]),
    ("always (not previous (Clear, BT, m[1] = <failure>) implies not (Move, BT, m[1] = <halted>))", [true, true]),
    ("eventually (Clear, BT, m[1] = <failure>) implies eventually (Move, BT, m[1] = <running>)", [false, true]),
];

#[test]
fn a_run_and_a_campaign_count_the_same_conditions_that_never_occurred() {
    let folder = tempdir().unwrap();
    let properties = CONDITIONS.iter().enumerate().map(|(place, (text, _))| format!("property p{place} := {text}\n"));
    let scenario = application(folder.path(), &properties.collect::<String>(), "expect.errors = [\"Move\"]");
    for (run, max_time_s) in ["1.5", "6"].into_iter().enumerate() {
        let set = format!("execution.max_time_s={max_time_s}");
        let found = report(scenario.to_str().unwrap(), &folder.path().join("run"), &["--set", &set]);
        for ((text, occurs), monitor) in CONDITIONS.iter().zip(found["monitors"].as_array().unwrap()) {
            assert_eq!(monitor["verdict"], "satisfied", "{text} in {max_time_s} s: {monitor}");
            let is_vacuous = !monitor["vacuous"].as_array().unwrap().is_empty();
            assert_eq!(is_vacuous, !occurs[run], "{text} in {max_time_s} s: {monitor}");
        }
    }
    let file = folder.path().join("campaign.toml");
    let parameter = "[[parameters]]\nkey = \"execution.max_time_s\"\nvalues = [1.5, 6]\n";
    fs::write(&file, format!("scenario = \"scenario.toml\"\nsampling = \"grid\"\n{parameter}")).unwrap();
    let out = folder.path().join("campaign");
    let output = steward(&["campaign", file.to_str().unwrap(), "--out", out.to_str().unwrap()]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let summary: Value = serde_json::from_slice(&fs::read(out.join("summary.json")).unwrap()).unwrap();
    for ((text, occurs), property) in CONDITIONS.iter().zip(summary["properties"].as_array().unwrap()) {
        assert_eq!(property["vacuous"], occurs.iter().filter(|occurs| !**occurs).count(), "{text}: {property}");
    }
}

/// Each with its verdict at the end of the run, and if that end is final.
const AT_THE_END: [(&str, [&str; 2]); 8] = [
    ("eventually (Move, BT, m[1] = <success>) or time_until (Move, BT, m[1] = <halted>) < 100", ["inconclusive"; 2]),
    (
        "eventually (Move, BT, m[1] = <success>) or time_until (Move, BT, m[1] = <halted>) < 2",
        ["inconclusive", "violated"],
    ),
    ("time_until (Move, BT, m[1] = <halted>) < 100", ["inconclusive"; 2]),
    ("time_until (Move, BT, m[1] = <halted>) < 2", ["violated"; 2]),
    ("not time_until (Move, BT, m[1] = <halted>) < 100", ["satisfied"; 2]),
    ("not eventually (Move, BT, m[1] = <success>)", ["satisfied"; 2]),
    ("(not (Move, BT, m[1] = <success>)) until (Move, BT, m[1] = <success>)", ["inconclusive", "violated"]),
    ("always ((Move, BT, m[1] = <running>) implies next (Move, BT, m[1] = <running>))", ["inconclusive", "violated"]),
];

#[test]
fn the_end_of_a_run_decides_what_no_open_deadline_could_still_meet() {
    let folder = tempdir().unwrap();
    let properties = AT_THE_END.iter().enumerate().map(|(place, (text, _))| format!("property p{place} := {text}\n"));
    let lines = "execution.max_time_s = 6\nexpect.errors = [\"Move\"]";
    let scenario = application(folder.path(), &properties.collect::<String>(), lines);
    for (place, is_final) in [false, true].into_iter().enumerate() {
        let set = format!("stop.final_for={is_final}");
        let found = report(scenario.to_str().unwrap(), &folder.path().join("out"), &["--set", &set]);
        for ((text, verdicts), monitor) in AT_THE_END.iter().zip(found["monitors"].as_array().unwrap()) {
            assert_eq!(monitor["verdict"], verdicts[place], "{text}, final: {is_final}: {monitor}");
            if verdicts[0] == "inconclusive" && verdicts[place] == "violated" {
                assert_eq!((&monitor["time_s"], &monitor["tick"]), (&json!(6.0), &json!(5)), "{text}: {monitor}");
            }
        }
    }
}

/// Move is asked again and again, and never succeeds.
const MISSED: &str = "
property ticks := always ((BT, Move, m[1] = <tick>) implies time_until (Move, BT, m[1] = <success>) < 2)
timed property seconds :=
    always ((BT, Move, m[1] = <tick>) implies time_until (Move, BT, m[1] = <success>) < 1500 ms)
";

#[test]
fn each_deadline_that_is_missed_again_is_counted_at_its_time() {
    let folder = tempdir().unwrap();
    let lines = "execution.max_time_s = 9.5\nexpect.errors = [\"Move\"]";
    let scenario = application(folder.path(), MISSED, lines);
    let (out, log) = (folder.path().join("out"), folder.path().join("log.jsonl"));
    let found = report(scenario.to_str().unwrap(), &out, &["--record", log.to_str().unwrap()]);
    let log = fs::read_to_string(log).unwrap();
    let lines: Vec<Value> = log.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let number = |line: &Value, field: &str| line[field].as_f64().unwrap();
    let ticks = lines.iter().filter(|line| line["generated"] == "tick");
    let ticks: Vec<f64> = ticks.map(|line| number(line, "time_s")).collect();
    let asked = lines.iter().filter(|line| line["to"] == "Move" && line["message"][0]["sym"] == "tick");
    let asked: Vec<&Value> = asked.collect();
    // By ticks, a deadline passes with a tick; by time, it is noticed at the next tick or message, and is the moment.
    let last_s = ticks.last().copied().unwrap();
    let in_ticks: Vec<f64> =
        asked.iter().filter_map(|line| ticks.get(line["tick"].as_u64().unwrap() as usize + 2).copied()).collect();
    let in_time = asked.iter().map(|line| ((number(line, "time_s") + 1.5) * 1e9).round() / 1e9);
    let in_time: Vec<f64> = in_time.filter(|due_s| *due_s <= last_s).collect();
    assert!(in_ticks.len() > 3 && in_time.len() > 3, "{log}");
    for (place, due_s) in [in_ticks, in_time].iter().enumerate() {
        let (monitor, first_s) = (&found["monitors"][place], due_s[0]);
        let violations = &monitor["violations"];
        assert_eq!((&monitor["verdict"], &violations["count"]), (&json!("violated"), &json!(due_s.len())), "{monitor}");
        let from: Vec<f64> = violations["first"].as_array().unwrap().iter().map(|one| number(one, "from_s")).collect();
        assert_eq!(&from, due_s, "{monitor}");
        // None is ever over.
        assert_eq!(violations["total_s"], ((9.5 - first_s) * 1e9).round() / 1e9, "{monitor}");
        assert_eq!(number(monitor, "time_s"), first_s, "{monitor}");
    }
}

/// The deadline lies between two ticks, and the second one shows that it was missed.
#[test]
fn a_missed_deadline_has_the_same_time_in_all_results() {
    let folder = tempdir().unwrap();
    let lines = "execution.max_time_s = 9.5\nexpect = { ticks = \"violated\", seconds = \"violated\" }\n\
                 [[faults]]\nkind = \"halt_lost\"\nat_s = 0.5\nleaf = \"Move\"";
    let scenario = application(folder.path(), MISSED, lines);
    let scenario = scenario.to_str().unwrap();
    let [file, campaign, log, out] =
        ["campaign.toml", "campaign", "log.jsonl", "out"].map(|name| folder.path().join(name));
    fs::write(&file, "scenario = \"scenario.toml\"\nruns = 1\n").unwrap();
    let output = steward(&["campaign", file.to_str().unwrap(), "--out", campaign.to_str().unwrap()]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let journal = fs::read_to_string(campaign.join("journal.jsonl")).unwrap();
    let record: Value = serde_json::from_str(journal.lines().nth(1).unwrap()).unwrap();
    // The same run, with its event log, and its summary.
    let seed = record["seed"].to_string();
    let found = report(scenario, &out, &["--seed", &seed, "--record", log.to_str().unwrap()]);
    let said = steward(&["run", scenario, "--seed", &seed, "--no-snapshots", "--out", out.to_str().unwrap()]).stdout;
    let log = fs::read_to_string(log).unwrap();
    let lines: Vec<Value> = log.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let nanoseconds = |line: &Value| (line["time_s"].as_f64().unwrap() * 1e9).round();
    let asked = lines.iter().find(|line| line["to"] == "Move" && line["message"][0]["sym"] == "tick").unwrap();
    let due = nanoseconds(asked) + 1.5e9;
    let ticks = lines.iter().filter(|line| line["generated"] == "tick").map(nanoseconds);
    let tick = ticks.clone().filter(|time| *time <= due).count() - 1;
    assert!(ticks.clone().all(|time| time != due) && ticks.clone().any(|time| time > due), "{log}");
    let (monitor, facts) = (&found["monitors"][1], &record["facts"]);
    let in_campaign = &facts["monitors"][1];
    let from_s = &monitor["violations"]["first"][0]["from_s"];
    for time_s in [&monitor["time_s"], &monitor["witness"]["time_s"], from_s, &in_campaign["time_s"]] {
        assert_eq!(*time_s, json!(due / 1e9), "{monitor} {in_campaign}");
    }
    assert_eq!([&monitor["tick"], &in_campaign["tick"]], [&json!(tick); 2]);
    let onset = (facts["fault_onset_s"].as_f64().unwrap() * 1e9).round();
    assert_eq!(in_campaign["latency_s"], json!((due - onset) / 1e9), "{record}");
    let said = String::from_utf8_lossy(&said);
    assert!(said.contains(&format!("at tick {tick}, {:.2} s", due / 1e9)), "{said}");
}

/// Both properties, of which the scenario says nothing, are violated.
const BAD: &str = "property rests := always not (Move, BT, m[1] = <running>)
property fine := always true
";

#[test]
fn as_expected_means_the_same_in_a_run_and_in_a_campaign() {
    let folder = tempdir().unwrap();
    let scenario = application(folder.path(), BAD, "execution.max_time_s = 1");
    let cases = [
        ("", false),
        ("expect={fine='satisfied'}", false),
        ("expect.rests='violated'", true),
        ("expect.rests='any'", true),
    ];
    for (place, (set, is_as_expected)) in cases.into_iter().enumerate() {
        let options: &[&str] = if set.is_empty() { &[] } else { &["--set", set] };
        let run = report(scenario.to_str().unwrap(), &folder.path().join("run"), options);
        assert_eq!(run["outcome"] == "as_expected", is_as_expected, "{set}");
        let file = folder.path().join(format!("campaign{place}.toml"));
        let set = if set.is_empty() { String::new() } else { format!("{set:?}") };
        let goal = "[goal]\ntest = \"expectation\"\nbound = 0.5\nindifference = 0.3\nerror = 0.1\n";
        fs::write(&file, format!("scenario = \"scenario.toml\"\nruns = 12\nset = [{set}]\n{goal}")).unwrap();
        let out = folder.path().join(format!("out{place}"));
        let output = steward(&["campaign", file.to_str().unwrap(), "--out", out.to_str().unwrap()]);
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        let summary: Value = serde_json::from_slice(&fs::read(out.join("summary.json")).unwrap()).unwrap();
        let (runs, none) = (summary["runs"].as_u64().unwrap(), 0);
        let [met, not] = ["as_expected", "not_as_expected"].map(|name| summary["outcomes"][name].as_u64().unwrap());
        assert_eq!((met, not), if is_as_expected { (runs, none) } else { (none, runs) }, "{set}: {said}");
        assert_eq!(summary["goal"]["side"], if is_as_expected { "below" } else { "above" }, "{set}: {said}");
        let repeated =
            steward(&["campaign", file.to_str().unwrap(), "--only", "0", "--out", out.join("only").to_str().unwrap()]);
        assert_eq!(repeated.status.code(), Some(i32::from(!is_as_expected)), "{set}");
        if !is_as_expected {
            assert!(said.contains("expected rests not to be violated"), "{said}");
        }
    }
}

/// Rows of a campaign's table stand for several properties only if all their numbers are equal.
#[test]
fn properties_with_different_numbers_are_not_one_row() {
    let folder = tempdir().unwrap();
    let fine = (1..6).map(|number| format!("property p{number} := always true\n")).collect::<String>();
    let idle =
        "property idle NUMBER := always ((Move, BT, m[1] = <success>) implies next (Move, BT, m[1] = <running>))\n";
    let idle = (1..6).map(|number| idle.replace(" NUMBER", &number.to_string())).collect::<String>();
    // In half of the runs, something happens that the last two need.
    let some = "property some NUMBER := always ((BT, Move, m[1] = <halt>) implies true)\n";
    let some = (1..3).map(|number| some.replace(" NUMBER", &number.to_string())).collect::<String>();
    application(folder.path(), &(fine + &idle + &some), "expect.errors = [\"Move\"]\nexecution.max_time_s = 6");
    let file = folder.path().join("campaign.toml");
    let parameter = "[[parameters]]\nkey = \"execution.max_time_s\"\nvalues = [1, 6]\n";
    fs::write(
        &file,
        format!("scenario = \"scenario.toml\"\nruns = 4\nsampling = \"grid\"\n{parameter}").replace("runs = 4\n", ""),
    )
    .unwrap();
    let out = folder.path().join("out");
    let output = steward(&["campaign", file.to_str().unwrap(), "--out", out.to_str().unwrap()]);
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
    let summary: Value = serde_json::from_slice(&fs::read(out.join("summary.json")).unwrap()).unwrap();
    let numbers = |name: &str| {
        let all = summary["properties"].as_array().unwrap();
        let of = all.iter().find(|property| property["of"] == name).unwrap();
        (of["count"].clone(), of["vacuous"].clone(), of["inconclusive"].clone())
    };
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    for text in [said.replace('\n', " "), page] {
        for (first, rest) in text.match_indices(", each: ").map(|(at, words)| (&text[..at], &text[at + words.len()..]))
        {
            let end = rest.find(|c: char| !(c.is_alphanumeric() || ", ".contains(c))).unwrap_or(rest.len());
            let names: Vec<&str> = rest[..end].split(", ").map(|name| name.split(' ').next().unwrap()).collect();
            assert!(
                names.iter().all(|name| numbers(name) == numbers(names[0])),
                "{names:?} after {}",
                &first[first.len().saturating_sub(80)..]
            );
        }
        assert!(text.contains("each: p1, p2, p3, p4, p5"), "{text}");
    }
}

/// No number of seconds has digits that its nanoseconds do not have.
#[test]
fn numbers_of_seconds_have_no_noise() {
    fn check(value: &Value, place: &str) {
        match value {
            Value::Object(fields) => {
                fields.iter().filter(|(key, _)| *key != "timing").for_each(|(key, value)| check(value, key));
            }
            Value::Array(items) => items.iter().for_each(|item| check(item, place)),
            Value::Number(number) if place.ends_with("_s") => {
                let text = number.to_string();
                let decimals = text.split_once('.').map_or(0, |(_, decimals)| decimals.len());
                assert!(decimals <= 9, "{place} = {text}");
            }
            _ => {}
        }
    }
    let folder = tempdir().unwrap();
    let scenario = application(folder.path(), BAD, "execution = { max_time_s = 9.1, tick_s = 0.14 }");
    let log = folder.path().join("log.jsonl");
    let found = report(scenario.to_str().unwrap(), &folder.path().join("out"), &["--record", log.to_str().unwrap()]);
    check(&found, "");
    assert!(found["monitors"][0]["violations"]["total_s"].is_number(), "{found}");
    for line in fs::read_to_string(log).unwrap().lines() {
        check(&serde_json::from_str(line).unwrap(), "");
    }
}
