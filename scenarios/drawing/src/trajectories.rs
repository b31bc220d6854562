//! Where a robot was and where it was believed to be: trajectories on a map, and the error over time.

use std::time::Duration;

use maps::Point;

use super::canvas::{Anchor, Canvas, Paint, TextStyle};
use super::geometry::{Area, Spot};
use super::map_panel::{scale_bar, thinned};
use super::map_picture::MapPicture;
use super::panel;
use super::path::Path;
use super::text::Font;
use super::theme;
use super::time_axis::{Tick, TimeAxis};
use super::view::View;

/// Width and margin of the page, in pixels.
const WIDTH: f64 = 1600.0;
const MARGIN: f64 = 28.0;
const HEADER: f64 = 66.0;
const FOOT: f64 = 40.0;
const CHART: f64 = 170.0;
const GAP: f64 = 14.0;

const TITLE: Font = Font::bold(26.0);
const TEXT: Font = Font::regular(15.0);
const SMALL: Font = Font::regular(13.0);

/// A robot's path on a map: the true one, the estimated one, and the one according to odometry alone.
#[derive(Clone, Debug)]
pub struct Trajectories<'a> {
    /// The title.
    pub title: String,
    /// A sentence that describes the picture.
    pub caption: String,
    /// The map.
    pub map: &'a MapPicture,
    /// Where the robot was, in the `map` frame.
    pub corrected: Vec<Point>,
    /// Where it was believed to be.
    pub estimate: Vec<Point>,
    /// Where it was according to odometry.
    pub odometry: Vec<Point>,
    /// Times in seconds, ascending, and the distance between belief and truth, in meters.
    pub errors: Vec<(f64, f64)>,
}

