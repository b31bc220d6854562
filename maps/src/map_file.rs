//! Map files: the YAML and image of ROS `map_server`, as `nav2_map_server` reads them.

mod meaning;
mod save;

use std::path::Path;

use diagnostics::document::{Document, Field, Item, Table};
use diagnostics::{Problem, ReadFile, Span, Spanned, read_text};
use meaning::{Change, Meaning, Mode};
use rasters::{Raster, RasterError};
pub use save::{ImageFormat, MapFiles, map_files, save_map};

use crate::{Cell, MAX_CELLS, OccupancyGrid, Pose, pose};

/// Coordinates beyond this, in meters, are refused as mistakes.
pub(crate) const MAX_COORDINATE_M: f64 = 1e7;

/// Loads the map that the YAML file at `path` describes: a map of ROS `map_server`, as `nav2_map_server` reads them.
/// `read` reads the YAML and the image, from disk ([`from_disk`](diagnostics::from_disk)) or from elsewhere.
///
/// ```yaml
/// image: house.pgm            # PGM, PNG or BMP, relative to this file
/// resolution: 0.05            # meters per cell
/// origin: [-16.0, -6.0, 0.0]  # x m, y m, yaw rad of the image's lower left corner
/// negate: 0                   # 1: black is free
/// occupied_thresh: 0.65
/// free_thresh: 0.196
/// mode: trinary               # or scale, raw; may be left out
/// ```
///
/// `mode` decides what a pixel means. Its *shade* is the mean of its colors, from 0 (black) to 1 (white), its
/// *occupancy* is 1 − shade, or the shade itself if `negate` is set.
///
/// - **trinary**: occupied above `occupied_thresh`, free below `free_thresh`, unknown otherwise. Alpha counts as a
///   color, and gray with alpha as three colors.
/// - **scale**: unknown where the image is transparent. Elsewhere ROS publishes 100 % above `occupied_thresh`, 0 %
///   below `free_thresh`, and scales values between them linearly from 0 to 100 %.
/// - **raw**: ROS publishes the shade, from 0 to 255, as a percentage if it is at most 100, otherwise as unknown.
///   `negate` has no effect.
///
/// ROS passes percentages on; this project has three kinds of [`Cell`](crate::Cell). In scale and raw mode, a cell is
/// occupied if its percentage is at least 100 × `occupied_thresh`, free if it is at most 100 × `free_thresh`, and
/// unknown in between.
///
/// So do ROS 1 and Nav2 up to Iron and Jazzy 1.3.6. Later releases of Nav2 read some images differently; see
/// [`load_map_with_concerns`].
///
/// All keys but `mode` are required. Unknown keys are ignored, since other programs add their own, unless they look
/// like a misspelling of a missing key.
///
/// The yaw of the origin rotates the whole map. Maps of more than [`MAX_CELLS`](crate::MAX_CELLS) cells are refused.
///
/// # Errors
/// [`Error::Read`](diagnostics::Error::Read) if the YAML file cannot be read;
/// [`Error::Problems`](diagnostics::Error::Problems) with everything that is wrong with the YAML and its image. An
/// unusable image is reported at the line that names it.
///
/// # Example
/// A map in memory:
/// ```
/// use std::path::Path;
/// use maps::{Cell, load_map};
///
/// let files = |path: &Path| match path.to_str() {
///     Some("maps/tiny.yaml") => Ok("image: tiny.pgm\nresolution: 0.5\norigin: [0, 0, 0]\n\
///                                   negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n".into()),
///     Some("maps/tiny.pgm") => Ok("P2  3 1  255  0 205 254".into()),
///     _ => Err(std::io::ErrorKind::NotFound.into()),
/// };
/// let map = load_map(Path::new("maps/tiny.yaml"), &files)?;
/// assert_eq!(map.cells(), [Cell::Occupied, Cell::Unknown, Cell::Free]);
/// # Ok::<(), diagnostics::Error>(())
/// ```
pub fn load_map(path: &Path, read: ReadFile<'_>) -> Result<OccupancyGrid, diagnostics::Error> {
    load_map_with_concerns(path, read).map(|(map, _)| map)
}

