//! The data computed once from a map's walls, shared by any number of simulations.

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

/// The occupied cells of a map, for lasers and for collisions.
///
/// Simulations [within](crate::Simulation::within) it share it. It never changes, and a clone is the same building.
#[derive(Resource, Clone)]
pub struct Building {
    walls: Arc<Walls>,
    /// The frame in which bodies and single rays are computed.
    pub(crate) frame: LocalFrame,
    /// All walls as one shape, in that frame; `None` if there are no walls.
    pub(crate) blocks: Option<SharedShape>,
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

    /// The walls for lasers.
    #[must_use]
    pub fn walls(&self) -> &Walls {
        &self.walls
    }
}

/// A solid rectangle of the grid.
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
