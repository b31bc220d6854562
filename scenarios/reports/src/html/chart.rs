//! The run on one time axis: battery, what the tree was doing, its leaves, skills, components and monitors.

mod battery;
mod happenings;
mod lanes;

use std::time::Duration;

use drawing::canvas::{Anchor, Canvas, Paint, TextStyle};
use drawing::text::Font;
use drawing::time_axis::{Stretch, Tick, TimeAxis};
use drawing::{Area, Spot, theme};
use recording::RunView;

use super::figure::{Drawing, Layout, NARROW};
use super::words;
use crate::timeline::Timeline;

use happenings::Happening;
use lanes::Group;

/// Sizes of the chart, in pixels.
#[derive(Clone, Copy)]
struct Sizes {
    width: f64,
    /// Where the lanes begin; their names stand left of it, or above them where there is no room.
    left: f64,
    font: Font,
    small: Font,
    lane: f64,
    lane_gap: f64,
    names_above: bool,
    /// Room for a label of the time axis.
    label_room: f64,
}

impl Sizes {
    fn of(layout: Layout) -> Self {
        Self {
            width: layout.pick(1080.0, NARROW),
            left: layout.pick(186.0, 26.0),
            font: Font::regular(layout.pick(13.0, 11.0)),
            small: Font::regular(layout.pick(11.5, 9.5)),
            lane: layout.pick(20.0, 15.0),
            lane_gap: layout.pick(4.0, 4.0),
            names_above: layout == Layout::Narrow,
            label_room: layout.pick(56.0, 40.0),
        }
    }

    /// How far a lane is from the next one.
    fn pitch(&self) -> f64 {
        self.lane + self.lane_gap + if self.names_above { self.font.line_height() } else { 0.0 }
    }
}

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

struct Chart {
    canvas: Canvas,
    axis: TimeAxis,
    sizes: Sizes,
    plot: Area,
    y: f64,
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

    fn axis_labels(&mut self) {
        let style = TextStyle::new(self.sizes.small, theme::MUTED).anchored(Anchor::Middle);
        let y = self.y + self.sizes.small.line_height() / 2.0;
        for Tick { x, label } in self.axis.ticks(self.sizes.label_room) {
            self.centered((x, y), &label, style);
        }
        self.y += self.sizes.small.line_height() + 6.0;
    }

    /// How long the stretches are that are drawn shorter than they are.
    fn shortened_labels(&mut self) {
        let style = TextStyle::new(self.sizes.small, theme::MUTED).anchored(Anchor::Middle);
        let stretches: Vec<Stretch> = self.axis.shortened().copied().collect();
        for stretch in &stretches {
            let text = words::roughly(stretch.to_s - stretch.from_s);
            let y = self.y + self.sizes.small.line_height() / 2.0;
            self.centered(((stretch.left + stretch.right) / 2.0, y), &text, style);
        }
        if !stretches.is_empty() {
            self.y += self.sizes.small.line_height() + 6.0;
        }
    }

    /// A text centred at a place, or as near as the edges let it.
    fn centered(&mut self, (x, y): Spot, text: &str, style: TextStyle) {
        let half = style.font.width(text) / 2.0;
        let x = x.max(half + 1.0).min(self.sizes.width - half - 1.0);
        self.canvas.centered_text((x, y), text, style);
    }

    /// The ground: lines at the labelled times, and stretches that are drawn shorter than they are.
    fn grid(&self, canvas: &mut Canvas, height: f64) {
        let room = self.sizes.small.line_height() + 8.0;
        let (top, bottom) = (room, height - room);
        for Tick { x, .. } in self.axis.ticks(self.sizes.label_room) {
            canvas.line((x, top), (x, bottom), Paint::stroke(theme::RULE, 1.0));
        }
        for stretch in self.axis.shortened() {
            let area = Area::new(stretch.left, top, stretch.right - stretch.left, bottom - top);
            canvas.rounded(area, 0.0, Paint::fill(theme::IDLE_LIGHT).fill_opacity(0.75));
            for x in [stretch.left, stretch.right] {
                canvas.line((x, top), (x, bottom), Paint::stroke(theme::IDLE, 1.2).dashed("2 5"));
            }
        }
    }
}
