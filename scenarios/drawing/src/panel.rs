//! The frame that all panels of a page share: a sheet of paper with a title at the top.

use super::canvas::{Canvas, Paint, TextStyle};
use super::geometry::Area;
use super::text::Font;
use super::theme;

pub(super) const TITLE: Font = Font::bold(16.0);
/// Height of the title line, in pixels.
pub(super) const HEAD: f64 = 46.0;
/// Room below the contents, in pixels.
pub(super) const FOOT: f64 = 12.0;
/// Margin to the left and right of the contents, in pixels.
pub(super) const MARGIN: f64 = 20.0;

/// Draws a panel without a title.
pub(super) fn sheet(canvas: &mut Canvas, area: Area) {
    canvas.rounded(area, 10.0, Paint::fill(theme::PAPER).outlined(theme::RULE, 1.0));
}

/// Draws a panel with a title; returns the part inside.
pub(super) fn titled(canvas: &mut Canvas, area: Area, title: &str) -> Area {
    sheet(canvas, area);
    canvas.centered_text((area.x + MARGIN, title_y(area)), title, TextStyle::new(TITLE, theme::INK));
    let (width, height) = (area.width - 2.0 * MARGIN, area.height - HEAD - FOOT);
    Area::new(area.x + MARGIN, area.y + HEAD, width, height.max(0.0))
}

/// The middle of the title line.
pub(super) fn title_y(area: Area) -> f64 {
    area.y + HEAD / 2.0 + 2.0
}
