//! The colors of all pictures. Meaning never depends on color alone: a symbol, a shape or a word goes with it.

/// An RGB color in SVG syntax, `#rrggbb`.
pub type Color = &'static str;

/// Behind everything.
pub const PAGE: Color = "#f4f6f8";
/// Panels, the floor of a map, and the halo of labels.
pub const PAPER: Color = "#ffffff";
/// Borders of panels and lines between their parts.
pub const RULE: Color = "#d5dbe1";
/// Text and whatever else is in front.
pub const INK: Color = "#1b2530";
/// Text that explains.
pub const MUTED: Color = "#52606d";
/// Thin lines that connect things.
pub const LINE: Color = "#8a96a3";

/// Unknown cells.
pub const UNKNOWN: Color = "#e4e8ec";
/// Walls and the outlines of furniture.
pub const WALL: Color = "#2f3a45";
/// The inside of furniture and of other thick things.
pub const SOLID: Color = "#bcc5ce";

/// Success, and the planned path.
pub const GOOD: Color = "#157a43";
/// A light background for [`GOOD`].
pub const GOOD_LIGHT: Color = "#d9f2e3";
/// Failure, and faults.
pub const BAD: Color = "#c0392b";
/// A light background for [`BAD`].
pub const BAD_LIGHT: Color = "#fde2df";
/// What is in progress.
pub const BUSY: Color = "#d97f00";
/// A light background for [`BUSY`].
pub const BUSY_LIGHT: Color = "#fff0cf";
/// Text about a destination.
pub const BUSY_DARK: Color = "#7d5000";
/// What is idle.
pub const IDLE: Color = "#a3aeb9";
/// A light background for [`IDLE`].
pub const IDLE_LIGHT: Color = "#eef1f4";
/// What the lasers see.
pub const LASER: Color = "#1f6fd0";
/// The estimate of localization.
pub const BELIEF: Color = "#0f7b8a";
/// People and other bodies that are not on the map.
pub const BODY: Color = "#8e5bb5";
/// A light background for [`BODY`].
pub const BODY_LIGHT: Color = "#eadff3";

/// All colors above.
pub const ALL: [Color; 23] = [
    PAGE, PAPER, RULE, INK, MUTED, LINE, UNKNOWN, WALL, SOLID, GOOD, GOOD_LIGHT, BAD, BAD_LIGHT, BUSY, BUSY_LIGHT,
    BUSY_DARK, IDLE, IDLE_LIGHT, LASER, BELIEF, BODY, BODY_LIGHT, "#000000",
];

/// The red, green and blue of a color in this file.
pub fn rgb(color: Color) -> [u8; 3] {
    let value = u32::from_str_radix(&color[1..], 16).expect("the theme's colors are hexadecimal");
    let [_, red, green, blue] = value.to_be_bytes();
    [red, green, blue]
}
