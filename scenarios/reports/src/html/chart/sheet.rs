//! The sheet on which the chart is drawn: its sizes, its time axis and its background.

use drawing::canvas::{Anchor, Canvas, Paint, TextStyle};
use drawing::text::Font;
use drawing::time_axis::{Stretch, Tick, TimeAxis};
use drawing::{Area, Spot, theme};

use super::super::figure::{Layout, NARROW};
use super::super::words;

/// Sizes of the chart, in pixels.
#[derive(Clone, Copy)]
pub(super) struct Sizes {
    pub(super) width: f64,
    /// Where the lanes begin; their names are to the left of this, or above them if there is no room.
    pub(super) left: f64,
    pub(super) font: Font,
    pub(super) small: Font,
    pub(super) lane: f64,
    pub(super) lane_gap: f64,
    pub(super) names_above: bool,
    /// Room for a label of the time axis.
    pub(super) label_room: f64,
}

impl Sizes {
    pub(super) fn of(layout: Layout) -> Self {
        Self {
            width: layout.pick(900.0, NARROW),
            left: layout.pick(178.0, 26.0),
            font: Font::regular(layout.pick(13.0, 11.0)),
            small: Font::regular(layout.pick(11.5, 9.5)),
            lane: layout.pick(20.0, 15.0),
            lane_gap: layout.pick(4.0, 4.0),
            names_above: layout == Layout::Narrow,
            label_room: layout.pick(56.0, 40.0),
        }
    }

    /// The distance from one lane to the next.
    pub(super) fn pitch(&self) -> f64 {
        self.lane + self.lane_gap + if self.names_above { self.font.line_height() } else { 0.0 }
    }
}

/// An unfinished chart: its drawing, and how far down it extends.
pub(super) struct Chart {
    pub(super) canvas: Canvas,
    pub(super) axis: TimeAxis,
    pub(super) sizes: Sizes,
    pub(super) plot: Area,
    pub(super) y: f64,
    /// Where it may be divided: no lane or plot is there.
    pub(super) breaks: Vec<f64>,
}

impl Chart {
    pub(super) fn axis_labels(&mut self) {
        let style = TextStyle::new(self.sizes.small, theme::MUTED).anchored(Anchor::Middle);
        let y = self.y + self.sizes.small.line_height() / 2.0;
        for Tick { x, label } in self.axis.ticks(self.sizes.label_room) {
            self.centered((x, y), &label, style);
        }
        self.y += self.sizes.small.line_height() + 6.0;
    }

    /// Labels compressed stretches with their durations.
    pub(super) fn shortened_labels(&mut self) {
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

    /// Draws a text centered at a place, or as near to it as the edges allow.
    pub(super) fn centered(&mut self, (x, y): Spot, text: &str, style: TextStyle) {
        let half = style.font.width(text) / 2.0;
        let x = x.max(half + 1.0).min(self.sizes.width - half - 1.0);
        self.canvas.centered_text((x, y), text, style);
    }

    /// Draws the background: lines at the labeled times, and compressed stretches.
    pub(super) fn grid(&self, canvas: &mut Canvas, height: f64) {
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
