//! A state machine as a separate picture.

use super::canvas::Canvas;
use super::diagram_layout::DiagramLayout;
use super::frame::Diagram;
use super::geometry::Area;
use super::monitor_panel::{draw_diagram, draw_meanings};

/// The maximum width of a machine before its labels are shortened, and the margin around it, in pixels.
const WIDEST: f64 = 1600.0;
const MARGIN: f64 = 24.0;

/// The state machine as a standalone SVG picture, as large as necessary.
///
/// ```
/// use drawing::{Diagram, Location, Transition, diagram_svg};
///
/// let diagram = Diagram {
///     locations: [("wait", false), ("late", true)]
///         .map(|(name, error)| Location { name: name.to_owned(), error, ..Location::default() })
///         .to_vec(),
///     initial: 0,
///     active: 0,
///     transitions: vec![Transition { from: 0, to: 1, label: "after 5 s".to_owned() }],
/// };
/// assert!(diagram_svg(&diagram).contains(">after 5 s<"));
/// ```
#[must_use]
pub fn diagram_svg(diagram: &Diagram) -> String {
    let layout = DiagramLayout::new(diagram, WIDEST);
    let mut canvas = Canvas::for_browsers();
    let area = Area::new(MARGIN, MARGIN, layout.width, layout.height);
    draw_diagram(&mut canvas, area, &layout, diagram);
    let below = Area { y: area.bottom() + MARGIN / 2.0, width: area.width.max(300.0), ..area };
    let meanings = draw_meanings(&mut canvas, below, &[diagram]);
    canvas.finish(below.width + 2.0 * MARGIN, below.y + meanings + MARGIN)
}
