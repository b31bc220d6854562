//! The map with everything on it.

use maps::{Point, Pose};

use super::canvas::{Anchor, Canvas, Paint, TextStyle};
use super::frame::{BodyShape, Destination, Scene};
use super::geometry::{Area, Spot};
use super::icons::Icon;
use super::labels::{LabelPlacer, Site};
use super::panel;
use super::path::Path;
use super::text::Font;
use super::theme::{self, Color};
use super::view::{Bounds, View};

const FONT: Font = Font::regular(15.0);
const FOOT: f64 = 40.0;

/// Draws the map, the legend and the scale bar into `area`.
pub fn draw(canvas: &mut Canvas, area: Area, scene: &Scene) {
    panel::sheet(canvas, area);
    let frame = Area::new(area.x + 10.0, area.y + 10.0, area.width - 20.0, area.height - 10.0 - FOOT);
    let view = View::fitting(bounds(scene), frame);
    canvas.rounded(frame, 4.0, Paint::fill(theme::UNKNOWN));
    canvas.clipped("map", frame, |canvas| {
        scene.map.draw(canvas, &view);
        MapDrawing::new(canvas, view, scene, FONT).draw();
    });
    let foot = Area::new(frame.x, frame.bottom(), frame.width, FOOT);
    let right_of_bar = scale_bar(canvas, foot, &view);
    legend(canvas, foot, right_of_bar);
}

/// What must be in the picture: what is known of the map, and the places of the run. Things that move don't count, so
/// that all pictures of a run show the same section.
pub fn bounds(scene: &Scene) -> Bounds {
    let poses = scene.start.iter().chain(&scene.station).map(|pose| Point::from(pose.translation.vector));
    let corners = scene.destination.iter().flat_map(|destination| destination.corners.iter().copied());
    let places = poses.chain(corners).filter(|point| point.x.is_finite() && point.y.is_finite());
    match Bounds::around(places) {
        Some(places) => scene.map.bounds().union(places.grown(0.5)),
        None => scene.map.bounds(),
    }
}

/// A label whose place is to be found.
struct Label {
    site: Site,
    text: String,
    color: Color,
}

/// What is drawn on the floor of a map, with the labels that are still to be written.
pub struct MapDrawing<'a> {
    /// Where it is drawn.
    pub canvas: &'a mut Canvas,
    /// Where labels may still stand.
    pub placer: LabelPlacer,
    view: View,
    labels: Vec<Label>,
    scene: &'a Scene,
    font: Font,
}

impl<'a> MapDrawing<'a> {
    /// A drawing on a floor that is there already; labels are in that font.
    pub fn new(canvas: &'a mut Canvas, view: View, scene: &'a Scene, font: Font) -> Self {
        let placer = LabelPlacer::new(view.area.inset(6.0));
        Self { canvas, placer, view, labels: Vec::new(), scene, font }
    }
}

