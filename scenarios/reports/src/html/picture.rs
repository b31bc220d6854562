//! Parts of a frame as drawings on a page: a scene, a state machine, a behavior tree.

use drawing::canvas::{Canvas, Paint};
use drawing::map_panel::{self, MapDrawing};
use drawing::text::Font;
use drawing::view::View;
use drawing::{
    Area, Diagram, DiagramLayout, ExecutionContext, FoldedTree, Scene, TreeLayout, TreeNode, draw_diagram,
    draw_execution_context, draw_meanings, draw_nodes, draw_signs, signs_height, theme,
};

use super::figure::{Drawing, Layout, NARROW};

/// The width of a drawing that fits beside another one, in pixels.
pub const HALF: f64 = 500.0;
const MARGIN: f64 = 8.0;

/// The map with everything on it. `name` distinguishes it from the page's other drawings.
pub fn scene(scene: &Scene, name: &str, layout: Layout) -> Drawing {
    let name = format!("{name}-{}", layout.pick("wide", "narrow"));
    on_map(scene, layout.pick(HALF, NARROW), &name, |canvas, view| {
        MapDrawing::new(canvas, view, scene, Font::regular(layout.pick(12.0, 10.5))).draw();
    })
}

/// The map, this wide, with what `draw` draws on its floor.
pub(super) fn on_map(scene: &Scene, width: f64, name: &str, draw: impl FnOnce(&mut Canvas, View)) -> Drawing {
    let bounds = map_panel::bounds(scene);
    let extent = bounds.high - bounds.low;
    // As high as the map needs, within reason: a corridor would be a thin line, or longer than a screen.
    let height = (width * extent.y / extent.x.max(1e-3)).clamp(width * 0.4, width * 1.3);
    let area = Area::new(0.0, 0.0, width, height);
    let view = View::fitting(bounds, area);
    let mut canvas = Canvas::for_browsers();
    canvas.rounded(area, 8.0, Paint::fill(theme::UNKNOWN));
    canvas.clipped(name, area, |canvas| {
        scene.map.draw(canvas, &view);
        draw(canvas, view);
    });
    Drawing { canvas, width, height }
}

/// A state machine: as wide as two drawings side by side, or wider if names and labels need it.
pub fn machine(diagram: &Diagram, layout: Layout) -> Drawing {
    let narrowest = layout.pick(HALF, NARROW);
    let attempt = |factor: f64| (factor * narrowest, DiagramLayout::new(diagram, factor * narrowest - 2.0 * MARGIN));
    let mut wider = [1.25, 1.6, 2.0, 2.6].into_iter().map(attempt);
    let first = attempt(1.0);
    let complete = |(_, placed): &(f64, DiagramLayout)| placed.is_complete(diagram);
    let (width, placed) = if complete(&first) { first } else { wider.find(complete).unwrap_or(first) };
    let mut canvas = Canvas::for_browsers();
    let area = Area::new(MARGIN, MARGIN, width - 2.0 * MARGIN, placed.height);
    draw_diagram(&mut canvas, area, &placed, diagram);
    let meanings = draw_meanings(&mut canvas, Area { y: area.bottom() + MARGIN, ..area }, &[diagram]);
    Drawing { canvas, width, height: placed.height + meanings + 2.0 * MARGIN }
}

/// The processes of a system with their channels.
pub fn context(context: &ExecutionContext, layout: Layout) -> Drawing {
    let width = layout.pick(1.4 * HALF, 1.6 * NARROW);
    let mut canvas = Canvas::for_browsers();
    let height = draw_execution_context(&mut canvas, context, Area::new(MARGIN, 0.0, width - 2.0 * MARGIN, 0.0));
    Drawing { canvas, width, height }
}

/// A behavior tree.
pub fn tree(tree: &[TreeNode], layout: Layout) -> Drawing {
    // On a phone, it is drawn smaller instead of with shorter names.
    let width = layout.pick(HALF, 1.4 * NARROW);
    let (pleasant, _) = TreeLayout::wanted_height(tree);
    let placed = TreeLayout::new(tree, width - 2.0 * MARGIN, pleasant);
    let mut canvas = Canvas::for_browsers();
    draw_nodes(&mut canvas, &placed, &FoldedTree::whole(tree), (MARGIN, MARGIN));
    let below = placed.height + 2.0 * MARGIN;
    let width = placed.width.min(width);
    draw_signs(&mut canvas, (MARGIN, below), tree, width);
    Drawing { canvas, width: width + 2.0 * MARGIN, height: below + signs_height(tree, width) + MARGIN }
}
