//! The robot's path, and what the tree was doing on it.

use std::time::Duration;

use maps::Point;

/// The trail has a point this often, in meters.
const STEP_M: f64 = 0.10;
/// What the tree does for no longer than this is not a separate stage, such as a leaf whose answer took one step.
const IN_PASSING: Duration = Duration::from_millis(250);

/// A stretch of the path on which the tree was doing one thing.
#[derive(Clone, Debug, PartialEq)]
pub struct Stage {
    /// The leaves that were running, by name; empty where none was.
    pub doing: String,
    /// When it began.
    pub from: Duration,
    /// When it ended.
    pub to: Duration,
    /// The robot's positions with their times, in the `map` frame: the first, the last, and one every few centimeters
    /// between them; empty without a robot.
    pub points: Vec<(Duration, Point)>,
}

impl Stage {
    /// The length of the path, in meters.
    #[must_use]
    pub fn distance_m(&self) -> f64 {
        self.points.windows(2).map(|pair| (pair[1].1 - pair[0].1).norm()).sum()
    }
}

/// The path of a robot, in stages.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trail {
    stages: Vec<Stage>,
    here: Option<(Duration, Point)>,
}

impl Trail {
    /// Notes where the robot is now, if there is one.
    pub(super) fn note(&mut self, now: Duration, here: Option<Point>) {
        self.here = here.map(|here| (now, here));
        match self.stages.last_mut().map(|stage| &mut stage.points) {
            None => {
                let points = self.here.into_iter().collect();
                self.stages.push(Stage { doing: String::new(), from: now, to: now, points });
            }
            Some(points) => {
                let is_new = |(_, here): &(Duration, Point)| {
                    points.last().is_none_or(|(_, last)| (last - here).norm() >= STEP_M)
                };
                let here = self.here.filter(is_new);
                points.extend(here);
            }
        }
    }

    /// Notes what the tree is doing now.
    pub(super) fn set_doing(&mut self, now: Duration, doing: &str) {
        let Some(last) = self.stages.last_mut().filter(|stage| stage.doing != doing) else { return };
        last.to = now;
        last.points.extend(self.here);
        let points = self.here.into_iter().collect();
        self.stages.push(Stage { doing: doing.to_owned(), from: now, to: now, points });
    }

    /// The path up to a time at which the robot was `here`.
    pub(super) fn until(&self, time: Duration, here: Option<Point>) -> Self {
        let stages = self.stages.iter().filter(|stage| stage.from <= time).cloned();
        let cut = |mut stage: Stage| {
            stage.points.retain(|(at, _)| *at <= time);
            stage
        };
        Self { stages: stages.map(cut).collect(), here: here.map(|here| (time, here)) }
    }

    /// The stages of a run up to `end`. Very short activities belong to the stage before.
    #[must_use]
    pub fn stages(&self, end: Duration) -> Vec<Stage> {
        let mut stages: Vec<Stage> = Vec::new();
        for (index, stage) in self.stages.iter().enumerate() {
            let mut stage = stage.clone();
            if index + 1 == self.stages.len() {
                stage.to = end;
                stage.points.extend(self.here);
            }
            let in_passing = |stage: &Stage| stage.to - stage.from <= IN_PASSING;
            match stages.last_mut() {
                Some(before) if before.doing == stage.doing || in_passing(&stage) => {
                    before.to = stage.to;
                    before.points.extend(stage.points);
                }
                Some(before) if index == 1 && in_passing(before) => {
                    before.doing = stage.doing;
                    before.to = stage.to;
                    before.points.extend(stage.points);
                }
                _ => stages.push(stage),
            }
        }
        stages
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(time_ms: u64) -> Duration {
        Duration::from_millis(time_ms)
    }

    #[test]
    fn equal_stages_join_and_short_activities_are_no_stages() {
        let mut trail = Trail::default();
        for step in 0..500_u64 {
            let doing = match step {
                0..100 => "Go",
                100 => "Ask",
                101..200 => "Go",
                _ => "Wait",
            };
            trail.note(at(step * 20), Some(Point::new(step.min(200) as f64 * 0.01, 0.0)));
            trail.set_doing(at(step * 20), doing);
        }
        let stages = trail.stages(at(10_000));
        let found: Vec<_> = stages.iter().map(|stage| (stage.doing.as_str(), stage.from, stage.to)).collect();
        assert_eq!(found, [("Go", at(0), at(4000)), ("Wait", at(4000), at(10_000))]);
        assert!((stages[0].distance_m() - 2.0).abs() < 1e-9);
        assert!(stages[1].distance_m() < 0.02);
    }
}
