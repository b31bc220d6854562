//! The report as a page: `report.html`, one self-contained file that explains to a stranger what happened in a run.
//!
//! It needs no network, has a light and a dark color scheme, and can be read on a phone and on paper: every chart is
//! drawn twice, for wide and for narrow screens. With a script, a reader explores the timeline; without it, the page
//! has the same contents. The page allows this script and no other. The same run gives the same bytes: how long the
//! computer took is not on the page.
//!
//! Charts are drawn on the canvas of all pictures ([`drawing`]), which measures its texts. The page prescribes the
//! length of each text, so that nothing overlaps whatever fonts a reader has.

mod activities;
mod chart;
mod colors;
mod evidence;
mod facts;
mod figure;
pub mod live;
mod logs;
mod map;
mod markup;
pub mod picture;
mod pictures;
mod sent_once;
mod sequence;
mod settings;
#[cfg(test)]
mod tests;
mod tree;
mod verdicts;
mod violations;
mod words;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use diagnostics::{Staging, counted};
use drawing::{Renderer, Scene};
use maud::{DOCTYPE, Markup, PreEscaped, html};
use monitors::Outcome;
use recording::{RunView, ShownVerdict};
use sha2::{Digest, Sha256};

use crate::Error;
use crate::file_name;
use crate::report::{MonitorReport, Report};
use crate::timeline::Timeline;

use activities::Activity;
use pictures::Album;
use violations::Story;

pub use pictures::Picture;
pub use settings::quoted;

pub use logs::{Day, LogRow, logs};

pub use figure::{Drawing, Layout, NARROW, figure};
pub use markup::{command, row, section, table, text};

/// The name of the page's file.
pub const FILE: &str = "report.html";
/// How the names of charts begin.
pub(crate) const CHART: &str = "sequence-";

/// A page should open quickly on a phone: pictures beyond this total size are linked, not shown.
const MOST_BYTES: usize = 780_000;

const STYLE: &str = include_str!("html/style.css");

/// Draws the timeline anew as one explores it.
const SCRIPT: &str = include_str!("html/timeline.js");

/// Writes the page of a finished run beside the report's snapshots.
///
/// # Errors
/// [`Error::File`] if the page cannot be written, or the error of reading a snapshot.
pub fn write(folder: &Staging, view: &RunView, timeline: &Timeline, report: &Report) -> Result<(), Error> {
    let mut pictures = Vec::new();
    for snapshot in &report.snapshots {
        pictures.push(Picture { snapshot: snapshot.clone(), png: folder.read(&snapshot.file)? });
    }
    Ok(folder.write(FILE, page(view, timeline, report, &pictures))?)
}

/// The story of each violation, as it is on the page: the number of the property, and sentences with code in
/// backquotes.
pub(crate) fn stories(view: &RunView, timeline: &Timeline) -> impl Iterator<Item = (usize, Vec<String>)> {
    violations::in_sentences(view, timeline)
}

/// Writes the sequence chart of each violation, as SVG and PNG, beside the page.
///
/// # Errors
/// [`Error`] if something cannot be drawn or written.
pub fn write_charts(folder: &Staging, view: &RunView, timeline: &Timeline) -> Result<(), Error> {
    let renderer = Renderer::new();
    for (property, [svg, embedded]) in violations::pictures(view, timeline) {
        let name = format!("{CHART}{}", file_name(&property));
        folder.write(format!("{name}.svg"), svg)?;
        folder.write(format!("{name}.png"), renderer.png(&embedded)?)?;
    }
    Ok(())
}

