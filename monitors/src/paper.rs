//! The paper's two monitors, location by location as in its figure "Runtime monitors for safety and response
//! properties".

use std::sync::Arc;

use channels::{
    ChannelId, Condition, Content, GraphMonitor, Message, ProgramGraph, Relation, Term, Topology, VariableId,
    WiringError,
};

use crate::Property;

/// φ1: the level that BatteryLevel reads is never below `safe_pct` (20 in the paper).
///
/// # Errors
/// [`WiringError::MissingChannel`] if the topology lacks the channel from BatteryReader to BatteryLevel.
pub fn phi1(topology: &Topology, safe_pct: i64) -> Result<Property, WiringError> {
    let levels = channel(topology, "phi1", "BatteryReader", "BatteryLevel")?;
    let mut graph = ProgramGraph::builder("phi1");
    let [idle, get, failure] = ["idle", "get", "failure"].map(|name| graph.location(name));
    let level = graph.variable("level");
    let safe = ok(level).negated().or(level.field(2).compare(Relation::GreaterOrEqual, safe_pct));
    graph.receive(idle, levels, level, get).caption = "a level is read".to_owned();
    graph.internal(get, safe.clone(), [], idle).caption = format!("≥ {safe_pct}");
    graph.internal(get, safe.negated(), [], failure).caption = format!("< {safe_pct}");
    let graph = Arc::new(graph.initial(idle).build()?);
    Ok(Property {
        name: "phi1".to_owned(),
        formula: format!("always (BatteryReader, BatteryLevel, m[1] = <ok> implies m[2] >= {safe_pct})"),
        summary: format!("the level read is never below {safe_pct} %"),
        place: None,
        monitor: Box::new(GraphMonitor::new(graph, [failure])),
    })
}

/// The thresholds of [`phi2`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PhiTwo {
    /// At or below this level, in percent, the robot must start a trip to the charging station.
    pub low_pct: i64,
    /// θ: the deadline, in ticks.
    pub deadline_ticks: u32,
}

impl Default for PhiTwo {
    /// 30 %, as in the paper's experiments, and 10 ticks, as in its published code: the paper gives θ no value.
    fn default() -> Self {
        Self { low_pct: 30, deadline_ticks: 10 }
    }
}

/// φ2: when the level read is at most `low_pct` on the way to the destination, the command to go to the charging
/// station follows in fewer than `deadline_ticks` ticks.
///
/// As in the paper's figure, the timer starts at θ and the monitor fails on the tick that finds it at 0: one tick later
/// than `< θ` demands. It counts the ticks that the tree takes, and it remembers a `<running>` until the next answer.
///
/// # Errors
/// [`WiringError::MissingChannel`] if the topology lacks one of the channels that φ2 mentions.
pub fn phi2(topology: &Topology, PhiTwo { low_pct, deadline_ticks }: PhiTwo) -> Result<Property, WiringError> {
    let channel = |source, target| channel(topology, "phi2", source, target);
    let running = channel("Navigation", "GoToDestination")?;
    let levels = channel("BatteryReader", "BatteryLevel")?;
    let commands = channel("GotoRechargingStation", "Navigation")?;
    let ticks = channel("TickGenerator", "BT")?;

    let mut graph = ProgramGraph::builder("phi2");
    let [i, i1, c1, s, c2, t, err] = ["I", "I1", "C1", "S", "C2", "T", "Err"].map(|name| graph.location(name));
    let [level, tick] = ["level", "tick"].map(|name| graph.variable(name));
    let timer = graph.variable_with("timer", Content::Value(0.into()));
    let low = ok(level).and(level.field(2).compare(Relation::LessOrEqual, low_pct));
    let one_less = Term::Difference(Box::new(timer.term()), Box::new(1.into()));
    let start = Message::symbols(["start_navigation", "RechargingStation"]);
    // In the order of the figure, from `I` to `Err`.
    graph.receive(i, running, Message::symbols(["ok", "running"]), i1).caption = "running".to_owned();
    graph.receive(i1, levels, level, c1).caption = "level".to_owned();
    graph.internal(c1, low.clone().negated(), [], i1).caption = format!("> {low_pct}");
    graph.internal(c1, low, [], s).caption = format!("≤ {low_pct}");
    graph.internal(s, Condition::True, [(timer, i64::from(deadline_ticks).into())], c2).caption =
        "timer := θ".to_owned();
    graph.receive(c2, commands, start, i).caption = "start for the station".to_owned();
    graph.receive(c2, ticks, tick, t).caption = "tick".to_owned();
    graph.internal(t, timer.term().compare(Relation::Greater, 0), [(timer, one_less)], c2).caption =
        "timer > 0".to_owned();
    graph.internal(t, timer.term().compare(Relation::Equal, 0), [], err).caption = "timer = 0".to_owned();
    let graph = Arc::new(graph.initial(i).build()?);
    Ok(Property {
        name: "phi2".to_owned(),
        formula: format!(
            "always ((Navigation, GoToDestination, m[1] = <ok> and m[2] = <running>) and \
             (BatteryReader, BatteryLevel, m[1] = <ok> and m[2] <= {low_pct}) implies \
             time_until (GotoRechargingStation, Navigation, m[1] = <start_navigation> and \
             m[2] = <RechargingStation>) < {deadline_ticks})"
        ),
        summary: format!(
            "at {low_pct} % or less on the way, it starts for the station in fewer than {deadline_ticks} ticks"
        ),
        place: None,
        monitor: Box::new(GraphMonitor::new(graph, [err]).with_open([c2])),
    })
}

