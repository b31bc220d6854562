//! The course of a run: everything on one time axis.
//!
//! A [`Timeline`] looks at a run after each step and records what has changed: the battery, the leaves of the tree, the
//! states of skills, components and monitors, navigation's status, and the robot's path. It also keeps the latest
//! events, so that each violation has the messages that led to it ([`Episode`]). Its memory is bounded by the number of
//! changes, not of steps.

mod course;
mod recent;
mod steps;
mod track;
mod trail;

use std::convert::Infallible;
use std::time::Duration;

use channels::{Event, EventKind};
use monitors::EventTime;
use recording::{Follower, Happening, Navigation, RunView};

use crate::bounds::signals;
use crate::pictures;

pub use course::Course;
pub use recent::Episode;
pub use steps::Steps;
pub use track::{Interval, Lane, Track};
pub use trail::{Stage, Trail};

use recent::Recent;

/// The state of a monitor.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MonitorState {
    /// The verdict on the property so far.
    pub verdict: drawing::Verdict,
    /// Whether something must still happen.
    pub is_open: bool,
}

/// The course of a run over time.
#[derive(Clone, Debug)]
pub struct Timeline {
    battery: Course,
    charging: Track<bool>,
    signals: Vec<Steps>,
    navigation: Track<Navigation>,
    leaves: Vec<Lane<drawing::NodeStatus>>,
    skills: Vec<Lane<String>>,
    components: Vec<Lane<String>>,
    monitors: Vec<Lane<MonitorState>>,
    trail: Trail,
    recent: Recent,
    episodes: Vec<Episode>,
    end: Duration,
}

impl Timeline {
    /// The timeline of a run that is about to begin.
    #[must_use]
    pub fn new(view: &RunView) -> Self {
        let header = view.header();
        let lanes = |names: &[String]| names.iter().map(|name| Lane::new(name)).collect();
        let leaves = header.tree.iter().filter(|node| node.is_leaf);
        let mut timeline = Self {
            battery: Course::default(),
            charging: Track::default(),
            signals: signals(header).into_iter().map(Steps::new).collect(),
            navigation: Track::default(),
            leaves: leaves.map(|leaf| Lane::new(&leaf.process)).collect(),
            skills: lanes(&header.skills),
            components: lanes(&header.components),
            monitors: header.monitors.iter().map(|monitor| Lane::new(&monitor.name)).collect(),
            trail: Trail::default(),
            recent: Recent::default(),
            episodes: Vec::new(),
            end: view.time(),
        };
        timeline.look(view);
        timeline.look_at_processes(view);
        timeline
    }

    /// Records what may change in any step.
    fn look(&mut self, view: &RunView) {
        let (now, robot) = (view.time(), view.robot());
        self.end = now;
        if let Some(battery) = robot.battery {
            self.battery.note(now, battery.charge_pct);
            self.charging.note(now, &battery.charging);
        }
        if let Some(navigation) = view.navigation() {
            self.navigation.note(now, navigation);
        }
        self.trail.note(now, view.position());
    }

    /// Records the values of signals in the messages of the last step.
    fn note_signals(&mut self, view: &RunView) {
        for event in view.events() {
            let EventKind::Received { channel, message } = &event.kind else { continue };
            for steps in self.signals.iter_mut().filter(|steps| steps.signal().channel == *channel) {
                let value = steps.signal().value(message, view.topology());
                value.into_iter().for_each(|value| steps.note(event.time, value));
            }
        }
    }

    /// Records what changes only when a message is received or a tick is generated.
    fn look_at_processes(&mut self, view: &RunView) {
        let now = view.time();
        let nodes = view.header().tree.iter().zip(view.outcomes());
        let leaves = nodes.filter(|(node, _)| node.is_leaf);
        for (lane, (_, outcome)) in self.leaves.iter_mut().zip(leaves) {
            lane.track.note(now, &pictures::node_status(*outcome));
        }
        self.trail.set_doing(now, &view.running().collect::<Vec<_>>().join(", "));
        for lane in self.skills.iter_mut().chain(&mut self.components) {
            if let Some(location) = view.location(&lane.name) {
                lane.track.note(now, &location.to_owned());
            }
        }
        for (lane, monitor) in self.monitors.iter_mut().zip(view.monitors()) {
            let (verdict, is_open) = (pictures::verdict(monitor.state, false), monitor.state.is_open);
            lane.track.note(now, &MonitorState { verdict, is_open });
        }
    }

    /// The timeline up to the moment that `view` shows.
    #[must_use]
    pub fn until(&self, view: &RunView) -> Self {
        let now = view.time();
        let mut episodes = self.episodes.clone();
        episodes.retain(|episode| episode.decided.time <= now);
        Self {
            battery: self.battery.until(now),
            charging: self.charging.until(now),
            signals: self.signals.iter().map(|steps| steps.until(now)).collect(),
            navigation: self.navigation.until(now),
            leaves: Lane::all_until(&self.leaves, now),
            skills: Lane::all_until(&self.skills, now),
            components: Lane::all_until(&self.components, now),
            monitors: Lane::all_until(&self.monitors, now),
            trail: self.trail.until(now, view.position()),
            recent: Recent::default(),
            episodes,
            end: now,
        }
    }

    /// How far the run is, or when it ended.
    #[must_use]
    pub fn end(&self) -> Duration {
        self.end
    }

    /// The battery's level, in percent; without points if there is no battery.
    #[must_use]
    pub fn battery(&self) -> &Course {
        &self.battery
    }

    /// Whether the battery is being charged.
    #[must_use]
    pub fn charging(&self) -> &Track<bool> {
        &self.charging
    }

