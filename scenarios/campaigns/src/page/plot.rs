//! The common parts of all charts of a report: a frame with its axes.

use drawing::canvas::{Anchor, Canvas, Paint, TextStyle};
use drawing::scale::{Scale, short};
use drawing::text::Font;
use drawing::{Area, Spot, theme};
use reports::html::{Drawing, Layout, NARROW};

use super::super::ParameterValue;
use super::axis::Axis;

/// Width of a chart with another one beside it, and of a single chart, in pixels.
const HALF: f64 = 500.0;
const FULL: f64 = 860.0;
/// Room for labels to the left of a plot, below it, above it and to its right, in pixels.
const LEFT: f64 = 54.0;
const BELOW: f64 = 46.0;
const ABOVE: f64 = 12.0;
const RIGHT: f64 = 16.0;

const FONT: Font = Font::regular(12.0);
/// Distance between the middles of two labels below an axis, in pixels.
const BETWEEN: f64 = 54.0;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Size {
    /// With another chart beside it if the page is wide.
    Half,
    /// As wide as the page.
    Full,
}

/// An unfinished chart: the area of its plot, and what is drawn in it.
pub(super) struct Plot {
    pub(super) canvas: Canvas,
    pub(super) area: Area,
}

impl Plot {
    /// An empty plot whose height is a fraction of its width.
    pub(super) fn new(size: Size, layout: Layout, height_share: f64) -> Self {
        let wide = if size == Size::Half { HALF } else { FULL };
        let width = layout.pick(wide, NARROW);
        let plot_width = width - LEFT - RIGHT;
        let height = plot_width * layout.pick(height_share, height_share.max(0.6));
        Self { canvas: Canvas::for_browsers(), area: Area::new(LEFT, ABOVE, plot_width, height) }
    }

    /// The same, with the title of the left axis above it.
    pub(super) fn with_title(mut self, title: &str) -> Self {
        let style = TextStyle::new(FONT, theme::INK);
        let title = FONT.fit(&format!("↑ {title}"), self.area.width + LEFT - 4.0);
        self.canvas.text((4.0, FONT.size), &title, style);
        self.area.y += FONT.size;
        self
    }

    pub(super) fn finish(self) -> Drawing {
        let (width, height) = (self.area.right() + RIGHT, self.area.bottom() + BELOW);
        Drawing { canvas: self.canvas, width, height }
    }

    /// A place in the plot, as fractions of its two axes.
    pub(super) fn at(&self, x: f64, y: f64) -> Spot {
        (self.area.x + x * self.area.width, self.area.bottom() - y * self.area.height)
    }

    /// A part of the plot, as fractions of its two axes.
    pub(super) fn part(&self, x: [f64; 2], y: [f64; 2]) -> Area {
        let ((left, bottom), (right, top)) = (self.at(x[0], y[0]), self.at(x[1], y[1]));
        Area::new(left, top, right - left, bottom - top)
    }

    /// Draws the axis below the plot, with its title.
    pub(super) fn x_axis(&mut self, axis: &Axis, title: &str) {
        let most = (self.area.width / BETWEEN) as usize;
        let base = self.area.bottom();
        let style = TextStyle::new(FONT, theme::MUTED).anchored(Anchor::Middle);
        for (share, label) in labels(axis, most) {
            let (x, _) = self.at(share, 0.0);
            self.canvas.line((x, base), (x, base + 4.0), Paint::stroke(theme::LINE, 1.0));
            self.canvas.text((x, base + 17.0), &label, style);
        }
        let title = FONT.fit(title, self.area.width + LEFT);
        let middle = (self.area.x + self.area.width / 2.0).max(FONT.width(&title) / 2.0 + 2.0);
        self.canvas.text((middle, base + 37.0), &title, TextStyle { color: theme::INK, ..style });
        let (left, right) = ((self.area.x, base), (self.area.right(), base));
        self.canvas.line(left, right, Paint::stroke(theme::LINE, 1.0));
    }

    /// Draws the axis to the left of the plot, with lines across the plot if `lines` is set.
    pub(super) fn y_axis(&mut self, axis: &Axis, lines: bool, write: impl Fn(String) -> String) {
        let most = (self.area.height / 34.0) as usize;
        let style = TextStyle::new(FONT, theme::MUTED).anchored(Anchor::End);
        for (share, label) in labels(axis, most) {
            let (x, y) = self.at(0.0, share);
            if lines {
                self.canvas.line((x, y), (self.area.right(), y), Paint::stroke(theme::RULE, 1.0));
            }
            self.canvas.centered_text((x - 7.0, y), &write(label), style);
        }
        let (top, bottom) = ((self.area.x, self.area.y), (self.area.x, self.area.bottom()));
        self.canvas.line(top, bottom, Paint::stroke(theme::LINE, 1.0));
    }

    /// Draws an axis of rates from 0 to 100 %.
    pub(super) fn rate_axis(&mut self) {
        let rates = Axis::Scale(Scale::new(0.0..100.0, false, 1));
        self.y_axis(&rates, true, |label| format!("{label} %"));
    }

    /// Draws a line from bottom to top with a label, at a fraction of the axis below.
    pub(super) fn upright(&mut self, share: f64, label: &str, paint: Paint, label_at: f64) {
        let (bottom, top) = (self.at(share, 0.0), self.at(share, 1.0));
        self.canvas.line(bottom, top, paint);
        let style = TextStyle::new(Font::bold(12.0), theme::INK).with_halo();
        let (x, y) = self.at(share, label_at);
        let fits = x + 7.0 + style.font.width(label) < self.area.right();
        let (x, anchor) = if fits { (x + 7.0, Anchor::Start) } else { (x - 7.0, Anchor::End) };
        self.canvas.centered_text((x, y), label, style.anchored(anchor));
    }
}

/// The labels of an axis and their positions, as fractions of it; at most about this many.
fn labels(axis: &Axis, most: usize) -> Vec<(f64, String)> {
    match axis {
        Axis::Scale(scale) => scale.ticks(most).into_iter().map(|tick| (scale.share(tick), short(tick))).collect(),
        Axis::Classes(values) => {
            let every = values.len().div_ceil(most.max(1));
            let label =
                |(place, value): (usize, &ParameterValue)| ((place as f64 + 0.5) / values.len() as f64, written(value));
            values.iter().enumerate().step_by(every.max(1)).map(label).collect()
        }
    }
}

/// A parameter's value for people.
pub(super) fn written(value: &ParameterValue) -> String {
    match value {
        ParameterValue::Integer(integer) => integer.to_string(),
        ParameterValue::Number(number) => short(*number),
        ParameterValue::Boolean(boolean) => boolean.to_string(),
        ParameterValue::Text(text) => text.clone(),
    }
}
