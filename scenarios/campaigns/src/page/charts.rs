//! The charts of a report.

use drawing::canvas::{Anchor, Paint, TextStyle};
use drawing::path::Path;
use drawing::scale::{Scale, short};
use drawing::text::Font;
use drawing::theme;
use reports::html::{Drawing, Layout};

use super::super::statistics::{Confidence, Count};
use super::against::ModelSurvey;
use super::axis::Axis;
use super::histogram::Histogram;
use super::plot::{Plot, Size};

/// Narrower cells have no number in them, in pixels.
const ROOM_FOR_A_NUMBER: f64 = 19.0;

/// Rates along an axis: one point per bin, with its interval.
pub(super) fn rates(axis: &Axis, counts: &[Count], title: &str, layout: Layout) -> Drawing {
    let mut plot = Plot::new(Size::Half, layout, 0.5);
    plot.rate_axis();
    points(&mut plot, axis, counts);
    plot.x_axis(axis, title);
    plot.finish()
}

fn points(plot: &mut Plot, axis: &Axis, counts: &[Count]) {
    let bins = counts.len() as f64;
    let middle = |bin: usize| (bin as f64 + 0.5) / bins;
    let with_rate = || counts.iter().enumerate().filter_map(|(bin, count)| Some((bin, *count, count.rate()?)));
    if matches!(axis, Axis::Scale(_)) {
        let line = Path::through(with_rate().map(|(bin, _, rate)| plot.at(middle(bin), rate)));
        plot.canvas.path(&line, Paint::stroke(theme::LASER, 1.2).stroke_opacity(0.5));
    }
    for (bin, count, rate) in with_rate() {
        let interval = count.interval(Confidence::OF_RESULTS);
        let (low, high) = (plot.at(middle(bin), interval.low), plot.at(middle(bin), interval.high));
        plot.canvas.line(low, high, Paint::stroke(theme::LASER, 3.0).stroke_opacity(0.35));
        plot.canvas.circle(plot.at(middle(bin), rate), 3.2, Paint::fill(theme::LASER));
    }
}

/// Rates along two axes: one cell per pair of bins.
pub(super) fn heat_map(axes: [&Axis; 2], titles: [&str; 2], cells: &[Vec<Count>], layout: Layout) -> Drawing {
    heat(axes, titles, cells, true, layout).finish()
}

/// A heat map of one slice of the model's parameters, with the runs' frontier and the model's.
pub(super) fn slice(model: &ModelSurvey, number: usize, titles: [&str; 2], layout: Layout) -> Drawing {
    let axes = [0, 1].map(|input| Axis::Scale(model.inputs[input].scale));
    let cells = &model.slices[number];
    let mut plot = heat([&axes[0], &axes[1]], titles, cells, false, layout);
    halves(&mut plot, cells);
    let curve =
        |plot: &Plot, quantity| Path::through(model.curve(number, quantity).into_iter().map(|(x, y)| plot.at(x, y)));
    if let Some((frontier, _)) = model.frontier {
        let path = curve(&plot, frontier);
        plot.canvas.path(&path, Paint::stroke(theme::PAPER, 5.0).stroke_opacity(0.8));
        plot.canvas.path(&path, Paint::stroke(theme::LASER, 2.2));
    }
    let path = curve(&plot, model.layout.bound);
    plot.canvas.path(&path, Paint::stroke(theme::PAPER, 5.0).stroke_opacity(0.8));
    plot.canvas.path(&path, Paint::stroke(theme::LASER, 2.2).dashed("7 5"));
    plot.finish()
}

fn heat(axes: [&Axis; 2], titles: [&str; 2], cells: &[Vec<Count>], numbers: bool, layout: Layout) -> Plot {
    let mut plot = Plot::new(Size::Half, layout, 0.74).with_title(titles[1]);
    let ground = plot.area;
    plot.canvas.rounded(ground, 0.0, Paint::fill(theme::IDLE_LIGHT));
    let x_bins = cells.len() as f64;
    for (x, column) in cells.iter().enumerate() {
        let y_bins = column.len() as f64;
        for (y, count) in column.iter().enumerate() {
            let Some(rate) = count.rate() else { continue };
            let ends = |bin: usize, bins: f64| [bin as f64 / bins, (bin + 1) as f64 / bins];
            let cell = plot.part(ends(x, x_bins), ends(y, y_bins));
            // Red over light green: a rate of 0 differs from a bin without runs, which stays gray.
            plot.canvas.rounded(cell, 0.0, Paint::fill(theme::GOOD_LIGHT));
            if rate > 0.0 {
                plot.canvas.rounded(cell, 0.0, Paint::fill(theme::BAD).fill_opacity(0.6 * rate));
            }
            if numbers && cell.width >= ROOM_FOR_A_NUMBER && cell.height >= 11.0 {
                let middle = (cell.x + cell.width / 2.0, cell.y + cell.height / 2.0);
                let style = TextStyle::new(Font::regular(9.0), theme::INK).anchored(Anchor::Middle);
                plot.canvas.centered_text(middle, &format!("{:.0}", 100.0 * rate), style);
            }
        }
    }
    plot.x_axis(axes[0], titles[0]);
    plot.y_axis(axes[1], false, |label| Font::regular(12.0).fit(&label, 44.0));
    plot
}

