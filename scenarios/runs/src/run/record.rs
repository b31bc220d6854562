//! The records of a run.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use channels::{Event, Monitor, ProcessId};
use maps::{Place, Places};
use monitors::EventTime;
use programs::ProgramProcess;
use recording::{
    Decision, Detail, Details, End, Ended, EntryValue, Evidence, Happening, Header, MonitorEnd, MonitorState,
    Navigation, RobotBody, Scene, Step,
};
use robot::RobotModel;
use scenarios::scenario::schedule::DriverData;
use scenarios::scenario::{Behavior, MachineMonitor, Premises, Runs, Scenario, TreeForm};

use super::{Judged, Run};
use crate::world::SimulatedRobot;
use crate::{end_is_final, machines};

impl Run {
    /// The constant data of the run.
    #[must_use]
    pub fn header(&self) -> Header {
        let Scenario { name, file, origin, premises, .. } = &*self.scenario;
        // A schedule has no map.
        let premises = premises.as_ref().filter(|_| !self.kind.has_schedule());
        let is_model = matches!(self.scenario.behavior, Behavior::Model(_));
        Header {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            commit: recording::commit(),
            scenario: name.clone(),
            about: file.about.clone(),
            origin: origin.clone(),
            settings: file.settings.clone(),
            seed: self.seed,
            tick: file.execution.tick,
            dt: if is_model { Duration::ZERO } else { file.execution.step() },
            unwatched: self.recorded.monitors.is_empty() && !file.properties.is_empty(),
            topology: Arc::clone(self.system.topology()),
            tree: self.scenario.tree().into_iter().flat_map(|tree| tree.nodes()).map(recording::Node::from).collect(),
            tree_xml: self.told_tree().map(|tree| tree.to_instance_xml()),
            blackboards: self.scenario.tree().map_or_else(Vec::new, |tree| tree.blackboard_names()),
            skills: self.scenario.skills.keys().cloned().collect(),
            components: self.scenario.component_names().map(str::to_owned).collect(),
            remote: self.scenario.remote_components().map(|(name, _)| name.to_owned()).collect(),
            is_piloted: self.partnership.has_controller(),
            machines: self
                .scenario
                .machine_processes()
                .map(|(name, skill)| machines::record(name, &skill.machine))
                .collect(),
            monitors: self.monitors.records(),
            faults: file.faults.iter().map(|fault| Arc::new(fault.record())).collect(),
            premises: premises.map(premises_record),
            robot: premises.map(|premises| robot_record(&premises.entry.sim.model)),
            snapshots: file.snapshots.clone(),
            expected: self.scenario.expected(),
        }
    }

    /// The record of the last step, or of the initial state, with the given detail. Call it once before the first step
    /// and once after each.
    pub fn record(&mut self, detail: Detail) -> Step {
        // A verdict that has become unsure shows only in the state of its monitor.
        let detail = if self.monitors.judged.is_some() { detail.max(Detail::Full) } else { detail };
        if detail > Detail::Verdicts {
            self.kind.refine();
        }
        if let Some(ids) = self.ids.tree.filter(|_| detail > Detail::Verdicts && self.time().is_zero()) {
            bt::note_transitions_in(&mut self.system, ids.tree);
        }
        let mut robot = self.world.robot.as_ref().map(SimulatedRobot::state).unwrap_or_default();
        if self.kind.has_schedule() {
            let known = DriverData::of(&self.system).battery;
            robot.battery = known.map(|(charge_pct, charging)| recording::Battery { charge_pct, charging });
        }
        let (time, happenings) = (self.time(), std::mem::take(&mut self.trace.happenings));
        let is_start = time.is_zero();
        let wants_scene = match detail {
            Detail::Verdicts => false,
            // The clock advances even if a scene is recorded anyway.
            Detail::Full => (!is_start && self.scene_clock.is_any(time, robot.is_charging())) || !happenings.is_empty(),
            Detail::Scenes => true,
        };
        let details = (detail > Detail::Verdicts || is_start).then(|| self.details(wants_scene));
        self.recorded.scene = wants_scene;
        let changes = robot.since(&self.recorded.robot);
        self.recorded.robot = robot;
        Step {
            time,
            ticks: self.system.ticks(),
            overruns: self.overruns,
            communications: self.system.steps(),
            robot: changes,
            happenings,
            details: details.filter(|details| !details.is_empty()).map(Box::new),
        }
    }

