//! The picture of how a trip ended.

use drawing::canvas::{Canvas, Paint, TextStyle};
use drawing::{Area, Body, Scene, map_panel, text, theme};
use sim::ObstacleTruth;

use super::Trip;

/// Size of the picture, and height of the line above the map, in pixels.
const SIZE: (f64, f64) = (1600.0, 1200.0);
const HEAD: f64 = 56.0;

/// The picture of a trip that ended in this scene, as SVG.
pub fn picture(trip: &Trip, scene: &Scene) -> String {
    let mut canvas = Canvas::new();
    canvas.rounded(Area::new(0.0, 0.0, SIZE.0, SIZE.1), 0.0, Paint::fill(theme::PAGE));
    let title = format!("{}, seed {}, {:.1} s: {}", trip.map, trip.seed, trip.time_s, trip.words());
    canvas.text((20.0, 36.0), &title, TextStyle::new(text::Font::bold(20.0), theme::INK));
    map_panel::draw(&mut canvas, Area::new(10.0, HEAD, SIZE.0 - 20.0, SIZE.1 - HEAD - 10.0), scene);
    canvas.finish(SIZE.0, SIZE.1)
}

/// A person or a box, as drawn.
pub(super) fn body(obstacle: &ObstacleTruth<'_>) -> Body {
    Body { shape: obstacle.shape, pose: obstacle.pose, label: obstacle.name.to_owned() }
}
