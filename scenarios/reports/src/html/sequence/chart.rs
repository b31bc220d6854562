//! Draws a sequence chart.

use drawing::canvas::{Anchor, Canvas, Paint, TextStyle};
use drawing::icons::Icon;
use drawing::path::Path;
use drawing::text::Font;
use drawing::theme::{self, Color};
use drawing::{Area, Spot};

use super::select::{Row, Sequence, Weight};
use crate::html::evidence::Seen;
use crate::html::figure::{Drawing, Layout, NARROW};
use crate::html::words;

/// Sizes of a chart, in pixels.
struct Sizes {
    width: f64,
    /// Where the step numbers are.
    gutter: f64,
    name: Font,
    label: Font,
    small: Font,
    row: f64,
}

impl Sizes {
    fn of(layout: Layout, lifelines: usize) -> Self {
        let wide = (150.0 * lifelines as f64 + 90.0).clamp(560.0, 960.0);
        Self {
            width: layout.pick(wide, NARROW),
            gutter: layout.pick(84.0, 27.0),
            name: Font::bold(layout.pick(13.5, 10.0)),
            label: Font::regular(layout.pick(13.5, 10.5)),
            small: Font::regular(layout.pick(12.0, 9.5)),
            row: layout.pick(36.0, 32.0),
        }
    }
}

/// A sequence chart as a separate picture.
pub(crate) fn picture(canvas: Canvas, sequence: &Sequence) -> String {
    let Drawing { canvas: chart, width, height } = draw_on(canvas, sequence, Layout::Wide);
    let mut page = Canvas::new();
    page.rounded(Area::new(0.0, 0.0, width, height), 0.0, Paint::fill(theme::PAPER));
    page.append(chart);
    page.finish(width, height)
}

/// Draws a sequence chart for a page.
pub(crate) fn draw(sequence: &Sequence, layout: Layout) -> Drawing {
    draw_on(Canvas::for_browsers(), sequence, layout)
}

fn draw_on(canvas: Canvas, sequence: &Sequence, layout: Layout) -> Drawing {
    let sizes = Sizes::of(layout, sequence.lifelines.len());
    let mut chart = Chart { canvas, sequence, sizes, y: 0.0, narrow: layout == Layout::Narrow };
    let head = chart.head_height();
    let height = head + sequence.rows.iter().map(|row| chart.height(row)).sum::<f64>() + 10.0;
    chart.lifelines(head, height);
    chart.y = head;
    for row in &sequence.rows {
        chart.row(row);
        chart.y += chart.height(row);
    }
    Drawing { canvas: chart.canvas, width: chart.sizes.width, height }
}

struct Chart<'a> {
    canvas: Canvas,
    sequence: &'a Sequence,
    sizes: Sizes,
    y: f64,
    narrow: bool,
}

