//! The monitors: their properties, verdicts and state machines.

use super::canvas::{Anchor, Canvas, Paint, TextStyle};
use super::diagram_arrows::PlacedEdge;
use super::diagram_layout::DiagramLayout;
use super::frame::{Diagram, Monitor, Verdict};
use super::geometry::{Area, Spot};
use super::icons::Look;
use super::panel;
use super::path::Path;
use super::text::{Font, Weight};
use super::theme::{self, Color};

const NAME: Font = Font::bold(15.0);
const WORDS: Font = Font::regular(14.0);
const SMALL: Font = Font::regular(12.0);
const VERDICT: Font = Font::bold(13.0);
const HEAD: f64 = 28.0;
/// Height of each additional line of a monitor's description, in pixels.
const LINE: f64 = 17.0;
/// Room for a verdict: the same for every verdict, so that nothing moves when the verdict changes.
const PILL: f64 = 152.0;
const CHIPS: f64 = 24.0;
const GAP: f64 = 14.0;
const TIGHT_GAP: f64 = 8.0;
/// Columns and rows of names, if there is room only for names and verdicts.
const COLUMNS: usize = 2;
const ROW: f64 = 25.0;

/// How much of a monitor is drawn below its head.
enum Body {
    /// Its state machine.
    Machine(DiagramLayout),
    /// Only its locations, in one row.
    Chips,
    Nothing,
}

/// A monitor to draw.
struct Detail {
    /// Its description, in lines.
    words: Vec<String>,
    body: Body,
}

impl Detail {
    fn new(monitor: &Monitor, width: f64) -> Self {
        let left = NAME.width(&name(monitor, width)) + 12.0;
        let words = WORDS.wrap(&monitor.description, width - PILL - left - 10.0, 2);
        Self { words, body: Body::Machine(DiagramLayout::new(&monitor.diagram, width)) }
    }

    fn head(&self) -> f64 {
        HEAD + LINE * self.words.len().saturating_sub(1) as f64
    }

    /// The room between it and the next one.
    fn gap(&self) -> f64 {
        match self.body {
            Body::Machine(_) => GAP,
            Body::Chips | Body::Nothing => TIGHT_GAP,
        }
    }

    fn height(&self) -> f64 {
        let body = match &self.body {
            Body::Machine(layout) => layout.height,
            Body::Chips => CHIPS,
            Body::Nothing => 0.0,
        };
        self.head() + body + self.gap()
    }
}

/// The monitor's name, or its beginning.
fn name(monitor: &Monitor, width: f64) -> String {
    NAME.fit(&monitor.name, width * 0.25)
}

/// The height at which all monitors can be drawn in full in a panel of this width, in pixels.
pub(super) fn wanted_height(monitors: &[Monitor], width: f64) -> f64 {
    let room = width - 2.0 * panel::MARGIN;
    let details = monitors.iter().map(|monitor| Detail::new(monitor, room).height());
    let diagrams: Vec<&Diagram> = monitors.iter().map(|monitor| &monitor.diagram).collect();
    panel::HEAD + details.sum::<f64>() + meanings_height(&diagrams, room)
}

/// The meaning of the names of locations, in lines.
fn meanings(diagrams: &[&Diagram], width: f64) -> Vec<String> {
    let mut meanings: Vec<String> = Vec::new();
    for location in diagrams.iter().flat_map(|diagram| &diagram.locations).filter(|location| !location.about.is_empty())
    {
        let meaning = format!("{} {}", location.name, location.about);
        if !meanings.contains(&meaning) {
            meanings.push(meaning);
        }
    }
    SMALL.wrap_items(&meanings, " · ", width)
}

fn meanings_height(diagrams: &[&Diagram], width: f64) -> f64 {
    lines_height(meanings(diagrams, width).len())
}

fn lines_height(lines: usize) -> f64 {
    lines as f64 * SMALL.line_height() + if lines > 0 { 6.0 } else { 0.0 }
}

