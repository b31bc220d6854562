//! The battery's level over time.

use std::time::Duration;

use super::canvas::{Anchor, Canvas, Paint, TextStyle};
use super::frame::{BatteryHistory, Threshold};
use super::geometry::{Area, Spot};
use super::icons::Icon;
use super::panel;
use super::path::Path;
use super::text::Font;
use super::theme::{self, Color};
use super::time_axis::{Tick, TimeAxis};

const FONT: Font = Font::regular(13.0);
/// The shortest time axis: a run that has just begun is not stretched over the whole width.
const SHORTEST: Duration = Duration::from_secs(10);
/// Distance between the middles of two labels on the time axis, in pixels.
const TICK_ROOM: f64 = 60.0;

/// Draws the battery's panel; `now` is where its time axis ends.
pub(super) fn draw(canvas: &mut Canvas, area: Area, battery: &BatteryHistory, now: Duration) {
    let inner = panel::titled(canvas, area, "Battery");
    level_now(canvas, area, battery);
    let labels: Vec<String> = battery
        .thresholds
        .iter()
        .map(|threshold| format!("{:.0} % {}", threshold.level_pct, threshold.label))
        .collect();
    let right = labels.iter().map(|label| FONT.width(label)).fold(0.0, f64::max).min(inner.width * 0.3);
    let left = FONT.width("100") + 8.0;
    let plot = Area::new(inner.x + left, inner.y - 4.0, inner.width - left - right - 8.0, inner.height - 18.0);
    let chart = Chart { plot, axis: TimeAxis::to_scale(now.max(SHORTEST), plot) };
    chart.axes(canvas);
    chart.thresholds(canvas, &battery.thresholds, &labels, right);
    chart.history(canvas, battery);
    chart.faults(canvas, &battery.faults);
}

/// Writes the present level at the top right, with a word if it is low or rising.
fn level_now(canvas: &mut Canvas, area: Area, battery: &BatteryHistory) {
    let below = |critical: bool| {
        battery
            .thresholds
            .iter()
            .any(|threshold| threshold.critical == critical && battery.level_pct < threshold.level_pct)
    };
    let color: Color = if below(true) {
        theme::BAD
    } else if below(false) {
        theme::BUSY_DARK
    } else {
        theme::INK
    };
    let font = Font::bold(22.0);
    let text = if battery.level_pct.is_finite() { format!("{:.1} %", battery.level_pct) } else { "unknown".to_owned() };
    let (right, middle) = (area.right() - 20.0, area.y + 26.0);
    canvas.centered_text((right, middle), &text, TextStyle::new(font, color).anchored(Anchor::End));
    if battery.charging {
        let (font, x) = (Font::regular(15.0), right - font.width(&text) - 14.0);
        canvas.centered_text((x, middle), "charging", TextStyle::new(font, theme::GOOD).anchored(Anchor::End));
        Icon::Bolt.draw(canvas, (x - font.width("charging") - 12.0, middle), 16.0, theme::GOOD);
    }
}

struct Chart {
    plot: Area,
    axis: TimeAxis,
}

impl Chart {
    fn y(&self, level_pct: f64) -> f64 {
        self.plot.bottom() - self.plot.height * level_pct.clamp(0.0, 100.0) / 100.0
    }

    fn axes(&self, canvas: &mut Canvas) {
        let plot = self.plot;
        for level_pct in [0.0, 50.0, 100.0] {
            let y = self.y(level_pct);
            canvas.line((plot.x, y), (plot.right(), y), Paint::stroke(theme::RULE, 1.0));
            let style = TextStyle::new(FONT, theme::MUTED).anchored(Anchor::End);
            canvas.centered_text((plot.x - 7.0, y), &format!("{level_pct:.0}"), style);
        }
        for Tick { x, label } in self.axis.ticks(TICK_ROOM) {
            canvas.line((x, plot.bottom()), (x, plot.bottom() + 4.0), Paint::stroke(theme::LINE, 1.0));
            let at = (x.min(plot.right() + 20.0 - FONT.width(&label) / 2.0), plot.bottom() + 13.0);
            canvas.centered_text(at, &label, TextStyle::new(FONT, theme::MUTED).anchored(Anchor::Middle));
        }
    }