/// Draws lines between cells with a rate of at least one half and cells below that.
fn halves(plot: &mut Plot, cells: &[Vec<Count>]) {
    let mostly = |x: usize, y: usize| cells.get(x)?.get(y)?.rate().map(|rate| rate >= 0.5);
    let edge = |place: usize, bins: usize| place as f64 / bins as f64;
    let (columns, rows) = (cells.len(), cells.first().map_or(0, Vec::len));
    let mut lines = Vec::new();
    for (x, y) in (0..columns).flat_map(|x| (0..rows).map(move |y| (x, y))) {
        let differs = |x: usize, y: usize, other: Option<bool>| mostly(x, y).zip(other).is_some_and(|(a, b)| a != b);
        let ([left, right], [bottom, top]) = ([x, x + 1].map(|x| edge(x, columns)), [y, y + 1].map(|y| edge(y, rows)));
        if differs(x, y, mostly(x + 1, y)) {
            lines.push([(right, bottom), (right, top)]);
        }
        if differs(x, y, mostly(x, y + 1)) {
            lines.push([(left, top), (right, top)]);
        }
    }
    for line in lines {
        let [from, to] = line.map(|(x, y)| plot.at(x, y));
        plot.canvas.line(from, to, Paint::stroke(theme::INK, 1.6));
    }
}

/// Rates along the model's quantity, with the model's bound and the frontier.
pub(super) fn quantity(model: &ModelSurvey, layout: Layout) -> Drawing {
    // A rate of one or two runs means nothing.
    let runs: u64 = model.quantities.iter().map(Histogram::total).sum();
    let bins = [48, 24, 12].into_iter().find(|bins| bins * 8 <= runs).unwrap_or(6);
    let [held, happened] = model.quantities.each_ref().map(|quantities| quantities.coarser(bins as usize));
    let counts: Vec<Count> = held
        .counts
        .iter()
        .zip(&happened.counts)
        .map(|(held, happened)| Count::new(*happened, held + happened))
        .collect();
    let mut plot = Plot::new(Size::Full, layout, 0.3);
    plot.rate_axis();
    let scale = held.scale;
    points(&mut plot, &Axis::Scale(scale), &counts);
    let bound = model.layout.bound;
    let model_line = Paint::stroke(theme::LASER, 2.0).dashed("7 5");
    plot.upright(scale.share(bound).clamp(0.0, 1.0), &format!("model: {}", short(bound)), model_line, 0.12);
    if let Some((frontier, _)) = model.frontier {
        let label = format!("simulated: {}", short(frontier));
        plot.upright(scale.share(frontier), &label, Paint::stroke(theme::LASER, 2.2), 0.28);
    }
    plot.x_axis(&Axis::Scale(scale), &model.layout.quantity);
    plot.finish()
}

/// The number of runs in each bin.
pub(super) fn histogram(histogram: &Histogram, title: &str, layout: Layout) -> Drawing {
    let most = histogram.counts.iter().copied().max().unwrap_or(0).max(1);
    let heights = Scale::new(0.0..most as f64, false, 1);
    let mut plot = Plot::new(Size::Half, layout, 0.45);
    plot.y_axis(&Axis::Scale(heights), true, |label| label);
    let bins = histogram.counts.len() as f64;
    for (bin, count) in histogram.counts.iter().enumerate().filter(|(_, count)| **count > 0) {
        let across = [(bin as f64 + 0.06) / bins, (bin as f64 + 0.94) / bins];
        let bar = plot.part(across, [0.0, *count as f64 / most as f64]);
        plot.canvas.rounded(bar, 0.0, Paint::fill(theme::LASER).fill_opacity(0.75));
    }
    plot.x_axis(&Axis::Scale(histogram.scale), title);
    plot.finish()
}

/// A measurement along an axis: the median, and the range of the middle 80 % of the runs.
pub(super) fn measured(axis: &Axis, histograms: &[Histogram], title: &str, layout: Layout) -> Drawing {
    let mut plot = Plot::new(Size::Half, layout, 0.5);
    let Some(scale) = histograms.first().map(|histogram| histogram.scale) else { return plot.finish() };
    plot.y_axis(&Axis::Scale(scale), true, |label| label);
    let bins = histograms.len() as f64;
    let line = |share: f64| -> Vec<(f64, f64)> {
        let each = histograms.iter().enumerate();
        each.filter_map(|(bin, histogram)| Some(((bin as f64 + 0.5) / bins, scale.share(histogram.quantile(share)?))))
            .collect()
    };
    let (low, high) = (line(0.1), line(0.9));
    let around = high.iter().chain(low.iter().rev()).map(|(x, y)| plot.at(*x, *y));
    let band = Path::through(around).close();
    plot.canvas.path(&band, Paint::fill(theme::LASER).fill_opacity(0.2));
    let median: Vec<_> = line(0.5).into_iter().map(|(x, y)| plot.at(x, y)).collect();
    plot.canvas.path(&Path::through(median.iter().copied()), Paint::stroke(theme::LASER, 2.0));
    for spot in median {
        plot.canvas.circle(spot, 2.6, Paint::fill(theme::LASER));
    }
    plot.x_axis(axis, title);
    plot.finish()
}