/// Loads a map like [`load_map`], with warnings about cells that Nav2 reads differently from Jazzy 1.3.7 and Kilted on:
/// where the image has alpha, where a shade lies on a threshold, and where the image has colors.
///
/// # Errors
/// Those of [`load_map`].
pub fn load_map_with_concerns(
    path: &Path,
    read: ReadFile<'_>,
) -> Result<(OccupancyGrid, Vec<Problem>), diagnostics::Error> {
    let text = read_text(path, read)?;
    let document = Document::parse_yaml(&path.display().to_string(), &text)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    Ok(document.read(|root| read_map(root, folder, read))?)
}

fn read_map(root: Table<'_>, folder: &Path, read: ReadFile<'_>) -> Option<(OccupancyGrid, Vec<Problem>)> {
    root.allow_other_keys();
    let image = root.text("image").try_map(|name, span| load_raster(&folder.join(&name), span, read));
    let image = image.spanned().required();
    let resolution_m = number(root, "resolution").above(0.0).within(1e-4..=100.0).required();
    let origin = read_origin(root);
    let meaning = read_meaning(root);
    let (Spanned { value: raster, span }, meaning) = (image?, meaning?);
    let (mut cells, changes) = read_cells(&raster, &meaning);
    // An image begins with its top row, a grid with its bottom row.
    flip(&mut cells, raster.width());
    let map = OccupancyGrid::from_cells(raster.width(), raster.height(), resolution_m?, origin?, cells);
    Some((map, concerns(changes, &span)))
}

/// A cell, what newer releases of Nav2 read instead, and why.
type Changed = (Cell, Cell, Change);

/// The cells of an image from its top row on, and how many newer releases of Nav2 read differently.
fn read_cells(raster: &Raster, meaning: &Meaning) -> (Vec<Cell>, Vec<(Changed, usize)>) {
    let (mut cells, mut changes): (Vec<Cell>, Vec<(Changed, usize)>) = (Vec::new(), Vec::new());
    let mut pixels = raster.pixels().peekable();
    while let Some(pixel) = pixels.next() {
        // In a map, most pixels equal the one before them, and it takes long to work out what a pixel means.
        let count = 1 + std::iter::from_fn(|| pixels.next_if_eq(&pixel)).count();
        let cell = meaning.cell(pixel, raster.white());
        cells.extend(std::iter::repeat_n(cell, count));
        let Some((why, newer)) = meaning.change(pixel, raster.white()) else { continue };
        let change = (cell, newer, why);
        match changes.iter_mut().find(|(known, _)| *known == change) {
            Some((_, all)) => *all += count,
            None => changes.push((change, count)),
        }
    }
    (cells, changes)
}

/// Warnings about cells that newer releases of Nav2 read differently, one for each reason and pair of cells.
fn concerns(changes: Vec<(Changed, usize)>, image: &Span) -> Vec<Problem> {
    let word = |cell| match cell {
        Cell::Free => "free",
        Cell::Occupied => "occupied",
        Cell::Unknown => "unknown",
    };
    let problem = |((older, newer, why), count)| {
        let cells = if count == 1 { "1 cell is".to_owned() } else { format!("{count} cells are") };
        let (older, newer) = (word(older), word(newer));
        let message = format!("{cells} {older} in ROS 1 and in Nav2 up to Jazzy 1.3.6, but {newer} in later releases");
        let (label, help) = match why {
            Change::Alpha => (
                "its alpha channel",
                "earlier releases, and steward, count alpha as a color; Nav2 from Jazzy 1.3.7 and Kilted on takes \
                 pixels that are transparent for unknown, and otherwise ignores alpha: save the image without alpha",
            ),
            Change::Threshold => (
                "shades on a threshold",
                "earlier releases, and steward, take a shade on `free_thresh` or `occupied_thresh` for unknown; Nav2 \
                 from Jazzy 1.3.7 and Kilted on takes it for free or occupied: choose thresholds between the shades",
            ),
            Change::Weights => (
                "its colors",
                "earlier releases, and steward, take the mean of the colors for a shade; Nav2 from Jazzy 1.3.7 and \
                 Kilted on weights them: save the image in shades of gray",
            ),
        };
        image.problem(message).as_warning().with_label(label).with_help(help)
    };
    changes.into_iter().map(problem).collect()
}

