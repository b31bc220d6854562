//! The map with the robot's path, colored by what the tree was doing.

use drawing::canvas::{Anchor, Paint, TextStyle};
use drawing::labels::Site;
use drawing::map_panel::{self, MapDrawing};
use drawing::path::Path;
use drawing::text::Font;
use drawing::view::View;
use drawing::{Area, Mark, Scene, Spot, theme};
use maps::Point;
use recording::RunView;

use super::activities::Activity;
use super::figure::{Drawing, Layout, NARROW};
use super::picture::on_map;
use crate::pictures::{Camera, violation_mark};
use crate::timeline::Timeline;

/// If there are more stages than this, only those in which the robot drove have a number on the map.
const MOST_NUMBERS: usize = 12;
/// It drove if it covered at least this distance, in meters.
const LEAST_M: f64 = 0.5;

/// The contents of the map: the run's last moment, without the robot's readings and plans. None without a map.
pub(super) fn scene(run: &RunView, timeline: &Timeline) -> Option<Scene> {
    /// More faults than this are marked without words: the list beside the map has the words.
    const MOST_WORDS: usize = 4;
    let mut scene = Camera::new(run).frame(run, "").scene?;
    let has_words = |fault: &&mut Mark| !fault.label.is_empty();
    scene.faults.iter_mut().filter(has_words).skip(MOST_WORDS).for_each(|fault| fault.label.clear());
    let violations = timeline
        .episodes()
        .iter()
        .filter_map(|episode| violation_mark(run.monitor(episode.property), episode.position?));
    scene.violations = violations.collect();
    scene.laser_hits.clear();
    scene.particles.clear();
    scene.path.clear();
    scene.trail.clear();
    Some(scene)
}

/// Draws the map, with a path by odometry alone if there is one.
pub(super) fn draw(scene: &Scene, activities: &[Activity], odometry: &[Point], layout: Layout) -> Drawing {
    // A phone has no room for words that the page has elsewhere.
    let mut scene = scene.clone();
    if layout.pick(false, true) {
        scene.faults.iter_mut().chain(&mut scene.violations).for_each(|mark| mark.label.clear());
    }
    let scene = &scene;
    on_map(scene, layout.pick(660.0, NARROW), layout.pick("map-wide", "map-narrow"), |canvas, view| {
        // Labels keep clear of everything drawn before them, so they come last.
        let font = Font::regular(layout.pick(13.5, 10.5));
        let mut drawing = MapDrawing::new(canvas, view, scene, font);
        drawing.areas();
        let spots = map_panel::thinned(view.spots(odometry), 1.0);
        drawing.canvas.path(&Path::through(spots), Paint::stroke(theme::MUTED, 2.0).dashed("5 4"));
        way(&mut drawing, &view, activities);
        drawing.bodies();
        drawing.places();
        drawing.robot();
        drawing.faults();
        drawing.violations();
        drawing.write_labels();
        numbers(&mut drawing, &view, activities, layout);
    })
}

/// Draws the trail: one line per stage on a light background.
fn way(drawing: &mut MapDrawing<'_>, view: &View, activities: &[Activity]) {
    for ground in [true, false] {
        for activity in activities {
            let points: Vec<Point> = activity.stage.points.iter().map(|(_, point)| *point).collect();
            let spots = map_panel::thinned(view.spots(&points), 1.0);
            let path = Path::through(spots.iter().copied());
            match ground {
                true => drawing.canvas.path(&path, Paint::stroke(theme::PAPER, 7.0).stroke_opacity(0.8)),
                false => drawing.canvas.path(&path, Paint::stroke(activity.color, 3.4)),
            }
            if !ground {
                drawing.placer.avoid_line(spots);
            }
        }
    }
}

/// Whether there are so many stages that only those in which the robot drove have a number on the map.
pub(super) fn is_crowded(activities: &[Activity]) -> bool {
    activities.iter().filter(|activity| activity.number.is_some()).count() > MOST_NUMBERS
}

/// Draws the number of each stage near where it began.
fn numbers(drawing: &mut MapDrawing<'_>, view: &View, activities: &[Activity], layout: Layout) {
    let font = Font::bold(layout.pick(12.0, 10.0));
    let radius = layout.pick(9.5, 8.0);
    let crowded = is_crowded(activities);
    for activity in activities.iter().filter(|activity| !crowded || activity.stage.distance_m() >= LEAST_M) {
        let begin = activity.stage.points.first().and_then(|(_, point)| view.spot(*point));
        let (Some(number), Some(spot)) = (activity.number, begin) else { continue };
        let site = Site { symbol: Area::around(spot, 12.0, 12.0), roomy: false };
        let area = drawing.placer.place(&site, (2.0 * radius, 2.0 * radius));
        let center: Spot = area.center();
        drawing.canvas.line(spot, center, Paint::stroke(activity.color, 1.4));
        drawing.canvas.circle(center, radius, Paint::fill(activity.color).outlined(theme::PAPER, 1.4));
        let style = TextStyle::new(font, theme::PAPER).anchored(Anchor::Middle);
        drawing.canvas.centered_text(center, &number.to_string(), style);
    }
}
