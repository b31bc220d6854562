//! The processes of a system and the channels between them, on the levels of the paper's Figure 2.

use super::canvas::{Anchor, Canvas, Paint, TextStyle};
use super::geometry::{Area, Spot};
use super::path::Path;
use super::text::Font;
use super::theme;

/// The level of a process in the paper's architecture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// The source of the ticks, and the tree.
    TaskPlot,
    /// A skill.
    Skill,
    /// A component.
    Component,
}

/// The communication between the processes of a system.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ExecutionContext {
    /// The processes by name, each with its level; the tree is the last one on its level.
    pub processes: Vec<(String, Level)>,
    /// The channels: sender and receiver, as indices in `processes`.
    pub channels: Vec<(usize, usize)>,
}

const TITLE: Font = Font::bold(13.0);
const NAME: Font = Font::regular(13.0);
const BOX: f64 = 34.0;
const GAP: f64 = 12.0;
const HEAD: f64 = 30.0;
/// Half the base of the triangle that stands for the tree.
const TREE: f64 = 46.0;

/// Draws the processes in three columns, as wide as `room` and starting at its upper edge. Returns their height.
pub fn draw_execution_context(canvas: &mut Canvas, context: &ExecutionContext, room: Area) -> f64 {
    let of = |level: Level| -> Vec<usize> {
        let places = context.processes.iter().enumerate();
        places.filter(|(_, process)| process.1 == level).map(|(place, _)| place).collect()
    };
    let columns = [of(Level::TaskPlot), of(Level::Skill), of(Level::Component)];
    let rows = columns.iter().map(Vec::len).max().unwrap_or(0) as f64;
    let room = Area { height: HEAD + rows * (BOX + GAP), ..room };
    let mut areas = draw_titles(canvas, context, &columns, room);
    let tree = columns[0].last().copied();
    if let Some(tree) = tree {
        areas[tree] = Area::around(areas[tree].center(), 2.0 * TREE, 1.6 * TREE);
    }
    for &(from, to) in &context.channels {
        // Two opposite channels are drawn as one line with two heads.
        let both = context.channels.contains(&(to, from));
        if !both || from < to {
            draw_channel(canvas, areas[from], areas[to], both);
        }
    }
    for (place, ((name, level), area)) in context.processes.iter().zip(&areas).enumerate() {
        draw_process(canvas, *area, name, *level, Some(place) == tree);
    }
    room.height
}

/// Draws the titles of the columns. Returns the places of the processes, which are spread over the height of `room`.
fn draw_titles(canvas: &mut Canvas, context: &ExecutionContext, columns: &[Vec<usize>; 3], room: Area) -> Vec<Area> {
    let widths = columns.each_ref().map(|column| {
        let names = column.iter().map(|place| NAME.width(&context.processes[*place].0) + 22.0);
        names.fold(2.0 * TREE, f64::max)
    });
    let between = (room.width - widths.iter().sum::<f64>()) / 2.0;
    let mut areas = vec![Area::new(0.0, 0.0, 0.0, 0.0); context.processes.len()];
    let mut left = room.x;
    for (column, (title, width)) in columns.iter().zip(["task plot", "skills", "components"].into_iter().zip(widths)) {
        let style = TextStyle::new(TITLE, theme::MUTED).anchored(Anchor::Middle);
        canvas.centered_text((left + width / 2.0, room.y + HEAD / 2.0 - 2.0), title, style);
        let step = (room.height - HEAD) / column.len().max(1) as f64;
        for (row, place) in column.iter().enumerate() {
            let middle = (left + width / 2.0, room.y + HEAD + step * (row as f64 + 0.5));
            areas[*place] = Area::around(middle, width, BOX);
        }
        left += width + between;
    }
    areas
}

fn draw_process(canvas: &mut Canvas, area: Area, name: &str, level: Level, is_tree: bool) {
    let (ground, outline) = match level {
        Level::TaskPlot => (theme::PAPER, theme::INK),
        Level::Skill => (theme::IDLE_LIGHT, theme::IDLE),
        Level::Component => (theme::PAPER, theme::LASER),
    };
    let paint = Paint::fill(ground).outlined(outline, 1.6);
    let (x, y) = area.center();
    let mut middle = (x, y);
    if is_tree {
        canvas
            .path(&Path::through([(x, area.y), (area.right(), area.bottom()), (area.x, area.bottom())]).close(), paint);
        middle.1 = area.bottom() - NAME.line_height();
    } else {
        canvas.rounded(area, 6.0, paint);
    }
    canvas.centered_text(middle, name, TextStyle::new(NAME, theme::INK).anchored(Anchor::Middle));
}

fn draw_channel(canvas: &mut Canvas, from: Area, to: Area, both: bool) {
    let (a, b) = (from.center(), to.center());
    let (start, end) = if (a.0 - b.0).abs() < 1.0 {
        // One is above the other.
        let down = b.1 > a.1;
        ((a.0, if down { from.bottom() } else { from.y }), (b.0, if down { to.y } else { to.bottom() }))
    } else if b.0 > a.0 {
        ((from.right(), a.1), (to.x, b.1))
    } else {
        ((from.x, a.1), (to.right(), b.1))
    };
    canvas.line(start, end, Paint::stroke(theme::LINE, 1.3));
    draw_head(canvas, start, end);
    if both {
        draw_head(canvas, end, start);
    }
}

/// The head of an arrow that comes from `from`.
fn draw_head(canvas: &mut Canvas, from: Spot, tip: Spot) {
    const LENGTH: f64 = 8.0;
    let (dx, dy) = (tip.0 - from.0, tip.1 - from.1);
    let length = (dx * dx + dy * dy).sqrt().max(1e-6);
    let (ux, uy) = (dx / length * LENGTH, dy / length * LENGTH);
    let side = |sign: f64| (tip.0 - ux - uy * sign * 0.4, tip.1 - uy + ux * sign * 0.4);
    canvas.path(&Path::through([tip, side(1.0), side(-1.0)]).close(), Paint::fill(theme::MUTED));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_process_and_every_channel_is_drawn_once() {
        let process = |name: &str, level| (name.to_owned(), level);
        let context = ExecutionContext {
            processes: vec![
                process("TickGenerator", Level::TaskPlot),
                process("BT", Level::TaskPlot),
                process("Look", Level::Skill),
                process("Camera", Level::Component),
            ],
            channels: vec![(0, 1), (1, 2), (2, 1), (2, 3), (3, 2)],
        };
        let mut canvas = Canvas::for_browsers();
        draw_execution_context(&mut canvas, &context, Area::new(0.0, 0.0, 600.0, 0.0));
        let drawn = canvas.into_elements();
        for (name, _) in &context.processes {
            assert_eq!(drawn.matches(&format!(">{name}<")).count(), 1, "{name} in {drawn}");
        }
        let line = Paint::stroke(theme::LINE, 1.3);
        let mut one = Canvas::for_browsers();
        one.line((0.0, 0.0), (1.0, 1.0), line);
        let sign = format!("stroke=\"{}\"", theme::LINE);
        assert_eq!(one.into_elements().matches(&sign).count(), 1);
        assert_eq!(drawn.matches(&sign).count(), 3, "one line for a channel or two: {drawn}");
    }
}
