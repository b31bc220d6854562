//! The summary for people at the end of a run.

use std::path::Path;
use std::process::ExitCode;

use anstyle::Style;
use campaigns::Error;
use diagnostics::counted;
use monitors::Outcome;
use recording::length;
use reports::html;
use reports::report::{BatteryReport, MonitorReport, OutcomeReport, Report, TreeErrorReport};

use crate::interrupt;
use crate::output::{BAD, GOOD, HEAD, OPEN, Text, complain_of, print_wrapped};

/// Summarizes a run, and returns the matching exit status. In quiet mode, only a run that was not as expected or was
/// interrupted is reported, on stderr.
pub(crate) fn print(report: &Report, folder: &Path, quiet: bool) -> Result<ExitCode, Error> {
    let mut text = Text::default();
    write_outcome(&mut text, report);
    if !quiet {
        write_summary(&mut text, report, folder);
        print_wrapped(text)?;
    } else if report.outcome != OutcomeReport::AsExpected {
        complain_of(text);
    }
    Ok(ExitCode::from(match report.outcome {
        OutcomeReport::AsExpected => 0,
        OutcomeReport::NotAsExpected => 1,
        OutcomeReport::Interrupted => interrupt::STATUS,
    }))
}

/// Whether it is no run of a simulation: such a recording has no seed, and nothing was expected of it.
fn is_recording(report: &Report) -> bool {
    matches!(report.ended, "recorded" | "cut_off")
}

/// Whether the run was as expected, and what differs.
fn write_outcome(text: &mut Text, report: &Report) {
    text.paint(HEAD, &report.scenario, 0);
    if is_recording(report) {
        *text += ": a recording\n";
        return;
    }
    *text += format!(", seed {}: ", report.seed);
    match report.outcome {
        OutcomeReport::AsExpected if report.expectations.is_empty() => text.paint(OPEN, "nothing was expected", 0),
        OutcomeReport::AsExpected => text.paint(GOOD, "as expected", 0),
        OutcomeReport::NotAsExpected => text.paint(BAD, "NOT as expected", 0),
        OutcomeReport::Interrupted => {
            text.paint(OPEN, "interrupted", 0);
            *text += format!(" after {:.1} s of simulated time; this is what happened until then", report.sim_time_s);
        }
    }
    *text += "\n";
    report.differences.iter().for_each(|words| *text += format!("  ! {words}\n"));
}

fn write_summary(text: &mut Text, report: &Report, folder: &Path) {
    let widest = report.monitors.iter().map(|monitor| monitor.name.chars().count()).fold(7, usize::max).min(32);
    let widest = report.skill_errors.iter().map(|error| error.kind.len()).fold(widest, usize::max);
    for monitor in &report.monitors {
        *text += format!("  {:<widest$}  ", monitor.name);
        let evidence = evidence(monitor);
        let name = monitor.found().name();
        text.paint(style(monitor.verdict), name, if evidence.is_empty() { 0 } else { 14 });
        *text += evidence + "\n";
        let violations = monitor.violations.as_ref().and_then(|violations| violations.words.as_ref());
        for note in violations
            .into_iter()
            .chain(&monitor.unsure)
            .chain(&monitor.open)
            .chain(&monitor.vacuous)
            .chain(&monitor.unheard)
            .chain(&monitor.errors)
        {
            *text += format!("  {:<widest$}  {note}\n", "");
        }
    }
    let facts = errors(report).chain(robot(report)).chain(end(report, folder));
    facts.into_iter().for_each(|(name, words)| *text += format!("  {name:<widest$}  {words}\n"));
}

/// A fact: its subject, and what there is to report about it.
type Fact<'r> = (&'r str, String);