/// The page of a finished run.
#[must_use]
pub fn page(view: &RunView, timeline: &Timeline, report: &Report, pictures: &[Picture]) -> String {
    let recorded = view.header().origin.recorded.is_some();
    let seed = if recorded { String::new() } else { format!(" · seed {}", report.seed) };
    let title = format!("{}{seed} · {}", report.scenario, in_a_word(report));
    let before = html! {
        (head(view, report))
        // A recording has no expectations.
        @if !recorded { (verdicts::outcome(report)) }
    };
    let stories = violations::stories(view, timeline);
    let between = html! {
        (verdicts::section(view, timeline, report))
        @if !recorded { (way(view, timeline, report)) } @else { (recorded_way(view, timeline)) }
        (course(view, timeline))
    };
    let after = html! {
        (settings::section(view))
        (settings::reproduction(view, report))
    };
    let parts = [before.0.len(), between.0.len(), after.0.len(), STYLE.len()];
    let used: usize = parts.into_iter().chain(stories.iter().map(Story::len)).sum();
    let album = Album::new(pictures, MOST_BYTES.saturating_sub(used));
    let main = html! {
        (before)
        (violations::section(&stories, |story| album.violation(&story.name)))
        (between)
        (album.section())
        (after)
    };
    document_with(SCRIPT, &title, &main)
}

/// A self-contained page with this title, in the colors and the style of all pages.
pub fn document(title: &str, main: &Markup) -> String {
    document_with("", title, main)
}

/// The same, with a script unless that is empty.
fn document_with(script: &str, title: &str, main: &Markup) -> String {
    let allowed = format!("'sha256-{}'", BASE64.encode(Sha256::digest(script)));
    let policy = format!("default-src 'none'; style-src 'unsafe-inline'; img-src data:; script-src {allowed}");
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta http-equiv="Content-Security-Policy" content=(policy);
                meta name="generator" content={ "steward " (env!("CARGO_PKG_VERSION")) };
                title { (title) }
                link rel="icon" href="data:,";
                style { (PreEscaped(colors::definitions())) (PreEscaped(STYLE)) }
            }
            body {
                main { (main) }
                @if !script.is_empty() { script { (PreEscaped(script)) } }
            }
        }
    };
    // Users' texts may contain characters that are not allowed in a page, and maud lets them through.
    let is_space = |character| matches!(character, '\t' | '\n' | '\r');
    let mut page = page.into_string();
    page.retain(|character| {
        is_space(character) || !character.is_control() && !matches!(character, '\u{fffe}' | '\u{ffff}')
    });
    page
}

/// The verdicts for the page's title.
fn in_a_word(report: &Report) -> String {
    let verdict = |monitor: &MonitorReport| match monitor.found() {
        ShownVerdict::Groundless => format!("{} without a verdict", monitor.name),
        found => format!("{} {found}", monitor.name),
    };
    let verdicts: Vec<String> = report.monitors.iter().map(verdict).collect();
    if verdicts.is_empty() { "no property watched".to_owned() } else { verdicts.join(", ") }
}

fn head(view: &RunView, report: &Report) -> Markup {
    let has_map = view.header().premises.is_some();
    let recorded = view.header().origin.recorded.is_some();
    let what = match () {
        () if recorded => "A recording under runtime monitors",
        () if has_map => "A run of a service robot under runtime monitors",
        () => "A run of a behavior tree under runtime monitors",
    };
    let links = [
        ("violations", "What went wrong"),
        ("verdicts", "Verdicts"),
        ("way", if has_map { "Map" } else { "Tree" }),
        ("timeline", "Timeline"),
        ("pictures", "Pictures"),
        ("parameters", "Parameters"),
        ("reproduce", if recorded { "Check it again" } else { "Run it again" }),
    ];
    let violated = report.monitors.iter().any(|monitor| monitor.verdict == Outcome::Violated);
    // The page has no section for what did not happen, and a link must lead somewhere.
    let is_there = |id| {
        (id != "violations" || violated)
            && (id != "way" || !recorded || has_map || tree::is_known(view))
            && (id != "parameters" || settings::are_known(view))
            && (id != "pictures" || report.snapshots.iter().any(|snapshot| snapshot.violated.is_none()))
    };
    html! {
        header.head {
            p.over { (what) }
            h1 { (report.scenario) }
            p.about { (text(&words::sentence(&view.header().about))) }
            p.quiet {
                @if !recorded { "seed " (report.seed) " · " }
                (words::time(view.time())) (if recorded { " recorded" } else { " simulated" })
                @if view.header().knows_ticks() { " · " (counted(report.ticks, "tick")) }
            }
            @for said in report.lost.iter().chain(&report.remarks) { p { (text(&words::sentence(said))) } }
            nav { @for (id, words) in links.into_iter().filter(|(id, _)| is_there(*id)) { a href={ "#" (id) } { (words) } } }
        }
    }
}

