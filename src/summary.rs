//! What a person reads at the end of a run.

use std::fmt::Write;
use std::path::Path;
use std::process::ExitCode;

use campaigns::Error;
use reports::html;
use reports::report::{MonitorReport, OutcomeReport, Report, TreeErrorReport};

use crate::output::{complain_of, print};

/// Tells how a run went, and gives the exit status that says so. A quiet program tells only of a run that was not as
/// expected, and that on stderr.
pub(crate) fn tell(report: &Report, folder: &Path, quiet: bool) -> Result<ExitCode, Error> {
    let unexpected = report.outcome == OutcomeReport::NotAsExpected;
    if !quiet {
        print(&summary(report, folder))?;
    } else if unexpected {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = write_outcome(&mut text, report);
        complain_of(&text);
    }
    Ok(ExitCode::from(u8::from(unexpected)))
}

/// The summary of a run whose files went to `folder`.
fn summary(report: &Report, folder: &Path) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write_summary(&mut text, report, folder);
    text
}

/// Whether the run was as expected, and what differs.
fn write_outcome(text: &mut String, report: &Report) -> std::fmt::Result {
    let outcome = match report.outcome {
        OutcomeReport::AsExpected => "as expected",
        OutcomeReport::NotAsExpected => "NOT as expected",
    };
    writeln!(text, "{}, seed {}: {outcome}", report.scenario, report.seed)?;
    for difference in &report.differences {
        writeln!(text, "  ! {difference}")?;
    }
    Ok(())
}

fn write_summary(text: &mut String, report: &Report, folder: &Path) -> std::fmt::Result {
    write_outcome(text, report)?;
    let widest = report.monitors.iter().map(|monitor| monitor.name.chars().count()).fold(8, usize::max).min(32);
    for monitor in &report.monitors {
        writeln!(text, "  {:<widest$} {:<12} {}", monitor.name, monitor.verdict, evidence(monitor))?;
        for note in monitor.open.iter().chain(&monitor.vacuous).chain(&monitor.errors) {
            writeln!(text, "           {note}")?;
        }
    }
    for (effect, when) in report.faults_in_words() {
        writeln!(text, "  fault    {effect} {when}")?;
    }
    for error in &report.tree_errors {
        let TreeErrorReport { label, node, message, tick, time_s } = error;
        writeln!(text, "  tree     {label} (node {node}): {message}; first in tick {tick}, {time_s:.2} s")?;
    }
    for error in &report.skill_errors {
        writeln!(text, "  skill    {}: {}; first at {:.2} s", error.place(), error.words(), error.time_s)?;
    }
    let battery = &report.battery;
    writeln!(
        text,
        "  battery  {:.1} % at the start, {:.1} % at the end, never below {:.1} %",
        battery.initial, battery.r#final, battery.minimum
    )?;
    let robot = &report.robot;
    writeln!(
        text,
        "  robot    drove {:.1} m in {:.0} s, {}, localized to {:.1} mm (rmse), {:.1} mm at worst",
        robot.distance_m,
        report.sim_time_s,
        collisions(robot.collisions),
        robot.localization.rmse_m * 1000.0,
        robot.localization.max_m * 1000.0,
    )?;
    for trips in robot.given_up_in_words() {
        writeln!(text, "  gave up  {trips}")?;
    }
    let reached: Vec<String> = report
        .places
        .iter()
        .filter_map(|place| Some((&place.name, place.reached_at_s.filter(|at| *at > 0.1)?)))
        .map(|(name, at)| format!("{name} at {at:.1} s"))
        .collect();
    writeln!(text, "  reached  {}", if reached.is_empty() { "no place".to_owned() } else { reached.join(", ") })?;
    writeln!(text, "  ended    {}", report.ended_because)?;
    let pictures = match report.snapshots.len() {
        0 => String::new(),
        1 => " and a picture".to_owned(),
        count => format!(" and {count} pictures"),
    };
    let comma = if report.snapshots.is_empty() { " and" } else { "," };
    writeln!(text, "  wrote    {}{comma} report.json{pictures}", folder.join(html::FILE).display())
}

fn collisions(count: u64) -> String {
    match count {
        0 => "no collisions".to_owned(),
        1 => "1 collision".to_owned(),
        count => format!("{count} collisions"),
    }
}

/// When and with which message a property was violated, if it was.
fn evidence(monitor: &MonitorReport) -> String {
    let (Some(tick), Some(time_s), Some(witness)) = (monitor.tick, monitor.time_s, &monitor.witness) else {
        return String::new();
    };
    let message = match (witness["from"].as_str(), witness["to"].as_str()) {
        (Some(from), Some(to)) => format!(": {from} → {to} {}", words(&witness["message"])),
        _ => String::new(),
    };
    format!("at tick {tick}, {time_s:.2} s{message}")
}

/// A message of the event log as the paper writes it: `[<ok>, 10.0]`.
fn words(message: &serde_json::Value) -> String {
    let field =
        |field: &serde_json::Value| field["sym"].as_str().map_or_else(|| field.to_string(), |sym| format!("<{sym}>"));
    let fields: Vec<String> = message.as_array().into_iter().flatten().map(field).collect();
    format!("[{}]", fields.join(", "))
}