    /// The changes since the last record.
    fn details(&mut self, with_scene: bool) -> Details {
        let mut details = Details {
            events: self.trace.events.clone(),
            navigation: self.new_navigation(),
            scene: if with_scene { self.scene() } else { None },
            ..Details::default()
        };
        let is_start = self.time().is_zero();
        // Messages, timers and faults move any process. The world also moves devices and the robot's own components.
        let is_received = |event: &Event| !event.is_shown(self.system.topology());
        let stirs = is_start || self.trace.stirred || self.trace.events.iter().any(is_received);
        let drives = details.navigation.is_some();
        let scenario = Arc::clone(&self.scenario);
        let components = &scenario.components;
        if stirs {
            details.before_ticks = self.new_outcomes_before_ticks();
            details.outcomes = self.new_outcomes();
            details.transitions = self.new_transitions();
            details.entries = self.new_entries();
        }
        let is_device =
            |name: &str| components.get(name).is_some_and(|component| matches!(component.runs, Runs::Device(_)));
        let moves = |name: &str| stirs || is_device(name) || drives && !components.contains_key(name);
        details.locations = self.new_locations(moves);
        details.monitors = self.monitors.judged.as_mut().map_or_else(Vec::new, Judged::take_states);
        // Monitors move only when a message is received or shown, or a tick is generated.
        if is_start || !self.trace.events.is_empty() {
            for (index, attached) in self.system.monitors().iter().enumerate() {
                let state = MonitorState::of(attached.monitor.as_ref());
                details.monitors.extend(self.recorded.monitors.change(index, state));
            }
        }
        details
    }

    fn new_outcomes(&mut self) -> Vec<(usize, Option<bt::Outcome>)> {
        let Some((tree, ids)) = self.scenario.tree().zip(self.ids.tree) else { return Vec::new() };
        let states = bt::states_in(tree, &self.system, ids.tree);
        self.recorded.new_outcomes(states.into_iter().map(|state| state.outcome))
    }

    /// For each tick of the step, the outcomes that had changed before it.
    fn new_outcomes_before_ticks(&mut self) -> Vec<Vec<(usize, Option<bt::Outcome>)>> {
        let before_ticks = self.tree_watch.take_before_ticks();
        before_ticks.into_iter().map(|outcomes| self.recorded.new_outcomes(outcomes.into_iter())).collect()
    }

    /// The tree, if it reports how the statuses of its nodes change.
    fn told_tree(&self) -> Option<&Arc<bt::Tree>> {
        self.scenario.tree().filter(|_| self.scenario.file.execution.tree == TreeForm::Whole)
    }

    fn new_transitions(&mut self) -> Vec<(usize, Option<bt::Status>)> {
        let Some(ids) = self.ids.tree else { return Vec::new() };
        let transitions = bt::take_transitions_in(&mut self.system, ids.tree);
        transitions.iter().map(|transition| (transition.node.index(), transition.status)).collect()
    }

    fn new_entries(&mut self) -> Vec<(usize, String, Option<EntryValue>)> {
        let Some(board) = self.ids.tree.and_then(|ids| bt::blackboard_in(&self.system, ids.tree)) else {
            return Vec::new();
        };
        let entries = board.entries().map(|(place, key, value)| ((place, key.to_owned()), value.clone()));
        let entries: BTreeMap<(usize, String), bt::Value> = entries.collect();
        let before = std::mem::replace(&mut self.recorded.entries, entries);
        let entries = &self.recorded.entries;
        let new = entries.iter().filter(|(at, value)| before.get(at) != Some(value));
        let new = new.map(|((place, key), value)| (*place, key.clone(), Some(EntryValue::from(value))));
        let gone = before.keys().filter(|at| !entries.contains_key(at));
        new.chain(gone.map(|(place, key)| (*place, key.clone(), None))).collect()
    }

    /// The locations that have changed, among those of the skills and components that may have moved.
    fn new_locations(&mut self, may_have_moved: impl Fn(&str) -> bool) -> Vec<(usize, String)> {
        let Self { scenario, system, recorded, .. } = self;
        let names = scenario.skills.keys().map(String::as_str).chain(scenario.component_names());
        let mut new = Vec::new();
        for (name, recorded) in names.zip(&mut recorded.locations).filter(|(name, _)| may_have_moved(name)) {
            let Some(process) = system.topology().find_process(name) else { continue };
            let Some(location) = system.location(process) else { continue };
            if recorded.as_ref() != Some(&location) {
                new.push((process.index(), location.clone()));
                *recorded = Some(location);
            }
        }
        new
    }