impl Trajectories<'_> {
    /// The standalone SVG picture, 1600 pixels wide and as high as the map's shape requires.
    #[must_use]
    pub fn svg(&self) -> String {
        let bounds = self.map.bounds();
        let extent = bounds.high - bounds.low;
        let inner = WIDTH - 2.0 * MARGIN - 20.0;
        let map_height = (inner * extent.y / extent.x.max(1e-3)).clamp(360.0, 1250.0);
        let height = 2.0 * MARGIN + HEADER + map_height + 10.0 + FOOT + GAP + CHART;
        let mut canvas = Canvas::new();
        canvas.rounded(Area::new(0.0, 0.0, WIDTH, height), 0.0, Paint::fill(theme::PAGE));
        self.header(&mut canvas);
        let panel = Area::new(MARGIN, MARGIN + HEADER, WIDTH - 2.0 * MARGIN, map_height + 10.0 + FOOT);
        self.map_panel(&mut canvas, panel);
        self.error_panel(&mut canvas, Area { y: panel.bottom() + GAP, height: CHART, ..panel });
        canvas.finish(WIDTH, height)
    }

    fn header(&self, canvas: &mut Canvas) {
        let room = WIDTH - 2.0 * MARGIN;
        canvas.centered_text((MARGIN, MARGIN + 13.0), &TITLE.fit(&self.title, room), TextStyle::new(TITLE, theme::INK));
        let font = Font::regular(16.0);
        let style = TextStyle::new(font, theme::MUTED);
        canvas.centered_text((MARGIN, MARGIN + 43.0), &font.fit(&self.caption, room), style);
    }

    fn map_panel(&self, canvas: &mut Canvas, panel: Area) {
        panel::sheet(canvas, panel);
        let frame = Area::new(panel.x + 10.0, panel.y + 10.0, panel.width - 20.0, panel.height - 10.0 - FOOT);
        let view = View::fitting(self.map.bounds(), frame);
        canvas.rounded(frame, 4.0, Paint::fill(theme::UNKNOWN));
        canvas.clipped("map", frame, |canvas| {
            self.map.draw(canvas, &view);
            for line in [self.odometry_line(), self.corrected_line(), self.estimate_line()] {
                let spots = thinned(view.spots(line.points), 1.5);
                canvas.path(&Path::through(spots), line.paint);
            }
        });
        let foot = Area::new(frame.x, frame.bottom(), frame.width, FOOT);
        let left = scale_bar(canvas, foot, &view);
        self.legend(canvas, (left + 48.0, foot.center().1));
    }

    fn corrected_line(&self) -> TrajectoryLine<'_> {
        TrajectoryLine {
            points: &self.corrected,
            name: "corrected poses of the log",
            paint: Paint::stroke(theme::BUSY, 5.0),
        }
    }

    fn estimate_line(&self) -> TrajectoryLine<'_> {
        TrajectoryLine { points: &self.estimate, name: "localization", paint: Paint::stroke(theme::BELIEF, 2.0) }
    }

    fn odometry_line(&self) -> TrajectoryLine<'_> {
        let paint = Paint::stroke(theme::LINE, 1.4).dashed("6 4");
        TrajectoryLine { points: &self.odometry, name: "odometry alone", paint }
    }

    fn legend(&self, canvas: &mut Canvas, (mut x, y): Spot) {
        for line in [self.corrected_line(), self.estimate_line(), self.odometry_line()] {
            canvas.line((x, y), (x + 30.0, y), line.paint);
            canvas.centered_text((x + 40.0, y), line.name, TextStyle::new(TEXT, theme::MUTED));
            x += 40.0 + TEXT.width(line.name) + 36.0;
        }
    }

    /// Draws the error over time, on a logarithmic scale: both a centimeter and ten meters must be visible.
    fn error_panel(&self, canvas: &mut Canvas, panel: Area) {
        panel::sheet(canvas, panel);
        let title = "distance of localization from the corrected pose";
        canvas.centered_text((panel.x + 20.0, panel.y + 20.0), title, TextStyle::new(TEXT, theme::INK));
        let chart = Area::new(panel.x + 70.0, panel.y + 40.0, panel.width - 100.0, panel.height - 72.0);
        let last_s = self.errors.last().map_or(0.0, |last| last.0).max(0.0);
        let axis = TimeAxis::to_scale(Duration::from_secs_f64(last_s), chart);
        let most_m = self.errors.iter().map(|error| error.1).fold(1.0, f64::max);
        // Whole decades, so that the top of the chart has a label.
        let decades = libm::ceil(libm::log10(most_m / LEAST_M)).max(1.0);
        let height =
            |error_m: f64| chart.bottom() - chart.height * libm::log10(error_m.max(LEAST_M) / LEAST_M) / decades;
        let muted = TextStyle::new(SMALL, theme::MUTED);
        for decade in 0..=decades as i32 {
            let error_m = LEAST_M * libm::pow(10.0, f64::from(decade));
            let y = height(error_m);
            canvas.line((chart.x, y), (chart.right(), y), Paint::stroke(theme::RULE, 1.0));
            let label = format!("{error_m:.*} m", if error_m < 0.5 { (3 - decade).max(1) as usize } else { 0 });
            canvas.centered_text((chart.x - 10.0, y), &label, muted.anchored(Anchor::End));
        }
        let x = |time_s: f64| axis.x(Duration::try_from_secs_f64(time_s).unwrap_or_default());
        let spots = self.errors.iter().map(|(time_s, error_m)| (x(*time_s), height(*error_m)));
        canvas.path(&Path::through(thinned(spots, 1.0)), Paint::stroke(theme::BELIEF, 1.4));
        for Tick { x, label } in axis.ticks(90.0) {
            canvas.line((x, chart.bottom()), (x, chart.bottom() + 4.0), Paint::stroke(theme::LINE, 1.0));
            canvas.centered_text((x, chart.bottom() + 16.0), &label, muted.anchored(Anchor::Middle));
        }
    }
}

/// The smallest error that the chart distinguishes from zero, in meters.
const LEAST_M: f64 = 0.001;

/// A trajectory and its style.
struct TrajectoryLine<'a> {
    points: &'a [Point],
    name: &'static str,
    paint: Paint,
}

#[cfg(test)]
mod tests {
    use maps::pose;

    use super::super::Renderer;
    use super::*;

    #[test]
    fn a_picture_is_drawn_even_without_data_or_with_values_that_are_not_finite() {
        let map = MapPicture::new(&maps::OccupancyGrid::new(40, 20, 0.1, pose(0.0, 0.0, 0.0)));
        let line = |points: &[f64]| points.iter().map(|x| Point::new(*x, 1.0)).collect::<Vec<_>>();
        for (points, errors) in
            [(vec![], vec![]), (vec![0.5, f64::NAN, 3.0], vec![(0.0, 0.0), (1.0, 700.0), (2.0, f64::NAN)])]
        {
            let picture = Trajectories {
                title: "a <log>".to_owned(),
                caption: "two trajectories".to_owned(),
                map: &map,
                corrected: line(&points),
                estimate: line(&points),
                odometry: line(&points),
                errors,
            };
            Renderer::new().png(&picture.svg()).expect("the drawing is a valid picture");
        }
    }
}
