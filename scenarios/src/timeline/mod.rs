//! What a run was like over time: everything on one time axis.
//!
//! A [`Timeline`] looks at a run after each of its steps and writes down what has changed: the battery, the leaves of
//! the tree, where skills, components and monitors stand, navigation's status, the way the robot took. It also keeps the
//! latest events, so that for each violation there are the messages that led to it ([`Episode`]). Its memory is bounded
//! by the number of changes, not of steps.

mod course;
mod navigation;
mod recent;
mod track;
mod trail;

use std::time::Duration;

use channels::Verdict;

use crate::draw;
use crate::live::{Live, News};
use crate::pictures;

pub use course::Course;
pub use navigation::Navigation;
pub use recent::Episode;
pub use track::{Lane, Span, Track};
pub use trail::{Stage, Trail};

use recent::Recent;

/// Where a monitor stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MonitorState {
    /// What can be said of the property so far.
    pub verdict: draw::Verdict,
    /// The monitor's location.
    pub location: String,
}

/// A run over time.
#[derive(Clone, Debug)]
pub struct Timeline {
    battery: Course,
    charging: Track<bool>,
    navigation: Track<Navigation>,
    leaves: Vec<Lane<draw::NodeStatus>>,
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
    pub fn new(live: &Live) -> Self {
        let tree = &live.scenario().tree;
        let skills = live.scenario().charts.keys();
        let components = [components::BATTERY_READER, components::LOCALIZATION, components::NAVIGATION];
        let mut timeline = Self {
            battery: Course::default(),
            charging: Track::default(),
            navigation: Track::default(),
            leaves: tree.leaves().map(|leaf| Lane::new(leaf.label())).collect(),
            skills: skills.map(|name| Lane::new(name)).collect(),
            components: components.map(Lane::new).to_vec(),
            monitors: live.watched().iter().map(|watched| Lane::new(&watched.name)).collect(),
            trail: Trail::default(),
            recent: Recent::default(),
            episodes: Vec::new(),
            end: live.time(),
        };
        timeline.look(live);
        timeline.look_at_processes(live);
        timeline
    }

    /// Writes down what a step has changed. Call it after every step, with what the step brought.
    pub fn follow(&mut self, live: &Live, news: &[News]) {
        let events = live.events();
        if !events.is_empty() {
            self.recent.see(events);
            self.look_at_processes(live);
        }
        self.look(live);
        for news in news {
            if let News::Verdict(property) = news {
                self.keep_episode(live, *property);
            }
        }
    }

    /// What may change in any step.
    fn look(&mut self, live: &Live) {
        let (now, truth) = (live.time(), live.truth());
        let battery = truth.battery();
        self.end = now;
        self.battery.note(now, battery.charge_pct);
        self.charging.note(now, &battery.charging);
        self.navigation.note(now, &Navigation::of(live.software()));
        self.trail.note(now, truth.pose().translation.vector.into());
    }

    /// What only changes where a message is received or a tick is generated.
    fn look_at_processes(&mut self, live: &Live) {
        let (now, system) = (live.time(), live.system());
        let states = live.tree_states();
        let mut running = Vec::new();
        for (lane, leaf) in self.leaves.iter_mut().zip(live.scenario().tree.leaves()) {
            let status = pictures::node_status(&states[leaf.id().index()]);
            lane.track.note(now, &status);
            if status == draw::NodeStatus::Running {
                running.push(leaf.label());
            }
        }
        self.trail.set_doing(now, &running.join(", "));
        for lane in self.skills.iter_mut().chain(&mut self.components) {
            let process = system.topology().find_process(&lane.name);
            if let Some(location) = process.and_then(|process| system.location(process)) {
                lane.track.note(now, &location);
            }
        }
        for (lane, attached) in self.monitors.iter_mut().zip(system.monitors()) {
            let monitor = attached.monitor.as_ref();
            let state = MonitorState { verdict: pictures::verdict(monitor, false), location: monitor.location() };
            lane.track.note(now, &state);
        }
    }