    fn new_navigation(&mut self) -> Option<Navigation> {
        let new = self.world.robot.as_ref()?.new_navigation(self.recorded.navigation.as_ref())?;
        self.recorded.navigation = Some(new.clone());
        Some(new)
    }

    fn scene(&self) -> Option<Arc<Scene>> {
        self.world.scene().map(Arc::new)
    }

    /// What a run that ends like this decides: the properties that its end violates, with the reasons.
    pub(crate) fn verdicts_of_the_end(&self, ended: &Ended) -> Vec<Happening> {
        let violated = self.violated_by_the_end(ended).into_iter();
        violated.map(|(monitor, decision)| Happening::Verdict { monitor, decision }).collect()
    }

    fn violated_by_the_end(&self, ended: &Ended) -> Vec<(usize, Decision)> {
        let Some(monitoring) = self.monitors.monitoring.as_ref().filter(|_| end_is_final::is_the_end(ended)) else {
            return Vec::new();
        };
        let final_for = &self.scenario.file.stop.final_for;
        let tick = self.system.ticks().saturating_sub(1);
        let at = EventTime { step: self.system.steps(), tick, time: self.time() };
        let about = monitoring.records();
        let is_final = |index: usize, evidence: &Evidence| final_for.has(&about[index].name) && evidence.has_verdict();
        let monitors = self.monitors.evidence(&self.system).into_iter().enumerate();
        let watched = monitors.filter(|(index, (_, known))| is_final(*index, known));
        let violated = watched.filter_map(|(index, (monitor, _))| {
            Some((index, end_is_final::violation(monitor, &about[index].property, at)?))
        });
        violated.collect()
    }

    /// Ends the run, and with it the programs of its components and the goals of nodes. Returns the end record with the
    /// given detail.
    #[must_use]
    pub fn end(&mut self, ended: Ended, detail: Detail) -> End {
        let processes: Vec<ProcessId> = self.system.topology().processes().collect();
        for id in processes {
            if let Some(program) = self.system.process_mut::<ProgramProcess>(id) {
                program.conclude();
            }
        }
        self.partnership.leave(&mut self.system);
        self.skill_errors.note(&self.system, self.time());
        let violated = self.violated_by_the_end(&ended);
        let monitors = self.monitors.evidence(&self.system).into_iter().enumerate();
        let monitors = monitors.map(|(index, (monitor, evidence))| {
            let end = monitor_end(monitor, evidence);
            if violated.iter().any(|(at, _)| *at == index) { end_is_final::violated(end) } else { end }
        });
        // Faults that were added since the last step are not part of the run.
        let faults = 0..self.scenario.file.faults.len() - self.injector.added.len();
        End {
            ended,
            trace_hash: self.trace.hash.finish(),
            monitors: monitors.collect(),
            skill_errors: self.skill_errors.all(&self.system),
            messages_hit: faults.map(|fault| self.injector.messages_hit(fault, &self.system)).collect(),
            scene: if detail > Detail::Verdicts && !self.recorded.scene { self.scene() } else { None },
        }
    }
}

fn monitor_end(monitor: &dyn Monitor, evidence: Evidence) -> MonitorEnd {
    let errors = MachineMonitor::of(monitor).map_or_else(Vec::new, |machine| machine.errors().to_vec());
    MonitorEnd { errors, ..MonitorEnd::of(monitor, evidence) }
}

fn premises_record(Premises { entry, map, places, start, station, .. }: &Premises) -> recording::Premises {
    recording::Premises {
        map: Arc::clone(map),
        places: places.iter().map(|place| place_record(place, places)).collect(),
        start: *start,
        station: *station,
        destination: entry.sites.destination.as_ref().map(|name| name.value.clone()),
    }
}

fn robot_record(model: &RobotModel) -> RobotBody {
    RobotBody { radius_m: model.radius_m, lasers: model.lasers.clone() }
}

fn place_record((name, place): (&str, &Place), places: &Places) -> recording::Place {
    let zone = places.zones().iter().find(|zone| zone.name == name);
    let (corners, tolerance_m) = match place {
        Place::Area { corners } => (corners.clone(), 0.0),
        Place::Point { position_tolerance_m, .. } => (vec![place.goal_position()], *position_tolerance_m),
    };
    recording::Place {
        name: name.to_owned(),
        corners,
        tolerance_m,
        keep_out: zone.is_some_and(|zone| zone.keep_out),
        speed_mps: zone.and_then(|zone| zone.speed_mps),
    }
}
