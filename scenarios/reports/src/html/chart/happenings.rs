//! Events at one moment: faults, violations, arrivals, speeches.

use std::time::Duration;

use drawing::Area;
use drawing::canvas::{Canvas, Paint, TextStyle};
use drawing::icons::Icon;
use drawing::theme::{self, Color};
use recording::{FaultCourse, RunView, words};
use serde_json::{Value, json};

use super::looks::{round, variable};
use super::sheet::Chart;
use crate::html::violations;
use crate::timeline::Timeline;

/// Something that happened at one moment.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Happening {
    pub(super) time: Duration,
    pub(super) words: String,
    icon: Icon,
    color: Color,
    /// Whether it is marked across all lanes.
    across: bool,
    /// When it happened; a fault may happen several times.
    times: Vec<Duration>,
    /// When a fault was in effect.
    held: Vec<(Duration, Duration)>,
    /// The id of the part of the page with the details.
    anchor: Option<String>,
}

impl Happening {
    /// Something that happened once, and at one instant.
    fn at(time: Duration, words: String, icon: Icon, color: Color) -> Self {
        Self { time, words, icon, color, across: false, times: vec![time], held: Vec::new(), anchor: None }
    }

    /// The same, marked across all lanes.
    fn across(self) -> Self {
        Self { across: true, ..self }
    }

    /// For the script: time, words, color, whether it is marked across all lanes, and the id of the details.
    pub(super) fn data(&self) -> Value {
        let color = variable(self.color);
        json!([round(self.time.as_secs_f64(), 1e3), self.words, color, self.across, self.anchor])
    }

    /// When it was in effect, in seconds.
    pub(super) fn held(&self) -> impl Iterator<Item = [f64; 2]> {
        self.held.iter().map(|(from, to)| [from, to].map(|time| round(time.as_secs_f64(), 1e3)))
    }

    /// Whether it is a fault that was in effect for a while.
    pub(super) fn has_held(&self) -> bool {
        !self.held.is_empty()
    }
}

/// Everything that happened, in order.
pub(super) fn of(view: &RunView, timeline: &Timeline) -> Vec<Happening> {
    let faults = view.fault_courses().into_iter().map(|course| Happening {
        times: course.records.iter().map(|record| record.time).collect(),
        held: held(&course, view.time()),
        ..Happening::at(course.first().time, course.words().replace('`', ""), Icon::Alert, theme::BAD).across()
    });
    let violations = timeline.episodes().iter().map(|episode| {
        let words = format!("{} violated", view.monitor(episode.property).name());
        let anchor = violations::anchor(view.monitor(episode.property).name());
        Happening {
            anchor: Some(anchor),
            ..Happening::at(episode.decided.time, words, Icon::Cross, theme::BAD).across()
        }
    });
    let arrivals =
        view.arrivals().map(|(place, at)| Happening::at(at, words::arrival(place), Icon::Check, theme::GOOD));
    let said = view.said().iter();
    let said = said.map(|said| Happening::at(said.time, words::speech(&said.text), Icon::Open, theme::MUTED));
    let mut happenings: Vec<Happening> = faults.chain(violations).chain(arrivals).chain(said).collect();
    happenings.sort_by_key(|happening| happening.time);
    happenings
}

/// When a fault was in effect; empty for one that happens at an instant.
fn held(course: &FaultCourse<'_>, end: Duration) -> Vec<(Duration, Duration)> {
    if course.fault.momentary {
        return Vec::new();
    }
    course.records.iter().map(|record| (record.time, record.until.unwrap_or(end))).collect()
}

/// Where the sign and the words of a happening are drawn.
struct Placed<'a> {
    happening: &'a Happening,
    x: f64,
    row: usize,
    /// Empty where there is no room for it.
    text: String,
    /// Whether the words are to the left of the sign.
    leftwards: bool,
}

const SIGN: f64 = 7.5;
/// With more rows than this, the chart would become a list.
const MOST_ROWS: usize = 6;

