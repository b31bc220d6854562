//! The map with everything on it.

use maps::{Point, Pose, Shape};

use super::canvas::{Anchor, Canvas, Paint, TextStyle};
use super::frame::{Mark, Place, Scene, Station};
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
/// Radius of the sign for a fault or a violation, in pixels.
const BADGE: f64 = 8.0;

/// Draws the map, the legend and the scale bar into `area`.
pub fn draw(canvas: &mut Canvas, area: Area, scene: &Scene) {
    draw_on(canvas, area, scene, false);
}

/// The same. In a series of pictures, the labels of immovable things stay where they were.
pub(super) fn draw_on(canvas: &mut Canvas, area: Area, scene: &Scene, one_of_many: bool) {
    panel::sheet(canvas, area);
    let frame = Area::new(area.x + 10.0, area.y + 10.0, area.width - 20.0, area.height - 10.0 - FOOT);
    let view = View::fitting(bounds(scene), frame);
    canvas.rounded(frame, 4.0, Paint::fill(theme::UNKNOWN));
    canvas.clipped("map", frame, |canvas| {
        scene.map.draw(canvas, &view);
        let drawing = MapDrawing::new(canvas, view, scene, FONT);
        MapDrawing { one_of_many, ..drawing }.draw();
    });
    let foot = Area::new(frame.x, frame.bottom(), frame.width, FOOT);
    let right_of_bar = scale_bar(canvas, foot, &view);
    legend(canvas, foot, right_of_bar, &signs(scene));
}

/// The rectangle that must be in the picture: the known part of the map, and the places of the run. Things that move
/// don't count, so all pictures of a run show the same section.
pub fn bounds(scene: &Scene) -> Bounds {
    let poses = scene.start.iter().chain(scene.station.iter().map(|station| &station.pose));
    let poses = poses.map(|pose| Point::from(pose.translation.vector));
    let corners = scene.destination.iter().chain(&scene.places).flat_map(|place| place.corners.iter().copied());
    let places = poses.chain(corners).filter(|point| point.x.is_finite() && point.y.is_finite());
    match Bounds::around(places) {
        Some(places) => scene.map.bounds().union(places.grown(0.5)),
        None => scene.map.bounds(),
    }
}

/// A label whose position is not yet known.
struct Label {
    site: Site,
    /// Its text, and a shorter text, if there is one.
    texts: [String; 2],
    color: Color,
    /// Whether its owner stays where it is for the whole run.
    stands_still: bool,
}

/// The floor of a map, with the labels that are still to be written.
pub struct MapDrawing<'a> {
    /// The canvas on which it is drawn.
    pub canvas: &'a mut Canvas,
    /// Finds room for labels.
    pub placer: LabelPlacer,
    view: View,
    labels: Vec<Label>,
    /// The parts that change from picture to picture: lines, and the robot. Labels of fixed things do not move for
    /// them.
    moving_lines: Vec<Vec<Spot>>,
    moving: Vec<Area>,
    one_of_many: bool,
    scene: &'a Scene,
    font: Font,
}

impl<'a> MapDrawing<'a> {
    /// A drawing on top of a floor that has been drawn; labels have this font.
    pub fn new(canvas: &'a mut Canvas, view: View, scene: &'a Scene, font: Font) -> Self {
        let placer = LabelPlacer::new(view.area.inset(6.0));
        Self {
            canvas,
            placer,
            view,
            labels: Vec::new(),
            moving_lines: Vec::new(),
            moving: Vec::new(),
            one_of_many: false,
            scene,
            font,
        }
    }
}