impl MapDrawing<'_> {
    /// Everything, one thing on top of the other.
    pub fn draw(mut self) {
        let scene = self.scene;
        if let Some(destination) = &scene.destination {
            self.destination(destination);
        }
        self.lines();
        self.bodies();
        self.places();
        self.faults();
        self.robot();
        self.write_labels();
    }

    /// Start and charging station.
    pub fn places(&mut self) {
        if let Some(start) = &self.scene.start {
            self.start(start);
        }
        if let Some(station) = &self.scene.station {
            self.station(station);
        }
    }

    /// Where the robot is to go.
    pub fn destination(&mut self, destination: &Destination) {
        let spots: Vec<Spot> = self.view.spots(&destination.corners).collect();
        let Some(&first) = spots.first() else { return };
        if spots.len() < 3 {
            self.canvas.circle(first, 11.0, Paint::fill(theme::BUSY_LIGHT).outlined(theme::BUSY, 2.0).dashed("5 4"));
            self.canvas.circle(first, 3.0, Paint::fill(theme::BUSY));
            self.label(first, 15.0, &destination.label, theme::BUSY_DARK);
            return;
        }
        let low = spots.iter().fold(first, |low, spot| (low.0.min(spot.0), low.1.min(spot.1)));
        let high = spots.iter().fold(first, |high, spot| (high.0.max(spot.0), high.1.max(spot.1)));
        let symbol = Area::new(low.0, low.1, high.0 - low.0, high.1 - low.1).inset(-4.0);
        let paint = Paint::fill(theme::BUSY_LIGHT).fill_opacity(0.85).outlined(theme::BUSY, 2.0).dashed("7 5");
        self.canvas.path(&Path::through(spots).close(), paint);
        let site = Site { symbol, roomy: true };
        self.labels.push(Label { site, text: destination.label.clone(), color: theme::BUSY_DARK });
    }

    /// The trail, the path, the particles and the laser hits.
    fn lines(&mut self) {
        let (scene, view) = (self.scene, self.view);
        let trail = thinned(view.spots(&scene.trail), 1.5);
        let path: Vec<Spot> = view.spots(&scene.path).collect();
        self.placer.avoid_line(trail.iter().copied());
        self.placer.avoid_line(path.iter().copied());
        self.canvas.path(&Path::through(trail), Paint::stroke(theme::MUTED, 2.6).dashed("0.1 6"));
        let particles = Path::dots(view.spots(&scene.particles));
        self.canvas.path(&particles, Paint::stroke(theme::BELIEF, 2.6).stroke_opacity(0.5));
        self.canvas.path(&Path::through(path.iter().copied()), Paint::stroke(theme::PAPER, 6.5).stroke_opacity(0.7));
        self.canvas.path(&Path::through(path), Paint::stroke(theme::GOOD, 3.6));
        self.canvas.path(&Path::dots(view.spots(&scene.laser_hits)), Paint::stroke(theme::LASER, 4.2));
    }

    /// People, doors and boxes.
    pub fn bodies(&mut self) {
        for body in &self.scene.bodies {
            let paint = Paint::fill(theme::BODY_LIGHT).outlined(theme::BODY, 1.8);
            let (center, reach) = match &body.shape {
                BodyShape::Disc { center, radius_m } => {
                    let radius = self.view.pixels(*radius_m).max(3.0);
                    let Some(spot) = self.view.spot(*center) else { continue };
                    self.canvas.circle(spot, radius, paint);
                    (spot, radius)
                }
                BodyShape::Rectangle { pose, length_m, width_m } => {
                    let Some(spot) = self.spot(pose) else { continue };
                    let corner =
                        |along: f64, across: f64| pose * Point::new(along * length_m / 2.0, across * width_m / 2.0);
                    let corners = [corner(1.0, 1.0), corner(-1.0, 1.0), corner(-1.0, -1.0), corner(1.0, -1.0)];
                    self.canvas.path(&Path::through(self.view.spots(&corners)).close(), paint);
                    (spot, self.view.pixels(length_m.max(*width_m)) / 2.0)
                }
            };
            if !body.label.is_empty() {
                self.label(center, reach + 5.0, &body.label, theme::BODY);
            }
        }
    }

    fn start(&mut self, start: &Pose) {
        let Some(spot) = self.spot(start) else { return };
        self.canvas.circle(spot, 5.5, Paint::fill(theme::PAPER).outlined(theme::MUTED, 2.0));
        self.canvas.circle(spot, 2.0, Paint::fill(theme::MUTED));
        self.label(spot, 10.0, "start", theme::MUTED);
    }

    fn station(&mut self, station: &Pose) {
        const RADIUS: f64 = 11.5;
        let Some(spot) = self.spot(station) else { return };
        let tick = ahead(station, spot, RADIUS + 7.0);
        self.canvas.line(spot, tick, Paint::stroke(theme::PAPER, 7.0));
        self.canvas.line(spot, tick, Paint::stroke(theme::GOOD, 3.4));
        self.canvas.circle(spot, RADIUS, Paint::fill(theme::PAPER).outlined(theme::GOOD, 3.0));
        Icon::Bolt.draw(self.canvas, spot, 15.0, theme::GOOD);
        self.label(spot, RADIUS + 11.0, "charging station", theme::GOOD);
    }

    /// Where faults took hold.
    pub fn faults(&mut self) {
        const RADIUS: f64 = 8.0;
        for fault in &self.scene.faults {
            let Some(spot) = self.view.spot(fault.position) else { continue };
            self.canvas.circle(spot, RADIUS, Paint::fill(theme::BAD).outlined(theme::PAPER, 1.6));
            Icon::Alert.draw(self.canvas, spot, 12.0, theme::PAPER);
            self.label(spot, RADIUS + 5.0, &fault.label, theme::BAD);
        }
    }

    /// The robot where it is and, if that differs visibly, where it believes it is.
    pub fn robot(&mut self) {
        let scene = self.scene;
        let radius = self.view.pixels(scene.robot_radius_m).max(7.0);
        let Some(spot) = self.spot(&scene.robot) else { return };
        self.placer.block(Area::around(spot, 2.0 * radius + 6.0, 2.0 * radius + 6.0));
        let paint = Paint::fill(theme::INK).outlined(theme::PAPER, 1.6);
        let nose = |pose: &Pose, spot: Spot| {
            Path::through([(0.75, 0.62), (1.6, 0.0), (0.75, -0.62)].map(|(x, y)| {
                let tip = pose.rotation * nalgebra::Vector2::new(x, y) * radius;
                (spot.0 + tip.x, spot.1 - tip.y)
            }))
            .close()
        };
        self.canvas.path(&nose(&scene.robot, spot), paint);
        self.canvas.circle(spot, radius, paint);
        self.canvas.line(spot, ahead(&scene.robot, spot, radius * 0.95), Paint::stroke(theme::PAPER, radius * 0.22));
        let Some(estimate) = scene.estimate else { return };
        let Some(believed) = self.spot(&estimate) else { return };
        let aligned = scene.robot.rotation.rotation_to(&estimate.rotation).re > 0.985;
        if aligned && (believed.0 - spot.0).abs().max((believed.1 - spot.1).abs()) < 4.0 {
            return;
        }
        let paint = Paint::stroke(theme::BELIEF, 2.2).dashed("4 3.5");
        self.canvas.path(&nose(&estimate, believed), Paint::fill(theme::BELIEF));
        self.canvas.circle(believed, radius, paint);
        self.label(believed, radius + 6.0, "estimate", theme::BELIEF);
    }

    /// Where a pose lies; `None` if it is not finite.
    fn spot(&self, pose: &Pose) -> Option<Spot> {
        let heading = pose.rotation.re + pose.rotation.im;
        self.view.spot(pose.translation.vector.into()).filter(|_| heading.is_finite())
    }

    /// Notes a label for a sign of that radius; it is written last, when everything it should keep clear of is known.
    pub fn label(&mut self, at: Spot, radius: f64, text: &str, color: Color) {
        let site = Site { symbol: Area::around(at, 2.0 * radius, 2.0 * radius), roomy: false };
        self.placer.block(site.symbol);
        self.labels.push(Label { site, text: text.to_owned(), color });
    }

    /// Writes the labels of all that was drawn, none over another.
    pub fn write_labels(&mut self) {
        for label in std::mem::take(&mut self.labels) {
            let font = self.font;
            let text = font.fit(&label.text, self.view.area.width * 0.4);
            let (view, map) = (self.view, &self.scene.map);
            let area = self.placer.place(&label.site, (font, font.width(&text)), |area| map.covered(area, &view));
            let style = TextStyle::new(font, label.color).anchored(Anchor::Middle).with_halo();
            self.canvas.centered_text(area.center(), &text, style);
        }
    }
}

