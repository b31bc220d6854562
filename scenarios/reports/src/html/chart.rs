//! The run on one time axis: battery, what the tree was doing, its leaves, skills, components and monitors.

mod battery;
mod happenings;
mod lanes;
mod sheet;

use std::time::Duration;

use drawing::Area;
use drawing::canvas::Canvas;
use drawing::time_axis::TimeAxis;
use recording::RunView;

use super::figure::{Drawing, Layout};
use crate::timeline::Timeline;

use happenings::Happening;
use lanes::Group;
use sheet::{Chart, Sizes};

/// Draws the timeline of a run.
pub(super) fn draw(view: &RunView, timeline: &Timeline, layout: Layout) -> Drawing {
    let sizes = Sizes::of(layout);
    let happenings = happenings::of(view, timeline);
    let groups = lanes::groups(timeline);
    let plot = Area::new(sizes.left, 0.0, sizes.width - sizes.left - 14.0, 0.0);
    let axis = TimeAxis::around_changes(timeline.end(), changes(timeline, &happenings), plot);
    let mut chart = Chart { canvas: Canvas::for_browsers(), axis, sizes, plot, y: 4.0 };
    chart.draw(timeline, &happenings, &groups);
    let height = chart.y;
    let mut canvas = Canvas::for_browsers();
    chart.grid(&mut canvas, height);
    canvas.append(chart.canvas);
    Drawing { canvas, width: sizes.width, height }
}

/// When something changes besides the battery's level.
fn changes(timeline: &Timeline, happenings: &[Happening]) -> Vec<Duration> {
    /// A lane that changes all the time says nothing about what is worth the room.
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
    fn draw(&mut self, timeline: &Timeline, happenings: &[Happening], groups: &[Group]) {
        self.axis_labels();
        self.shortened_labels();
        let top = self.y;
        self.happenings(happenings);
        self.battery(timeline);
        for group in groups {
            self.group(group);
        }
        self.happening_lines(happenings, top);
        self.y += 4.0;
        self.axis_labels();
    }
}