impl Chart {
    /// Draws the signs with their words, in as many rows as needed.
    pub(super) fn happenings(&mut self, happenings: &[Happening]) {
        let placed = self.placed(happenings);
        let rows = placed.iter().map(|placed| placed.row + 1).max().unwrap_or(0);
        let pitch = self.sizes.font.line_height() + 7.0;
        for Placed { happening, x, row, text, leftwards } in placed {
            let y = self.y + (row as f64 + 0.5) * pitch;
            self.canvas.circle((x, y), SIGN, Paint::fill(happening.color).outlined(theme::PAPER, 1.5));
            happening.icon.draw(&mut self.canvas, (x, y), 10.5, theme::PAPER);
            let style = TextStyle::new(self.sizes.font, happening.color).with_halo();
            let width = self.sizes.font.width(&text);
            let left = if leftwards { x - SIGN - 5.0 - width } else { x + SIGN + 5.0 };
            self.canvas.centered_text((left, y), &text, style);
        }
        self.y += rows as f64 * pitch + if rows > 0 { 4.0 } else { 0.0 };
    }

    /// Finds room: for violations first, then in order of time. Words are to the right of their sign if possible,
    /// otherwise to its left; if there is no room for them, the sign stands alone.
    fn placed<'a>(&self, happenings: &'a [Happening]) -> Vec<Placed<'a>> {
        let (low, high) = (1.0, self.sizes.width - 1.0);
        let mut rows: Vec<Vec<(f64, f64)>> = vec![Vec::new(); MOST_ROWS];
        let mut placed = Vec::new();
        let (first, then): (Vec<_>, Vec<_>) = happenings.iter().partition(|happening| happening.icon == Icon::Cross);
        for happening in first.into_iter().chain(then) {
            let x = self.axis.x(happening.time);
            let text = self.sizes.font.fit(&happening.words, (high - low) * 0.6);
            let reach = SIGN + 8.0 + self.sizes.font.width(&text);
            let (near, far) = (x - SIGN - 1.0, x + SIGN + 1.0);
            let ways = [(text.clone(), false, near, x + reach), (text, true, x - reach, far)];
            let alone = (String::new(), false, near, far);
            let free = |taken: &[(f64, f64)], from: f64, to: f64| {
                from >= low && to <= high && taken.iter().all(|(left, right)| to <= *left || from >= *right)
            };
            // Both sides are tried in a row before the next row is, so that there are few rows.
            let place = |ways: &[(String, bool, f64, f64)]| {
                rows.iter().enumerate().find_map(|(row, taken)| {
                    ways.iter().find(|(.., from, to)| free(taken, *from, *to)).map(|way| (row, way.clone()))
                })
            };
            if let Some((row, (text, leftwards, from, to))) = place(&ways).or_else(|| place(&[alone])) {
                rows[row].push((from, to));
                placed.push(Placed { happening, x, row, text, leftwards });
            }
        }
        placed
    }

    /// Draws a line across all lanes for each fault and each violation, and a band while a fault was in effect.
    pub(super) fn happening_lines(&mut self, happenings: &[Happening], top: f64) {
        let mut lines = Canvas::for_browsers();
        for (from, until) in happenings.iter().flat_map(|happening| &happening.held) {
            let (left, right) = (self.axis.x(*from), self.axis.x(*until));
            let band = Area::new(left, top, right - left, self.y - top);
            lines.rounded(band, 0.0, Paint::fill(theme::BAD).fill_opacity(0.09));
        }
        for happening in happenings.iter().filter(|happening| happening.across) {
            for x in happening.times.iter().map(|time| self.axis.x(*time)) {
                lines.line((x, top), (x, self.y), Paint::stroke(happening.color, 1.4).stroke_opacity(0.75));
            }
        }
        let front = std::mem::replace(&mut self.canvas, lines);
        self.canvas.append(front);
    }
}
