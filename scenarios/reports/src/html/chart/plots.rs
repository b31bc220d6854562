//! Numbers over time: the battery's level, and the signals in properties.

use std::time::Duration;

use drawing::canvas::{Anchor, Paint, TextStyle};
use drawing::icons::Icon;
use drawing::path::Path;
use drawing::{Area, Spot, theme};
use recording::RunView;

use super::super::words;
use super::sheet::Chart;
use crate::bounds;
use crate::timeline::Timeline;

/// A number over time, with the numbers that properties compare with it.
pub(super) struct Plot {
    pub(super) title: String,
    /// Times and values, joined by lines.
    pub(super) points: Vec<(Duration, f64)>,
    /// The least and the greatest value for which there is room.
    pub(super) range: [f64; 2],
    /// The labeled values.
    pub(super) ticks: Vec<f64>,
    /// The numbers, greatest first: with a label, and whether a property requires it by itself.
    pub(super) bounds: Vec<(f64, String, bool)>,
    is_battery: bool,
}

/// The battery's level, if there is a battery, and the signals in properties.
pub(super) fn plots(view: &RunView, timeline: &Timeline) -> Vec<Plot> {
    let levels = bounds::thresholds(view.header()).into_iter();
    let levels = levels
        .map(|one| (one.level_pct, format!("{} % {}", words::decimals(one.level_pct, 1), one.label), one.critical));
    let battery = Plot {
        title: "Battery, in percent".to_owned(),
        points: timeline.battery().points(),
        range: [0.0, 100.0],
        ticks: vec![0.0, 50.0, 100.0],
        bounds: levels.collect(),
        is_battery: true,
    };
    let signals = timeline.signals().iter().map(|steps| {
        let (signal, points) = (steps.signal(), steps.points(timeline.end()));
        let values = points.iter().map(|(_, value)| *value).chain(signal.bounds.iter().map(|(bound, ..)| *bound));
        let [low, high] =
            values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)]);
        let room = if high > low { 0.06 * (high - low) } else { 0.5 };
        let range = [low - room, high + room];
        let bounds =
            signal.bounds.iter().map(|(bound, label, critical)| (*bound, format!("{bound} {label}"), *critical));
        let title = signal.title(view.topology());
        Plot { title, points, range, ticks: round_numbers(low, high), bounds: bounds.collect(), is_battery: false }
    });
    let mut plots: Vec<Plot> = std::iter::once(battery).chain(signals).filter(|plot| !plot.points.is_empty()).collect();
    plots.iter_mut().for_each(|plot| plot.bounds.sort_by(|a, b| b.0.total_cmp(&a.0)));
    plots
}

/// Two to five round numbers in a range.
fn round_numbers(low: f64, high: f64) -> Vec<f64> {
    let rough = ((high - low) / 3.0).max(1e-9);
    let power = libm::pow(10.0, libm::floor(libm::log10(rough)));
    let step =
        [1.0, 2.0, 5.0, 10.0].into_iter().map(|factor| factor * power).find(|step| *step >= rough).unwrap_or(rough);
    let first = libm::ceil(low / step) as i64;
    (first..).map(|number| number as f64 * step).take_while(|number| *number <= high + 1e-9 * step).take(6).collect()
}

impl Chart {
    /// Draws a number as a line, with the numbers of properties and, of the battery, the times of charging.
    pub(super) fn plot(&mut self, plotted: &Plot, timeline: &Timeline) {
        self.heading(&plotted.title);
        let height = if self.sizes.names_above { 92.0 } else { 120.0 } * if plotted.is_battery { 1.0 } else { 0.7 };
        let plot = Area::new(self.plot.x, self.y + 4.0, self.plot.width, height);
        if plotted.is_battery {
            self.charging(plot, timeline);
        }
        self.scale(plot, plotted);
        let points = plotted.points.iter();
        let spots: Vec<Spot> = points.map(|&(time, value)| (self.axis.x(time), plotted.y(plot, value))).collect();
        // Points closer together than this make the page larger, and the line no better.
        let spots = drawing::map_panel::thinned(spots.into_iter(), 0.6);
        if let (Some(first), Some(last)) = (spots.first(), spots.last()) {
            let ground = [(last.0, plot.bottom()), (first.0, plot.bottom())];
            let filled = Path::through(spots.iter().copied().chain(ground)).close();
            self.canvas.path(&filled, Paint::fill(theme::INK).fill_opacity(0.06));
            self.canvas.path(&Path::through(spots.iter().copied()), Paint::stroke(theme::INK, 2.0));
        }
        self.thresholds(plot, plotted);
        self.y = plot.bottom() + 12.0;
    }

