//! Finds room for the labels of a map.

use super::geometry::{Area, Spot};

/// Places labels one after another, each where it covers the least.
///
/// The placement is greedy: a label never moves again, and the first ones get the best places. Finding the best places
/// for all of them together is NP-hard, and on a map with a dozen labels the difference cannot be seen.
///
/// ```
/// use drawing::labels::{LabelPlacer, Site};
/// use drawing::Area;
///
/// let mut placer = LabelPlacer::new(Area::new(0.0, 0.0, 200.0, 100.0));
/// let site = Site { symbol: Area::around((100.0, 50.0), 20.0, 20.0), roomy: false };
/// placer.block(site.symbol);
/// let first = placer.place(&site, (60.0, 14.0));
/// let second = placer.place(&site, (60.0, 14.0));
/// assert!(!first.overlaps(&second) && !first.overlaps(&site.symbol));
/// ```
#[derive(Clone, Debug)]
pub struct LabelPlacer {
    within: Area,
    /// The symbols and labels placed so far.
    taken: Vec<Area>,
    /// Spots along lines that should stay visible.
    lines: Vec<Spot>,
    /// The lines from symbols to their labels.
    leaders: Vec<[Spot; 2]>,
}

impl LabelPlacer {
    /// A placer that keeps all labels inside `within`.
    pub fn new(within: Area) -> Self {
        Self { within, taken: Vec::new(), lines: Vec::new(), leaders: Vec::new() }
    }

    /// Keeps labels off a symbol.
    pub fn block(&mut self, area: Area) {
        self.taken.push(area);
    }

    /// Keeps labels off a line if possible.
    pub fn avoid_line(&mut self, spots: impl IntoIterator<Item = Spot>) {
        const STEP: f64 = 6.0;
        let mut previous: Option<Spot> = None;
        for spot in spots {
            let from = previous.unwrap_or(spot);
            let (dx, dy) = (spot.0 - from.0, spot.1 - from.1);
            let steps = (dx.abs().max(dy.abs()) / STEP).ceil().clamp(1.0, 400.0);
            self.lines.extend((1..=steps as usize).map(|i| {
                let part = i as f64 / steps;
                (from.0 + dx * part, from.1 + dy * part)
            }));
            previous = Some(spot);
        }
    }

    /// Whether a box lies inside the picture and overlaps nothing placed so far.
    pub fn is_free(&self, area: &Area) -> bool {
        self.within.encloses(area) && self.taken.iter().all(|taken| !taken.overlaps(area))
    }

    /// The box for a text of this width and height at `site`.
    pub fn place(&mut self, site: &Site, size: (f64, f64)) -> Area {
        let best = self.best(site, site.candidates(size), |_| 0.0, |_| true).unwrap_or(site.symbol);
        self.take(site, best);
        best
    }

    /// The same, but none if it would have to cover a symbol or another label, or contents that cost more than `most`;
    /// `cost` is the cost of covering the contents of a box (0 to 1). Where there is no such box near the site, it may
    /// be up to `reach` pixels away.
    pub fn place_free(
        &mut self,
        site: &Site,
        size: (f64, f64),
        cost: impl Fn(&Area) -> f64,
        most: f64,
        reach: f64,
    ) -> Option<Area> {
        let is_free = |area: &Area| {
            let letters = area.inset(0.5);
            self.taken.iter().all(|taken| !taken.overlaps(&letters)) && cost(area) <= most
        };
        let near = self.best(site, site.candidates(size), &cost, is_free);
        let far = || self.best(site, site.far_candidates(size, reach), &cost, is_free);
        let best = near.or_else(far)?;
        self.take(site, best);
        Some(best)
    }

    /// A label needs some room beside it, or the next one would look like its continuation.
    fn take(&mut self, site: &Site, label: Area) {
        const GAP: f64 = 6.0;
        self.leaders.extend(site.leader(&label));
        self.taken.push(Area { x: label.x - GAP, width: label.width + 2.0 * GAP, ..label });
    }

    /// The cheapest of the candidates that fit; the first ones are preferred.
    fn best(
        &self,
        site: &Site,
        candidates: Vec<Area>,
        cost: impl Fn(&Area) -> f64,
        is_fit: impl Fn(&Area) -> bool,
    ) -> Option<Area> {
        let ranks = candidates.len().max(100) as f64;
        let candidates = candidates.into_iter().map(|area| self.moved_inside(area)).enumerate();
        let priced = candidates.filter(|(_, area)| is_fit(area)).map(|(rank, area)| {
            // Inside a site or beside it: on its edge, a label would seem to belong to neither side.
            let is_astride = site.roomy && area.overlaps(&site.symbol) && !site.symbol.encloses(&area);
            let edge = if is_astride { 8.0 } else { 0.0 };
            (self.price(site, &area) + edge + 4.0 * cost(&area) + 4.0 * rank as f64 / ranks, area)
        });
        priced.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, area)| area)
    }

    fn moved_inside(&self, area: Area) -> Area {
        let within = self.within;
        let x = area.x.min(within.right() - area.width).max(within.x);
        let y = area.y.min(within.bottom() - area.height).max(within.y);
        Area { x, y, ..area }
    }

    fn price(&self, site: &Site, area: &Area) -> f64 {
        let size = (area.width * area.height).max(1.0);
        let covered: f64 = self.taken.iter().map(|taken| taken.shared_with(area) / size).sum();
        let crossed = self.lines.iter().filter(|&&spot| area.contains(spot)).count();
        // An overlap outweighs every rank in the list of candidates, and any number of lines but a tangle. Crossing a
        // line outweighs a few ranks: a label moves aside for it, but not far away.
        let collisions = if covered > 0.0 { 10.0 } else { 0.0 };
        // A line to a label that crosses a sign or a word seems to belong to it.
        let others = self.taken.iter().filter(|taken| !taken.overlaps(&site.symbol));
        let own = site.leader(area).map_or(0, |leader| others.filter(|taken| taken.is_crossed_by(leader)).count());
        let of_others = self.leaders.iter().filter(|leader| area.is_crossed_by(**leader)).count();
        collisions + 20.0 * covered + 0.25 * crossed as f64 + 2.0 * (own + of_others) as f64
    }
}

