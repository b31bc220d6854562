//! The run on one time axis: battery, what the tree was doing, its leaves, skills, components and monitors.

mod data;
mod happenings;
mod lanes;
mod looks;
mod plots;
mod sheet;

use std::time::Duration;

use drawing::Area;
use drawing::canvas::Canvas;
use drawing::time_axis::TimeAxis;
use maud::{Markup, html};
use recording::RunView;

use super::figure::{Drawing, Layout};
use crate::timeline::Timeline;

use happenings::Happening;
use lanes::Group;
use plots::Plot;
use sheet::{Chart, Sizes};

pub(super) use data::data;

/// Draws the timeline of a run.
pub(super) fn draw(view: &RunView, timeline: &Timeline, layout: Layout) -> Drawing {
    let sizes = Sizes::of(layout);
    let happenings = happenings::of(view, timeline);
    let groups = lanes::groups(view, timeline);
    let mut chart = Chart::new(timeline, &happenings, sizes);
    chart.draw(timeline, &happenings, &groups, &plots::plots(view, timeline));
    let height = chart.y;
    let mut canvas = Canvas::for_browsers();
    chart.grid(&mut canvas, height);
    canvas.append(chart.canvas);
    Drawing { canvas, width: sizes.width, height }
}

/// The meaning of the colors and signs on the timeline.
pub(super) fn caption(view: &RunView, timeline: &Timeline) -> Markup {
    let happenings = happenings::of(view, timeline);
    let groups = lanes::groups(view, timeline);
    // One caption serves the wide chart and the narrow one: it explains what at least one of them shows.
    let charts = [Layout::Wide, Layout::Narrow].map(|layout| Chart::new(timeline, &happenings, Sizes::of(layout)));
    html! {
        (lanes::colors(&groups, &charts))
        @if charts.iter().any(|chart| chart.is_crowded(&groups)) {
            " Gray marks: changes that follow each other too quickly to be drawn individually."
        }
        @if happenings.iter().any(Happening::has_held) { " Light red columns: a fault in effect." }
        @if plots::plots(view, timeline).iter().any(|plot| !plot.bounds.is_empty()) {
            " Dashed lines: numbers in the properties named there, red where one requires it."
        }
        @if charts[0].axis.shortened().next().is_some() {
            " The time axis is compressed where the background is gray and only numbers change."
        }
    }
}

/// The times at which something other than the battery's level changes.
fn changes(timeline: &Timeline, happenings: &[Happening]) -> Vec<Duration> {
    /// The changes of a lane with more changes than this are ignored.
    const RESTLESS: usize = 300;
    let mut changes: Vec<Duration> = happenings.iter().map(|happening| happening.time).collect();
    let mut add = |times: Vec<Duration>| {
        if times.len() < RESTLESS {
            changes.extend(times);
        }
    };
    add(timeline.charging().changes().collect());
    add(timeline.navigation().changes().collect());
    timeline.leaves().iter().for_each(|lane| add(lane.track.changes().collect()));
    timeline.skills().iter().for_each(|lane| add(lane.track.changes().collect()));
    timeline.components().iter().for_each(|lane| add(lane.track.changes().collect()));
    timeline.monitors().iter().for_each(|lane| add(lane.track.changes().collect()));
    changes
}

impl Chart {
    fn new(timeline: &Timeline, happenings: &[Happening], sizes: Sizes) -> Self {
        let plot = Area::new(sizes.left, 0.0, sizes.width - sizes.left - 14.0, 0.0);
        let axis = TimeAxis::around_changes(timeline.end(), changes(timeline, happenings), plot);
        Self { canvas: Canvas::for_browsers(), axis, sizes, plot, y: 4.0 }
    }

    fn draw(&mut self, timeline: &Timeline, happenings: &[Happening], groups: &[Group], plots: &[Plot]) {
        self.axis_labels();
        self.shortened_labels();
        let top = self.y;
        self.happenings(happenings);
        plots.iter().for_each(|plot| self.plot(plot, timeline));
        for group in groups {
            self.group(group);
        }
        self.happening_lines(happenings, top);
        self.y += 4.0;
        self.axis_labels();
    }
}