    fn scale(&mut self, plot: Area, plotted: &Plot) {
        for value in &plotted.ticks {
            let y = plotted.y(plot, *value);
            self.canvas.line((plot.x, y), (plot.right(), y), Paint::stroke(theme::RULE, 1.0));
            let style = TextStyle::new(self.sizes.small, theme::MUTED).anchored(Anchor::End);
            self.canvas.centered_text((plot.x - 6.0, y), &words::decimals(*value, 3), style);
        }
    }

    fn thresholds(&mut self, plot: Area, plotted: &Plot) {
        let lines: Vec<f64> = plotted.bounds.iter().map(|(bound, ..)| plotted.y(plot, *bound)).collect();
        // If there is no room beside the plot, labels are inside it, above or below their lines, and cross no line.
        let is_inside = self.sizes.names_above;
        let offsets: &[f64] =
            if is_inside { &[-0.6, 0.6, -1.6, 1.6] } else { &[0.0, -0.5, 0.5, -1.0, 1.0, -1.5, 1.5, -2.0, 2.0] };
        let mut taken: Vec<f64> = Vec::new();
        for ((_, label, critical), y) in plotted.bounds.iter().zip(&lines) {
            let (line, ink) = if *critical { (theme::BAD, theme::BAD) } else { (theme::BUSY, theme::BUSY_DARK) };
            self.canvas.line((plot.x, *y), (plot.right(), *y), Paint::stroke(line, 1.3).dashed("5 4"));
            // The labels of close thresholds must not touch: each takes the nearest free height.
            let pitch = self.sizes.small.line_height();
            let crosses_none = |y: &f64| !is_inside || lines.iter().all(|line| (line - y).abs() >= 0.5 * pitch);
            let is_free = |y: &f64| taken.iter().all(|other| (other - y).abs() >= pitch) && crosses_none(y);
            let Some(height) = offsets.iter().map(|part| y + part * pitch).find(is_free) else { continue };
            taken.push(height);
            let style = TextStyle::new(self.sizes.small, ink);
            if is_inside {
                let text = self.sizes.small.fit(label, plot.width * 0.5);
                self.canvas.centered_text((plot.x + 4.0, height), &text, style.with_halo());
            } else {
                let text = self.sizes.small.fit(label, plot.x - 38.0);
                self.canvas.centered_text((plot.x - 34.0, height), &text, style.anchored(Anchor::End));
            }
        }
    }

    fn charging(&mut self, plot: Area, timeline: &Timeline) {
        for span in timeline.charging().spans(timeline.end()).filter(|span| *span.state) {
            let (left, right) = (self.axis.x(span.from), self.axis.x(span.to));
            let area = Area::new(left, plot.y, (right - left).max(1.5), plot.height);
            self.canvas.rounded(area, 0.0, Paint::fill(theme::GOOD_LIGHT).fill_opacity(0.8));
            let room = right - left;
            let middle = (left + room / 2.0, plot.y + 11.0);
            let text = "charging";
            let width = self.sizes.small.width(text);
            if room > width + 30.0 {
                Icon::Bolt.draw(&mut self.canvas, (middle.0 - width / 2.0 - 7.0, middle.1), 12.0, theme::GOOD);
                let style = TextStyle::new(self.sizes.small, theme::GOOD).anchored(Anchor::Middle);
                self.canvas.centered_text((middle.0 + 4.0, middle.1), text, style);
            } else if room > 14.0 {
                Icon::Bolt.draw(&mut self.canvas, middle, 12.0, theme::GOOD);
            }
        }
    }
}

impl Plot {
    /// Where a value is in this area.
    fn y(&self, plot: Area, value: f64) -> f64 {
        let [low, high] = self.range;
        plot.bottom() - plot.height * ((value - low) / (high - low)).clamp(0.0, 1.0)
    }
}
