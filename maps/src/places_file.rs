//! Places files: the named points and areas of a map, in TOML beside it, or in the format of YARP's Map2D.

mod map2d;
mod place;

use std::collections::BTreeMap;
use std::path::Path;

use diagnostics::document::{Document, Key, Table};
use diagnostics::{FileProblems, Problem, ReadFile, Span, Spanned, read_text};
use serde_json::{Value, json};

use crate::{Place, Places, Point, Zone, pose};
use place::{area, near_enough, near_enough_text};

pub use place::{DEFAULT_HEADING_TOLERANCE_DEG, DEFAULT_POSITION_TOLERANCE_M, heading_concern};

/// The key that makes a place an area.
const CORNERS: &str = "corners_m";

/// The keys that make an area a zone.
const ZONE: [&str; 2] = ["keep_out", "speed_mps"];

/// A position, in words.
const POINT: &str = "[x, y] in meters, in the map frame";

/// The places of a file, each with its location in the file.
///
/// Each table is a place. One with `position_m` is a point, one with `corners_m` an area, the inside of the outline
/// through its corners. As a goal, an area stands for its centroid, which must therefore lie inside. An area can be a
/// zone: one to keep out of, where no robot is sent, or one to be slow in.
///
/// A file whose name ends in `.ini` is one of YARP's Map2D, where a line `name map x y degrees` is a point and `name
/// map count x y x y …` an area; all its places must belong to one map.
#[derive(Clone, Debug, Default)]
pub struct PlacesFile {
    places: Places,
    spans: BTreeMap<String, Span>,
    concerns: Vec<Problem>,
}

impl PlacesFile {
    /// Loads the places file at `path` through `read`.
    ///
    /// # Errors
    /// [`Error::Read`](diagnostics::Error::Read) if it cannot be read;
    /// [`Error::Problems`](diagnostics::Error::Problems) with everything that is wrong with it.
    pub fn load(path: &Path, read: ReadFile<'_>) -> Result<Self, diagnostics::Error> {
        Ok(Self::parse(&path.display().to_string(), &read_text(path, read)?)?)
    }

    /// Parses a places file. Diagnostics refer to it by `name`.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    ///
    /// # Example
    /// ```
    /// let file = maps::PlacesFile::parse("house.places.toml", "[start]\nposition_m = [0, 0]\nheading_deg = 90\n")?;
    /// let start = file.places().get("start").expect("it is in the file");
    /// assert_eq!(start.goal_heading(), Some(std::f64::consts::FRAC_PI_2));
    /// # Ok::<(), diagnostics::FileProblems>(())
    /// ```
    pub fn parse(name: &str, text: &str) -> Result<Self, FileProblems> {
        if Path::new(name).extension().is_some_and(|ending| ending.eq_ignore_ascii_case("ini")) {
            return map2d::parse(name, text).map(|(places, spans, concerns)| Self { places, spans, concerns });
        }
        Document::parse_toml(name, text)?.read(read_file)
    }

    /// All keys of a places file in TOML.
    #[must_use]
    pub fn keys() -> Vec<Key> {
        Key::all(read_file)
    }

    /// The JSON schema of a places file in TOML.
    #[must_use]
    pub fn schema() -> Value {
        Key::json_schema("Places on a map for steward", json!({}), &Self::keys())
    }

    /// The places.
    #[must_use]
    pub fn places(&self) -> &Places {
        &self.places
    }

    /// Warnings about headings that look like radians.
    #[must_use]
    pub fn concerns(&self) -> &[Problem] {
        &self.concerns
    }

    /// Only the places.
    #[must_use]
    pub fn into_places(self) -> Places {
        self.places
    }

    /// Where a place's position or corners are written, so that problems with them can be reported later.
    #[must_use]
    pub fn span(&self, name: &str) -> Option<&Span> {
        self.spans.get(name)
    }
}

fn read_file(root: Table<'_>) -> Option<PlacesFile> {
    let mut file = PlacesFile::default();
    let concerns = &mut file.concerns;
    let read: Vec<_> = root.names("NAME").map(|(name, _)| (name, read_place(root, name, concerns))).collect();
    for (name, place) in read {
        let (Spanned { value, span }, rules) = place?;
        if let (Place::Area { corners }, Some((keep_out, speed_mps))) = (&value, rules) {
            file.places.add_zone(Zone { name: name.to_owned(), corners: corners.clone(), keep_out, speed_mps });
        }
        file.places.insert(name, value);
        file.spans.insert(name.to_owned(), span);
    }
    Some(file)
}

