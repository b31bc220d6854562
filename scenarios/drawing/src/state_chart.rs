//! A skill's state machine as a separate picture: states inside states.
//!
//! Every state is a box with its transitions written in it and its children below. A dot leads to the default state, a
//! dashed box contains states that are active together, and a double outline marks a final state.

use super::canvas::{Canvas, Paint, TextStyle};
use super::geometry::{Area, Spot};
use super::text::Font;
use super::theme;

const TITLE: Font = Font::bold(15.0);
const LINE: Font = Font::regular(12.5);
const PADDING: f64 = 12.0;
const GAP: f64 = 14.0;
const MARGIN: f64 = 20.0;
/// The maximum width of a row of boxes, unless its only box is wider.
const ROW_WIDTH: f64 = 760.0;
/// The maximum width of a line of text.
const TEXT_WIDTH: f64 = 460.0;
const CORNER: f64 = 9.0;
const DOT: f64 = 4.5;

/// A state of a machine, or the machine itself, with what is inside it.
#[derive(Clone, Debug, Default)]
pub struct State {
    /// Its name.
    pub title: String,
    /// Its transitions, in words; `->` is drawn as an arrow.
    pub lines: Vec<String>,
    /// Whether it is entered when the state around it is entered by default.
    pub is_default: bool,
    /// Whether its inner states are active together.
    pub is_parallel: bool,
    /// Whether it ends the state around it.
    pub is_final: bool,
    /// Its inner states, in the order of the document.
    pub inner: Vec<Self>,
}

/// A state's box, with what is in it.
struct StateBox<'a> {
    state: &'a State,
    lines: Vec<String>,
    /// The position of its upper left corner in the box around it.
    at: Spot,
    width: f64,
    height: f64,
    inner: Vec<Self>,
}

/// A machine as a standalone SVG picture, as large as necessary. Each state is a part of the picture (`data-state`),
/// numbered in document order; the machine itself has the number 0.
///
/// ```
/// use drawing::{State, state_chart_svg};
///
/// let idle = State {
///     title: "idle".to_owned(),
///     lines: vec!["start -> driving".to_owned()],
///     is_default: true,
///     ..State::default()
/// };
/// let driving = State { title: "driving".to_owned(), ..State::default() };
/// let machine = State { title: "Drive".to_owned(), inner: vec![idle, driving], ..State::default() };
/// assert!(state_chart_svg(&machine).contains("driving"));
/// ```
#[must_use]
pub fn state_chart_svg(machine: &State) -> String {
    let mut whole = measured(machine);
    whole.at = (MARGIN, MARGIN);
    let mut canvas = Canvas::for_browsers();
    let (width, height) = (whole.width + 2.0 * MARGIN, whole.height + 2.0 * MARGIN);
    canvas.rounded(Area::new(0.0, 0.0, width, height), 0.0, Paint::fill(theme::PAGE));
    draw(&mut canvas, &whole, (0.0, 0.0), 0, &mut 0);
    canvas.finish(width, height)
}

/// The box of a state: its size, and the positions of its children.
fn measured(state: &State) -> StateBox<'_> {
    let lines: Vec<String> = state.lines.iter().map(|line| LINE.fit(&line.replace("->", "→"), TEXT_WIDTH)).collect();
    let mut inner: Vec<StateBox<'_>> = state.inner.iter().map(measured).collect();
    let text_width = lines.iter().map(|line| LINE.width(line)).fold(TITLE.width(&state.title), f64::max);
    let text_height = TITLE.line_height() + lines.len() as f64 * LINE.line_height();
    let (inner_width, inner_height) = arrange(&mut inner, PADDING + text_height + GAP);
    let below = if inner.is_empty() { 0.0 } else { GAP + inner_height };
    StateBox {
        state,
        lines,
        at: (0.0, 0.0),
        width: text_width.max(inner_width) + 2.0 * PADDING,
        height: text_height + below + 2.0 * PADDING,
        inner,
    }
}

