//! All parameters of a scenario with their effective values, and the command that runs it again.

mod given;

use maud::{Markup, html};
use recording::RunView;

use super::markup::{self, row};
use crate::report::Report;

/// Whether there are any: a recording from elsewhere has those of its mapping, if it has one.
pub(super) fn are_known(view: &RunView) -> bool {
    let origin = &view.header().origin;
    origin.recorded.is_none() || !given::of(origin).is_empty()
}

/// The section with the parameters.
pub(super) fn section(view: &RunView) -> Markup {
    if !are_known(view) {
        return Markup::default();
    }
    let is_recorded = view.header().origin.recorded.is_some();
    let given = given::of(&view.header().origin);
    let content = html! {
        div.panel {
            h3 { (if is_recorded { "Settings of the mapping" } else { "Settings of the scenario" }) }
            div.scroll {
                table.parameters { tbody { @for given in &given { (given.row()) } } }
            }
            @if !is_recorded { (settings_in_effect(view)) }
        }
    };
    markup::section("parameters", "Parameters", content)
}

/// The settings of a simulation, given or not.
fn settings_in_effect(view: &RunView) -> Markup {
    html! {
        details {
            summary {
                "Everything else: "
                @if view.header().robot.is_some() { "robot, world and " }
                "execution in effect"
            }
            div.groups {
                @for group in &view.header().settings {
                    div {
                        h4 { code { (group.title) } }
                        table.parameters {
                            tbody { @for (about, value) in &group.rows { (row(markup::prose(about), [html! { code { (value) } }])) } }
                        }
                    }
                }
            }
        }
    }
}

/// The section with the command line.
pub(super) fn reproduction(view: &RunView, report: &Report) -> Markup {
    let is_recorded = view.header().origin.recorded.is_some();
    let content = html! {
        div.panel {
            pre.command { (markup::command(&command(view, report))) }
            @if is_recorded { p { "The hash of the events is " code { (report.trace_hash) } "." } }
            @else if let Some(outside) = outside(view) { p {
                (outside) " took part from outside the program: another run need not be the same, and the verdicts are \
                 about the messages that have arrived from there. The hash of this one's trace is "
                code { (report.trace_hash) } "."
            } }
            @else if view.has_acts() { p {
                "Without what was done by hand: " em { "Save as scenario" } " on the live page makes a scenario that gives \
                 the same run. The hash of this one's trace is " code { (report.trace_hash) } "."
            } }
            @else { p {
                "With version " (report.version) " of the program, this gives the same run to the last bit on any \
                 machine of the same kind. The hash of its trace is " code { (report.trace_hash) } "."
            } }
            p { "Beside this page: " a href="report.json" { "report.json" } ", the same as data." }
            @if !report.snapshots.is_empty() {
                ul.files { @for picture in &report.snapshots { li { a href=(picture.file) { (picture.file) } } } }
            }
        }
    };
    markup::section("reproduce", if is_recorded { "Check it again" } else { "Run it again" }, content)
}

/// What took part in a run from outside the program, if anything did.
fn outside(view: &RunView) -> Option<String> {
    let header = view.header();
    let driver = header.is_piloted.then(|| "The robot's controller".to_owned());
    driver.or_else(|| (!header.remote.is_empty()).then(|| header.remote.join(", ")))
}

/// The command line that runs the scenario again.
pub(super) fn command(view: &RunView, report: &Report) -> String {
    let origin = &view.header().origin;
    if let Some(command) = &origin.recorded {
        return command.clone();
    }
    let how = if view.header().is_piloted { "sim" } else { "run" };
    let mut command = format!("steward {how} {} --seed {}", quoted(&origin.argument), report.seed);
    for assignment in &origin.overrides {
        command += &format!(" --set {}", quoted(assignment));
    }
    if view.header().unwatched {
        command += " --no-monitors";
    }
    command
}

/// A word quoted for a shell.
#[must_use]
pub fn quoted(word: &str) -> String {
    let plain = |character: char| character.is_ascii_alphanumeric() || "-_./=:,+@%".contains(character);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shell_reads_every_quoted_word_as_one() {
        assert_eq!(quoted("battery.initial_pct=35"), "battery.initial_pct=35");
        assert_eq!(quoted("faults=[]"), "'faults=[]'");
        assert_eq!(quoted("about=it's"), r"'about=it'\''s'");
    }
}