/// Whether to keep out of an area, and the highest speed in it.
type Rules = Option<(bool, Option<f64>)>;

/// A place, where its position or corners are written, and its rules if it is a zone.
fn read_place(root: Table<'_>, name: &str, concerns: &mut Vec<Problem>) -> Option<(Spanned<Place>, Rules)> {
    let table = root.table(name).rules(|| {
        json!({
            "if": { "required": [CORNERS] },
            "then": { "propertyNames": { "enum": [CORNERS, ZONE[0], ZONE[1]] } },
            "else": { "required": ["position_m", "heading_deg"], "propertyNames": { "not": { "enum": ZONE } } },
        })
    });
    let about = "A place: a point with `position_m` and `heading_deg`, or an area with `corners_m`.";
    let table = table.about(about).optional()?;
    let is_area = table.has(CORNERS);
    // Both are read while keys are declared.
    let point = table.form(!is_area).map(|table| read_point(table, concerns).map(|point| (point, None)));
    let area = table.form(is_area).map(read_area);
    point.or(area)?
}

fn read_point(table: Table<'_>, concerns: &mut Vec<Problem>) -> Option<Spanned<Place>> {
    table.know(CORNERS);
    let position = table.get::<[f64; 2]>("position_m").about("Where a point is.").words(POINT);
    let position = position.check(near_enough, near_enough_text()).spanned();
    let position = position.required_or("add `position_m` and `heading_deg` for a point, or `corners_m` for an area");
    let heading = table.number("heading_deg").within(-360.0..=360.0);
    let heading = heading.about("Which way the robot faces at a point, in degrees counter-clockwise from the x axis.");
    let heading = heading.spanned();
    let heading_deg = if table.has("position_m") { heading.required() } else { heading.optional() };
    let heading_deg = heading_deg.map(|Spanned { value, span }| {
        concerns.extend(heading_concern(value, &span));
        value
    });
    let tolerance_m = table.number("position_tolerance_m").above(0.0);
    let tolerance_m = tolerance_m.about("A robot within this distance of a point is there, in meters.");
    let tolerance_m = tolerance_m.default(DEFAULT_POSITION_TOLERANCE_M);
    let tolerance_deg = table.number("heading_tolerance_deg").above(0.0).within(0.0..=180.0);
    let tolerance_deg = tolerance_deg.about("How far from the point's heading it may face, in degrees.");
    let tolerance_deg = tolerance_deg.default(DEFAULT_HEADING_TOLERANCE_DEG);
    let Spanned { value: [x_m, y_m], span } = position?;
    let value = Place::Point {
        pose: pose(x_m, y_m, heading_deg?.to_radians()),
        position_tolerance_m: tolerance_m,
        heading_tolerance_rad: tolerance_deg.to_radians(),
    };
    Some(Spanned { value, span })
}

fn read_area(table: Table<'_>) -> Option<(Spanned<Place>, Rules)> {
    let keep_out = table.boolean("keep_out");
    let keep_out = keep_out.about("Whether no part of the robot may be in the area: navigation drives around it.");
    let keep_out = keep_out.default(false);
    let speed_mps = table.number("speed_mps").above(0.0).about("The highest speed in the area, in m/s.").optional();
    let rules = (keep_out || speed_mps.is_some()).then_some((keep_out, speed_mps));
    let corners = table.get::<Vec<Spanned<[f64; 2]>>>(CORNERS).words("[[x, y], …] in meters, in the map frame");
    let corners = corners.rules(|| json!({ "minItems": 3 })).about(
        "The corners of an area, in either direction. The robot is there if it is inside. It drives to the area's \
         centroid, which must be inside, too.",
    );
    let Spanned { value: corners, span } = corners.spanned().required()?;
    let far = corners.iter().filter(|corner| !near_enough(&corner.value));
    let problems: Vec<Problem> =
        far.map(|corner| corner.span.problem(format!("a corner must {}", near_enough_text()))).collect();
    let point = |corner: Spanned<[f64; 2]>| Spanned { value: Point::from(corner.value), span: corner.span };
    let corners: Vec<_> = corners.into_iter().map(point).collect();
    let read = if problems.is_empty() { area(corners, &span, keep_out) } else { Err(problems) };
    let value = read.map_err(|problems| problems.into_iter().for_each(|problem| table.report(problem))).ok()?;
    Some((Spanned { value, span }, rules))
}

#[cfg(test)]
mod tests;