/// Writes the meanings of a machine's location names below it, and returns the height of this text.
pub fn draw_meanings(canvas: &mut Canvas, area: Area, diagrams: &[&Diagram]) -> f64 {
    let lines = meanings(diagrams, area.width);
    for (number, line) in lines.iter().enumerate() {
        let y = area.y + (number as f64 + 0.5) * SMALL.line_height();
        canvas.centered_text((area.x, y), line, TextStyle::new(SMALL, theme::MUTED));
    }
    lines_height(lines.len())
}

/// Draws the panel of the monitors: each with its description and as much of its machine as there is room for, or only
/// names and verdicts if there are too many.
pub(super) fn draw(canvas: &mut Canvas, area: Area, monitors: &[Monitor]) {
    let inner = panel::titled(canvas, area, "Monitors");
    if monitors.is_empty() {
        let nothing = TextStyle::new(WORDS, theme::MUTED);
        canvas.centered_text((inner.x, inner.y + 11.0), "No property is being monitored.", nothing);
    }
    let room = Area { height: area.bottom() - 6.0 - inner.y, ..inner };
    let Some(details) = details(monitors, room) else {
        let hidden = draw_names(canvas, room, monitors);
        if hidden > 0 {
            let style = TextStyle::new(WORDS, theme::MUTED).anchored(Anchor::End);
            let text = format!("+{hidden} more");
            canvas.centered_text((area.right() - panel::MARGIN, panel::title_y(area)), &text, style);
        }
        return;
    };
    draw_details(canvas, room, monitors, &details);
}

/// Draws the monitors below each other, and the meanings of their locations at the bottom.
fn draw_details(canvas: &mut Canvas, room: Area, monitors: &[Monitor], details: &[Detail]) {
    let shown = diagrams(monitors, details);
    let room = Area { height: room.height - meanings_height(&shown, room.width), ..room };
    draw_meanings(canvas, Area { y: room.bottom(), ..room }, &shown);
    let used: f64 = details.iter().map(Detail::height).sum();
    let spare = ((room.height - used) / details.len().max(1) as f64).clamp(0.0, 26.0);
    let mut y = room.y;
    for (i, (monitor, detail)) in monitors.iter().zip(details).enumerate() {
        if i > 0 {
            let line = y - (details[i - 1].gap() + spare) / 2.0 + 1.0;
            canvas.line((room.x, line), (room.right(), line), Paint::stroke(theme::RULE, 1.0));
        }
        draw_head(canvas, Area { y, height: detail.head(), ..room }, monitor, &detail.words);
        let body = Area { y: y + detail.head(), height: detail.height() - detail.head(), ..room };
        match &detail.body {
            Body::Machine(layout) => draw_diagram(canvas, body, layout, &monitor.diagram),
            Body::Chips => draw_chips(canvas, body, &monitor.diagram),
            Body::Nothing => {}
        }
        y += detail.height() + spare;
    }
}

/// How each monitor is drawn; none if they do not all fit. If room is short, monitors are reduced to chips one by one,
/// starting with the last; then, in the same way, to their verdicts.
fn details(monitors: &[Monitor], room: Area) -> Option<Vec<Detail>> {
    let mut details: Vec<Detail> = monitors.iter().map(|monitor| Detail::new(monitor, room.width)).collect();
    let fits = |details: &[Detail]| {
        let meanings = meanings_height(&diagrams(monitors, details), room.width);
        details.iter().map(Detail::height).sum::<f64>() - GAP + meanings <= room.height
    };
    for shorter in [|| Body::Chips, || Body::Nothing] {
        for i in (0..details.len()).rev() {
            if !fits(&details) {
                details[i].body = shorter();
            }
        }
    }
    fits(&details).then_some(details)
}

/// The height of the names and verdicts only, in pixels.
pub(super) fn least_height(monitors: &[Monitor]) -> f64 {
    panel::HEAD + monitors.len().div_ceil(COLUMNS) as f64 * ROW + 6.0
}

