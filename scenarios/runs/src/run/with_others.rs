//! A run in which others take part, in other programs.

use std::sync::Arc;
use std::time::Duration;

use channels::{ChannelId, ChannelSystem};
use recording::Happening;
use remote::{Call, Loss, RemoteClients, RemoteProcess};
use scenarios::Error;
use scenarios::scenario::Scenario;

use super::{Run, RunKind};
use crate::others::Others;
use crate::outside::Delivery;
use crate::pilot::Orders;
use crate::wiring::start_programs;

/// A run with others.
impl Run {
    /// The scenario at its start, as [`new`](Self::new) makes it, with others: in their time, and not the same every
    /// time. If somebody drives the robot, the tree gets no ticks; they still come, for the monitors.
    ///
    /// # Errors
    /// [`Error::BadInput`] if the scenario's parts do not fit together, or if it is no run for these others.
    pub fn among(scenario: Arc<Scenario>, seed: u64, watch: bool, others: Others) -> Result<Self, Error> {
        let mut run = match &others {
            Others::Nobody => return Self::new(scenario, seed, watch),
            Others::Pilot(pilot) => {
                let offered = if pilot.serves() { scenario.offered().offered } else { Arc::default() };
                let mut run = Self::offering(scenario, seed, watch, &offered)?;
                run.hand_over()?;
                run
            }
            Others::Components(outside) => Self::beside(scenario, seed, watch, outside.run())?,
        };
        run.others = others;
        Ok(run)
    }

    /// A run beside the nodes of ROS 2 that are components of it, which know it by a number.
    fn beside(scenario: Arc<Scenario>, seed: u64, watch: bool, number: u64) -> Result<Self, Error> {
        let mut run = Self::prepare(scenario, seed, watch)?;
        if !matches!(run.kind, RunKind::Application) {
            let help = "run its application instead";
            return Err(Error::refused("a schedule has no time in which nodes could answer", help));
        }
        start_programs(&run.scenario, &mut run.system)?;
        for id in &run.remote {
            run.system.process_mut::<RemoteProcess>(*id).expect("it is one").begin(number);
        }
        Ok(run)
    }

    /// Takes the robot from the tree.
    fn hand_over(&mut self) -> Result<(), Error> {
        if self.world.robot().is_none() {
            let message = format!("the scenario {} has no robot that somebody could drive", self.scenario.name);
            return Err(Error::refused(message, "name one with a map, and without a schedule"));
        }
        self.ids.tree.iter().for_each(|ids| self.system.suspend(ids.tick_generator, true));
        Ok(())
    }

    /// Lets somebody else drive the robot, and the components that are nodes of ROS 2 say what has come; one that hangs
    /// hears it later. Returns what else has happened there, in words; none while it is not yet known.
    pub(super) fn follow_others(&mut self, now: Duration) -> Option<Vec<String>> {
        if let Some(pilot) = self.others.pilot() {
            let Orders { calls, mut happened, .. } = self.world.obey(pilot, &self.said, &mut self.system)?;
            self.said.clear();
            if let Some(clients) = self.ids.clients.and_then(|id| self.system.process_mut::<RemoteClients>(id)) {
                calls.iter().for_each(|call| clients.hear(call));
                self.stirred |= !calls.is_empty();
                happened.extend(clients.take_notes());
            }
            return Some(happened);
        }
        let Some(outside) = self.others.outside() else { return Some(Vec::new()) };
        let Delivery { answers, losses, resumed, happened } = outside.hear(now)?;
        self.end_gaps();
        losses.iter().for_each(|loss| self.begin_gaps(loss));
        resumed.iter().for_each(|lost| self.losses.end(lost));
        let Self { remote, system, .. } = self;
        for id in remote {
            let is_suspended = system.is_suspended(*id);
            let Some(component) = system.process_mut::<RemoteProcess>(*id) else { continue };
            answers.iter().for_each(|answer| component.hear(answer));
            self.stirred |= !is_suspended && component.act();
        }
        Some(happened)
    }

    /// A loss leaves gaps in channels, from here on.
    fn begin_gaps(&mut self, loss: &Loss) {
        for id in &self.remote {
            let channels = self.system.process::<RemoteProcess>(*id).map(|component| component.channels_of(&loss.what));
            for gap in self.losses.begin(loss, &channels.unwrap_or_default()) {
                self.judged.iter_mut().for_each(|judged| judged.miss(&gap));
                self.happenings.push(Happening::Lost(gap));
            }
        }
    }

    /// Ends the gaps that were over before this step.
    fn end_gaps(&mut self) {
        let Self { losses, judged, system, happenings, .. } = self;
        for channel in losses.take_over(|channel| is_empty(channel, system)) {
            judged.iter_mut().for_each(|judged| judged.resume(channel));
            happenings.push(Happening::Resumed(channel));
        }
    }