/// The section with the map and what the tree was doing; without a map, only the latter.
fn way(view: &RunView, timeline: &Timeline, report: &Report) -> Markup {
    let activities = activities::activities(timeline);
    let scene = map::scene(view, timeline);
    let content = html! {
        div.panel.way {
            @if let Some(scene) = &scene { (map_figure(scene, &activities, view, timeline)) }
            div {
                (facts::numbers(view, report))
                (facts::faults(report))
                (facts::tree_errors(report))
                (facts::skill_errors(report, "skill"))
                (facts::skill_errors(report, "component"))
                (facts::stages(&activities, scene.is_some()))
                (tree::outline(view))
            }
        }
    };
    section("way", if scene.is_some() { "Where the robot went" } else { "What the tree did" }, content)
}

/// The section with the map of a recording, if it has one, or else its tree.
fn recorded_way(view: &RunView, timeline: &Timeline) -> Markup {
    let Some(scene) = map::scene(view, timeline) else {
        let outline = tree::outline(view);
        let content = html! { @if tree::is_known(view) { div.panel { (outline) } } };
        return section("way", "What the tree did", content);
    };
    let odometry = &view.header().origin.odometry;
    let label = "Map with the robot's path";
    let content = html! {
        figure.panel {
            (figure(label, |layout| map::draw(&scene, &activities::activities(timeline), odometry, layout)))
            figcaption {
                "The robot’s path, by localization; its size is not known."
                @if !odometry.is_empty() { " Dashed: by odometry alone, from the first pose of localization on." }
                @if !timeline.episodes().is_empty() { " Red with ✗: where it was when a property was violated." }
            }
        }
    };
    section("way", "Where the robot went", content)
}

/// The map, with what its colors and signs mean.
fn map_figure(scene: &Scene, activities: &[Activity], view: &RunView, timeline: &Timeline) -> Markup {
    let label = "Map with the robot's path, colored by the leaf of the behavior tree that was running";
    html! {
        figure {
            (figure(label, |layout| map::draw(scene, activities, &[], layout)))
            figcaption {
                "The robot’s path, colored by the leaf of the behavior tree that was running; the numbers are \
                 those in the table and the timeline."
                @if activities::has_more_leaves_than_colors(activities) { " There are more leaves than colors." }
                @if map::is_crowded(activities) { " Stages in which it did not move are not drawn." }
                @if !view.faults().is_empty() { " Red with !: where a fault put something, or else where the robot was when it took effect." }
                @if !timeline.episodes().is_empty() { " Red with ✗: where it was when a property was violated." }
                @if !view.scene().bodies.is_empty() { " Violet: things that are not on the map, where they were \
                                                       at the end." }
            }
        }
    }
}

/// The section of the timeline.
fn course(view: &RunView, timeline: &Timeline) -> Markup {
    let label = match view.header().robot {
        Some(_) => "Timeline of battery, behavior tree, skills, components, monitors and faults on one time axis",
        None => "Timeline of behavior tree, skills, components, monitors and faults on one time axis",
    };
    let keys = "Drag it, or click and turn the wheel; the keys + − ← → and 0 do the same, comma and period go from \
                event to event";
    // Inside a script, only `</script` would end it.
    let data = chart::data(view, timeline).to_string().replace('<', "\\u003c");
    let content = html! {
        figure.panel.timeline {
            (chart::figure(view, timeline, label))
            div.explore {
                p.tools {
                    button type="button" value="+" { "zoom in" }
                    button type="button" value="-" { "zoom out" }
                    button type="button" value="0" { "whole run" }
                    output { span.fine { (keys) "." } span.coarse { "Drag it; two fingers zoom." } }
                }
                canvas tabindex="0" role="application" aria-label={ (label) ". " (keys) } {}
            }
            script type="application/json" { (PreEscaped(data)) }
            figcaption { (chart::caption(view, timeline)) }
        }
    };
    section("timeline", "What happened when", content)
}
