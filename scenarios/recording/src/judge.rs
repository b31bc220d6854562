//! Records of what was recorded elsewhere, such as by a real robot: events, and the verdicts of monitors.

use std::sync::Arc;
use std::time::Duration;

use channels::{ChannelId, Event, Gap, Ground, Topology, Verdict};
use maps::Pose;
use monitors::{LogEnd, Property, ScopeMonitor};

use crate::{
    Details, Doubts, End, Ended, Happening, Header, Monitor, MonitorEnd, MonitorLog, MonitorState, Origin, RobotState,
    Scene, Step, TraceHash,
};

/// Lets monitors judge events, and makes the records of a run from them, without what is known only in a simulation.
#[derive(Debug)]
pub struct Judge {
    topology: Arc<Topology>,
    monitors: MonitorLog,
    doubts: Doubts,
    provisional: Vec<Provisional>,
    hash: TraceHash,
    end: LogEnd,
}

/// How far the violations of a property have been found, and what the last of them rests on.
#[derive(Debug, Default)]
struct Provisional {
    violations: u64,
    unless: Option<String>,
}

impl Provisional {
    /// Unless which message was lost the property is violated. It is asked again only if it may have changed.
    fn follow(&mut self, doubts: &Doubts, index: usize, property: &Property) -> Option<String> {
        let counted = property.scope_monitor().and_then(ScopeMonitor::violations).map(|violations| violations.count);
        let violations = counted.unwrap_or(u64::from(property.monitor.verdict() == Verdict::False));
        if violations > self.violations || self.unless.is_some() {
            self.unless = doubts.unless(index, property).filter(|_| doubts.why(index).is_none());
        }
        self.violations = violations;
        self.unless.clone()
    }
}

impl Judge {
    /// Starts to judge events on these channels; `name` and `about` describe their origin, `doubts` what may be missing
    /// from them. Also returns the first two records.
    #[must_use]
    pub fn begin(
        [name, about]: [String; 2],
        origin: Origin,
        topology: &Arc<Topology>,
        tick: Duration,
        properties: &[Property],
        doubts: Doubts,
    ) -> (Self, Header, Step) {
        let mut monitors = MonitorLog::new(properties.len());
        let states = properties.iter().map(|property| MonitorState::of(property.monitor.as_ref())).enumerate();
        let states = states.filter_map(|(index, state)| monitors.change(index, state)).collect();
        let start = Details { monitors: states, ..Details::default() };
        let header = Header {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            commit: crate::commit(),
            scenario: name,
            about,
            origin,
            tick,
            topology: Arc::clone(topology),
            monitors: properties.iter().map(|property| Monitor::of(property, topology)).collect(),
            ..Header::default()
        };
        let judge = Self {
            topology: Arc::clone(topology),
            monitors,
            doubts,
            provisional: properties.iter().map(|_| Provisional::default()).collect(),
            hash: TraceHash::default(),
            end: LogEnd::default(),
        };
        let start = judge.record(Duration::ZERO, Vec::new(), start);
        (judge, header, start)
    }

    /// The record of where the robot was at a time, between events, and of what it saw there, if that is known.
    #[must_use]
    pub fn place(&self, time: Duration, estimate: Pose, scene: Option<Scene>) -> Step {
        let robot = RobotState { estimate: Some(estimate), ..RobotState::default() };
        let details = Details { scene: scene.map(Arc::new), ..Details::default() };
        Step { robot, ..self.record(time, Vec::new(), details) }
    }

    /// Lets the monitors judge an event, and returns its record.
    pub fn step(&mut self, event: Event, properties: &mut [Property]) -> Step {
        self.end.count(&event);
        self.hash.event(&event, &self.topology);
        let (mut happenings, mut monitors) = (Vec::new(), Vec::new());
        properties.iter_mut().for_each(|property| property.monitor.observe(&event));
        self.doubts.observe(&event, properties);
        for (index, property) in properties.iter_mut().enumerate() {
            let mut state = MonitorState::of(property.monitor.as_ref());
            if self.doubts.why(index).is_some() || self.doubts.is_groundless(index, property) {
                (state.verdict, state.is_open) = (Verdict::Inconclusive, true);
            }
            state.unless = self.provisional[index].follow(&self.doubts, index, property);
            if state.verdict != Verdict::Inconclusive {
                happenings.extend(self.monitors.verdict(index, property.monitor.as_ref(), &event));
            }
            monitors.extend(self.monitors.change(index, state));
        }
        let time = event.time;
        self.record(time, happenings, Details { events: vec![event], monitors, ..Details::default() })
    }

    /// Messages are missing from here on: the verdicts that they could change remain open.
    pub fn miss(&mut self, gap: &Gap, properties: &mut [Property]) {
        self.doubts.miss(gap, properties);
        let unsure = self.doubts.all().enumerate().filter(|(_, why)| why.is_some());
        unsure.for_each(|(index, _)| self.monitors.withdraw(index));
    }

    /// The source vouches for the messages of this channel.
    pub fn vouch(&mut self, channel: ChannelId, ground: Ground) {
        self.doubts.vouch(channel, ground);
    }

    /// A gap in the messages of this channel is over.
    pub fn resume(&mut self, channel: ChannelId, properties: &[Property]) {
        self.doubts.resume(channel, properties);
    }

    /// What missing messages make unsure.
    #[must_use]
    pub fn doubts(&self) -> &Doubts {
        &self.doubts
    }

    /// The record of a time at which nothing happened.
    #[must_use]
    pub fn quiet(&self, time: Duration) -> Step {
        self.record(time, Vec::new(), Details::default())
    }

    /// The run ended at this time. Returns the record of that.
    pub fn end_at(&mut self, time: Duration) -> Step {
        self.end.ended = Some(time);
        self.quiet(time)
    }

    fn record(&self, time: Duration, happenings: Vec<Happening>, details: Details) -> Step {
        Step {
            time,
            ticks: self.end.ticks,
            overruns: 0,
            communications: self.end.messages,
            robot: RobotState::default(),
            happenings,
            details: Some(Box::new(details)),
        }
    }

    /// How far the events go.
    #[must_use]
    pub fn end(&self) -> LogEnd {
        self.end
    }

    /// The last record.
    #[must_use]
    pub fn finish(&self, properties: &[Property]) -> End {
        End {
            ended: Ended::Recorded,
            trace_hash: self.hash.finish(),
            monitors: properties
                .iter()
                .enumerate()
                .map(|(index, property)| {
                    MonitorEnd::of(property.monitor.as_ref(), self.doubts.evidence(index, property))
                })
                .collect(),
            skill_errors: Vec::new(),
            messages_hit: Vec::new(),
            scene: None,
        }
    }
}