    fn keep_episode(&mut self, live: &Live, property: usize) {
        let verdict = live.system().monitors()[property].monitor.verdict();
        let decided = &live.watched()[property].decided;
        if let (Verdict::False, Some(decided)) = (verdict, decided) {
            self.episodes.push(self.recent.episode(property, decided.clone()));
        }
    }

    /// When the run has come to, or ended.
    #[must_use]
    pub fn end(&self) -> Duration {
        self.end
    }

    /// The battery's level, in percent.
    #[must_use]
    pub fn battery(&self) -> &Course {
        &self.battery
    }

    /// Whether the battery is being charged.
    #[must_use]
    pub fn charging(&self) -> &Track<bool> {
        &self.charging
    }

    /// What navigation is doing.
    #[must_use]
    pub fn navigation(&self) -> &Track<Navigation> {
        &self.navigation
    }

    /// What each leaf of the tree answered last, in document order.
    #[must_use]
    pub fn leaves(&self) -> &[Lane<draw::NodeStatus>] {
        &self.leaves
    }

    /// Which states of each skill are active when a step is over.
    #[must_use]
    pub fn skills(&self) -> &[Lane<String>] {
        &self.skills
    }

    /// Where each component stands when a step is over.
    #[must_use]
    pub fn components(&self) -> &[Lane<String>] {
        &self.components
    }

    /// Where each monitor stands, in the order of the scenario's properties.
    #[must_use]
    pub fn monitors(&self) -> &[Lane<MonitorState>] {
        &self.monitors
    }

    /// The way that the robot took.
    #[must_use]
    pub fn trail(&self) -> &Trail {
        &self.trail
    }

    /// For each violation the messages that led to it, in the order in which they happened.
    #[must_use]
    pub fn episodes(&self) -> &[Episode] {
        &self.episodes
    }
}

#[cfg(test)]
impl Timeline {
    /// Goes on until `end` with leaves and skills that change their minds ten times a second.
    pub(crate) fn shake(&mut self, end: Duration) {
        let statuses = [draw::NodeStatus::Success, draw::NodeStatus::Failure, draw::NodeStatus::Running];
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
    use std::sync::Arc;

    use super::*;
    use crate::scenario::{Scenario, find};

    /// The timeline of the first experiment, together with its last moment.
    fn battery_fault() -> (Live, Timeline) {
        let scenario = Scenario::load(&find::find("battery_fault").unwrap(), &[]).unwrap();
        let mut live = Live::new(Arc::new(scenario), 1, true).unwrap();
        let mut timeline = Timeline::new(&live);
        while live.time() < Duration::from_secs(30) {
            let news = live.step(None).unwrap();
            timeline.follow(&live, &news);
        }
        (live, timeline)
    }

    #[test]
    fn a_run_leaves_its_turning_points_and_no_more() {
        let (live, timeline) = battery_fault();
        assert_eq!(timeline.end(), live.time());
        let levels = timeline.battery().points().len();
        assert!((4..60).contains(&levels), "{levels} levels for a line with one step");
        let goto = timeline.leaves().iter().find(|lane| lane.name == "GotoRechargingStation").unwrap();
        let statuses: Vec<_> = goto.track.spans(timeline.end()).map(|span| *span.state).collect();
        assert_eq!(statuses, [draw::NodeStatus::NotTicked, draw::NodeStatus::Running]);
        let stages = timeline.trail().stages(timeline.end());
        let doings: Vec<_> = stages.iter().map(|stage| stage.doing.as_str()).collect();
        assert_eq!(doings, ["GoToDestination", "GotoRechargingStation"]);
        let way_m: f64 = stages.iter().map(Stage::distance_m).sum();
        assert!((way_m - live.truth().distance_m()).abs() < 0.1, "{way_m} m");
    }

    #[test]
    fn the_messages_before_a_violation_are_kept() {
        let (live, timeline) = battery_fault();
        let [episode] = timeline.episodes() else { panic!("one violation, {} episodes", timeline.episodes().len()) };
        assert_eq!(live.watched()[episode.property].name, "phi1");
        assert!(episode.events.contains(&episode.decided));
        assert_eq!(episode.events.first().map(|event| event.tick), Some(0));
    }
}