fn load_raster(path: &Path, span: &Span, read: ReadFile<'_>) -> Result<Raster, Problem> {
    let problem = |why| span.problem(format!("the image {} {why}", path.display())).with_label("this image");
    let bytes = read(path).map_err(|error| {
        problem(format!("cannot be read: {error}")).with_help("its path is relative to the folder of this file")
    })?;
    Raster::decode(&bytes, MAX_CELLS).map_err(|error| {
        let problem = problem(format!("cannot be used: {error}"));
        match error {
            RasterError::Format => problem.with_help("PGM, PBM, PPM, PNG and BMP are accepted"),
            _ => problem,
        }
    })
}

fn read_origin(root: Table<'_>) -> Option<Pose> {
    let origin = match root.get::<Item<'_>>("origin").optional().and_then(|item| quoted_numbers(&item)) {
        Some(read) => root.get::<Item<'_>>("origin").map(|_| read),
        None => root.get::<[f64; 3]>("origin"),
    };
    let origin = origin.check(
        |[x_m, y_m, _]| x_m.abs() <= MAX_COORDINATE_M && y_m.abs() <= MAX_COORDINATE_M,
        format!("lie within {} km of the frame's origin", MAX_COORDINATE_M / 1e3),
    );
    origin.map(|[x_m, y_m, yaw_rad]| pose(x_m, y_m, yaw_rad)).required()
}

fn read_meaning(root: Table<'_>) -> Option<Meaning> {
    let modes = [("trinary", Mode::Trinary), ("scale", Mode::Scale), ("raw", Mode::Raw)];
    // Nav2 reads these words in any case.
    let written = root.get::<Item<'_>>("mode").optional().and_then(|item| item.as_text());
    let known = written.and_then(|text| modes.into_iter().find(|(name, _)| name.eq_ignore_ascii_case(text)));
    let mode = known.map_or_else(|| root.one_of("mode", &modes).or(Mode::Trinary), |(_, mode)| mode);
    let negate = root.get::<Item<'_>>("negate").try_map(|item, _| yes_or_no(&item));
    let negate = negate.required_or("add `negate: 0`, or `negate: 1` if black is free");
    let occupied = number(root, "occupied_thresh").within(0.0..=1.0).required();
    let free = number(root, "free_thresh").within(0.0..=1.0);
    let free = match occupied {
        Some(occupied) => free.check(|free| *free < occupied, format!("be less than `occupied_thresh`, {occupied}")),
        None => free,
    };
    let free = free.required();
    Some(Meaning { mode, negate: negate?, occupied_threshold: occupied?, free_threshold: free? })
}

/// A number, which may be in quotes: ROS's YAML reader does not distinguish them.
fn number<'d>(root: Table<'d>, key: &'d str) -> Field<'d, f64> {
    let quoted = |item: Item<'_>| item.as_text().and_then(|text| text.trim().parse::<f64>().ok());
    match root.get::<Item<'_>>(key).optional().and_then(quoted) {
        Some(read) => root.get::<Item<'_>>(key).map(|_| read),
        None => root.number(key),
    }
}

/// Three numbers of which one is in quotes.
fn quoted_numbers(item: &Item<'_>) -> Option<[f64; 3]> {
    let items = item.as_array()?;
    let is_quoted = items.iter().any(|item| item.as_text().is_some());
    let read = |item: &Item<'_>| item.as_number().or_else(|| item.as_text()?.trim().parse().ok());
    let numbers: Vec<f64> = items.iter().map(read).collect::<Option<_>>()?;
    numbers.try_into().ok().filter(|numbers: &[f64; 3]| is_quoted && numbers.iter().all(|number| number.is_finite()))
}

/// A boolean as ROS's YAML reader accepts it, including 0, 1 and the words of YAML 1.1.
fn yes_or_no(item: &Item<'_>) -> Result<bool, Problem> {
    let word = match item.as_text() {
        Some("yes" | "on" | "true" | "1") => Some(true),
        Some("no" | "off" | "false" | "0") => Some(false),
        _ => None,
    };
    let number = item.as_integer().and_then(|number| [false, true].get(usize::try_from(number).ok()?).copied());
    item.as_boolean().or(word).or(number).ok_or_else(|| item.wrong("0, 1, false or true"))
}

/// Flips the rows of an image vertically.
fn flip<T>(cells: &mut [T], width: usize) {
    let height = cells.len() / width;
    let (top, bottom) = cells.split_at_mut(height / 2 * width);
    for (upper, lower) in top.chunks_exact_mut(width).zip(bottom.chunks_exact_mut(width).rev()) {
        upper.swap_with_slice(lower);
    }
}

#[cfg(test)]
mod tests;
