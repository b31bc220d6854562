//! A skill's state machine as a picture of its own: states inside states.
//!
//! Every state is a box with its transitions written in it and its children below. A dot leads to what is entered by
//! default, a dashed box holds states that are active together, a double line ends something.

use skills::{Chart, HistoryKind, StateId, StateKind};

use super::canvas::{Canvas, Paint, TextStyle};
use super::geometry::{Area, Spot};
use super::text::Font;
use super::theme;

const TITLE: Font = Font::bold(15.0);
const LINE: Font = Font::regular(12.5);
const PADDING: f64 = 12.0;
const GAP: f64 = 14.0;
const MARGIN: f64 = 20.0;
/// A row of boxes is as wide as this, or as its only box.
const ROW_WIDTH: f64 = 760.0;
/// A line of text is as wide as this at most.
const TEXT_WIDTH: f64 = 460.0;
const CORNER: f64 = 9.0;
const DOT: f64 = 4.5;

/// A state's box, with what is in it.
struct Box {
    state: StateId,
    title: String,
    lines: Vec<String>,
    is_default: bool,
    /// Where it lies in the box around it, by its upper left corner.
    at: Spot,
    width: f64,
    height: f64,
    inner: Vec<Self>,
}

/// The machine as a standalone SVG picture, as large as it has to be.
#[must_use]
pub fn state_chart_svg(chart: &Chart) -> String {
    let mut whole = measured(chart, chart.root(), false);
    whole.at = (MARGIN, MARGIN);
    let mut canvas = Canvas::for_browsers();
    let (width, height) = (whole.width + 2.0 * MARGIN, whole.height + 2.0 * MARGIN);
    canvas.rounded(Area::new(0.0, 0.0, width, height), 0.0, Paint::fill(theme::PAGE));
    draw(&mut canvas, chart, &whole, (0.0, 0.0), 0);
    canvas.finish(width, height)
}

/// The box of a state: how large it is, and how its children lie in it.
fn measured(chart: &Chart, id: StateId, is_default: bool) -> Box {
    let state = chart.state(id);
    let title = match state.kind() {
        _ if id == chart.root() => chart.name().to_owned(),
        StateKind::History(HistoryKind::Shallow) => format!("H  {}", state.id()),
        StateKind::History(HistoryKind::Deep) => format!("H*  {}", state.id()),
        _ => state.id().to_owned(),
    };
    let mut lines: Vec<String> =
        state.transitions().iter().map(|transition| chart.label(chart.transition(*transition))).collect();
    if let StateKind::History(_) = state.kind() {
        let targets: Vec<&str> = state.initial().iter().map(|target| chart.state(*target).id()).collect();
        lines.push(format!("-> {}", targets.join(", ")));
    }
    let lines: Vec<String> = lines.iter().map(|line| LINE.fit(&line.replace("->", "→"), TEXT_WIDTH)).collect();
    let mut children: Vec<StateId> = state.children().iter().chain(state.histories()).copied().collect();
    children.sort_unstable();
    let first = |child: StateId| state.kind() == StateKind::Compound && chart.enters_first(id, child);
    let mut inner: Vec<Box> = children.into_iter().map(|child| measured(chart, child, first(child))).collect();
    let text_width = lines.iter().map(|line| LINE.width(line)).fold(TITLE.width(&title), f64::max);
    let text_height = TITLE.line_height() + lines.len() as f64 * LINE.line_height();
    let (inner_width, inner_height) = arrange(&mut inner, PADDING + text_height + GAP);
    let below = if inner.is_empty() { 0.0 } else { GAP + inner_height };
    Box {
        state: id,
        title,
        lines,
        is_default,
        at: (0.0, 0.0),
        width: text_width.max(inner_width) + 2.0 * PADDING,
        height: text_height + below + 2.0 * PADDING,
        inner,
    }
}

/// Puts boxes into rows that begin at that height; says how much room they take.
fn arrange(boxes: &mut [Box], top: f64) -> (f64, f64) {
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

fn draw(canvas: &mut Canvas, chart: &Chart, item: &Box, origin: Spot, depth: usize) {
    let area = Area::new(origin.0 + item.at.0, origin.1 + item.at.1, item.width, item.height);
    let kind = chart.state(item.state).kind();
    let ground = if depth.is_multiple_of(2) { theme::PAPER } else { theme::IDLE_LIGHT };
    let paint = Paint::fill(ground).outlined(theme::LINE, 1.4);
    canvas.rounded(area, CORNER, if kind == StateKind::Parallel { paint.dashed("6 4") } else { paint });
    if kind == StateKind::Final {
        canvas.rounded(area.inset(3.5), CORNER - 2.5, Paint::stroke(theme::LINE, 1.4));
    }
    if item.is_default {
        canvas.circle((area.x, area.y + PADDING + TITLE.line_height() / 2.0), DOT, Paint::fill(theme::INK));
    }
    let mut baseline = area.y + PADDING + TITLE.size;
    canvas.text((area.x + PADDING, baseline), &item.title, TextStyle::new(TITLE, theme::INK));
    for line in &item.lines {
        baseline += LINE.line_height();
        canvas.text((area.x + PADDING, baseline), line, TextStyle::new(LINE, theme::MUTED));
    }
    item.inner.iter().for_each(|inner| draw(canvas, chart, inner, (area.x, area.y), depth + 1));
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Everything lies inside what it belongs to, and beside its siblings.
    fn assert_nested(item: &Box) {
        for (index, inner) in item.inner.iter().enumerate() {
            assert!(inner.at.0 >= 0.0 && inner.at.0 + inner.width <= item.width, "{}", inner.title);
            assert!(inner.at.1 >= 0.0 && inner.at.1 + inner.height <= item.height, "{}", inner.title);
            for other in &item.inner[index + 1..] {
                let apart = inner.at.0 + inner.width <= other.at.0
                    || other.at.0 + other.width <= inner.at.0
                    || inner.at.1 + inner.height <= other.at.1;
                assert!(apart, "{} and {}", inner.title, other.title);
            }
            assert_nested(inner);
        }
    }

    #[test]
    fn boxes_lie_inside_each_other_and_never_overlap() {
        for (name, text) in skills::SHIPPED {
            let chart = Chart::load(name, text).expect("shipped machines load");
            assert_nested(&measured(&chart, chart.root(), false));
            let svg = state_chart_svg(&chart);
            for state in chart.states() {
                assert!(svg.contains(chart.state(state).id()), "{name}");
            }
        }
    }
}
