//! Pictures of a run: snapshots and animations that people understand even if they have never seen the project.
//!
//! A [`Frame`] is plain data about one moment: the behavior tree, the monitors, and if there is a robot, its battery
//! and the map with everything on it. [`svg`] draws it as an SVG picture. A [`Renderer`] turns that picture into a PNG
//! with fonts that are compiled in, so the bytes are the same on every machine; a [`GifWriter`] makes an animation,
//! frame by frame.
//!
//! ```
//! use std::sync::Arc;
//! use std::time::Duration;
//!
//! use drawing::{BatteryHistory, Frame, MapPicture, Renderer, Scene, svg};
//!
//! let map = Arc::new(MapPicture::new(&maps::house::map())); // once per run
//! let mut scene = Scene::new(map, maps::pose(0.0, 0.0, 1.57), 0.3);
//! scene.laser_hits.push(maps::Point::new(1.0, 2.0));
//! let frame = Frame {
//!     scenario: "nominal".to_owned(),
//!     seed: Some(1),
//!     caption: "The robot sets off.".to_owned(),
//!     time: Duration::from_millis(20),
//!     tick: Some(0),
//!     scene: Some(scene),
//!     battery: Some(BatteryHistory { level_pct: 83.0, ..BatteryHistory::default() }),
//!     tree: Vec::new(),
//!     monitors: Vec::new(),
//! };
//! let png = Renderer::new().png(&svg(&frame)).expect("the drawing is a valid picture");
//! assert!(png.starts_with(b"\x89PNG"));
//! ```
//!
//! Text is measured with the fonts that draw it ([`TreeLayout`] and [`DiagramLayout`] determine where labels are
//! placed), so that nothing overlaps and nothing is cut off: long names end in an ellipsis, large trees become small,
//! and if there are many monitors, the last ones are reduced to their locations, then to their verdicts, then to a
//! count. Everything that a color means is also expressed by a sign or a word.
//!
//! This crate must not read a clock, draw random numbers, ask the system for a font, or call a function whose last bit
//! depends on the machine. The module `path` describes how shapes avoid such functions.

mod animation;
mod battery_panel;
pub mod canvas;
mod diagram_arrows;
mod diagram_layout;
mod diagram_order;
mod diagram_picture;
mod diagram_tracks;
mod error;
mod execution_context;
mod font;
mod frame;
mod geometry;
pub mod icons;
pub mod labels;
pub mod map_panel;
pub mod map_picture;
mod monitor_panel;
mod outline;
mod page;
mod palette;
mod panel;
pub mod path;
mod render;
#[cfg(test)]
mod sample;
pub mod scale;
mod state_chart;
#[cfg(test)]
mod tests;
pub mod text;
pub mod theme;
pub mod time_axis;
mod trajectories;
mod tree_folding;
mod tree_layout;
mod tree_panel;
mod tree_picture;
pub mod view;

pub use animation::{ANIMATION_SIZE_PX, GifWriter};
pub use diagram_arrows::{PlacedEdge, PlacedLabel};
pub use diagram_layout::{DiagramLayout, PlacedLocation};
pub use diagram_picture::diagram_svg;
pub use error::Error;
pub use execution_context::{ExecutionContext, Level, draw_execution_context};
pub use frame::{
    BatteryHistory, Body, Diagram, Frame, Location, Mark, Monitor, NodeStatus, Place, Scene, Station, Threshold,
    Transition, TreeNode, Verdict,
};
pub use geometry::{Area, Spot};
pub use map_picture::MapPicture;
pub use monitor_panel::{draw_diagram, draw_meanings};
pub use render::Renderer;
pub use scale::Scale;
pub use state_chart::{State, state_chart_svg};
pub use time_axis::TimeAxis;
pub use trajectories::Trajectories;
pub use tree_folding::FoldedTree;
pub use tree_layout::{Family, Link, PlacedNode, TreeLayout};
pub use tree_panel::{SYMBOLS, draw_nodes, draw_signs, short_name, signs_height};
pub use tree_picture::tree_svg;

/// The frame as a standalone SVG picture of 1600 × 900 pixels.
#[must_use]
pub fn svg(frame: &Frame) -> String {
    page::draw(frame, page::Page::Snapshot)
}
