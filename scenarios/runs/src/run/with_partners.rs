//! A run in which other programs take part.

use std::sync::Arc;
use std::time::Duration;

use channels::{ChannelId, ChannelSystem};
use recording::Happening;
use remote::{Loss, RemoteProcess};
use scenarios::Error;
use scenarios::scenario::Scenario;

use super::{Run, RunKind};
use crate::controller::ControllerOutput;
use crate::partners::Partners;
use crate::remote_components::Delivery;
use crate::wiring::start_programs;

impl Run {
    /// The scenario at its start, as [`new`](Self::new) makes it, with partners, which set its pace: another run need
    /// not be the same. If a controller drives the robot, the tree gets no ticks; the monitors still do.
    ///
    /// # Errors
    /// [`Error::BadInput`] if the scenario's parts do not fit together, or if these partners cannot take part in it.
    pub fn with_partners(scenario: Arc<Scenario>, seed: u64, watch: bool, partners: Partners) -> Result<Self, Error> {
        let mut run = match &partners {
            Partners::None => return Self::new(scenario, seed, watch),
            Partners::Controller(controller) => {
                let offered = if controller.serves() { scenario.offered().offered } else { Arc::default() };
                let mut run = Self::offering(scenario, seed, watch, &offered)?;
                run.hand_over()?;
                run
            }
            Partners::Components(components) => Self::beside(scenario, seed, watch, components.run())?,
        };
        run.partnership.partners = partners;
        Ok(run)
    }

    /// A run beside the nodes of ROS 2 that are components of it. The number distinguishes it from other runs.
    fn beside(scenario: Arc<Scenario>, seed: u64, watch: bool, number: u64) -> Result<Self, Error> {
        let mut run = Self::prepare(scenario, seed, watch)?;
        if !matches!(run.kind, RunKind::Application) {
            let help = "run its application instead";
            return Err(Error::refused("a schedule has no time in which nodes could answer", help));
        }
        start_programs(&run.scenario, &mut run.system)?;
        for id in &run.partnership.remote {
            run.system.process_mut::<RemoteProcess>(*id).expect("it is one").begin(number);
        }
        Ok(run)
    }

    /// Takes the robot from the tree, for a controller.
    fn hand_over(&mut self) -> Result<(), Error> {
        if self.world.robot.is_none() {
            let message = format!("the scenario {} has no robot to drive", self.scenario.name);
            return Err(Error::refused(message, "name one with a map, and without a schedule"));
        }
        self.ids.tree.iter().for_each(|ids| self.system.suspend(ids.tick_generator, true));
        Ok(())
    }

    /// Has the controller drive the robot, or delivers what the nodes of ROS 2 have sent to the processes of these
    /// components; one that hangs gets it later. Returns the partners' notes; `None` while the step still waits for
    /// them.
    pub(super) fn receive_from_partners(&mut self, now: Duration) -> Option<Vec<String>> {
        let Self { partnership, world, system, trace, .. } = self;
        if let Some(controller) = partnership.partners.controller() {
            let ControllerOutput { requests, mut notes, .. } = world.obey(controller, &partnership.outbox, system)?;
            partnership.outbox.clear();
            if let Some(clients) = partnership.clients(system) {
                requests.iter().for_each(|request| clients.receive(request));
                trace.stirred |= !requests.is_empty();
                notes.extend(clients.take_notes());
            }
            return Some(notes);
        }
        let Some(components) = partnership.partners.components() else { return Some(Vec::new()) };
        let Delivery { messages, losses, resumed, notes } = components.receive(now)?;
        self.end_gaps();
        losses.iter().for_each(|loss| self.begin_gaps(loss));
        resumed.iter().for_each(|lost| self.partnership.losses.end(lost));
        let Self { partnership, system, trace, .. } = self;
        for id in &partnership.remote {
            let is_suspended = system.is_suspended(*id);
            let Some(component) = system.process_mut::<RemoteProcess>(*id) else { continue };
            messages.iter().for_each(|message| component.receive(message));
            trace.stirred |= !is_suspended && component.act();
        }
        Some(notes)
    }