    /// Sends out what the components that are nodes of ROS 2 were asked in this step, and keeps what other components
    /// have said to such nodes.
    pub(super) fn ask_outside(&mut self) {
        let Self { others, remote, system, ids, said, .. } = self;
        if let Some(clients) = ids.clients.and_then(|id| system.process_mut::<RemoteClients>(id)) {
            said.extend(clients.take_said());
        }
        let Some(outside) = others.outside() else { return };
        let calls = remote.iter().filter_map(|id| Some(system.process_mut::<RemoteProcess>(*id)?.take_calls()));
        let calls: Vec<Call> = calls.flatten().collect();
        if !calls.is_empty() {
            outside.ask(calls);
        }
    }

    /// Whether somebody else drives the robot.
    pub(super) fn is_piloted(&self) -> bool {
        matches!(self.others, Others::Pilot(_))
    }

    /// Whether a step has begun that waits for others.
    pub(crate) fn is_waiting(&self) -> bool {
        self.is_waiting
    }

    /// Time has stood still since the last step, or since it last waited for others.
    pub(crate) fn resume(&mut self) {
        self.others.resume();
    }

    /// Cancels what nodes of ROS 2 are still doing for this run, ends what they are waiting for, and leaves them.
    pub(super) fn leave_others(&mut self) {
        if let Some(clients) = self.ids.clients.and_then(|id| self.system.process_mut::<RemoteClients>(id)) {
            clients.conclude();
        }
        for id in &self.remote {
            self.system.process_mut::<RemoteProcess>(*id).into_iter().for_each(RemoteProcess::conclude);
        }
        self.ask_outside();
        self.others.leave(&self.said);
    }
}

