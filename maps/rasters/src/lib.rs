//! Images made of pixels: the only crate with their file formats.
//!
//! [`Raster::decode`] reads an image within bounds: PGM and its relatives PBM and PPM, PNG, and BMP, as ROS's
//! `map_server` does. [`encode_pgm`], [`encode_gray_png`] and [`encode_rgb_png`] write one, and an [`Animation`] writes
//! a GIF frame by frame. The crate `image` does the work.
//!
//! ```
//! use rasters::{Raster, RasterError, encode_gray_png};
//!
//! let file = encode_gray_png(3, 1, &[0, 205, 254]);
//! let raster = Raster::decode(&file, 1_000)?;
//! assert_eq!((raster.width(), raster.height(), raster.white()), (3, 1, 255));
//! assert!(raster.pixels().eq([[0], [205], [254]]));
//!
//! let too_large = Raster::decode(&file, 2).unwrap_err();
//! assert_eq!(too_large.to_string(), "it has 3 × 1 pixels, more than the 2 that are allowed");
//! # Ok::<(), RasterError>(())
//! ```
//!
//! The bytes of a written file depend only on its pixels.

mod animation;
mod decode;
mod encode;
mod pnm;
mod raster;

pub use animation::Animation;
pub use encode::{encode_gray_png, encode_pgm, encode_rgb_png};
pub use raster::{Raster, RasterError};
