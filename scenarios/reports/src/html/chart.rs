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
use drawing::path::number;
use drawing::time_axis::TimeAxis;
use maud::{Markup, html};
use recording::RunView;

use super::figure::{self, Drawing, Layout};
use crate::timeline::Timeline;

use happenings::Happening;
use lanes::Group;
use plots::Plot;
use sheet::{Chart, Sizes};

pub(super) use data::data;

/// The timeline of a run: a drawing for each layout, and the wide one again on sheets for paper.
pub(super) fn figure(view: &RunView, timeline: &Timeline, label: &str) -> Markup {
    const ID: &str = "whole-timeline";
    let (mut wide, breaks) = draw(view, timeline, Layout::Wide);
    let [width, height] = [wide.width, wide.height].map(number);
    let sheets = sheets(&breaks, wide.height);
    wide.canvas.name(ID);
    html! {
        // A drawing to which another one refers must not be hidden itself, but what is around it may be.
        div.whole { (figure::inline(wide, Layout::Wide.class(), label)) }
        (figure::inline(draw(view, timeline, Layout::Narrow).0, Layout::Narrow.class(), label))
        @for [top, bottom] in sheets {
            svg.sheet viewBox={ "0 " (number(top)) " " (width) " " (number(bottom - top)) } aria-hidden="true" {
                use href={ "#" (ID) } width=(width) height=(height) {}
            }
        }
    }
}

/// From where to where each sheet of paper goes, if the drawing may be divided at these heights.
fn sheets(breaks: &[f64], height: f64) -> Vec<[f64; 2]> {
    /// What fits onto a page of A4 beside the section's title, at the width of the page.
    const ROOM: f64 = 1060.0;
    let (mut sheets, mut top) = (Vec::new(), 0.0);
    while height - top > ROOM {
        let last = breaks.iter().rfind(|at| **at > top && **at <= top + ROOM);
        let bottom = last.copied().unwrap_or(top + ROOM);
        sheets.push([top, bottom]);
        top = bottom;
    }
    sheets.push([top, height]);
    sheets
}

/// Draws the timeline of a run. Also returns the heights at which it may be divided.
pub(super) fn draw(view: &RunView, timeline: &Timeline, layout: Layout) -> (Drawing, Vec<f64>) {
    let sizes = Sizes::of(layout);
    let happenings = happenings::of(view, timeline);
    let groups = lanes::groups(view, timeline);
    let mut chart = Chart::new(timeline, &happenings, sizes);
    chart.draw(timeline, &happenings, &groups, &plots::plots(view, timeline));
    let height = chart.y;
    let mut canvas = Canvas::for_browsers();
    chart.grid(&mut canvas, height);
    canvas.append(chart.canvas);
    (Drawing { canvas, width: sizes.width, height }, chart.breaks)
}

/// The meaning of the colors and signs on the timeline.
pub(super) fn caption(view: &RunView, timeline: &Timeline) -> Markup {
    let happenings = happenings::of(view, timeline);
    let groups = lanes::groups(view, timeline);
    // One caption serves the wide chart and the narrow one: it explains what at least one of them shows.
    let charts = [Layout::Wide, Layout::Narrow].map(|layout| Chart::new(timeline, &happenings, Sizes::of(layout)));
    html! {
        (lanes::colors(view, &groups, &charts))
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
        Self { canvas: Canvas::for_browsers(), axis, sizes, plot, y: 4.0, breaks: Vec::new() }
    }

    fn draw(&mut self, timeline: &Timeline, happenings: &[Happening], groups: &[Group], plots: &[Plot]) {
        self.axis_labels();
        self.shortened_labels();
        let top = self.y;
        self.happenings(happenings);
        for plot in plots {
            self.breaks.push(self.y);
            self.plot(plot, timeline);
        }
        for group in groups {
            self.group(group);
        }
        self.happening_lines(happenings, top);
        self.y += 4.0;
        self.axis_labels();
    }
}
