//! Drawings on the page: each one twice, for wide and for narrow screens.

use drawing::canvas::Canvas;
use drawing::path::number;
use maud::{Markup, html};

use super::colors;

/// The width of a drawing for phones, in pixels: the inside of a panel on a screen 375 pixels wide.
pub const NARROW: f64 = 325.0;

/// The width for which a drawing is laid out. Text keeps its size; the style sheet shows the drawing that fits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// For tablets, desktop screens and paper.
    Wide,
    /// For phones.
    Narrow,
}

impl Layout {
    const ALL: [Self; 2] = [Self::Wide, Self::Narrow];

    pub(super) fn class(self) -> &'static str {
        match self {
            Self::Wide => "wide",
            Self::Narrow => "narrow",
        }
    }

    /// The value for this layout.
    pub fn pick<T>(self, wide: T, narrow: T) -> T {
        match self {
            Self::Wide => wide,
            Self::Narrow => narrow,
        }
    }
}

/// A drawing and its size, in pixels.
pub struct Drawing {
    /// What is drawn.
    pub canvas: Canvas,
    /// How wide it is.
    pub width: f64,
    /// How high it is.
    pub height: f64,
}

/// A drawing in both layouts, as SVG inside the page. `label` describes it to those who cannot see it.
pub fn figure(label: &str, draw: impl Fn(Layout) -> Drawing) -> Markup {
    html! { @for layout in Layout::ALL { (inline(draw(layout), layout.class(), label)) } }
}

/// A drawing as SVG inside the page.
pub(super) fn inline(drawing: Drawing, class: &str, label: &str) -> Markup {
    let (width, height) = (number(drawing.width), number(drawing.height));
    html! {
        svg.chart.(class) role="img" aria-label=(label) viewBox={ "0 0 " (width) " " (height) }
            stroke-linecap="round" stroke-linejoin="round" style={ "--width:" (width) "px" } {
            (colors::adopted(&drawing.canvas.into_elements()))
        }
    }
}

/// A small square sign with this side, for use in a line of text.
pub(super) fn sign(side: f64, draw: impl FnOnce(&mut Canvas, (f64, f64))) -> Markup {
    let mut canvas = Canvas::for_browsers();
    draw(&mut canvas, (side / 2.0, side / 2.0));
    let side = number(side);
    html! {
        svg.sign aria-hidden="true" viewBox={ "0 0 " (side) " " (side) } width=(side) height=(side)
            stroke-linecap="round" stroke-linejoin="round" {
            (colors::adopted(&canvas.into_elements()))
        }
    }
}
