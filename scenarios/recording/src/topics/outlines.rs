//! Outlines of things on the map: as markers, and as points for viewers that cannot draw markers.

use std::f64::consts::TAU;
use std::time::Duration;

use maps::{Point, Pose, Shape, pose};
use nalgebra::Vector2;

use crate::Body;
use crate::ros::{self, Color, Header, Marker, Markers, PointCloud, Vector};

/// The corners of a disc.
const CORNERS: usize = 24;
/// Distance between the points of an outline.
const SPACING_M: f64 = 0.05;
/// The width of a line.
const WIDTH_M: f64 = 0.03;
/// The height of the names.
const LETTERS_M: f64 = 0.25;

pub(super) struct Outline {
    name: String,
    /// Its corners; the line is closed.
    corners: Vec<Point>,
}

/// Constants of `visualization_msgs/Marker`.
mod marker {
    pub(super) const LINE_STRIP: i32 = 4;
    pub(super) const TEXT: i32 = 9;
    pub(super) const ADD: i32 = 0;
    pub(super) const DELETE_ALL: i32 = 3;
}

impl Outline {
    pub(super) fn new(name: impl Into<String>, corners: Vec<Point>) -> Self {
        Self { name: name.into(), corners }
    }

    pub(super) fn disc(name: impl Into<String>, at: &Pose, radius_m: f64) -> Self {
        let corner =
            |place: usize| at * pose(0.0, 0.0, TAU * place as f64 / CORNERS as f64) * Point::new(radius_m, 0.0);
        Self::new(name, (0..CORNERS).map(corner).collect())
    }

    fn rectangle(name: impl Into<String>, at: &Pose, length_m: f64, width_m: f64) -> Self {
        let (x, y) = (length_m / 2.0, width_m / 2.0);
        Self::new(name, [[x, y], [-x, y], [-x, -y], [x, -y]].map(|corner| at * Point::from(corner)).to_vec())
    }

    pub(super) fn of_body(body: &Body) -> Self {
        match body.shape {
            Shape::Disc { radius_m } => Self::disc(&body.name, &body.pose, radius_m),
            Shape::Box { length_m, width_m } => Self::rectangle(&body.name, &body.pose, length_m, width_m),
        }
    }

    fn line(&self) -> impl Iterator<Item = &Point> {
        self.corners.iter().chain(self.corners.first().filter(|_| self.corners.len() > 1))
    }

    fn center(&self) -> Point {
        let sum = self.corners.iter().fold(Vector2::zeros(), |sum, corner| sum + corner.coords);
        (sum / self.corners.len().max(1) as f64).into()
    }
}

/// Markers of outlines and their names, which replace the previous markers.
pub(super) fn markers(time: Duration, frame: &'static str, outlines: &[Outline]) -> Markers {
    let header = Header::new(time, frame);
    let clear = Marker { header: header.clone(), action: marker::DELETE_ALL, ..Marker::default() };
    let two = outlines.iter().zip(0..).flat_map(|(outline, id)| {
        let common = Marker {
            header: header.clone(),
            id,
            action: marker::ADD,
            pose: ros::pose(&Pose::identity()),
            color: Color { r: 0.1, g: 0.4, b: 0.8, a: 1.0 },
            // Robots move with their frame.
            frame_locked: true,
            ..Marker::default()
        };
        let line = Marker {
            ns: "outlines".to_owned(),
            r#type: marker::LINE_STRIP,
            scale: Vector { x: WIDTH_M, y: 0.0, z: 0.0 },
            points: outline.line().map(ros::point).collect(),
            ..common.clone()
        };
        let name = Marker {
            ns: "names".to_owned(),
            r#type: marker::TEXT,
            pose: ros::pose(&pose(outline.center().x, outline.center().y, 0.0)),
            scale: Vector { x: 0.0, y: 0.0, z: LETTERS_M },
            text: outline.name.clone(),
            ..common
        };
        [line, name]
    });
    Markers { markers: std::iter::once(clear).chain(two).collect() }
}

pub(super) fn points(time: Duration, frame: &'static str, outlines: &[Outline]) -> PointCloud {
    let along = outlines.iter().flat_map(|outline| {
        let ends = outline.line().zip(outline.line().skip(1));
        let sides = ends.flat_map(|(from, to)| {
            let (side, steps) = (to - from, ((to - from).norm() / SPACING_M).ceil().max(1.0));
            (0..steps as usize).map(move |step| from + side * (step as f64 / steps))
        });
        outline.corners.first().copied().into_iter().chain(sides)
    });
    ros::point_cloud(time, frame, along)
}