/// The owner of a label.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Site {
    /// Its box, with some room around it.
    pub symbol: Area,
    /// Whether the label may be in the box: it is an area rather than a sign.
    pub roomy: bool,
}

impl Site {
    /// The line to a label that is not beside it.
    pub fn leader(&self, label: &Area) -> Option<[Spot; 2]> {
        const FAR: f64 = 14.0;
        let (x, y) = if self.roomy { self.symbol.nearest(label.center()) } else { self.symbol.center() };
        let end = label.nearest((x, y));
        let (dx, dy) = (end.0 - x, end.1 - y);
        let far = (dx * dx + dy * dy).sqrt();
        // A sign is round, and what is longer than wide about an ellipse.
        let flat = libm::hypot(dx / self.symbol.width, dy / self.symbol.height);
        let radius = if self.roomy || flat == 0.0 { 0.0 } else { far / flat / 2.0 };
        (far > radius + FAR).then(|| [(x + dx / far * radius, y + dy / far * radius), end])
    }

    /// Boxes for a label to try, the most natural ones first.
    fn candidates(&self, (width, height): (f64, f64)) -> Vec<Area> {
        let (x, y) = self.symbol.center();
        let (half_width, half_height) = (self.symbol.width / 2.0, self.symbol.height / 2.0);
        let mut centers = Vec::new();
        if self.roomy && width <= self.symbol.width - 10.0 && height <= self.symbol.height {
            centers.extend([0.0, -0.5, 0.5].map(|part| (x, y + part * half_height)));
        }
        // In the order of preference, since each place in the list costs a little: beside the symbol, then above and
        // below it, from near to far; diagonally only after all of these.
        let around = |ring: f64| (half_width + ring + width / 2.0, half_height + ring + height / 2.0);
        for ring in [0.0, 10.0, 24.0, 42.0] {
            let (beside, above) = around(ring);
            let aligned = (width / 2.0 - half_width).max(0.0);
            let offsets = [
                (beside, 0.0),
                (-beside, 0.0),
                (0.0, -above),
                (0.0, above),
                (aligned, -above),
                (aligned, above),
                (-aligned, -above),
                (-aligned, above),
            ];
            centers.extend(offsets.map(|(dx, dy)| (x + dx, y + dy)));
        }
        for ring in [0.0, 24.0] {
            let (beside, above) = around(ring);
            let corners = [(beside, -above), (beside, above), (-beside, -above), (-beside, above)];
            centers.extend(corners.map(|(dx, dy)| (x + dx, y + dy)));
        }
        centers.into_iter().map(|center| Area::around(center, width, height)).collect()
    }

    /// Boxes for a label where there is no room near its owner, from near to far.
    fn far_candidates(&self, (width, height): (f64, f64), farthest: f64) -> Vec<Area> {
        const STEP: f64 = 12.0;
        let steps = (farthest / STEP) as i32;
        let offsets = (-steps..=steps).flat_map(|column| (-steps..=steps).map(move |row| (column, row)));
        let mut offsets: Vec<(i32, i32)> = offsets.collect();
        offsets.sort_by_key(|(column, row)| column * column + row * row);
        let (x, y) = self.symbol.center();
        let at = |(column, row)| (x + f64::from(column) * STEP, y + f64::from(row) * STEP);
        offsets.into_iter().map(|offset| Area::around(at(offset), width, height)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEIGHT: f64 = 16.8;
    const PAGE: Area = Area::new(0.0, 0.0, 400.0, 300.0);

    fn sign(x: f64, y: f64) -> Site {
        Site { symbol: Area::around((x, y), 24.0, 24.0), roomy: false }
    }

    #[test]
    fn labels_in_a_crowded_place_do_not_overlap() {
        let mut placer = LabelPlacer::new(PAGE);
        let site = sign(200.0, 150.0);
        placer.block(site.symbol);
        let placed: Vec<Area> = (0..12).map(|_| placer.place(&site, (70.0, HEIGHT))).collect();
        for (i, a) in placed.iter().enumerate() {
            assert!(!a.inset(0.01).overlaps(&site.symbol), "{a:?}");
            assert!(placed[..i].iter().all(|b| !a.overlaps(b)), "{placed:?}");
        }
    }

    #[test]
    fn a_label_at_the_edge_stays_inside() {
        let area = LabelPlacer::new(PAGE).place(&sign(399.0, 2.0), (120.0, HEIGHT));
        assert!(PAGE.encloses(&area), "{area:?}");
    }

    #[test]
    fn a_label_keeps_clear_of_a_line() {
        let mut placer = LabelPlacer::new(PAGE);
        placer.avoid_line([(200.0, 150.0), (390.0, 150.0)]);
        let area = placer.place(&sign(200.0, 150.0), (70.0, HEIGHT));
        assert!(!area.contains((230.0, 150.0)), "{area:?}");
    }

    #[test]
    fn an_area_contains_its_label_if_it_fits() {
        let site = Site { symbol: Area::new(100.0, 100.0, 100.0, 80.0), roomy: true };
        assert_eq!(LabelPlacer::new(PAGE).place(&site, (70.0, HEIGHT)).center(), (150.0, 140.0));
        let outside = LabelPlacer::new(PAGE).place(&site, (120.0, HEIGHT));
        assert!(!outside.overlaps(&site.symbol), "{outside:?}");
    }
}