/// Draws names and verdicts in columns, as far as there is room, and the number of those left out. If any are left out,
/// the violated ones come first, so that none of them is hidden.
fn draw_names(canvas: &mut Canvas, room: Area, monitors: &[Monitor]) -> usize {
    let rows = (room.height / ROW).max(0.0) as usize;
    let mut shown: Vec<&Monitor> = monitors.iter().collect();
    let hidden = monitors.len().saturating_sub(COLUMNS * rows);
    if hidden > 0 {
        shown.sort_by_key(|monitor| monitor.verdict != Verdict::Violated);
    }
    shown.truncate(COLUMNS * rows);
    let rows = shown.len().div_ceil(COLUMNS).max(1);
    let width = (room.width - 24.0 * (COLUMNS - 1) as f64) / COLUMNS as f64;
    for (place, monitor) in shown.into_iter().enumerate() {
        let (column, row) = ((place / rows) as f64, (place % rows) as f64);
        let cell = Area::new(room.x + column * (width + 24.0), room.y + row * ROW, width, 22.0);
        let look = Look::of_verdict(monitor.verdict);
        let pill = draw_verdict(canvas, cell, look, look.words);
        let name = NAME.fit(&monitor.name, pill.x - cell.x - 8.0);
        canvas.centered_text((cell.x, cell.y + 11.0), &name, TextStyle::new(NAME, theme::INK));
    }
    hidden
}

/// Draws a verdict at the right of a line.
fn draw_verdict(canvas: &mut Canvas, line: Area, look: Look, text: &str) -> Area {
    let width = VERDICT.width(text) + 38.0;
    let pill = Area::new(line.right() - width, line.y, width, 22.0);
    canvas.rounded(pill, 11.0, Paint::fill(look.ground));
    look.icon.draw(canvas, (pill.x + 15.0, pill.y + 11.0), 12.0, look.front);
    canvas.centered_text((pill.x + 26.0, pill.y + 11.0), text, TextStyle::new(VERDICT, look.front));
    pill
}

/// The diagrams whose locations are drawn.
fn diagrams<'a>(monitors: &'a [Monitor], details: &[Detail]) -> Vec<&'a Diagram> {
    let drawn = monitors.iter().zip(details).filter(|(_, detail)| !matches!(detail.body, Body::Nothing));
    drawn.map(|(monitor, _)| &monitor.diagram).collect()
}

/// Draws name, description and verdict in one line.
fn draw_head(canvas: &mut Canvas, area: Area, monitor: &Monitor, words: &[String]) {
    let look = Look::of_verdict(monitor.verdict);
    let y = area.y + 11.0;
    let text =
        if monitor.note.is_empty() { look.words.to_owned() } else { format!("{} · {}", look.words, monitor.note) };
    let text = VERDICT.fit(&text, PILL - 38.0);
    draw_verdict(canvas, area, look, &text);
    let name = name(monitor, area.width);
    canvas.centered_text((area.x, y), &name, TextStyle::new(NAME, theme::INK));
    let left = area.x + NAME.width(&name) + 12.0;
    for (number, line) in words.iter().enumerate() {
        canvas.centered_text((left, y + number as f64 * LINE), line, TextStyle::new(WORDS, theme::MUTED));
    }
}

/// The colors of a location: background, outline, text.
fn location_colors(diagram: &Diagram, i: usize) -> (Color, Color, Color) {
    match (i == diagram.active, diagram.locations[i].error) {
        (true, true) => (theme::BAD, theme::BAD, theme::PAPER),
        (true, false) => (theme::GOOD, theme::GOOD, theme::PAPER),
        (false, true) => (theme::PAPER, theme::BAD, theme::BAD),
        (false, false) => (theme::PAPER, theme::INK, theme::INK),
    }
}