    /// The fields of messages that properties compare with numbers, with their values.
    #[must_use]
    pub fn signals(&self) -> &[Steps] {
        &self.signals
    }

    /// What navigation is doing; nothing if there is none.
    #[must_use]
    pub fn navigation(&self) -> &Track<Navigation> {
        &self.navigation
    }

    /// The last outcome of each leaf of the tree, in document order.
    #[must_use]
    pub fn leaves(&self) -> &[Lane<drawing::NodeStatus>] {
        &self.leaves
    }

    /// The active states of each skill at the end of a step.
    #[must_use]
    pub fn skills(&self) -> &[Lane<String>] {
        &self.skills
    }

    /// The state of each component at the end of a step.
    #[must_use]
    pub fn components(&self) -> &[Lane<String>] {
        &self.components
    }

    /// The state of each monitor, in the order of the scenario's properties.
    #[must_use]
    pub fn monitors(&self) -> &[Lane<MonitorState>] {
        &self.monitors
    }

    /// The path of the robot.
    #[must_use]
    pub fn trail(&self) -> &Trail {
        &self.trail
    }

    /// Each violation with the messages that led to it, in order.
    #[must_use]
    pub fn episodes(&self) -> &[Episode] {
        &self.episodes
    }
}

impl Follower for Timeline {
    type Error = Infallible;

    fn follow(&mut self, view: &RunView) -> Result<(), Infallible> {
        let events = view.events();
        if !events.is_empty() {
            self.recent.see(events);
            self.note_signals(view);
            self.look_at_processes(view);
        }
        self.look(view);
        for happening in view.happenings() {
            if let Happening::Verdict { monitor, .. } = happening
                && let Some(decision) = view.monitor(*monitor).violation()
            {
                let EventTime { tick, time, .. } = decision.at();
                let decided = Event { tick, time, ..decision.event.clone() };
                self.episodes.push(self.recent.episode(*monitor, decided, view));
            }
        }
        // Messages that turn out to be missing take a verdict back.
        self.episodes.retain(|episode| view.monitor(episode.property).violation().is_some());
        Ok(())
    }
}

#[cfg(test)]
impl Timeline {
    /// Continues until `end`, with leaves and skills that change their state ten times a second.
    pub fn shake(&mut self, end: Duration) {
        let statuses = [drawing::NodeStatus::Success, drawing::NodeStatus::Failure, drawing::NodeStatus::Running];
        for (count, now) in (0_usize..).map(|i| (i, self.end + Duration::from_millis(100) * i as u32)) {
            if now > end {
                break;
            }
            for (shift, lane) in self.leaves.iter_mut().enumerate() {
                lane.track.note(now, &statuses[(count + shift) % 3]);
            }
            for lane in &mut self.skills {
                lane.track.note(now, &format!("state {}", count % 7));
            }
            self.trail.set_doing(now, if count % 40 < 20 { "Go" } else { "Wait" });
        }
        self.end = end;
    }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;
    use std::sync::Arc;

    use recording::{Detail, conduct};

    use super::*;
    use runs::Run;
    use scenarios::scenario::{Scenario, find};

    /// The timeline of the first experiment, together with its last moment.
    fn battery_fault() -> (RunView, Timeline) {
        let scenario = Scenario::load(&find::find("battery_fault").unwrap(), &[]).unwrap();
        let run = Run::new(Arc::new(scenario), 1, true).unwrap();
        let goes_on = |view: &RunView| {
            let over = view.time() >= Duration::from_secs(30);
            if over { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let begin = |view: &RunView| Ok::<_, scenarios::Error>(Timeline::new(view));
        let (timeline, view) = conduct(run, Detail::Full, None, begin, goes_on).unwrap();
        (view, timeline)
    }

    #[test]
    fn a_run_leaves_its_turning_points_and_no_more() {
        let (view, timeline) = battery_fault();
        assert_eq!(timeline.end(), view.time());
        let levels = timeline.battery().points().len();
        assert!((4..60).contains(&levels), "{levels} levels for a line with one step");
        let goto = timeline.leaves().iter().find(|lane| lane.name == "GotoRechargingStation").unwrap();
        let statuses: Vec<_> = goto.track.spans(timeline.end()).map(|span| *span.state).collect();
        assert_eq!(statuses, [drawing::NodeStatus::NotTicked, drawing::NodeStatus::Running]);
        let stages = timeline.trail().stages(timeline.end());
        let doings: Vec<_> = stages.iter().map(|stage| stage.doing.as_str()).collect();
        assert_eq!(doings, ["GoToDestination", "GotoRechargingStation"]);
        let way_m: f64 = stages.iter().map(Stage::distance_m).sum();
        assert!((way_m - view.robot().truth.unwrap().distance_m).abs() < 0.1, "{way_m} m");
    }

    #[test]
    fn the_messages_before_a_violation_are_kept() {
        let (view, timeline) = battery_fault();
        let [episode] = timeline.episodes() else { panic!("one violation, {} episodes", timeline.episodes().len()) };
        assert_eq!(view.monitor(episode.property).name(), "phi1");
        assert!(episode.events.contains(&episode.decided));
        assert_eq!(episode.events.first().map(|event| event.tick), Some(0));
        let EventKind::Received { message, .. } = &episode.decided.kind else { panic!("a message decides") };
        let read_pct = message.field(2).and_then(channels::Value::as_number).unwrap();
        // The level was read in the step before, and falls by 0.001 % per step.
        let fallen_pct = read_pct - episode.charge_pct.unwrap();
        assert!((fallen_pct - 0.001).abs() < 1e-9, "{fallen_pct}");
    }
}