    fn thresholds(&self, canvas: &mut Canvas, thresholds: &[Threshold], labels: &[String], room: f64) {
        let heights = spread(thresholds.iter().map(|threshold| self.y(threshold.level_pct)).collect(), FONT.size + 1.0);
        for ((threshold, label), height) in thresholds.iter().zip(labels).zip(heights) {
            let (line, words) =
                if threshold.critical { (theme::BAD, theme::BAD) } else { (theme::BUSY, theme::BUSY_DARK) };
            let (y, right) = (self.y(threshold.level_pct), self.plot.right());
            canvas.line((self.plot.x, y), (right, y), Paint::stroke(line, 1.4).dashed("5 4"));
            canvas.centered_text((right + 7.0, height), &FONT.fit(label, room), TextStyle::new(FONT, words));
        }
    }

    fn history(&self, canvas: &mut Canvas, battery: &BatteryHistory) {
        let spots = battery
            .history
            .iter()
            .filter(|(_, level_pct)| level_pct.is_finite())
            .map(|&(time, level_pct)| (self.axis.x(time), self.y(level_pct)));
        let line = turning_points(spots);
        let (Some(&first), Some(&last)) = (line.first(), line.last()) else { return };
        let ground = [(last.0, self.plot.bottom()), (first.0, self.plot.bottom())];
        let filled = Path::through(line.iter().copied().chain(ground)).close();
        canvas.path(&filled, Paint::fill(theme::INK).fill_opacity(0.07));
        canvas.path(&Path::through(line), Paint::stroke(theme::INK, 2.4));
        canvas.circle(last, 3.6, Paint::fill(theme::INK));
    }

    fn faults(&self, canvas: &mut Canvas, faults: &[(Duration, String)]) {
        let mut taken = f64::NEG_INFINITY;
        for (time, label) in faults {
            let (x, top) = (self.axis.x(*time), self.plot.y);
            canvas.line((x, top - 4.0), (x, self.plot.bottom()), Paint::stroke(theme::BAD, 1.6));
            let text = FONT.fit(label, self.plot.width * 0.4);
            let width = FONT.width(&text) + 7.0;
            let (left, anchor, at) = match x - width >= self.plot.x.max(taken) {
                true => (x - width, Anchor::End, x - 6.0),
                false => (x, Anchor::Start, x + 6.0),
            };
            if left >= taken && left + width <= self.plot.right() + 4.0 {
                canvas.centered_text(
                    (at, top + 5.0),
                    &text,
                    TextStyle::new(FONT, theme::BAD).anchored(anchor).with_halo(),
                );
                taken = left + width;
            }
        }
    }
}

/// A line that looks the same with far fewer spots: close spots are left out, but both ends of every step remain.
fn turning_points(spots: impl Iterator<Item = Spot>) -> Vec<Spot> {
    let mut line: Vec<Spot> = Vec::new();
    let mut skipped: Option<Spot> = None;
    for spot in spots {
        match line.last() {
            Some(last) if (spot.0 - last.0).abs() < 2.0 && (spot.1 - last.1).abs() < 1.0 => skipped = Some(spot),
            _ => {
                let jump = |before: &Spot| (spot.1 - before.1).abs() >= 1.0;
                line.extend(skipped.take().filter(jump));
                line.push(spot);
            }
        }
    }
    line.extend(skipped);
    line
}

/// Heights as close to the wanted ones as a minimum distance allows, in the same order.
fn spread(wanted: Vec<f64>, least: f64) -> Vec<f64> {
    let mut order: Vec<usize> = (0..wanted.len()).collect();
    order.sort_by(|&a, &b| wanted[a].total_cmp(&wanted[b]));
    let mut heights = wanted;
    for pair in order.windows(2) {
        let missing = least - (heights[pair[1]] - heights[pair[0]]);
        if missing > 0.0 {
            heights[pair[0]] -= missing / 2.0;
            heights[pair[1]] += missing / 2.0;
        }
    }
    heights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_remains_a_step() {
        let spots = (0..1000).map(|i| (f64::from(i) * 0.1, if i < 500 { 10.0 } else { 60.0 }));
        let line = turning_points(spots);
        assert!(line.len() < 120, "{} spots", line.len());
        let step = line.windows(2).find(|pair| pair[1].1 > pair[0].1).expect("the step exists");
        assert!(step[1].0 - step[0].0 < 0.2, "{step:?}");
        assert_eq!(line.last(), Some(&(99.9, 60.0)));
    }

    #[test]
    fn labels_of_close_thresholds_are_spread() {
        let heights = spread(vec![100.0, 110.0], 14.0);
        assert_eq!(heights, [98.0, 112.0]);
    }
}