/// Draws a state machine into `area`, where `layout` fits.
pub fn draw_diagram(canvas: &mut Canvas, area: Area, layout: &DiagramLayout, diagram: &Diagram) {
    let (dx, dy) = (area.x + (area.width - layout.width).max(0.0) / 2.0, area.y);
    let font = Font::regular(layout.font_px);
    if let Some(initial) = layout.locations.get(diagram.initial) {
        let tip = (initial.area.x + dx, initial.area.center().1 + dy);
        let dot = (tip.0 - font.size * 1.4, tip.1);
        canvas.circle(dot, font.size * 0.2, Paint::fill(theme::MUTED));
        draw_arrow(canvas, &[dot, tip], font.size);
    }
    for edge in &layout.edges {
        let spine: Vec<Spot> = edge.spine.iter().map(|&(x, y)| (x + dx, y + dy)).collect();
        draw_arrow(canvas, &spine, font.size);
    }
    for (i, location) in layout.locations.iter().enumerate() {
        draw_location(canvas, location.area.shifted(dx, dy), &location.label, font, diagram, i);
    }
    for label in layout.edges.iter().flat_map(|edge: &PlacedEdge| &edge.labels) {
        let style = TextStyle::new(font, theme::MUTED).anchored(Anchor::Middle).with_halo();
        canvas.centered_text(label.area.shifted(dx, dy).center(), &label.text, style);
    }
}

fn draw_location(canvas: &mut Canvas, area: Area, label: &str, font: Font, diagram: &Diagram, i: usize) {
    let (ground, outline, words) = location_colors(diagram, i);
    let active = i == diagram.active;
    if active {
        let ring = area.inset(-3.5);
        canvas.rounded(ring, ring.height / 2.0, Paint::stroke(outline, 1.6).stroke_opacity(0.45));
    }
    canvas.rounded(area, area.height / 2.0, Paint::fill(ground).outlined(outline, 1.7));
    if diagram.locations[i].error && !active {
        canvas.rounded(area.inset(3.2), area.height / 2.0, Paint::stroke(outline, 1.1));
    }
    let weight = if active { Weight::Bold } else { Weight::Regular };
    let style = TextStyle::new(Font { weight, ..font }, words).anchored(Anchor::Middle);
    canvas.centered_text(area.center(), label, style);
}

/// Draws a line through all spots with rounded corners and an arrowhead at its end.
fn draw_arrow(canvas: &mut Canvas, spine: &[Spot], font_px: f64) {
    let [.., before, tip] = spine else { return };
    let head = font_px * 0.62;
    let (dx, dy) = (tip.0 - before.0, tip.1 - before.1);
    let length = dx.abs().max(dy.abs()).max(1e-6);
    let (ux, uy) = (dx / length, dy / length);
    let neck = (tip.0 - ux * head * 0.8, tip.1 - uy * head * 0.8);
    let mut path = Path::new().move_to(spine[0]);
    for corner in spine.windows(3) {
        let (from, at, to) = (corner[0], corner[1], corner[2]);
        let longest = |a: Spot, b: Spot| (a.0 - b.0).abs().max((a.1 - b.1).abs());
        let radius = 8.0_f64.min(longest(from, at) * 0.9).min(longest(at, to) / 2.0);
        let towards = |other: Spot| {
            let length = longest(other, at).max(1e-6);
            (at.0 + (other.0 - at.0) / length * radius, at.1 + (other.1 - at.1) / length * radius)
        };
        path = path.line_to(towards(from)).corner(at, towards(to));
    }
    canvas.path(&path.line_to(neck), Paint::stroke(theme::MUTED, 1.5));
    let side = |sign: f64| (tip.0 - ux * head - uy * sign * head * 0.42, tip.1 - uy * head + ux * sign * head * 0.42);
    canvas.path(&Path::through([*tip, side(1.0), side(-1.0)]).close(), Paint::fill(theme::MUTED));
}

/// Draws the locations as a row of chips, the active one filled.
fn draw_chips(canvas: &mut Canvas, area: Area, diagram: &Diagram) {
    const SPACE: f64 = 6.0;
    let font = Font::regular(13.0);
    let count = diagram.locations.len();
    let natural: f64 = diagram.locations.iter().map(|location| font.width(&location.name) + 20.0 + SPACE).sum();
    let most = if natural <= area.width { f64::INFINITY } else { area.width / count.max(1) as f64 - SPACE };
    let mut x = area.x;
    for (i, location) in diagram.locations.iter().enumerate() {
        let width = (font.width(&location.name) + 20.0).min(most);
        let chip = Area::new(x, area.y, width, CHIPS - 2.0);
        draw_location(canvas, chip, &font.fit(&location.name, width - 8.0), font, diagram, i);
        x += width + SPACE;
    }
}
