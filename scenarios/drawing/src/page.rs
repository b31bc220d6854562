//! The layout of the page.

use super::canvas::{Anchor, Canvas, Paint, TextStyle};
use super::frame::Frame;
use super::geometry::Area;
use super::panel;
use super::text::Font;
use super::theme;
use super::tree_layout::TreeLayout;
use super::{battery_panel, map_panel, monitor_panel, tree_panel};

const MARGIN: f64 = 32.0;
const GAP: f64 = 12.0;
const HEADER: f64 = 64.0;

/// A page size, in pixels. Everything is laid out for it; text keeps its size.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Page {
    /// 1600 × 900: a snapshot.
    Snapshot,
    /// 1280 × 720: a frame of an animation, which is shown at three quarters of this size.
    Animation,
}

impl Page {
    /// Width and height in pixels.
    #[must_use]
    pub(super) const fn size_px(self) -> (u32, u32) {
        match self {
            Self::Snapshot => (1600, 900),
            Self::Animation => (1280, 720),
        }
    }

    fn margin(self) -> f64 {
        match self {
            Self::Snapshot => MARGIN,
            Self::Animation => 20.0,
        }
    }

    fn right_column(self) -> f64 {
        match self {
            Self::Snapshot => 612.0,
            Self::Animation => 548.0,
        }
    }
}

/// Draws a frame: title and map on the left; battery, tree and monitors on the right. Without a map, the tree takes its
/// place; if the tree is too large for its own place, they swap.
pub(super) fn draw(frame: &Frame, page: Page) -> String {
    let (width, height) = (f64::from(page.size_px().0), f64::from(page.size_px().1));
    let margin = page.margin();
    let whole = Area::new(0.0, 0.0, width, height);
    let inner = whole.inset(margin);
    let right = Area::new(inner.right() - page.right_column(), inner.y, page.right_column(), inner.height);
    let left = Area { width: right.x - GAP - inner.x, ..inner };
    let mut canvas = Canvas::new();
    canvas.rounded(whole, 0.0, Paint::fill(theme::PAGE));
    header(&mut canvas, Area { height: HEADER, ..left }, frame);
    let large = Area { y: left.y + HEADER, height: left.height - HEADER, ..left };
    // Each panel of the right column takes its height from the top; the monitors get what is left.
    let mut rest = right;
    if let Some(battery) = &frame.battery {
        let height = (right.height * 0.15).clamp(116.0, 132.0);
        battery_panel::draw(&mut canvas, Area { height, ..right }, battery, frame.time);
        rest = below(right, height);
    }
    let tree = match &frame.scene {
        Some(scene) => {
            let small = Area { height: upper_height(frame, rest), ..rest };
            rest = below(rest, small.height);
            let (map, tree) = if is_large(frame, small) { (small, large) } else { (large, small) };
            map_panel::draw_on(&mut canvas, map, scene, page == Page::Animation);
            tree
        }
        None => large,
    };
    tree_panel::draw(&mut canvas, tree, &frame.tree, frame.tick.is_some());
    monitor_panel::draw(&mut canvas, rest, &frame.monitors);
    canvas.finish(width, height)
}

/// The rest of a column below a panel of this height.
fn below(column: Area, height: f64) -> Area {
    Area { y: column.y + height + GAP, height: column.height - height - GAP, ..column }
}

/// Divides a column between tree and monitors. Both get what they need; if that is too much, the tree is squeezed
/// first, as far as it stays readable, then the monitors, but no further than to two fifths or to their names.
fn upper_height(frame: &Frame, area: Area) -> f64 {
    let room = area.height - GAP;
    let (pleasant, readable) = tree_heights(frame, area);
    let monitors = monitor_panel::wanted_height(&frame.monitors, area.width);
    let spare = (room - pleasant - monitors).max(0.0);
    let most = (room * 0.68).min(room - monitor_panel::least_height(&frame.monitors)).max(room * 0.5);
    (pleasant + spare * 0.4).min(room - monitors).max(readable.min(most)).max(pleasant.min(room * 0.25))
}

/// The heights of the tree's panel at which the tree is not squeezed, and at which it is just legible.
fn tree_heights(frame: &Frame, area: Area) -> (f64, f64) {
    let signs = tree_panel::signs_height(&frame.tree, area.width - 2.0 * panel::MARGIN);
    let around = panel::HEAD + signs + panel::FOOT;
    let (pleasant, readable) = TreeLayout::wanted_height(&frame.tree);
    (pleasant + around, readable + around)
}

/// Whether the tree would be hard to read there.
fn is_large(frame: &Frame, area: Area) -> bool {
    tree_heights(frame, area).1 > area.height
}

/// Scenario, seed, time, tick, and what is happening.
fn header(canvas: &mut Canvas, area: Area, frame: &Frame) {
    let (title, detail) = (Font::bold(26.0), Font::regular(16.0));
    let (first, second) = (area.y + 13.0, area.y + 43.0);
    let muted = TextStyle::new(detail, theme::MUTED);
    let time = format!("{:.2} s", frame.time.as_secs_f64());
    let right = area.right();
    canvas.centered_text((right, first), &time, TextStyle::new(title, theme::INK).anchored(Anchor::End));
    let tick = frame.tick.map_or(String::new(), |tick| format!("tick {tick} of the tree"));
    canvas.centered_text((right, second), &tick, muted.anchored(Anchor::End));
    let seed = frame.seed.map_or(String::new(), |seed| format!("seed {seed}"));
    let room = right - title.width(&time) - 40.0 - area.x;
    let name = title.fit(&frame.scenario, room - detail.width(&seed) - 18.0);
    canvas.centered_text((area.x, first), &name, TextStyle::new(title, theme::INK));
    canvas.centered_text((area.x + title.width(&name) + 18.0, first + 3.0), &seed, muted);
    caption(canvas, (area.x, second), &frame.caption, right - detail.width(&tick) - 24.0 - area.x);
}

/// Writes one line if it fits, otherwise two smaller ones.
fn caption(canvas: &mut Canvas, (x, y): (f64, f64), text: &str, room: f64) {
    let font = Font::regular(16.0);
    if font.width(text) <= room {
        canvas.centered_text((x, y), text, TextStyle::new(font, theme::MUTED));
        return;
    }
    let font = Font::regular(13.0);
    let lines = font.wrap(text, room, 2);
    let top = y - (lines.len().saturating_sub(1)) as f64 * font.line_height() / 2.0;
    for (i, line) in lines.iter().enumerate() {
        let at = (x, top + i as f64 * font.line_height());
        canvas.centered_text(at, line, TextStyle::new(font, theme::MUTED));
    }
}