/// The faults, and what went wrong in the tree and in skills.
fn errors(report: &Report) -> impl Iterator<Item = Fact<'_>> {
    let faults = report.faults_in_words().into_iter().map(|(effect, when)| ("fault", format!("{effect} {when}")));
    let absent = report.absent_effects().into_iter().map(|effect| ("fault", format!("never came: {effect}")));
    let tree = report.tree_errors.iter().map(|TreeErrorReport { label, node, message, tick, time_s }| {
        ("tree", format!("{label} (node {node}): {message}; first at tick {tick}, {time_s:.2} s"))
    });
    let lost = report.lost.iter().map(|lost| ("lost", lost.clone()));
    let remarks = report.remarks.iter().map(|remark| ("note", remark.clone()));
    let failure = report.tree_failure.iter().map(|failure| ("tree", failure.words()));
    let skills = report
        .skill_errors
        .iter()
        .map(|error| (error.kind, format!("{}: {}; first at {:.2} s", error.place(), error.words(), error.time_s)));
    faults.chain(absent).chain(lost).chain(remarks).chain(tree).chain(failure).chain(skills)
}

/// Battery, robot and places; of a run without a robot, the time.
fn robot(report: &Report) -> Vec<Fact<'_>> {
    let mut facts = Vec::new();
    if let Some(BatteryReport { initial, minimum, r#final: last, empty_at_s }) = report.battery {
        let lowest = match empty_at_s {
            Some(time_s) => format!("empty at {time_s:.2} s: the robot stood still"),
            None => format!("never below {minimum:.1} %"),
        };
        let words = format!("{initial:.1} % at the start, {last:.1} % at the end, {lowest}");
        facts.push(("battery", words));
    }
    let Some(robot) = &report.robot else {
        let ticks = match report.ticks {
            // Those of a recording may be unknown.
            0 if is_recording(report) => String::new(),
            ticks => format!(", {}", counted(ticks, "tick")),
        };
        facts.push(("time", format!("{:.0} s{ticks}", report.sim_time_s)));
        return facts;
    };
    let collisions = match robot.collisions {
        0 => "no collisions".to_owned(),
        count => counted(count, "collision"),
    };
    facts.push(("robot", format!("drove {:.1} m in {:.0} s, {collisions}", robot.distance_m, report.sim_time_s)));
    if let Some(error) = robot.localization {
        let [rmse, worst] = [error.rmse_m, error.max_m].map(length);
        facts.push(("", format!("localization error {rmse} (RMSE), at most {worst}")));
    }
    facts.extend(robot.given_up_in_words().into_iter().map(|trips| ("gave up", trips)));
    facts.push(("reached", reached(report)));
    facts
}

/// Why the run ended, and which files it has left.
fn end<'r>(report: &Report, folder: &Path) -> [Fact<'r>; 2] {
    let pictures = match report.snapshots.len() {
        0 => " and report.json".to_owned(),
        1 => ", report.json and a picture".to_owned(),
        count => format!(", report.json and {count} pictures"),
    };
    let page = folder.join(html::FILE);
    [("ended", report.ended_because.to_string()), ("wrote", format!("{}{pictures}", page.display()))]
}

/// The color of a verdict.
fn style(verdict: Outcome) -> Style {
    match verdict {
        Outcome::Satisfied => GOOD,
        Outcome::Violated => BAD,
        Outcome::Inconclusive => OPEN,
    }
}

/// The places where the robot came to rest, in the order of their times. Where it stood from the start is named only if
/// it came to rest nowhere else.
fn reached(report: &Report) -> String {
    let arrivals = report.arrivals();
    let start = report.places.iter().filter(|place| place.reached_at_s.is_some() && !place.arrived);
    let start: Vec<&str> = start.map(|place| place.name.as_str()).collect();
    match (arrivals.as_slice(), start.as_slice()) {
        ([], []) => "no place".to_owned(),
        ([], names) => format!("only {}, where it started", names.join(", ")),
        (arrivals, _) => {
            arrivals.iter().map(|(at, name)| format!("{name} at {at:.1} s")).collect::<Vec<_>>().join(", ")
        }
    }
}

/// When a property was violated, and by which message, if it was.
fn evidence(monitor: &MonitorReport) -> String {
    let (Some(moment), Some(witness)) = (monitor.moment(), &monitor.witness) else {
        return String::new();
    };
    let message = witness
        .communication
        .as_ref()
        .map_or_else(String::new, |seen| format!(": {} → {} {}", seen.from, seen.to, seen.message_in_words()));
    format!("at {moment}{message}")
}
