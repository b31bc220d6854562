//! The messages about wrong files: snapshots of the rendered text.

use std::time::Duration;

use miette::{Diagnostic, GraphicalReportHandler, GraphicalTheme};

use crate::robot::topology;

fn render(diagnostic: &dyn Diagnostic) -> String {
    let handler = GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor()).with_width(120);
    let mut text = String::new();
    handler.render_report(&mut text, diagnostic).expect("writing to a string");
    text.lines().map(str::trim_end).collect::<Vec<_>>().join("\n")
}

/// The problems or warnings of a file.
fn said_of(text: &str) -> (usize, String) {
    match monitors::load("wrong.scope", text, &topology(), Duration::from_secs(1)) {
        Ok(file) => (0, if file.warnings.is_empty() { String::new() } else { render(&file.warnings) }),
        Err(error) => (error.problems().iter().filter(|problem| problem.is_error()).count(), render(&error)),
    }
}

#[test]
fn ten_mistakes_give_ten_diagnostics_each_at_its_place() {
    let text = r#"// Ten mistakes.
const limit := 20
propery p1 := always (BatteryReader, BatteryLevel, m[2] >= limit)
property p2 := alway (BatteryReader, BatteryLevel, m[2] >= limit)
property p3 := always (BateryReader, BatteryLevel, m[2] >= limit)
property p4 := always (BatteryLevel, Navigation, m[1] = <ok>)
property p5 := always (BatteryReader, BatteryLevel, m.charge >= 20)
property p6 := always (Navigation, GoToDestination, m[2] = <runing>)
property p7 := always (BatteryReader, BatteryLevel, m[1] >= 20)
property p8 := (BatteryReader, BatteryLevel, m[2] >= 20)
property p9 := always (BatteryReader, BatteryLevel, m[2] >= limt)
property p10 := time_until (BatteryReader, BatteryLevel, m[2] >= 20) = 2.5 s
"#;
    let (errors, said) = said_of(text);
    insta::assert_snapshot!(said);
    assert_eq!(errors, 10);
}

#[test]
fn unreadable_text_is_reported_with_what_was_expected() {
    let text = r#"const a := 5 parsecs
const b := "without an end
const a = 3
property p := always ((BatteryReader, BatteryLevel, m[0] >= 20)
property q := always (BatteryReader BatteryLevel, m[1] = <ok>)
property r := always (BatteryReader, BatteryLevel, m[1] == <ok> && m[2] > 3)
property s := always (BatteryReader, BatteryLevel, always m[1] = <ok>)
property t := always not
property u := always (BatteryReader, BatteryLevel, m[1] = <ok>) always
property v := always (BatteryReader, BatteryLevel, m[1] = <ok>))
property w := always ((always (BatteryReader, BatteryLevel, m[1] = <ok>)
property x := time_until (BatteryReader, BatteryLevel, m[1] = <ok>)
# property y
"#;
    insta::assert_snapshot!(said_of(text).1);
}

#[test]
fn a_file_in_another_language_is_one_mistake_that_names_the_language() {
    let files = [
        ("{\n  \"jani-version\": 1, \"name\": \"m\", \"properties\": [{\"name\": \"p\"}]\n}\n", "a JANI model"),
        ("[1, 2]", "JSON"),
        ("\n<?xml version=\"1.0\"?>\n<scxml initial=\"a\"><state id=\"a\"/></scxml>", "an SCXML machine"),
        ("<root/>", "XML"),
    ];
    for (text, language) in files {
        let (errors, said) = said_of(text);
        assert_eq!(errors, 1, "{said}");
        assert!(said.contains(&format!("this is {language}, not a file of SCOPE properties")), "{said}");
        assert!(said.contains("property NAME := always"), "{said}");
    }
}

#[test]
fn operators_of_other_logics_are_refused_with_a_suggestion() {
    let q = "(BatteryReader, BatteryLevel, true)";
    let said = |formula: &str| said_of(&format!("property p := {formula}")).1;
    assert!(said(&format!("once {q}")).contains("not, next, always, eventually, true, false, time_until"));
    assert!(said(&format!("always (once {q})")).contains("not, next, always, eventually, true, false, time_until"));
    assert!(said(&format!("always {q} since {q}")).contains("the binary operators: and, or, implies, until"));
    assert!(said(&format!("always ({q} implise {q})")).contains("did you mean `implies`?"));
    assert!(said(&format!("alwys {q}")).contains("did you mean `always`?"));
}

/// Five thousand mistakes give five thousand problems, and no more.
#[test]
fn many_mistakes_are_reported_once_each() {
    let wrong = |n: u32| format!("property p{n} := once (BatteryReader, BatteryLevel, true) and (a, b");
    let text: String = (0..5_000).map(|n| wrong(n) + "\n").collect();
    let error = monitors::load("wrong.scope", &text, &topology(), Duration::from_secs(1)).expect_err("it is wrong");
    assert_eq!(error.problems().len(), 5_000);
    let all = vec!["(BatteryReader, BatteryLevel, m[2] > 3)"; 20_000].join(" and ");
    let error = monitors::load("wrong.scope", &format!("property p := {all}"), &topology(), Duration::from_secs(1));
    assert_eq!(error.expect_err("no operator").problems().len(), 20_000);
}

#[test]
fn conditions_are_checked_against_the_channel() {
    let text = r#"const time := 30 s
property a := always (BatteryReader, BatteryLevel, m[3] = 5)
property b := always (BatteryReader, BatteryLevel, m[2] = true)
property c := always (BatteryReader, BatteryLevel, m[1] < <ok>)
property d := always (BatteryLevel, BatteryReader, m[2] < time)
property e := always time_until (BatteryReader, BatteryLevel, m[2] < time) < -3
property f := always time_until (BatteryReader, BatteryLevel, m[2] < 3) < 2.5
property g := always time_until (BatteryReader, BatteryLevel, m[2] < 3) < <soon>
property h := always (Navigation, BatteryReader, true)
property i := always (AtRechargingStation, Navigation, true)
property j := always (GoToDestination, Navigation, m[1] = <start>)
property j := always (GoToDestination, Navigation, always = <start>)
"#;
    insta::assert_snapshot!(said_of(text).1);
}

#[test]
fn properties_that_can_never_fail_or_never_hold_are_warned_of() {
    let text = r#"property valid := always ((BatteryReader, BatteryLevel, m[2] < 20) or not (BatteryReader, BatteryLevel, m[2] < 20))
property never := eventually false
property always_false := always false
property contradictory := always (BatteryReader, BatteryLevel, m[2] < 20 and m[2] > 30)
property large := always ((BatteryReader, BatteryLevel, m[2] < 20) implies
    time_until (BatteryReader, BatteryLevel, m[2] > 30) = 40 and
    time_until (Navigation, GoToDestination, m[2] = <running>) = 40)
property fine := always (BatteryReader, BatteryLevel, m[2] < 20)
"#;
    insta::assert_snapshot!(said_of(text).1);
}
