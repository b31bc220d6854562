//! The run in numbers, and stage by stage.

use std::time::Duration;

use bt::{Outcome, Status};
use diagnostics::counted;
use maud::{Markup, html};
use recording::RunView;

use super::activities::Activity;
use super::markup::{breakable, row, table, text};
use super::words;
use crate::report::{Report, TreeFailureReport};

/// If there are more stages than this, the table has only this many of the first and the last ones.
const MOST_STAGES: usize = 40;
const FIRST_STAGES: usize = 32;
/// If there are more stages than this, the table is folded: the timeline shows them, too.
const FEW_STAGES: usize = 10;

/// The most telling numbers of a run.
pub(super) fn numbers(view: &RunView, report: &Report) -> Markup {
    let percent = |level: f64| format!("{} %", words::decimals(level, 1));
    let time = |time_s: f64| words::time(Duration::from_secs_f64(time_s));
    let mut facts = vec![
        ("simulated time", time(report.sim_time_s)),
        ("ticks", overruns(report)),
        ("messages received", report.steps.to_string()),
    ];
    if let Some(battery) = &report.battery {
        let levels = [battery.initial, battery.minimum, battery.r#final].map(percent).join(", ");
        let empty = battery.empty_at_s.map(|time_s| format!("; empty at {time_s:.2} s: the robot stood still"));
        facts.push(("battery at the start, lowest, at the end", levels + &empty.unwrap_or_default()));
    }
    if let Some(robot) = &report.robot {
        facts.push(("driven", format!("{} m", words::decimals(robot.distance_m, 1))));
        facts.push(("collisions", robot.collisions.to_string()));
    }
    if let Some(error) = report.robot.as_ref().and_then(|robot| robot.localization) {
        let words = format!("{} (RMSE), at most {}", words::length(error.rmse_m), words::length(error.max_m));
        facts.push(("localization error", words));
    }
    facts.push(("ended because", report.ended_because.clone()));
    facts.extend(tree(view, report).map(|words| ("the tree", words)));
    let arrivals = report.arrivals();
    if !arrivals.is_empty() {
        let words = arrivals.iter().map(|(at_s, place)| format!("{place} ({})", time(*at_s)));
        facts.push(("reached", words.collect::<Vec<_>>().join(", ")));
    }
    if let Some(robot) = report.robot.as_ref().filter(|robot| !robot.given_up.is_empty()) {
        facts.push(("given up", robot.given_up_in_words().join("; ")));
    }
    html! {
        dl.facts { @for (name, value) in facts { div { dt { (name) } dd { (text(&value)) } } } }
    }
}

/// Whether the tree as a whole failed, and why; none without a tree, or if its answers are not known.
fn tree(view: &RunView, report: &Report) -> Option<String> {
    let last = match view.outcomes().first()?.as_ref()? {
        Outcome::Answered(Status::Running) => "was running",
        Outcome::Answered(Status::Success) => "had succeeded",
        Outcome::Answered(Status::Failure | Status::Skipped) | Outcome::Halted => "was not running",
    };
    let failure = report.tree_failure.as_ref().map(TreeFailureReport::words);
    Some(failure.unwrap_or_else(|| format!("never failed; it {last} at the end")))
}

fn overruns(report: &Report) -> String {
    match report.overruns {
        0 => report.ticks.to_string(),
        overruns => format!("{}, {overruns} of them lost", report.ticks),
    }
}

/// A table of errors or faults, with a heading for each column; empty if there are none.
fn troubles<const N: usize>(head: [&str; N], lines: &[[String; N]]) -> Markup {
    html! {
        @if !lines.is_empty() {
            @let rows = html! { @for line in lines { (row(text(&line[0]), line[1..].iter().map(|cell| text(cell)))) } };
            (table("stages faults", head, &rows))
        }
    }
}

/// The faults that took effect, then those that never came; empty if there are none.
pub(super) fn faults(report: &Report) -> Markup {
    let faults = report.faults_in_words().into_iter().map(|(effect, when)| [when, effect]);
    let absent = report.absent_effects().into_iter().map(|effect| ["never".to_owned(), effect.to_owned()]);
    troubles(["fault", "what it did"], &faults.chain(absent).collect::<Vec<_>>())
}

/// Errors in the tree; empty if there are none.
pub(super) fn tree_errors(report: &Report) -> Markup {
    let lines = report.tree_errors.iter().map(|error| {
        let first = words::time(Duration::from_secs_f64(error.time_s));
        [first, format!("{} (node {})", error.label, error.node), error.message.clone()]
    });
    troubles(["first at", "tree node", "what went wrong"], &lines.collect::<Vec<_>>())
}

/// Errors in the skills, or in the components; empty if there are none.
pub(super) fn skill_errors(report: &Report, kind: &str) -> Markup {
    let lines = report.skill_errors.iter().filter(|error| error.kind == kind).map(|error| {
        let first = words::time(Duration::from_secs_f64(error.time_s));
        [first, error.place(), error.words()]
    });
    troubles(["first at", kind, "what went wrong"], &lines.collect::<Vec<_>>())
}

/// The activities of the tree, stage by stage, with the distance driven if the robot `drives`.
pub(super) fn stages(activities: &[Activity], drives: bool) -> Markup {
    let columns = if drives { 3 } else { 2 };
    let line = |activity: &Activity| {
        let stage = &activity.stage;
        let ground = format!("background:{}", super::colors::variable(activity.color));
        let badge = html! {
            span.stage {
                span.badge style=(ground) { @if let Some(number) = activity.number { (number) } }
                span { (breakable(activity.words())) }
            }
        };
        let distance = stage.distance_m();
        let driven = if distance < 0.05 { "–".to_owned() } else { format!("{} m", words::decimals(distance, 1)) };
        let [from, length] = [stage.from, stage.to - stage.from].map(|at| words::decimals(at.as_secs_f64(), 1) + " s");
        let cells = [from, length, driven];
        row(badge, cells.into_iter().take(columns))
    };
    let mut lines: Vec<Markup> = activities.iter().map(line).collect();
    // The beginning and the end explain a run better than what a robot repeats in between.
    if lines.len() > MOST_STAGES {
        let hidden = lines.len() - MOST_STAGES;
        let note = row(format!("… {}", counted(hidden, "more stage")), [""; 3].into_iter().take(columns));
        lines.splice(FIRST_STAGES..FIRST_STAGES + hidden, [note]);
    }
    let head = ["running leaf", "from", "for", "driven"].into_iter().take(1 + columns);
    let table = table("stages", head, &html! { @for line in lines { (line) } });
    html! {
        @if activities.len() <= FEW_STAGES { (table) }
        @else { details { summary { "The stages of the run" } (table) } }
    }
}
