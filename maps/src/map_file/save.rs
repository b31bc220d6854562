//! Writing a map as `map_server` YAML and an image.

use std::path::Path;

use diagnostics::Staging;

use rasters::{encode_gray_png, encode_pgm};

use crate::{Cell, Error, MAX_CELLS, OccupancyGrid, heading};

/// The kind of image that a map is saved as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum ImageFormat {
    /// A raw graymap: large, but the same bytes from any encoder.
    #[default]
    Pgm,
    /// A gray PNG: small.
    Png,
}

/// The two files of a map.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MapFiles {
    /// The YAML file.
    pub yaml: String,
    /// The image.
    pub image: Vec<u8>,
}

/// A map as files; the image belongs beside the YAML under `image_name`.
///
/// Mode trinary: occupied cells are black (0), free ones almost white (254), unknown ones light gray (205), like those
/// of ROS's map saver. Loading the files gives an equal grid, except for rounding in a rotated origin.
///
/// # Errors
/// [`Error::UnsavableSize`] for a grid without cells or with more than [`MAX_CELLS`].
pub fn map_files(grid: &OccupancyGrid, image_name: &str, format: ImageFormat) -> Result<MapFiles, Error> {
    let (width, height) = (grid.width(), grid.height());
    if !(1..=MAX_CELLS).contains(&grid.cells().len()) {
        return Err(Error::UnsavableSize { width, height });
    }
    let pixels: Vec<u8> = grid.cells().chunks_exact(width).rev().flatten().copied().map(shade).collect();
    let image = match format {
        ImageFormat::Pgm => encode_pgm(width, height, &pixels),
        ImageFormat::Png => encode_gray_png(width, height, &pixels),
    };
    Ok(MapFiles { yaml: yaml(grid, image_name), image })
}

/// Saves a map as the YAML file at `path` and an image with the same name beside it. Existing files are replaced; see
/// [`map_files`].
///
/// # Errors
/// [`Error::UnsavableSize`] as for [`map_files`]; [`Error::File`] if a file cannot be written.
pub fn save_map(grid: &OccupancyGrid, path: &Path, format: ImageFormat) -> Result<(), Error> {
    let extension = match format {
        ImageFormat::Pgm => "pgm",
        ImageFormat::Png => "png",
    };
    let image_path = path.with_extension(extension);
    let image_name = image_path.file_name().unwrap_or_default().to_string_lossy();
    let files = map_files(grid, &image_name, format)?;
    let yaml_name = path.file_name().unwrap_or_default();
    let staging =
        Staging::begin(path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new(".")))?;
    staging.write(&*image_name, &files.image)?;
    staging.write(yaml_name, &files.yaml)?;
    // The YAML is published last, so it never lacks its image.
    Ok(staging.publish(&[yaml_name])?)
}

fn shade(cell: Cell) -> u8 {
    match cell {
        Cell::Occupied => 0,
        Cell::Free => 254,
        Cell::Unknown => 205,
    }
}

fn yaml(grid: &OccupancyGrid, image_name: &str) -> String {
    let origin = grid.origin();
    let (x_m, y_m, yaw_rad) = (origin.translation.x, origin.translation.y, heading(&origin));
    let (image, resolution_m) = (quoted(image_name), grid.resolution_m());
    // {:?} writes all significant digits and a decimal point.
    format!(
        "image: {image}\nmode: trinary\nresolution: {resolution_m:?}\norigin: [{x_m:?}, {y_m:?}, {yaw_rad:?}]\n\
         negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
}

/// A name as a YAML scalar: bare if that is unambiguously a string, otherwise in double quotes.
fn quoted(name: &str) -> String {
    let plain = |character: char| character.is_ascii_alphanumeric() || "_-.".contains(character);
    if name.starts_with(|first: char| first.is_ascii_alphabetic()) && name.contains('.') && name.chars().all(plain) {
        return name.to_owned();
    }
    let mut quoted = String::from('"');
    for character in name.chars() {
        match character {
            '"' | '\\' => quoted.extend(['\\', character]),
            ' '..='~' => quoted.push(character),
            _ => quoted += &format!("\\U{:08X}", u32::from(character)),
        }
    }
    quoted + "\""
}
