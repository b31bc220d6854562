//! The report as a page: `report.html`, one self-contained file that tells a stranger what happened in a run.
//!
//! It needs no network and no script, has a light and a dark set of colours, and can be read on a phone and on paper:
//! every chart is drawn twice, for wide and for narrow surroundings. The same run gives the same bytes; how long the
//! computer took is not on it.
//!
//! Charts are drawn on the canvas of all pictures ([`drawing`]), which measures its texts; on the page each text is told
//! how long to be, so that nothing overlaps with whatever fonts a reader has.

mod activities;
mod chart;
mod colors;
mod evidence;
mod facts;
mod figure;
mod map;
mod markup;
pub mod picture;
mod pictures;
mod said_once;
mod sequence;
mod settings;
#[cfg(test)]
mod tests;
mod verdicts;
mod violations;
mod words;

use diagnostics::Staging;
use monitors::Outcome;
use recording::RunView;

use crate::Error;
use crate::report::Report;
use crate::timeline::Timeline;

pub use pictures::Picture;

pub use figure::{Drawing, Layout, NARROW, figure};
pub use markup::{escape, text};

/// The name of the page's file.
pub const FILE: &str = "report.html";

const STYLE: &str = include_str!("html/style.css");

/// Writes the page of a run in its last step beside the report's snapshots.
///
/// # Errors
/// [`Error::Write`] if the page cannot be written, and what keeps a snapshot from being read.
pub fn write(folder: &Staging, view: &RunView, timeline: &Timeline, report: &Report) -> Result<(), Error> {
    let mut pictures = Vec::new();
    for snapshot in &report.snapshots {
        pictures.push(Picture { snapshot: snapshot.clone(), png: folder.read(&snapshot.file)? });
    }
    Ok(folder.write(FILE, page(view, timeline, report, &pictures))?)
}

/// The page of a run in its last step.
#[must_use]
pub fn page(view: &RunView, timeline: &Timeline, report: &Report, pictures: &[Picture]) -> String {
    let sections = [
        verdicts::section(view, timeline, report),
        way(view, timeline, report),
        course(view, timeline),
        violations::section(view, timeline),
        pictures::section(pictures),
        settings::section(view),
        settings::reproduction(view, report),
    ];
    let title = format!("{} · seed {} · {}", escape(&report.scenario), report.seed, in_a_word(report));
    document(&title, &format!("{}{}", head(view, report), sections.concat()))
}

/// A page with that title, both of them markup: self-contained, with the colours and the style of all pages.
pub fn document(title: &str, main: &str) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"generator\" content=\"steward {}\">\n<title>{title}</title>\n\
         <link rel=\"icon\" href=\"data:,\">\n<style>\n{}{STYLE}</style>\n</head>\n<body>\n<main>\n{main}</main>\n</body>\n</html>\n",
        env!("CARGO_PKG_VERSION"),
        colors::definitions(),
    )
}

/// The verdicts for the page's title.
fn in_a_word(report: &Report) -> String {
    let verdicts: Vec<String> =
        report.monitors.iter().map(|monitor| format!("{} {}", escape(&monitor.name), monitor.verdict)).collect();
    if verdicts.is_empty() { "no property watched".to_owned() } else { verdicts.join(", ") }
}

fn head(view: &RunView, report: &Report) -> String {
    let links = [
        ("verdicts", "Verdicts"),
        ("way", "Map"),
        ("timeline", "Timeline"),
        ("violations", "Messages"),
        ("pictures", "Pictures"),
        ("parameters", "Parameters"),
        ("reproduce", "Run it again"),
    ];
    let violated = report.monitors.iter().any(|monitor| monitor.verdict == Outcome::Violated);
    let links: String = links
        .iter()
        .filter(|(id, _)| (*id != "violations" || violated) && (*id != "pictures" || !report.snapshots.is_empty()))
        .map(|(id, words)| format!("<a href=\"#{id}\">{words}</a>"))
        .collect();
    format!(
        "<header class=\"head\">\n<p class=\"over\">A run of a service robot under runtime monitors</p>\n<h1>{}</h1>\n\
         <p class=\"about\">{}</p>\n<p class=\"quiet\">seed {} · {} simulated · {}</p>\n<nav>{links}</nav>\n</header>\n",
        escape(&report.scenario),
        text(&words::sentence(&view.header().about)),
        report.seed,
        words::time(view.time()),
        words::count(report.ticks, "tick"),
    )
}

/// The section of the map.
fn way(view: &RunView, timeline: &Timeline, report: &Report) -> String {
    let activities = activities::activities(timeline);
    let scene = map::scene(view);
    let label = "Map with the way of the robot, coloured by which leaf of the behavior tree was running";
    let map = figure(label, |layout| map::draw(&scene, &activities, view, timeline, layout));
    format!(
        "<section id=\"way\">\n<h2>Where the robot went</h2>\n<div class=\"panel way\">\n<figure>{map}<figcaption>The way \
         is coloured by what the behavior tree was doing; the numbers are those of the table and of the \
         timeline.</figcaption></figure>\n<div>\n{}{}{}{}</div>\n{}</div>\n</section>\n",
        facts::stages(&activities),
        facts::faults(report),
        facts::tree_errors(report),
        facts::skill_errors(report),
        facts::numbers(report),
    )
}

/// The section of the timeline.
fn course(view: &RunView, timeline: &Timeline) -> String {
    let label = "Timeline of battery, behavior tree, skills, components, monitors and faults on one time axis";
    let chart = figure(label, |layout| chart::draw(view, timeline, layout));
    format!(
        "<section id=\"timeline\">\n<h2>What happened when</h2>\n<figure class=\"panel\">{chart}<figcaption>Green: success; \
         red: failure; orange: running; a thin line: not ticked. The time axis is drawn shorter where, on a grey ground, \
         nothing changes but the battery.</figcaption></figure>\n</section>\n"
    )
}