/// The spot so many pixels ahead of a pose that lies at `spot`.
fn ahead(pose: &Pose, spot: Spot, pixels: f64) -> Spot {
    (spot.0 + pose.rotation.re * pixels, spot.1 - pose.rotation.im * pixels)
}

/// The spots without those that are closer than `gap` pixels to the one before; the last one stays.
pub fn thinned(spots: impl Iterator<Item = Spot>, gap: f64) -> Vec<Spot> {
    let mut kept: Vec<Spot> = Vec::new();
    let mut last = None;
    for spot in spots {
        let far = |other: &Spot| (spot.0 - other.0).abs().max((spot.1 - other.1).abs()) >= gap;
        last = Some(spot);
        if kept.last().is_none_or(far) {
            kept.push(spot);
        }
    }
    kept.extend(last.filter(|last| kept.last() != Some(last)));
    kept
}

/// Draws a bar of a round length at the left of `foot`; returns how far right it reaches.
pub(super) fn scale_bar(canvas: &mut Canvas, foot: Area, view: &View) -> f64 {
    const ROUND_M: [f64; 10] = [100.0, 50.0, 20.0, 10.0, 5.0, 2.0, 1.0, 0.5, 0.2, 0.1];
    let length_m = ROUND_M.into_iter().find(|&length_m| view.pixels(length_m) <= 170.0).unwrap_or(0.1);
    let length = view.pixels(length_m).min(170.0);
    let (left, middle) = (foot.x + 8.0, foot.center().1);
    let (line, end) = (Paint::stroke(theme::INK, 2.0), 5.0);
    canvas.line((left, middle), (left + length, middle), line);
    for x in [left, left + length] {
        canvas.line((x, middle - end), (x, middle + end), line);
    }
    let text = format!("{length_m} m");
    canvas.centered_text((left + length + 10.0, middle), &text, TextStyle::new(FONT, theme::MUTED));
    left + length + 10.0 + FONT.width(&text)
}