/// Whether nothing that has come from nodes of ROS 2 waits for a channel.
fn is_empty(channel: ChannelId, system: &ChannelSystem) -> bool {
    let (source, target) = (system.topology().get(channel).source, system.topology().get(channel).target);
    let has_passed_on_all = system.process(source).is_some_and(RemoteProcess::has_passed_on_all);
    let is_free = system.content(channel).is_none() && !system.is_disturbed(channel);
    has_passed_on_all && is_free && !system.is_suspended(source) && !system.is_suspended(target)
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::rc::Rc;

    use remote::FromNode;
    use ros_messages::CdrWriter;
    use scenarios::processes::ROS;
    use scenarios::scenario::find;

    use super::*;
    use crate::pilot::{Pilot, Sensed};

    /// Lets the robot stand, and carries requests at their times, in seconds.
    #[derive(Default)]
    struct Carrier {
        calls: Vec<(f64, Call)>,
        /// With the times, in seconds.
        said: Rc<RefCell<Vec<(f64, FromNode)>>>,
        doors: Rc<RefCell<Vec<f64>>>,
    }

    impl Pilot for Carrier {
        fn drive(&mut self, sensed: &Sensed<'_>) -> Option<Orders> {
            let now_s = sensed.now.as_secs_f64();
            self.said.borrow_mut().extend(sensed.said.iter().map(|said| (now_s, said.clone())));
            self.doors.borrow_mut().extend(sensed.doors.iter().map(|(_, place)| *place));
            let calls = self.calls.extract_if(.., |(at_s, _)| *at_s <= now_s).map(|(_, call)| call).collect();
            Some(Orders { velocity: Some(Default::default()), calls, ..Orders::default() })
        }

        fn serves(&self) -> bool {
            true
        }

        fn leave(&mut self, said: &[FromNode]) {
            self.said.borrow_mut().extend(said.iter().map(|said| (f64::INFINITY, said.clone())));
        }
    }

    fn call(number: u64, service: &str, write: impl FnOnce(&mut CdrWriter)) -> Call {
        let mut body = CdrWriter::reusing(Vec::new());
        write(&mut body);
        Call { service: service.to_owned(), kind: String::new(), number, body: body.bytes() }
    }

    fn nothing(body: &mut CdrWriter) {
        body.number([0]);
    }

    /// A run of a scenario for some seconds, in which this is asked. Returns what was said, in words with the times in
    /// seconds, how far doors were open, and what happened.
    fn ran(name: &str, faults: &str, seconds: u64, calls: Vec<(f64, Call)>) -> (Vec<String>, Vec<f64>, Vec<String>) {
        let set = [format!("faults=[{faults}]"), "stop={}".to_owned()];
        let scenario = Arc::new(Scenario::load(&find::find(name).expect("shipped"), &set).expect("sound"));
        let carrier = Carrier { calls, ..Carrier::default() };
        let (said, doors) = (Rc::clone(&carrier.said), Rc::clone(&carrier.doors));
        let mut run = Run::among(scenario, 1, true, Others::Pilot(Box::new(carrier))).expect("a robot");
        let mut happened = Vec::new();
        while run.time() < Duration::from_secs(seconds) {
            run.step().expect("a step");
            happened.extend(run.happenings.iter().filter_map(|what| match what {
                Happening::Moved { words } => Some(words.clone()),
                _ => None,
            }));
        }
        run.leave_others();
        let said = said.take().into_iter().map(|(at_s, said)| match said {
            // A Boolean and a string: the string begins after its length.
            FromNode::Response { number, body } => {
                let text = String::from_utf8_lossy(body.get(12..).unwrap_or_default()).replace('\0', "");
                format!("{at_s:.2} to {number}: {} {text}", body[4]).trim_end().to_owned()
            }
            FromNode::Message { topic, body } => {
                let text = String::from_utf8_lossy(body.get(8..).unwrap_or_default()).replace('\0', "");
                format!("{at_s:.2} {topic} {text}").trim_end().to_owned()
            }
        });
        (said.collect(), doors.take(), happened)
    }

    #[test]
    fn nodes_ask_devices_and_hear_their_topics() {
        let calls = vec![
            (1.0, call(1, "/Door/open", nothing)),
            (1.0, call(2, "/Door/get_state", nothing)),
            (1.0, call(3, "/Speaker/say", |body| body.text("Hello."))),
            (1.0, call(4, "/Speaker/say", |body| body.text("Well?"))),
            (1.5, call(5, "/Tray/put", nothing)),
            (4.0, call(6, "/CallButton/get_press", nothing)),
            (4.0, call(7, "/Gate/open", nothing)),
            (4.0, call(8, "/Speaker/say", |body| body.number([1]))),
        ];
        let (said, doors, happened) = ran("parcel", "", 5, calls);
        assert_eq!(
            said,
            [
                "1.02 to 1: 1",
                "1.02 to 2: 1 closed",
                "1.06 /Door/moved moving",
                "1.44 to 3: 1",
                "1.44 /Speaker/spoken Hello.",
                "1.54 to 5: 0 there is no box",
                "1.78 to 4: 1",
                "1.78 /Speaker/spoken Well?",
                "3.04 /Door/moved open",
                "3.52 /CallButton/pressed",
                "4.02 to 8: 0 such requests cannot be read: they end before their definition does",
                "4.02 to 6: 1",
            ]
        );
        assert_eq!((doors[0], happened), (0.0, vec![]));
        assert!(doors.is_sorted() && doors[doors.len() - 1] > 1.0, "{doors:?}");
    }

    #[test]
    fn a_component_that_hangs_answers_later_and_one_that_was_started_again_never() {
        let hangs = r#"{ kind = "component_frozen", at_s = 0.5, component = "Door", lasts_s = 2 }"#;
        let calls = || vec![(1.0, call(1, "/Door/get_state", nothing)), (3.0, call(2, "/Door/get_state", nothing))];
        assert_eq!(ran("parcel", hangs, 4, calls()).0[..2], ["2.54 to 1: 1 closed", "3.02 to 2: 1 closed"]);
        let says = vec![
            (1.0, call(1, "/Speaker/say", |body| body.text("Somebody interrupts."))),
            (3.0, call(2, "/Speaker/say", |body| body.text("Hi."))),
        ];
        let crashes = r#"{ kind = "component_crash", at_s = 1.5, component = "Speaker", lasts_s = 1 }"#;
        assert_eq!(ran("parcel", crashes, 4, says).0[..1], ["3.24 to 2: 1"]);
    }

    #[test]
    fn without_components_nobody_is_served_and_the_run_is_as_before() {
        let scenario = |name: &str| Arc::new(Scenario::load(&find::find(name).expect("shipped"), &[]).expect("sound"));
        let among = |name: &str| {
            Run::among(scenario(name), 1, true, Others::Pilot(Box::new(Carrier::default()))).expect("a robot")
        };
        assert!(among("nominal").system().topology().find_process(ROS).is_none());
        assert!(among("parcel").system().topology().find_process(ROS).is_some());
        assert!(Run::new(scenario("parcel"), 1, true).expect("a run").system().topology().find_process(ROS).is_none());
        // A program has no types in ROS 2, and its name says so.
        let offered = scenario("guide").offered();
        let names: Vec<&str> = offered.offered.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["CallButton", "Door", "Microphone", "Speaker", "VisitorSensor"]);
        let [why] = &offered.left_out[..] else { panic!("{:?}", offered.left_out) };
        assert!(why.starts_with("the component TourPlanner is not offered to nodes of ROS 2: the type of `"), "{why}");
    }
}