impl MapDrawing<'_> {
    /// Draws everything, in layers.
    pub fn draw(mut self) {
        self.areas();
        self.lines();
        self.bodies();
        self.places();
        if !self.one_of_many {
            self.robot();
        }
        self.faults();
        self.violations();
        if self.one_of_many {
            // Signs and labels do not move aside for the robot.
            self.write_labels();
            self.robot();
        }
        self.write_labels();
        self.speeches();
    }

    /// Draws the start and the charging station.
    pub fn places(&mut self) {
        if let Some(start) = &self.scene.start {
            self.start(start);
        }
        if let Some(station) = &self.scene.station {
            self.station(station);
        }
    }

    /// Draws the robot's goal and the other places.
    pub fn areas(&mut self) {
        let scene = self.scene;
        for place in &scene.places {
            let calm = (theme::IDLE_LIGHT, theme::LINE, theme::MUTED);
            self.area(place, if place.keep_out { (theme::BAD_LIGHT, theme::BAD, theme::BAD) } else { calm });
        }
        if let Some(destination) = &scene.destination {
            self.area(destination, (theme::BUSY_LIGHT, theme::BUSY, theme::BUSY_DARK));
        }
    }

    fn area(&mut self, place: &Place, (ground, outline, ink): (Color, Color, Color)) {
        let spots: Vec<Spot> = self.view.spots(&place.corners).collect();
        let Some(&first) = spots.first() else { return };
        if spots.len() < 3 {
            self.canvas.circle(first, 11.0, Paint::fill(ground).outlined(outline, 2.0).dashed("5 4"));
            self.canvas.circle(first, 3.0, Paint::fill(outline));
            self.label(first, 15.0, &place.label, ink);
            return;
        }
        let low = spots.iter().fold(first, |low, spot| (low.0.min(spot.0), low.1.min(spot.1)));
        let high = spots.iter().fold(first, |high, spot| (high.0.max(spot.0), high.1.max(spot.1)));
        let symbol = Area::new(low.0, low.1, high.0 - low.0, high.1 - low.1);
        let paint = Paint::fill(ground).fill_opacity(0.85).outlined(outline, 2.0).dashed("7 5");
        self.canvas.path(&Path::through(spots).close(), paint);
        self.note(Site { symbol, roomy: true }, [&place.label, ""], ink, true);
    }

    /// Draws the trail, the path, the particles and the laser hits.
    fn lines(&mut self) {
        let (scene, view) = (self.scene, self.view);
        let trail = thinned(view.spots(&scene.trail), 1.5);
        let path: Vec<Spot> = view.spots(&scene.path).collect();
        self.moving_lines.extend([trail.clone(), path.clone()]);
        self.canvas.path(&Path::through(trail), Paint::stroke(theme::MUTED, 2.6).dashed("0.1 6"));
        let particles = Path::dots(view.spots(&particles(scene)));
        self.canvas.path(&particles, Paint::stroke(theme::BELIEF, 2.6).stroke_opacity(0.5));
        self.canvas.path(&Path::through(path.iter().copied()), Paint::stroke(theme::PAPER, 6.5).stroke_opacity(0.7));
        self.canvas.path(&Path::through(path), Paint::stroke(theme::GOOD, 3.6));
        let hits = thinned(view.spots(&scene.laser_hits), 1.0);
        self.canvas.path(&Path::dots(hits), Paint::stroke(theme::LASER, 4.2));
    }

    /// Draws people, doors and boxes.
    pub fn bodies(&mut self) {
        for body in &self.scene.bodies {
            let paint = Paint::fill(theme::BODY_LIGHT).outlined(theme::BODY, 1.8);
            let Some(center) = self.spot(&body.pose) else { continue };
            let extent = match body.shape {
                Shape::Disc { radius_m } => {
                    let radius = self.view.pixels(radius_m).max(3.0);
                    self.canvas.circle(center, radius, paint);
                    Area::around(center, 2.0 * radius, 2.0 * radius)
                }
                Shape::Box { length_m, width_m } => {
                    let corner = |along: f64, across: f64| {
                        body.pose * Point::new(along * length_m / 2.0, across * width_m / 2.0)
                    };
                    let corners = [corner(1.0, 1.0), corner(-1.0, 1.0), corner(-1.0, -1.0), corner(1.0, -1.0)];
                    let spots: Vec<Spot> = self.view.spots(&corners).collect();
                    let around = spots.iter().fold([0.0_f64; 2], |[width, height], (x, y)| {
                        [width.max(2.0 * (x - center.0).abs()), height.max(2.0 * (y - center.1).abs())]
                    });
                    self.canvas.path(&Path::through(spots).close(), paint);
                    Area::around(center, around[0], around[1])
                }
            };
            // A body may have moved in the next picture, so its label does not stand still.
            if !body.label.is_empty() {
                let site = Site { symbol: extent.inset(-5.0), roomy: false };
                self.note(site, [&body.label, ""], theme::BODY, false);
            }
        }
    }

    fn start(&mut self, start: &Pose) {
        let Some(spot) = self.spot(start) else { return };
        self.canvas.circle(spot, 5.5, Paint::fill(theme::PAPER).outlined(theme::MUTED, 2.0));
        self.canvas.circle(spot, 2.0, Paint::fill(theme::MUTED));
        self.label(spot, 10.0, "start", theme::MUTED);
    }

    fn station(&mut self, station: &Station) {
        const RADIUS: f64 = 11.5;
        let Some(spot) = self.spot(&station.pose) else { return };
        let tick = ahead(&station.pose, spot, RADIUS + 7.0);
        self.canvas.line(spot, tick, Paint::stroke(theme::PAPER, 7.0));
        self.canvas.line(spot, tick, Paint::stroke(theme::GOOD, 3.4));
        self.canvas.circle(spot, RADIUS, Paint::fill(theme::PAPER).outlined(theme::GOOD, 3.0));
        Icon::Bolt.draw(self.canvas, spot, 15.0, theme::GOOD);
        self.label(spot, RADIUS + 11.0, &station.label, theme::GOOD);
    }

    /// Marks where faults took effect, beside the robot if it is drawn there.
    pub fn faults(&mut self) {
        let mut marked: Vec<Spot> = Vec::new();
        for Mark { position, label, short } in &self.scene.faults {
            let Some(spot) = self.view.spot(*position) else { continue };
            let is_near = |other: &Spot| (other.0 - spot.0).abs().max((other.1 - spot.1).abs()) < 2.0 * BADGE;
            if label.is_empty() && marked.iter().any(is_near) {
                continue;
            }
            marked.push(spot);
            self.badge(spot, Icon::Alert, [label, short]);
        }
    }

    /// Marks where properties were violated, beside the robot if it is drawn there.
    pub fn violations(&mut self) {
        for Mark { position, label, short } in &self.scene.violations {
            if let Some(spot) = self.view.spot(*position) {
                self.badge(spot, Icon::Cross, [label, short]);
            }
        }
    }

    /// Draws a red sign at a spot, or beside it if there is already a sign.
    fn badge(&mut self, spot: Spot, icon: Icon, label: [&str; 2]) {
        const SIDE: f64 = 2.0 * BADGE + 2.0;
        let beside = [22.0, 40.0].into_iter().flat_map(|far| {
            [(0.0, -1.0), (1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.8, -0.8), (0.8, 0.8), (-0.8, 0.8), (-0.8, -0.8)]
                .map(|(dx, dy)| (spot.0 + far * dx, spot.1 + far * dy))
        });
        let is_free = |at: &Spot| {
            let sign = Area::around(*at, SIDE, SIDE);
            self.placer.is_free(&sign) && !self.moving.iter().any(|area| area.overlaps(&sign))
        };
        let at = std::iter::once(spot).chain(beside).find(is_free).unwrap_or(spot);
        self.canvas.line(spot, at, Paint::stroke(theme::BAD, 1.4));
        self.canvas.circle(at, BADGE, Paint::fill(theme::BAD).outlined(theme::PAPER, 1.6));
        icon.draw(self.canvas, at, 1.5 * BADGE, theme::PAPER);
        let side = 2.0 * (BADGE + 2.0);
        self.note(Site { symbol: Area::around(at, side, side), roomy: false }, label, theme::BAD, true);
    }

    /// Draws the robot where it is and, if that visibly differs, at its estimated pose.
    pub fn robot(&mut self) {
        let scene = self.scene;
        let radius = self.view.pixels(scene.robot_radius_m).max(7.0);
        let Some(spot) = self.spot(&scene.robot) else { return };
        self.moving.push(Area::around(spot, 2.0 * radius + 6.0, 2.0 * radius + 6.0));
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
        // Less than ten degrees and four pixels of difference look like a smudge.
        let aligned = scene.robot.rotation.rotation_to(&estimate.rotation).re > 0.985;
        if aligned && (believed.0 - spot.0).abs().max((believed.1 - spot.1).abs()) < 4.0 {
            return;
        }
        let paint = Paint::stroke(theme::BELIEF, 2.2).dashed("4 3.5");
        self.canvas.path(&nose(&estimate, believed), Paint::fill(theme::BELIEF));
        self.canvas.circle(believed, radius, paint);
        let site = Site { symbol: Area::around(believed, 2.0 * radius + 12.0, 2.0 * radius + 12.0), roomy: false };
        self.note(site, ["estimate", ""], theme::BELIEF, false);
    }

    /// Draws the robot's speech in bubbles, if there is room.
    fn speeches(&mut self) {
        let Some(robot) = self.spot(&self.scene.robot) else { return };
        let radius = self.view.pixels(self.scene.robot_radius_m).max(7.0);
        let far = 0.5 * self.view.area.width;
        for speech in &self.scene.speeches {
            let site = Site { symbol: Area::around(robot, 4.0 * radius, 4.0 * radius), roomy: true };
            let placed = [(260.0, 3), (140.0, 1)].into_iter().find_map(|(room, rows)| {
                let lines = self.font.wrap(speech, room, rows);
                let width = lines.iter().map(|line| self.font.width(line)).fold(0.0, f64::max) + 18.0;
                let size = (width, lines.len() as f64 * self.font.line_height() + 12.0);
                Some((self.placer.place_free(&site, size, |_| 0.0, 0.0, far)?, lines))
            });
            let Some((bubble, lines)) = placed else { continue };
            self.placer.block(bubble);
            let paint = Paint::fill(theme::PAPER).outlined(theme::INK, 1.4);
            let (x, y) = (bubble.x + bubble.width / 2.0, bubble.y + bubble.height / 2.0);
            self.canvas.line(robot, (x, y), Paint::stroke(theme::INK, 1.4));
            self.canvas.rounded(bubble, 8.0, paint);
            for (row, line) in lines.iter().enumerate() {
                let at = (bubble.x + 9.0, bubble.y + 6.0 + (row as f64 + 0.5) * self.font.line_height());
                self.canvas.centered_text(at, line, TextStyle::new(self.font, theme::INK));
            }
        }
    }

    /// The position of a pose on the page; `None` if it is not finite.
    fn spot(&self, pose: &Pose) -> Option<Spot> {
        let heading = pose.rotation.re + pose.rotation.im;
        self.view.spot(pose.translation.vector.into()).filter(|_| heading.is_finite())
    }

    /// Notes a label for a sign of this radius. It is written at the end, when everything that it should avoid is
    /// known.
    pub fn label(&mut self, at: Spot, radius: f64, text: &str, color: Color) {
        let symbol = Area::around(at, 2.0 * radius, 2.0 * radius);
        self.note(Site { symbol, roomy: false }, [text, ""], color, true);
    }

    fn note(&mut self, site: Site, texts: [&str; 2], color: Color, stands_still: bool) {
        if stands_still && !site.roomy {
            self.placer.block(site.symbol);
        } else if !stands_still {
            self.moving.push(site.symbol);
        }
        if !texts[0].is_empty() {
            self.labels.push(Label { site, texts: texts.map(str::to_owned), color, stands_still });
        }
    }

    /// Writes the labels of everything drawn, without overlaps. In a series of pictures, the labels of immovable things
    /// come first and depend on nothing else, so they stay where they were in the previous picture.
    pub fn write_labels(&mut self) {
        let one_of_many = self.one_of_many;
        let is_still = |label: &Label| label.stands_still && one_of_many;
        let (still, moving): (Vec<Label>, Vec<Label>) =
            std::mem::take(&mut self.labels).into_iter().partition(is_still);
        still.iter().for_each(|label| _ = self.write(label));
        std::mem::take(&mut self.moving).into_iter().for_each(|area| self.placer.block(area));
        std::mem::take(&mut self.moving_lines).into_iter().for_each(|line| self.placer.avoid_line(line));
        moving.iter().for_each(|label| _ = self.write(label));
    }

    /// Writes a label, if possible near and beside walls: in its lines, or else in narrower ones, or in fewer words;
    /// otherwise farther away, or where it covers the least of a wall, or not at all. Returns where.
    fn write(&mut self, label: &Label) -> Option<Area> {
        let (font, view, map) = (self.font, self.view, &self.scene.map);
        // A place beside a wall is better than one on it, even if it is farther away; but an area keeps its label.
        let walls = |area: &Area| {
            let covered = map.covered(&area.inset(-2.0), &view);
            let inside = label.site.roomy && label.site.symbol.encloses(area);
            if covered > 0.0 && !inside { 1.2 + covered } else { 0.0 }
        };
        let shapes = [(0, 0.36, 3), (0, 0.24, 5), (0, 0.16, 7), (1, 0.36, 1)];
        let shapes = shapes.map(|(text, share, most)| font.wrap(&label.texts[text], view.area.width * share, most));
        let far = 0.5 * view.area.width;
        let attempts = [(0.0, 0.0), (0.0, far), (f64::INFINITY, far)].into_iter();
        let attempts = attempts.flat_map(|limits| shapes.iter().map(move |lines| (lines, limits)));
        let (lines, area) = attempts.into_iter().find_map(|(lines, (most, reach))| {
            let width = lines.iter().map(|line| font.width(line)).fold(0.0, f64::max);
            // Narrower lines must not cut a word.
            let is_whole = most > 0.0 || lines.iter().all(|line| !line.ends_with('…'));
            let size = (width, font.line_height() * lines.len() as f64);
            let area = (width > 0.0 && is_whole).then(|| self.placer.place_free(&label.site, size, walls, most, reach));
            Some((lines, area.flatten()?))
        })?;
        if let Some([from, to]) = label.site.leader(&area) {
            self.canvas.line(from, to, Paint::stroke(label.color, 1.2));
        }
        let style = TextStyle::new(font, label.color).anchored(Anchor::Middle).with_halo();
        for (line, text) in lines.iter().enumerate() {
            let y = area.y + (line as f64 + 0.5) * font.line_height();
            self.canvas.centered_text((area.center().0, y), text, style);
        }
        Some(area)
    }
}