impl Chart<'_> {
    /// The room for a lifeline.
    fn column(&self) -> f64 {
        (self.sizes.width - self.sizes.gutter) / self.sequence.lifelines.len().max(1) as f64
    }

    fn x(&self, lifeline: usize) -> f64 {
        self.sizes.gutter + self.column() * (lifeline as f64 + 0.5)
    }

    /// The names split into lines, in the largest font in which all their words fit.
    fn names(&self) -> (Font, Vec<Vec<String>>) {
        const SMALLEST: f64 = 7.5;
        let room = self.column() - 7.0;
        let mut font = self.sizes.name;
        loop {
            let names: Vec<Vec<String>> = self.sequence.lifelines.iter().map(|name| broken(name, font, room)).collect();
            let cut = names.iter().flatten().any(|line| line.ends_with('…'));
            if !cut || font.size <= SMALLEST {
                return (font, names);
            }
            font.size -= 0.5;
        }
    }

    fn head_height(&self) -> f64 {
        let (font, names) = self.names();
        let lines = names.iter().map(Vec::len).max().unwrap_or(1);
        lines as f64 * font.line_height() + 26.0
    }

    fn lifelines(&mut self, head: f64, height: f64) {
        let column = self.column();
        let (font, names) = self.names();
        for (index, lines) in names.into_iter().enumerate() {
            let x = self.x(index);
            self.canvas.line((x, head - 12.0), (x, height), Paint::stroke(theme::RULE, 1.4).dashed("1 5"));
            let card = Area::new(x - column / 2.0 + 2.0, 1.0, column - 4.0, head - 13.0);
            self.canvas.rounded(card, 7.0, Paint::fill(theme::IDLE_LIGHT).outlined(theme::RULE, 1.0));
            let pitch = font.line_height();
            let top = card.center().1 - pitch * (lines.len() as f64 - 1.0) / 2.0;
            for (line, text) in lines.iter().enumerate() {
                let style = TextStyle::new(font, theme::INK).anchored(Anchor::Middle);
                self.canvas.centered_text((x, top + line as f64 * pitch), text, style);
            }
        }
    }

    fn height(&self, row: &Row) -> f64 {
        let pitch = self.sizes.small.line_height();
        match row {
            Row::Tick { .. } => 30.0,
            Row::Message { .. } => self.sizes.row,
            Row::Missing { .. } => self.sizes.row + pitch + 10.0,
            Row::Ticks { .. } | Row::Fault { .. } | Row::Moved { .. } | Row::Verdict { .. } => {
                self.note_lines(row).len() as f64 * self.sizes.label.line_height() + 22.0
            }
        }
    }

    fn row(&mut self, row: &Row) {
        match row {
            Row::Tick { tick, time } => {
                let tick = tick.map_or_else(String::new, |tick| format!("tick {tick} · "));
                self.tick(&(tick + &words::time(*time)));
            }
            Row::Message { from, to, seen, weight } => self.message((*from, *to), seen, *weight),
            Row::Missing { from, to, message, words } => self.missing((*from, *to), message, words),
            Row::Ticks { .. } => self.note(row, (theme::IDLE_LIGHT, theme::RULE, theme::MUTED), None),
            Row::Moved { .. } => self.note(row, (theme::PAPER, theme::RULE, theme::INK), None),
            Row::Fault { .. } => self.note(row, (theme::BAD_LIGHT, theme::BAD, theme::INK), Some(Icon::Alert)),
            Row::Verdict { .. } => self.note(row, (theme::BAD, theme::BAD, theme::PAPER), Some(Icon::Cross)),
        }
    }

    fn message(&mut self, ends: (usize, usize), seen: &Seen, weight: Weight) {
        let (color, ink) = match weight {
            Weight::Plain => (theme::LINE, theme::MUTED),
            Weight::Cause => (theme::BUSY, theme::BUSY_DARK),
            Weight::Decisive => (theme::BAD, theme::BAD),
            Weight::Afterwards => (theme::IDLE, theme::MUTED),
        };
        let strong = matches!(weight, Weight::Cause | Weight::Decisive);
        let width = if strong { 2.4 } else { 1.5 };
        let y = self.y + self.sizes.row - 9.0;
        self.arrow(ends, y, Paint::stroke(color, width), color);
        self.label(ends, y, &seen.message, ink, strong);
        let step = if self.narrow { format!("{}", seen.at.step) } else { format!("step {}", seen.at.step) };
        self.canvas.centered_text((2.0, y), &step, TextStyle::new(self.sizes.small, theme::MUTED));
    }

    /// Draws a message that did not come: dashed, and crossed out.
    fn missing(&mut self, (from, to): (usize, usize), message: &str, words: &str) {
        let y = self.y + self.sizes.row - 3.0;
        self.arrow((from, to), y, Paint::stroke(theme::BAD, 2.0).dashed("3 6"), theme::BAD);
        self.label((from, to), y - 5.0, message, theme::BAD, true);
        let middle = ((self.x(from) + self.x(to)) / 2.0, y);
        self.canvas.circle(middle, 8.0, Paint::fill(theme::BAD));
        Icon::Cross.draw(&mut self.canvas, middle, 12.0, theme::PAPER);
        let below = y + 10.0 + self.sizes.small.line_height() / 2.0;
        self.label_at(middle.0, below, words, TextStyle::new(self.sizes.small, theme::BAD));
    }

    fn tick(&mut self, text: &str) {
        let y = self.y + 17.0;
        let left = 2.0 + self.sizes.small.width(text) + 10.0;
        self.canvas.line((left, y), (self.sizes.width, y), Paint::stroke(theme::RULE, 1.2));
        let style = TextStyle::new(Font { weight: drawing::text::Weight::Bold, ..self.sizes.small }, theme::MUTED);
        self.canvas.centered_text((2.0, y), text, style.with_halo());
    }

    fn note_text(row: &Row) -> String {
        match row {
            Row::Ticks { first, last, words } if first == last => format!("tick {first}: {words}"),
            Row::Ticks { first, last, words } => format!("ticks {first} to {last}: {words}"),
            Row::Fault { words, time } => format!("fault at {}: {words}", words::time(*time)),
            Row::Moved { words } => words.clone(),
            Row::Verdict { words, time } => format!("{words} ({})", words::time(*time)),
            _ => String::new(),
        }
    }

    fn note_lines(&self, row: &Row) -> Vec<String> {
        let room = self.sizes.width - self.sizes.gutter - 54.0;
        self.sizes.label.wrap(&Self::note_text(row), room, 4)
    }

    /// Draws a box across all lifelines.
    fn note(&mut self, row: &Row, (ground, outline, ink): (Color, Color, Color), icon: Option<Icon>) {
        let lines = self.note_lines(row);
        let pitch = self.sizes.label.line_height();
        let card = Area::new(
            self.sizes.gutter,
            self.y + 6.0,
            self.sizes.width - self.sizes.gutter - 1.0,
            lines.len() as f64 * pitch + 10.0,
        );
        self.canvas.rounded(card, 7.0, Paint::fill(ground).outlined(outline, 1.2));
        let left = card.x + if icon.is_some() { 32.0 } else { 12.0 };
        if let Some(icon) = icon {
            icon.draw(
                &mut self.canvas,
                (card.x + 17.0, card.center().1),
                13.0,
                if ink == theme::PAPER { ink } else { outline },
            );
        }
        for (line, text) in lines.iter().enumerate() {
            let y = card.y + 5.0 + (line as f64 + 0.5) * pitch;
            self.canvas.centered_text((left, y), text, TextStyle::new(self.sizes.label, ink));
        }
    }

    fn arrow(&mut self, (from, to): (usize, usize), y: f64, paint: Paint, color: Color) {
        const HEAD: f64 = 8.0;
        let (start, tip) = (self.x(from), self.x(to));
        let forward = if tip >= start { 1.0 } else { -1.0 };
        self.canvas.line((start, y), (tip - forward * HEAD * 0.8, y), paint);
        let side = |sign: f64| (tip - forward * HEAD, y + sign * HEAD * 0.45);
        self.canvas.path(&Path::through([(tip, y), side(1.0), side(-1.0)]).close(), Paint::fill(color));
        self.canvas.circle((start, y), 2.2, Paint::fill(color));
    }

    /// Draws the text of an arrow, above its middle.
    fn label(&mut self, (from, to): (usize, usize), y: f64, text: &str, color: Color, strong: bool) {
        let font =
            if strong { Font { weight: drawing::text::Weight::Bold, ..self.sizes.label } } else { self.sizes.label };
        let middle = (self.x(from) + self.x(to)) / 2.0;
        self.label_at(middle, y - 4.0 - self.sizes.label.line_height() / 2.0, text, TextStyle::new(font, color));
    }

    /// Draws a text around `x` that stays inside the chart.
    fn label_at(&mut self, x: f64, y: f64, text: &str, style: TextStyle) {
        let room = self.sizes.width - self.sizes.gutter - 4.0;
        let text = style.font.fit(text, room);
        let half = style.font.width(&text) / 2.0;
        let x = x.min(self.sizes.width - 2.0 - half).max(self.sizes.gutter + half);
        let at: Spot = (x, y);
        self.canvas.centered_text(at, &text, style.anchored(Anchor::Middle).with_halo());
    }
}

/// A compound name in lines of at most `room` pixels, if possible.
fn broken(name: &str, font: Font, room: f64) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    for character in name.chars() {
        match words.last_mut() {
            Some(word) if !character.is_uppercase() || word.chars().all(char::is_uppercase) => word.push(character),
            _ => words.push(character.to_string()),
        }
    }
    let mut lines: Vec<String> = Vec::new();
    for word in words {
        match lines.last_mut() {
            Some(line) if font.width(&format!("{line}{word}")) <= room => line.push_str(&word),
            _ => lines.push(word),
        }
    }
    lines.iter().map(|line| font.fit(line, room)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_names_are_broken_between_their_words() {
        let font = Font::bold(10.0);
        let lines = broken("GotoRechargingStation", font, 62.0);
        assert_eq!(lines, ["Goto", "Recharging", "Station"]);
        assert_eq!(broken("GotoRechargingStation", font, 400.0), ["GotoRechargingStation"]);
        assert_eq!(broken("BT", font, 40.0), ["BT"]);
    }
}