    /// Begins the gaps that a loss leaves in channels.
    fn begin_gaps(&mut self, loss: &Loss) {
        for id in &self.partnership.remote {
            let channels = self.system.process::<RemoteProcess>(*id).map(|component| component.channels_of(&loss.what));
            for gap in self.partnership.losses.begin(loss, &channels.unwrap_or_default()) {
                self.monitors.judged.iter_mut().for_each(|judged| judged.miss(&gap));
                self.trace.happenings.push(Happening::Lost(gap));
            }
        }
    }

    /// Ends the gaps that were over before this step.
    fn end_gaps(&mut self) {
        let Self { partnership, monitors, system, trace, .. } = self;
        for channel in partnership.losses.take_over(|channel| is_empty(channel, system)) {
            monitors.judged.iter_mut().for_each(|judged| judged.resume(channel));
            trace.happenings.push(Happening::Resumed(channel));
        }
    }

    /// Whether a step has begun that waits for partners.
    pub(crate) fn is_waiting(&self) -> bool {
        self.partnership.is_waiting
    }

    /// Continues after a pause since the last step, or since it last waited for partners.
    pub(crate) fn resume(&mut self) {
        self.partnership.partners.resume();
    }
}

/// Whether no message from nodes of ROS 2 waits for a channel.
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

    use remote::{NodeMessage, ServiceRequest};
    use ros_messages::CdrWriter;
    use scenarios::processes::ROS;
    use scenarios::scenario::find;

    use super::*;
    use crate::controller::{Controller, ControllerInput};

    /// Keeps the robot still, and passes on requests at their times, in seconds.
    #[derive(Default)]
    struct Carrier {
        requests: Vec<(f64, ServiceRequest)>,
        /// What nodes receive, with the times in seconds.
        received: Rc<RefCell<Vec<(f64, NodeMessage)>>>,
        doors: Rc<RefCell<Vec<f64>>>,
    }

    impl Controller for Carrier {
        fn drive(&mut self, input: &ControllerInput<'_>) -> Option<ControllerOutput> {
            let now_s = input.now.as_secs_f64();
            self.received.borrow_mut().extend(input.outbox.iter().map(|message| (now_s, message.clone())));
            self.doors.borrow_mut().extend(input.doors.iter().map(|(_, place)| *place));
            let requests =
                self.requests.extract_if(.., |(at_s, _)| *at_s <= now_s).map(|(_, request)| request).collect();
            Some(ControllerOutput { velocity: Some(Default::default()), requests, ..ControllerOutput::default() })
        }

        fn serves(&self) -> bool {
            true
        }

        fn leave(&mut self, outbox: &[NodeMessage]) {
            self.received.borrow_mut().extend(outbox.iter().map(|message| (f64::INFINITY, message.clone())));
        }
    }

    fn request(number: u64, service: &str, write: impl FnOnce(&mut CdrWriter)) -> ServiceRequest {
        let mut body = CdrWriter::reusing(Vec::new());
        write(&mut body);
        ServiceRequest { service: service.to_owned(), kind: String::new(), number, body: body.bytes() }
    }

    fn nothing(body: &mut CdrWriter) {
        body.number([0]);
    }

    /// A run of a scenario for some seconds, with these requests. Returns what nodes received, in words with the times
    /// in seconds, how far doors were open, and the notes.
    fn ran(
        name: &str,
        faults: &str,
        seconds: u64,
        requests: Vec<(f64, ServiceRequest)>,
    ) -> (Vec<String>, Vec<f64>, Vec<String>) {
        let set = [format!("faults=[{faults}]"), "stop={}".to_owned()];
        let scenario = Arc::new(Scenario::load(&find::find(name).expect("shipped"), &set).expect("sound"));
        let carrier = Carrier { requests, ..Carrier::default() };
        let (received, doors) = (Rc::clone(&carrier.received), Rc::clone(&carrier.doors));
        let mut run = Run::with_partners(scenario, 1, true, Partners::Controller(Box::new(carrier))).expect("a robot");
        let mut notes = Vec::new();
        while run.time() < Duration::from_secs(seconds) {
            run.step().expect("a step");
            notes.extend(run.trace.happenings.iter().filter_map(|what| match what {
                Happening::Moved { words } => Some(words.clone()),
                _ => None,
            }));
        }
        run.partnership.leave(&mut run.system);
        let received = received.take().into_iter().map(|(at_s, message)| match message {
            // A Boolean and a string: the string begins after its length.
            NodeMessage::Response { number, body } => {
                let text = String::from_utf8_lossy(body.get(12..).unwrap_or_default()).replace('\0', "");
                format!("{at_s:.2} to {number}: {} {text}", body[4]).trim_end().to_owned()
            }
            NodeMessage::Message { topic, body } => {
                let text = String::from_utf8_lossy(body.get(8..).unwrap_or_default()).replace('\0', "");
                format!("{at_s:.2} {topic} {text}").trim_end().to_owned()
            }
        });
        (received.collect(), doors.take(), notes)
    }

    #[test]
    fn nodes_send_requests_to_devices_and_receive_their_topics() {
        let requests = vec![
            (1.0, request(1, "/Door/open", nothing)),
            (1.0, request(2, "/Door/get_state", nothing)),
            (1.0, request(3, "/Speaker/say", |body| body.text("Hello."))),
            (1.0, request(4, "/Speaker/say", |body| body.text("Well?"))),
            (1.5, request(5, "/Tray/put", nothing)),
            (4.0, request(6, "/CallButton/get_press", nothing)),
            (4.0, request(7, "/Gate/open", nothing)),
            (4.0, request(8, "/Speaker/say", |body| body.number([1]))),
        ];
        let (received, doors, notes) = ran("parcel", "", 5, requests);
        assert_eq!(
            received,
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
        assert_eq!((doors[0], notes), (0.0, vec![]));
        assert!(doors.is_sorted() && doors[doors.len() - 1] > 1.0, "{doors:?}");
    }

    #[test]
    fn a_component_that_hangs_responds_later_and_one_that_was_restarted_does_not() {
        let hangs = r#"{ kind = "component_frozen", at_s = 0.5, component = "Door", lasts_s = 2 }"#;
        let requests =
            || vec![(1.0, request(1, "/Door/get_state", nothing)), (3.0, request(2, "/Door/get_state", nothing))];
        assert_eq!(ran("parcel", hangs, 4, requests()).0[..2], ["2.54 to 1: 1 closed", "3.02 to 2: 1 closed"]);
        let speeches = vec![
            (1.0, request(1, "/Speaker/say", |body| body.text("Somebody interrupts."))),
            (3.0, request(2, "/Speaker/say", |body| body.text("Hi."))),
        ];
        let crashes = r#"{ kind = "component_crash", at_s = 1.5, component = "Speaker", lasts_s = 1 }"#;
        assert_eq!(ran("parcel", crashes, 4, speeches).0[..1], ["3.24 to 2: 1"]);
    }

    #[test]
    fn without_components_there_is_no_process_for_ros() {
        let scenario = |name: &str| Arc::new(Scenario::load(&find::find(name).expect("shipped"), &[]).expect("sound"));
        let controlled = |name: &str| {
            Run::with_partners(scenario(name), 1, true, Partners::Controller(Box::new(Carrier::default())))
                .expect("a robot")
        };
        assert!(controlled("nominal").system().topology().find_process(ROS).is_none());
        assert!(controlled("parcel").system().topology().find_process(ROS).is_some());
        assert!(Run::new(scenario("parcel"), 1, true).expect("a run").system().topology().find_process(ROS).is_none());
        // A program has no types in ROS 2.
        let offered = scenario("guide").offered();
        let names: Vec<&str> = offered.offered.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["CallButton", "Door", "Microphone", "Speaker", "VisitorSensor"]);
        let [why] = &offered.left_out[..] else { panic!("{:?}", offered.left_out) };
        assert!(why.starts_with("the component TourPlanner is not offered to nodes of ROS 2: the type of `"), "{why}");
    }
}