/// The visible particles: those that the robot does not cover.
fn particles(scene: &Scene) -> Vec<Point> {
    let robot = Point::from(scene.robot.translation.vector);
    let is_covered = |point: &Point| (point - robot).norm() <= scene.robot_radius_m;
    scene.particles.iter().copied().filter(|point| !is_covered(point)).collect()
}

/// Whether the robot has moved so far that its trail is visible.
fn has_moved(scene: &Scene) -> bool {
    let robot = Point::from(scene.robot.translation.vector);
    scene.trail.iter().any(|point| (point - robot).norm() > scene.robot_radius_m)
}

/// The spot this many pixels ahead of a pose at `spot`.
fn ahead(pose: &Pose, spot: Spot, pixels: f64) -> Spot {
    (spot.0 + pose.rotation.re * pixels, spot.1 - pose.rotation.im * pixels)
}

/// The spots without those that are closer than `gap` pixels to the spot before; the last one is kept.
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

/// Draws a bar of a round length at the left of `foot`; returns how far right it extends.
pub(super) fn scale_bar(canvas: &mut Canvas, foot: Area, view: &View) -> f64 {
    const ROUND_M: [f64; 10] = [100.0, 50.0, 20.0, 10.0, 5.0, 2.0, 1.0, 0.5, 0.2, 0.1];
    let most = (foot.width * 0.2).min(170.0);
    let length_m = ROUND_M.into_iter().find(|&length_m| view.pixels(length_m) <= most).unwrap_or(0.1);
    let length = view.pixels(length_m).min(most);
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

/// The meaning of a sign on the map, and what draws the sign.
type LegendEntry = (&'static str, fn(&mut Canvas, Spot));

/// The signs on the map. Those that come and go are last, so that the others stay where they are.
fn signs(scene: &Scene) -> Vec<LegendEntry> {
    let entries: [(bool, LegendEntry); 8] = [
        (true, ("robot", robot_sign)),
        (!scene.laser_hits.is_empty(), ("laser hits", hits_sign)),
        (has_moved(scene), ("driven", trail_sign)),
        (!scene.bodies.is_empty(), ("not on the map", body_sign)),
        (!scene.faults.is_empty(), ("fault", fault_sign)),
        (!scene.violations.is_empty(), ("violation", violation_sign)),
        (!scene.path.is_empty(), ("planned path", path_sign)),
        (!particles(scene).is_empty(), ("particles", particles_sign)),
    ];
    entries.into_iter().filter(|(is_there, _)| *is_there).map(|(_, entry)| entry).collect()
}

fn robot_sign(canvas: &mut Canvas, (x, y): Spot) {
    canvas.circle((x, y), 7.0, Paint::fill(theme::INK));
    canvas.line((x, y), (x + 7.0, y), Paint::stroke(theme::PAPER, 1.6));
}

fn hits_sign(canvas: &mut Canvas, (x, y): Spot) {
    canvas.path(&Path::dots([(x - 9.0, y), (x, y), (x + 9.0, y)]), Paint::stroke(theme::LASER, 4.2));
}

fn trail_sign(canvas: &mut Canvas, (x, y): Spot) {
    canvas.line((x - 12.0, y), (x + 12.0, y), Paint::stroke(theme::MUTED, 2.6).dashed("0.1 6"));
}

fn body_sign(canvas: &mut Canvas, at: Spot) {
    canvas.circle(at, 7.0, Paint::fill(theme::BODY_LIGHT).outlined(theme::BODY, 1.8));
}

fn fault_sign(canvas: &mut Canvas, at: Spot) {
    badge_sign(canvas, at, Icon::Alert);
}

fn violation_sign(canvas: &mut Canvas, at: Spot) {
    badge_sign(canvas, at, Icon::Cross);
}

fn badge_sign(canvas: &mut Canvas, at: Spot, icon: Icon) {
    canvas.circle(at, BADGE, Paint::fill(theme::BAD));
    icon.draw(canvas, at, 1.5 * BADGE, theme::PAPER);
}

fn path_sign(canvas: &mut Canvas, (x, y): Spot) {
    canvas.line((x - 12.0, y), (x + 12.0, y), Paint::stroke(theme::GOOD, 3.6));
}

fn particles_sign(canvas: &mut Canvas, (x, y): Spot) {
    let dots = [(-8.0, 2.0), (-3.0, -4.0), (0.0, 3.0), (4.0, -1.0), (8.0, 3.0), (9.0, -4.0)];
    let paint = Paint::stroke(theme::BELIEF, 2.8).stroke_opacity(0.7);
    canvas.path(&Path::dots(dots.map(|(dx, dy)| (x + dx, y + dy))), paint);
}

/// Draws the legend of the signs on the map, beside the scale: in one row, or in two smaller ones.
fn legend(canvas: &mut Canvas, foot: Area, left: f64, entries: &[LegendEntry]) {
    const SIGN: f64 = 34.0;
    let left = left + 16.0;
    let room = foot.right() - left;
    let long: f64 = entries.iter().map(|(words, _)| SIGN + FONT.width(words) + 16.0).sum();
    let (font, gap, up) = if long > room + 16.0 { (Font::regular(13.0), 8.0, 9.0) } else { (FONT, 16.0, 0.0) };
    let (mut x, mut y) = (left, foot.center().1 - up);
    for &(words, sign) in entries {
        let width = SIGN + font.width(words);
        if x > left && x + width > foot.right() {
            (x, y) = (left, foot.center().1 + up);
        }
        sign(canvas, (x + SIGN / 2.0 - 3.0, y));
        canvas.centered_text((x + SIGN, y), words, TextStyle::new(font, theme::MUTED));
        x += width + gap;
    }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;
    use std::sync::Arc;

    use maps::{Cell, CellIndex, OccupancyGrid, load_map, pose};

    use super::*;
    use crate::frame::{Body, Mark, Place, Station};
    use crate::map_picture::MapPicture;
    use crate::sample::Chance;

    /// Draws random things on a map, and returns how many labels there are, how many are missing, and how many meet a
    /// wall.
    fn labeled(grid: &OccupancyGrid, (size, font_px): ((f64, f64), f64), chance: &mut Chance) -> [usize; 3] {
        let index = |offset: usize| CellIndex { column: offset % grid.width(), row: offset / grid.width() };
        let is_free = |&offset: &usize| grid.cells()[offset] == Cell::Free;
        let free: Vec<Point> =
            (0..grid.cells().len()).filter(is_free).map(|offset| grid.center(index(offset))).collect();
        let mut somewhere = || free[chance.below(free.len())];
        let at = |point: Point| pose(point.x, point.y, 0.0);
        let mut scene = Scene::new(Arc::new(MapPicture::new(grid)), at(somewhere()), 0.2);
        let point = |label: &str, at| Place { label: label.to_owned(), corners: vec![at], keep_out: false };
        let names = ["Kitchen", "Bath", "LivingRoom", "Sculptures", "Desk", "Entrance"];
        scene.places = names.into_iter().map(|name| point(name, somewhere())).collect();
        scene.start = Some(at(somewhere()));
        scene.station = Some(Station { pose: at(somewhere()), label: "charging station".to_owned() });
        scene.faults =
            vec![Mark { position: somewhere(), label: "level set to 10 %".to_owned(), short: "level".to_owned() }];
        scene.violations = vec![Mark {
            position: somewhere(),
            label: "keeps_reserve violated".to_owned(),
            short: "keeps_reserve".to_owned(),
        }];
        let shape = maps::Shape::Disc { radius_m: 0.25 };
        scene.bodies = vec![Body { shape, pose: at(somewhere()), label: "person".to_owned() }];
        let view = View::fitting(bounds(&scene), Area::new(0.0, 0.0, size.0, size.1));
        let mut canvas = Canvas::new();
        let mut drawing = MapDrawing::new(&mut canvas, view, &scene, Font::regular(font_px));
        drawing.areas();
        drawing.bodies();
        drawing.places();
        drawing.faults();
        drawing.violations();
        std::mem::take(&mut drawing.moving).into_iter().for_each(|area| drawing.placer.block(area));
        let labels = std::mem::take(&mut drawing.labels);
        let written: Vec<Option<Area>> = labels.iter().map(|label| drawing.write(label)).collect();
        let meets_wall = |area: &&Area| scene.map.covered(area, &view) > 0.0;
        let areas: Vec<Area> = written.iter().flatten().copied().collect();
        for (index, area) in areas.iter().enumerate() {
            assert!(areas[..index].iter().all(|other| !other.overlaps(&area.inset(0.5))), "{areas:?}");
        }
        [labels.len(), labels.len() - areas.len(), areas.iter().filter(meets_wall).count()]
    }

    fn all_labels(grid: &OccupancyGrid, name: &str) -> [usize; 3] {
        let mut chance = Chance::new(1);
        let mut sum = [0; 3];
        // In a picture, on a page, and on a page on a phone.
        for size in [((960.0, 740.0), 15.0), ((660.0, 500.0), 13.5), ((360.0, 360.0), 10.5)] {
            for _ in 0..20 {
                let found = labeled(grid, size, &mut chance);
                // On a phone, a room or an aisle may be narrower than a name.
                assert!(size.0.0 < 400.0 || found[2] == 0, "{name}: {found:?}");
                sum = std::array::from_fn(|index| sum[index] + found[index]);
            }
        }
        println!("{name}: {} labels, {} without room, {} on walls", sum[0], sum[1], sum[2]);
        sum
    }

    #[test]
    fn labels_find_room_beside_walls() {
        for name in ["house", "museum"] {
            let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("../../maps/{name}.yaml"));
            let grid = load_map(&path, &diagnostics::from_disk).expect("the map is shipped");
            let [labels, missing, on_walls] = all_labels(&grid, name);
            assert!(missing == 0 && on_walls * 50 <= labels, "{name}: {on_walls}");
        }
    }

    #[test]
    #[ignore = "needs maps: STEWARD_MAPS names their folder"]
    fn labels_on_maps_of_a_folder_on_demand() {
        let folder = PathBuf::from(std::env::var_os("STEWARD_MAPS").expect("STEWARD_MAPS names a folder"));
        let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        let is_map = |path: &PathBuf| path.extension().is_some_and(|extension| extension == "yaml");
        for path in files.filter(is_map) {
            let map = load_map(&path, &diagnostics::from_disk).unwrap_or_else(|error| panic!("{error}"));
            let [labels, missing, on_walls] = all_labels(&map, &path.file_stem().unwrap().display().to_string());
            assert!(missing == 0 && on_walls * 50 <= labels);
        }
    }
}
