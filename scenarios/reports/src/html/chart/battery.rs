//! The battery's level over time.

use drawing::canvas::{Anchor, Paint, TextStyle};
use drawing::icons::Icon;
use drawing::path::Path;
use drawing::{Area, Spot, Threshold, theme};

use super::super::words;
use super::sheet::Chart;
use crate::timeline::Timeline;

impl Chart {
    /// Draws the level as a line, with thresholds and the times of charging; nothing without a battery.
    pub(super) fn battery(&mut self, timeline: &Timeline, thresholds: &[Threshold]) {
        if timeline.battery().points().is_empty() {
            return;
        }
        self.heading("Battery, in percent");
        let height = if self.sizes.names_above { 92.0 } else { 120.0 };
        let plot = Area::new(self.plot.x, self.y + 4.0, self.plot.width, height);
        self.charging(plot, timeline);
        self.scale(plot);
        let spots: Vec<Spot> = timeline
            .battery()
            .points()
            .iter()
            .map(|&(time, level)| (self.axis.x(time), height_of(plot, level)))
            .collect();
        // Points closer together than this make the page larger, and the line no better.
        let spots = drawing::map_panel::thinned(spots.into_iter(), 0.6);
        if let (Some(first), Some(last)) = (spots.first(), spots.last()) {
            let ground = [(last.0, plot.bottom()), (first.0, plot.bottom())];
            let filled = Path::through(spots.iter().copied().chain(ground)).close();
            self.canvas.path(&filled, Paint::fill(theme::INK).fill_opacity(0.06));
            self.canvas.path(&Path::through(spots.iter().copied()), Paint::stroke(theme::INK, 2.0));
        }
        self.thresholds(plot, thresholds);
        self.y = plot.bottom() + 12.0;
    }

    fn scale(&mut self, plot: Area) {
        for level in [0.0, 50.0, 100.0] {
            let y = height_of(plot, level);
            self.canvas.line((plot.x, y), (plot.right(), y), Paint::stroke(theme::RULE, 1.0));
            let style = TextStyle::new(self.sizes.small, theme::MUTED).anchored(Anchor::End);
            self.canvas.centered_text((plot.x - 6.0, y), &format!("{level:.0}"), style);
        }
    }

    fn thresholds(&mut self, plot: Area, thresholds: &[Threshold]) {
        let lines: Vec<f64> = thresholds.iter().map(|threshold| height_of(plot, threshold.level_pct)).collect();
        // If there is no room beside the plot, labels are inside it, above or below their lines, and cross no line.
        let is_inside = self.sizes.names_above;
        let offsets: &[f64] =
            if is_inside { &[-0.6, 0.6, -1.6, 1.6] } else { &[0.0, -0.5, 0.5, -1.0, 1.0, -1.5, 1.5, -2.0, 2.0] };
        let mut taken: Vec<f64> = Vec::new();
        for threshold in thresholds {
            let y = height_of(plot, threshold.level_pct);
            let (line, ink) =
                if threshold.critical { (theme::BAD, theme::BAD) } else { (theme::BUSY, theme::BUSY_DARK) };
            self.canvas.line((plot.x, y), (plot.right(), y), Paint::stroke(line, 1.3).dashed("5 4"));
            // The labels of close thresholds must not touch: each takes the nearest free height.
            let pitch = self.sizes.small.line_height();
            let crosses_none = |y: &f64| !is_inside || lines.iter().all(|line| (line - y).abs() >= 0.5 * pitch);
            let is_free = |y: &f64| taken.iter().all(|other| (other - y).abs() >= pitch) && crosses_none(y);
            let Some(height) = offsets.iter().map(|part| y + part * pitch).find(is_free) else { continue };
            taken.push(height);
            let text = format!("{} % {}", words::decimals(threshold.level_pct, 1), threshold.label);
            let style = TextStyle::new(self.sizes.small, ink);
            if is_inside {
                let text = self.sizes.small.fit(&text, plot.width * 0.5);
                self.canvas.centered_text((plot.x + 4.0, height), &text, style.with_halo());
            } else {
                let text = self.sizes.small.fit(&text, plot.x - 38.0);
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

fn height_of(plot: Area, level_pct: f64) -> f64 {
    plot.bottom() - plot.height * level_pct.clamp(0.0, 100.0) / 100.0
}