/// `m[1] = <ok>`
fn ok(message: VariableId) -> Condition {
    message.field(1).compare(Relation::Equal, channels::Symbol::new("ok"))
}

fn channel(topology: &Topology, property: &str, source: &str, target: &str) -> Result<ChannelId, WiringError> {
    topology.find_channel(source, target).ok_or_else(|| WiringError::MissingChannel {
        process: property.to_owned(),
        channel: format!("{source} → {target}"),
    })
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use channels::{Capacity, Domain, Event, EventKind, Verdict};

    use super::*;
    use crate::Outcome;

    /// The channels that the properties mention; monitors look at messages only, so the domains stay empty.
    fn topology() -> Topology {
        let mut topology = Topology::default();
        for (source, target) in [
            ("BatteryReader", "BatteryLevel"),
            ("Navigation", "GoToDestination"),
            ("GotoRechargingStation", "Navigation"),
            ("TickGenerator", "BT"),
        ] {
            let [source, target] = [source, target].map(|name| {
                topology.find_process(name).unwrap_or_else(|| topology.process(name).expect("a new process"))
            });
            topology.channel(source, target, Capacity::One, Domain::new([])).expect("a new channel");
        }
        topology
    }

    struct Watch {
        topology: Topology,
        property: Property,
    }

    impl Watch {
        fn new(build: impl FnOnce(&Topology) -> Result<Property, WiringError>) -> Self {
            let topology = topology();
            Self { property: build(&topology).expect("all channels are there"), topology }
        }

        fn see(&mut self, source: &str, target: &str, message: Message) -> String {
            let channel = self.topology.find_channel(source, target).expect("a known channel");
            let kind = EventKind::Received { channel, message };
            self.property.monitor.observe(&Event { step: 0, tick: 0, time: Duration::ZERO, kind });
            self.property.monitor.location()
        }

        fn level(&mut self, level: f64) -> String {
            self.see("BatteryReader", "BatteryLevel", Message::new([channels::Value::symbol("ok"), level.into()]))
        }

        fn tick(&mut self) -> String {
            self.see("TickGenerator", "BT", Message::new([channels::Value::symbol("tick"), 1.into()]))
        }

        fn low_on_the_way(&mut self) -> String {
            self.see("Navigation", "GoToDestination", Message::symbols(["ok", "running"]));
            self.level(30.0)
        }
    }

    #[test]
    fn phi1_fails_for_good_at_the_first_level_below_twenty() {
        let mut watch = Watch::new(|topology| phi1(topology, 20));
        assert_eq!(watch.level(20.0), "idle");
        assert_eq!(watch.level(19.999), "failure");
        assert_eq!(watch.level(90.0), "failure");
        assert_eq!(watch.property.monitor.verdict(), Verdict::False);
    }

    #[test]
    fn phi1_ignores_errors() {
        let mut watch = Watch::new(|topology| phi1(topology, 20));
        let error = Message::new([channels::Value::symbol("error"), "no sensor".into()]);
        assert_eq!(watch.see("BatteryReader", "BatteryLevel", error), "idle");
    }

    #[test]
    fn phi2_waits_for_a_low_level_on_the_way() {
        let mut watch = Watch::new(|topology| phi2(topology, PhiTwo::default()));
        assert_eq!(watch.level(12.0), "I");
        assert_eq!(watch.see("Navigation", "GoToDestination", Message::symbols(["ok", "stopped"])), "I");
        assert_eq!(watch.low_on_the_way(), "C2");
        assert_eq!(Outcome::of(watch.property.monitor.as_ref()), Outcome::Inconclusive);
        let start = |place| Message::symbols(["start_navigation", place]);
        assert_eq!(watch.see("GotoRechargingStation", "Navigation", start("Destination")), "C2");
        assert_eq!(watch.see("GotoRechargingStation", "Navigation", start("RechargingStation")), "I");
        assert_eq!(Outcome::of(watch.property.monitor.as_ref()), Outcome::Satisfied);
    }

    #[test]
    fn phi2_fails_on_the_tick_that_finds_the_timer_at_zero() {
        let mut watch = Watch::new(|topology| phi2(topology, PhiTwo { low_pct: 30, deadline_ticks: 3 }));
        assert_eq!(watch.low_on_the_way(), "C2");
        assert_eq!([watch.tick(), watch.tick(), watch.tick(), watch.tick()], ["C2", "C2", "C2", "Err"]);
        assert_eq!(Outcome::of(watch.property.monitor.as_ref()), Outcome::Violated);
    }

    #[test]
    fn a_missing_channel_is_named() {
        let error = phi1(&Topology::default(), 20).map(|_| ()).unwrap_err();
        assert!(error.to_string().contains("BatteryReader → BatteryLevel"), "{error}");
    }
}
