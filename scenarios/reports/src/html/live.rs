//! The parts of a page that shows a run while it goes on: those of the report, for the run so far.

use std::collections::BTreeSet;
use std::time::Duration;

use drawing::canvas::Canvas;
use drawing::icons::Look;
use drawing::map_panel::{self, MapDrawing};
use drawing::text::Font;
use drawing::view::View;
use drawing::{Area, FoldedTree, MapPicture, Monitor, Scene, Verdict, theme};
use maps::{Point, pose};
use maud::{Markup, html};
use monitors::Outcome;
use recording::{Machine, MonitorView, RunView};

use super::evidence::Evidence;
use super::figure::{Drawing, sign};
use super::markup::text;
use super::{STYLE, chart, colors, figure, violations, words};
use crate::pictures::{self, Camera};
use crate::reporting;
use crate::timeline::Timeline;

/// Pixels per meter on the floor.
const PIXELS_PER_M: f64 = 40.0;
/// The maximum length of the floor's longer side, in pixels.
const LONGEST: f64 = 4000.0;

/// The style sheet with its colors.
#[must_use]
pub fn style() -> String {
    colors::definitions() + STYLE
}

/// The floor on which a run takes place, as a picture.
pub struct Floor {
    /// The picture: map, places, start and station.
    pub svg: String,
    /// Its width and height, in pixels.
    pub size: [f64; 2],
    /// The origin of the `map` frame in the picture, x₀ and y₀ in pixels, and the number of pixels per meter; x points
    /// right, and y up.
    pub origin: [f64; 3],
}

/// The floor of a run; none without a map.
#[must_use]
pub fn floor(view: &RunView) -> Option<Floor> {
    let premises = view.header().premises.as_ref()?;
    let scene = Camera::new(view).frame(view, "").scene;
    let scene = scene.unwrap_or_else(|| Scene::new(MapPicture::new(&premises.map).into(), pose(0.0, 0.0, 0.0), 0.3));
    let bounds = map_panel::bounds(&scene);
    let extent = bounds.high - bounds.low;
    let scale = PIXELS_PER_M.min(LONGEST / extent.x.max(extent.y).max(1e-3));
    let size = [extent.x * scale, extent.y * scale];
    let area = Area::new(0.0, 0.0, size[0], size[1]);
    let view = View::fitting(bounds, area);
    let mut canvas = Canvas::for_browsers();
    canvas.rounded(area, 0.0, drawing::canvas::Paint::fill(theme::UNKNOWN));
    scene.map.draw(&mut canvas, &view);
    let mut drawing = MapDrawing::new(&mut canvas, view, &scene, Font::regular(15.0));
    drawing.areas();
    drawing.places();
    drawing.write_labels();
    let zero = view.spot(Point::new(0.0, 0.0)).unwrap_or_default();
    let svg = figure::inline(Drawing { canvas, width: size[0], height: size[1] }, "floor", "Map").into_string();
    Some(Floor { svg, size, origin: [zero.0, zero.1, view.pixels(1.0)] })
}

/// A larger tree is folded, except for what is going on and what has been opened.
const TREE_ROWS: usize = 16;

/// The tree, each node with its last outcome. `opened` are the nodes, by their index, of which all children are shown,
/// however large the tree is.
#[must_use]
pub fn tree(view: &RunView, opened: &BTreeSet<usize>) -> String {
    let nodes = pictures::tree_nodes(&view.header().tree, view.outcomes());
    colors::adopted(&drawing::tree_svg(&FoldedTree::new(&nodes, TREE_ROWS, opened))).into_string()
}

/// The meaning of the sign of an inner tree node.
#[must_use]
pub fn meaning(sign: &str) -> Option<&'static str> {
    drawing::SYMBOLS.iter().find(|(known, _)| *known == sign).map(|(_, meaning)| *meaning)
}

/// A machine. Each of its states is a part of the picture (`data-state`), by its index.
#[must_use]
pub fn machine(machine: &Machine) -> String {
    colors::adopted(&pictures::machine_svg(machine)).into_string()
}

/// A line per property with its verdict so far; opened, what it requires, and how a violation happened.
#[must_use]
pub fn verdicts(view: &RunView, timeline: &Timeline) -> String {
    let evidence: Vec<Evidence<'_>> = timeline.episodes().iter().map(|episode| Evidence::of(episode, view)).collect();
    let of = |index: usize| evidence.iter().find(|evidence| evidence.episode.property == index);
    html! { @for (index, monitor) in view.monitors().enumerate() { (line(view, &monitor, of(index))) } }.into_string()
}

fn line(view: &RunView, monitor: &MonitorView<'_>, evidence: Option<&Evidence<'_>>) -> Markup {
    let picture: Monitor = pictures::monitor(*monitor, view);
    let look = Look::of_verdict(picture.verdict);
    let class = match picture.verdict {
        Verdict::Violated => Outcome::Violated,
        Verdict::Inconclusive => Outcome::Inconclusive,
        Verdict::HoldsSoFar | Verdict::Satisfied => Outcome::Satisfied,
    };
    let icon = sign(14.0, |canvas, center| look.icon.draw(canvas, center, 13.0, look.front));
    html! {
        details.property data-name=(monitor.name()) {
            summary {
                span.pill.(class) { (icon) (look.words) }
                span.name { (monitor.name()) }
                @if let Some(decision) = monitor.violation() { span.quiet { (words::time(decision.at().time)) } }
                @if monitor.state.unless.is_some() { span.quiet { "unless a message was lost" } }
            }
            p { (text(&words::sentence(&monitor.about.summary))) }
            @if let Some(unless) = &monitor.state.unless { p { "Unless " (text(unless)) "." } }
            @if let Some(evidence) = evidence { p { (violations::in_short(evidence, view)) } }
            @if !picture.diagram.locations.is_empty() {
                div.swipe tabindex="0" { (colors::adopted(&drawing::diagram_svg(&picture.diagram))) }
            }
        }
    }
}

/// The page of the report, without pictures; `None` while the run goes on.
#[must_use]
pub fn report(view: &RunView, timeline: &Timeline) -> Option<String> {
    let report = reporting::report(view, view.end()?, Vec::new(), Duration::ZERO);
    Some(super::page(view, timeline, &report, &[]))
}

/// How each violation happened, in words and as a sequence chart.
#[must_use]
pub fn stories(view: &RunView, timeline: &Timeline) -> String {
    violations::section(&violations::stories(view, timeline), |_| html! {}).into_string()
}

/// Everything on one time axis, for [`TIMELINE_SCRIPT`].
#[must_use]
pub fn course(view: &RunView, timeline: &Timeline) -> serde_json::Value {
    chart::data(view, timeline)
}

/// A script that defines `explore`, which shows a timeline.
pub const TIMELINE_SCRIPT: &str = super::SCRIPT;
