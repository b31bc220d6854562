//! A path, and the robot's progress along it.

use maps::Point;

/// How far ahead of the last projection the next one is searched for, in meters: enough for a robot that was pushed,
/// too little to jump to a later part of the path that happens to be near.
const SEARCH_M: f64 = 1.0;

/// A path of at least two points with the robot's position on it.
#[derive(Clone, Debug)]
pub(crate) struct Route {
    points: Vec<Point>,
    /// From each point to the end, in meters.
    to_end_m: Vec<f64>,
    /// The segment that the robot is on, and its position along it, from 0 to 1.
    segment: usize,
    along: f64,
}

impl Route {
    /// # Panics
    /// If there are fewer than two points.
    pub(crate) fn new(points: Vec<Point>) -> Self {
        assert!(points.len() >= 2, "a route has a start and an end");
        let mut to_end_m = vec![0.0; points.len()];
        for index in (0..points.len() - 1).rev() {
            to_end_m[index] = to_end_m[index + 1] + (points[index + 1] - points[index]).norm();
        }
        Self { points, to_end_m, segment: 0, along: 0.0 }
    }

    pub(crate) fn points(&self) -> &[Point] {
        &self.points
    }

    pub(crate) fn end(&self) -> Point {
        self.points[self.points.len() - 1]
    }

    /// Advances to the position nearest to the robot and returns the distance to the robot, in meters.
    pub(crate) fn advance(&mut self, at: &Point) -> f64 {
        let farthest = self.to_end_m[self.segment] - SEARCH_M;
        let mut best = (f64::INFINITY, self.segment, self.along);
        for segment in self.segment..self.points.len() - 1 {
            if segment > self.segment && self.to_end_m[segment] < farthest {
                break;
            }
            let (from, to) = (self.points[segment], self.points[segment + 1]);
            let length_squared = (to - from).norm_squared();
            let along = if length_squared > 0.0 { (at - from).dot(&(to - from)) / length_squared } else { 0.0 };
            let least = if segment == self.segment { self.along } else { 0.0 };
            let along = along.clamp(least, 1.0);
            let distance_m = (at - (from + (to - from) * along)).norm();
            if distance_m < best.0 {
                best = (distance_m, segment, along);
            }
        }
        (self.segment, self.along) = (best.1, best.2);
        best.0
    }

    /// The remaining distance, in meters.
    pub(crate) fn remaining_m(&self) -> f64 {
        let (from, to) = (self.to_end_m[self.segment], self.to_end_m[self.segment + 1]);
        from + (to - from) * self.along
    }

    /// The point at this distance ahead along the path, or the end.
    pub(crate) fn ahead(&self, way_m: f64) -> Point {
        let left_m = self.remaining_m() - way_m;
        if left_m <= 0.0 {
            return self.end();
        }
        let beyond = self.to_end_m[self.segment..].partition_point(|to_end_m| *to_end_m > left_m);
        let to = (self.segment + beyond).min(self.points.len() - 1);
        let length_m = self.to_end_m[to - 1] - self.to_end_m[to];
        let back = if length_m > 0.0 { (left_m - self.to_end_m[to]) / length_m } else { 0.0 };
        self.points[to] + (self.points[to - 1] - self.points[to]) * back
    }

    /// The points of the path ahead up to this distance, each with its distance from here, in meters.
    pub(crate) fn points_ahead(&self, way_m: f64) -> impl Iterator<Item = (f64, Point)> {
        let remaining_m = self.remaining_m();
        let ahead = self.points.iter().zip(&self.to_end_m).skip(self.segment + 1);
        ahead.map(move |(point, to_end_m)| (remaining_m - to_end_m, *point)).take_while(move |(way, _)| *way <= way_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner() -> Route {
        Route::new([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)].map(|(x, y)| Point::new(x, y)).to_vec())
    }

    #[test]
    fn progress_is_tracked_around_the_corner() {
        let mut route = corner();
        assert!((route.remaining_m() - 2.0).abs() < 1e-12);
        assert!((route.advance(&Point::new(0.4, 0.1)) - 0.1).abs() < 1e-12);
        assert!((route.remaining_m() - 1.6).abs() < 1e-12);
        assert!((route.ahead(0.8) - Point::new(1.0, 0.2)).norm() < 1e-12);
        assert_eq!(route.ahead(5.0), route.end());
        route.advance(&Point::new(1.1, 0.7));
        assert!((route.remaining_m() - 0.3).abs() < 1e-12);
        route.advance(&Point::new(0.2, 0.0));
        assert!(route.remaining_m() < 0.3 + 1e-9, "never back");
    }

    #[test]
    fn points_ahead_come_with_their_distance() {
        let mut route = corner();
        route.advance(&Point::new(0.4, 0.0));
        let ahead: Vec<f64> = route.points_ahead(1.0).map(|(way_m, _)| way_m).collect();
        assert!(ahead.len() == 1 && (ahead[0] - 0.6).abs() < 1e-12, "{ahead:?}");
    }
}