/// What the signs on the map mean, spread over the rest of the foot.
fn legend(canvas: &mut Canvas, foot: Area, left: f64) {
    type Sign = fn(&mut Canvas, Spot);
    const SIGN: f64 = 34.0;
    let entries: [(&str, Sign); 5] = [
        ("robot", |canvas, (x, y)| {
            canvas.circle((x, y), 7.0, Paint::fill(theme::INK));
            canvas.line((x, y), (x + 7.0, y), Paint::stroke(theme::PAPER, 1.6));
        }),
        ("planned path", |canvas, (x, y)| canvas.line((x - 12.0, y), (x + 12.0, y), Paint::stroke(theme::GOOD, 3.6))),
        ("driven", |canvas, (x, y)| {
            canvas.line((x - 12.0, y), (x + 12.0, y), Paint::stroke(theme::MUTED, 2.6).dashed("0.1 6"));
        }),
        ("laser hits", |canvas, (x, y)| {
            canvas.path(&Path::dots([(x - 9.0, y), (x, y), (x + 9.0, y)]), Paint::stroke(theme::LASER, 4.2));
        }),
        ("particles", |canvas, (x, y)| {
            let dots = [(-8.0, 2.0), (-3.0, -4.0), (0.0, 3.0), (4.0, -1.0), (8.0, 3.0), (9.0, -4.0)];
            let paint = Paint::stroke(theme::BELIEF, 2.8).stroke_opacity(0.7);
            canvas.path(&Path::dots(dots.map(|(dx, dy)| (x + dx, y + dy))), paint);
        }),
    ];
    let width = |entries: &[(&str, Sign)]| entries.iter().map(|(words, _)| SIGN + FONT.width(words)).sum::<f64>();
    let room = foot.right() - left - 8.0;
    let shown = (0..entries.len()).find(|&hidden| width(&entries[hidden..]) <= room).unwrap_or(entries.len());
    let entries = &entries[shown..];
    let needed = width(entries);
    let gap = ((room - needed) / (entries.len() + 1) as f64).min(48.0);
    let y = foot.center().1;
    let mut x = foot.right() - needed - gap * entries.len().saturating_sub(1) as f64 - 8.0;
    for &(words, sign) in entries {
        sign(canvas, (x + SIGN / 2.0 - 3.0, y));
        canvas.centered_text((x + SIGN, y), words, TextStyle::new(FONT, theme::MUTED));
        x += SIGN + FONT.width(words) + gap;
    }
}
