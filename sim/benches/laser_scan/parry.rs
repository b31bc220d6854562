//! The walls as parry2d's static shapes.

use maps::{Cell, CellIndex, OccupancyGrid, Point, Pose};
use nalgebra::Vector2;
use parry2d::math::{Pose as GlamPose, Rotation, Vector};
use parry2d::query::{Ray, RayCast};
use parry2d::shape::{Compound, Polyline, SharedShape, TriMesh};
use sim::Beams;

use crate::rectangles::{Rectangle, rectangles};

/// The ranges of a scan.
pub(crate) fn ranges(shape: &impl RayCast, beams: &Beams, base: &Pose, range_max_m: f32, ranges_m: &mut Vec<f32>) {
    let origin = glam((base * beams.origin()).coords);
    ranges_m.clear();
    ranges_m.extend(beams.directions().map(|direction| {
        let ray = Ray::new(origin, glam(base.rotation * direction));
        shape.cast_local_ray(&ray, range_max_m, true).unwrap_or(f32::INFINITY)
    }));
}

/// A cuboid for each rectangle of occupied cells, as in the physics.
pub(crate) fn compound(grid: &OccupancyGrid) -> Compound {
    let rotation = grid.origin().rotation;
    let rotation = Rotation::from_cos_sin_unchecked(rotation.re as f32, rotation.im as f32);
    let cuboid = |rectangle: &Rectangle| {
        let half = Vector2::new(rectangle.width as f64, rectangle.height as f64) / 2.0;
        let center = vertex(grid, rectangle.column as f64 + half.x, rectangle.row as f64 + half.y);
        let half = glam(half * grid.resolution_m());
        (GlamPose::from_parts(center, rotation), SharedShape::cuboid(half.x, half.y))
    };
    Compound::new(rectangles(grid).iter().map(cuboid).collect())
}

/// The outlines of all occupied areas, with segments as long as possible.
pub(crate) fn polyline(grid: &OccupancyGrid) -> Polyline {
    let is_occupied = |column: usize, row: usize| {
        // Left of column 0 and below row 0 there is nothing: the subtraction wraps around to far outside.
        grid.cell(CellIndex { column: column.wrapping_sub(1), row: row.wrapping_sub(1) }) == Some(Cell::Occupied)
    };
    let (mut vertices, mut segments) = (Vec::new(), Vec::new());
    let mut trace =
        |along: usize, across: usize, is_edge: &dyn Fn(usize, usize) -> bool, at: &dyn Fn(f64, f64) -> Vector| {
            for line in 0..=across {
                let mut start = None;
                for n in 0..=along {
                    let goes_on = n < along && is_edge(n, line);
                    if goes_on && start.is_none() {
                        start = Some(n);
                    } else if let Some(from) = start.take_if(|_| !goes_on) {
                        let first = vertices.len() as u32;
                        vertices.extend([at(from as f64, line as f64), at(n as f64, line as f64)]);
                        segments.push([first, first + 1]);
                    }
                }
            }
        };
    let (width, height) = (grid.width(), grid.height());
    trace(width, height, &|n, line| is_occupied(n + 1, line) != is_occupied(n + 1, line + 1), &|n, line| {
        vertex(grid, n, line)
    });
    trace(height, width, &|n, line| is_occupied(line, n + 1) != is_occupied(line + 1, n + 1), &|n, line| {
        vertex(grid, line, n)
    });
    Polyline::new(vertices, Some(segments))
}

/// Two triangles for each rectangle of occupied cells.
pub(crate) fn trimesh(grid: &OccupancyGrid) -> TriMesh {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for Rectangle { column, row, width, height } in rectangles(grid) {
        let first = vertices.len() as u32;
        let corners = [(column, row), (column + width, row), (column + width, row + height), (column, row + height)];
        vertices.extend(corners.map(|(column, row)| vertex(grid, column as f64, row as f64)));
        triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    TriMesh::new(vertices, triangles).expect("there are walls")
}

/// A point in grid coordinates for parry, in the `map` frame.
fn vertex(grid: &OccupancyGrid, column: f64, row: f64) -> Vector {
    glam(grid.from_grid(&Point::new(column, row)).coords)
}

fn glam(vector: Vector2<f64>) -> Vector {
    Vector::new(vector.x as f32, vector.y as f32)
}
