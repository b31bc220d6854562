//! What is worked out of a map's walls once, however many simulations are in it.

use std::fmt;
use std::sync::Arc;

use bevy_ecs::prelude::Resource;
use maps::{OccupancyGrid, Point, Pose};
use nalgebra::Vector2;
use parry2d::math::Pose as GlamPose;
use parry2d::shape::SharedShape;

use crate::convert::LocalFrame;
use crate::rectangles::{Rectangle, rectangles};
use crate::walls::Walls;

/// The occupied cells of a map as lasers see them and bodies run into them.
///
/// Simulations [within](crate::Simulation::within) it share it; it never changes, and a clone is the same building.
#[derive(Resource, Clone)]
pub struct Building {
    walls: Arc<Walls>,
    /// Where bodies and single rays are computed.
    frame: LocalFrame,
    /// All walls as one shape, in that frame; none where there are none.
    blocks: Option<SharedShape>,
}

impl Building {
    /// The building whose walls are the occupied cells of `grid`.
    #[must_use]
    pub fn new(grid: &OccupancyGrid) -> Self {
        let frame = LocalFrame::of(grid);
        let blocks: Vec<_> = rectangles(grid).iter().map(|rectangle| block(grid, &frame, rectangle)).collect();
        let blocks = (!blocks.is_empty()).then(|| SharedShape::compound(blocks));
        Self { walls: Arc::new(Walls::new(grid)), frame, blocks }
    }

    /// The walls as lasers see them.
    #[must_use]
    pub fn walls(&self) -> &Walls {
        &self.walls
    }

    /// The frame in which bodies are computed.
    pub(crate) fn frame(&self) -> LocalFrame {
        self.frame
    }

    /// The walls as bodies run into them, in the building's frame.
    pub(crate) fn blocks(&self) -> Option<&SharedShape> {
        self.blocks.as_ref()
    }
}

/// A rectangle of the grid, solid, in its place.
fn block(grid: &OccupancyGrid, frame: &LocalFrame, rectangle: &Rectangle) -> (GlamPose, SharedShape) {
    let half = Vector2::new(rectangle.width as f64, rectangle.height as f64) / 2.0;
    let center = grid.from_grid(&Point::new(rectangle.column as f64 + half.x, rectangle.row as f64 + half.y));
    let half = half * grid.resolution_m();
    let pose = Pose::from_parts(center.coords.into(), grid.origin().rotation);
    (frame.pose_to_glam(&pose), SharedShape::cuboid(half.x as f32, half.y as f32))
}

impl fmt::Debug for Building {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Building").field("has_walls", &self.blocks.is_some()).finish_non_exhaustive()
    }
}