/// Puts boxes into rows that begin at this height, and returns the room that they take.
fn arrange(boxes: &mut [StateBox<'_>], top: f64) -> (f64, f64) {
    // Rows are filled greedily in document order: a better packing would separate states that were written side by
    // side.
    let (mut x, mut y, mut row_height, mut widest) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64);
    for item in boxes.iter_mut() {
        if x > 0.0 && x + item.width > ROW_WIDTH {
            (x, y, row_height) = (0.0, y + row_height + GAP, 0.0);
        }
        item.at = (PADDING + x, top + y);
        widest = widest.max(x + item.width);
        row_height = row_height.max(item.height);
        x += item.width + GAP;
    }
    (widest, y + row_height)
}

fn draw(canvas: &mut Canvas, item: &StateBox<'_>, origin: Spot, depth: usize, number: &mut usize) {
    let area = Area::new(origin.0 + item.at.0, origin.1 + item.at.1, item.width, item.height);
    canvas.part("state", *number, |canvas| {
        *number += 1;
        draw_box(canvas, item, area, depth);
        item.inner.iter().for_each(|inner| draw(canvas, inner, (area.x, area.y), depth + 1, number));
    });
}

/// Draws the box of a state without its contents.
fn draw_box(canvas: &mut Canvas, item: &StateBox<'_>, area: Area, depth: usize) {
    let ground = if depth.is_multiple_of(2) { theme::PAPER } else { theme::IDLE_LIGHT };
    let paint = Paint::fill(ground).outlined(theme::LINE, 1.4);
    canvas.rounded(area, CORNER, if item.state.is_parallel { paint.dashed("6 4") } else { paint });
    if item.state.is_final {
        canvas.rounded(area.inset(3.5), CORNER - 2.5, Paint::stroke(theme::LINE, 1.4));
    }
    if item.state.is_default {
        canvas.circle((area.x, area.y + PADDING + TITLE.line_height() / 2.0), DOT, Paint::fill(theme::INK));
    }
    let mut baseline = area.y + PADDING + TITLE.size;
    canvas.text((area.x + PADDING, baseline), &item.state.title, TextStyle::new(TITLE, theme::INK));
    for line in &item.lines {
        baseline += LINE.line_height();
        canvas.text((area.x + PADDING, baseline), line, TextStyle::new(LINE, theme::MUTED));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Everything is inside its parent and beside its siblings.
    fn assert_nested(item: &StateBox<'_>) {
        for (index, inner) in item.inner.iter().enumerate() {
            assert!(inner.at.0 >= 0.0 && inner.at.0 + inner.width <= item.width, "{}", inner.state.title);
            assert!(inner.at.1 >= 0.0 && inner.at.1 + inner.height <= item.height, "{}", inner.state.title);
            for other in &item.inner[index + 1..] {
                let apart = inner.at.0 + inner.width <= other.at.0
                    || other.at.0 + other.width <= inner.at.0
                    || inner.at.1 + inner.height <= other.at.1;
                assert!(apart, "{} and {}", inner.state.title, other.state.title);
            }
            assert_nested(inner);
        }
    }

    /// A state with transitions and nested states of many sizes, to this depth.
    fn state(number: usize, depth: usize) -> State {
        let children = if depth == 0 { 0 } else { number % 5 };
        State {
            title: format!("{} {number}", "state".repeat(number % 4 + 1)),
            lines: (0..number % 3).map(|line| "event -> ".repeat(line * number + 1)).collect(),
            is_parallel: number.is_multiple_of(2),
            is_default: number.is_multiple_of(3),
            is_final: children == 0,
            inner: (0..children).map(|child| state(3 * number + child + 1, depth - 1)).collect(),
        }
    }

    #[test]
    fn boxes_are_nested_and_never_overlap() {
        for number in 0..40 {
            let machine = state(number, 4);
            assert_nested(&measured(&machine));
            let svg = state_chart_svg(&machine);
            let (mut shown, mut count) = (vec![&machine], 0);
            while let Some(state) = shown.pop() {
                assert!(svg.contains(&state.title), "{}", state.title);
                assert!(svg.contains(&format!("data-state=\"{count}\"")), "{count}");
                count += 1;
                shown.extend(&state.inner);
            }
            assert_eq!(svg.matches("data-state").count(), count);
        }
    }
}
