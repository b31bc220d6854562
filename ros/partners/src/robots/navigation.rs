//! The robot's own navigation as a server of Nav2's action `navigate_to_pose`.

use std::time::Duration;

use components::Component;
use maps::heading;
use nav::{GiveUpReason, Goal, NavigationStatus, Navigator, PlanError, Recovery};
use recording::ros::{
    self, NavigateToPoseFeedback, NavigateToPoseFeedbackMessage, NavigateToPoseGoal, NavigateToPoseResult,
    NavigateToPoseResultResponse, PoseStamped, Quaternion, Uuid,
};
use remote::{ActionServer, Demand, Ending, GoalId, NodeMessage, ServiceRequest, action};
use ros_messages::{CdrReader, RosType};
use runs::{ControllerInput, TripCommand};

use super::commands::LARGEST;

/// The action's name in a namespace, and its type.
pub(super) const NAME: &str = "navigate_to_pose";
pub(super) const KIND: &str = "nav2_msgs/action/NavigateToPose";

/// The interval of feedback, in simulated time.
const PERIOD: Duration = Duration::from_millis(100);

/// Below this speed, in m/s, the feedback has no estimated time of arrival.
const SLOW_MPS: f64 = 0.01;

/// The error codes of Nav2's planners and controllers that apply here, and `UNKNOWN` for any other error.
const NONE: u16 = 0;
const NO_PROGRESS: u16 = 105;
const UNKNOWN: u16 = 200;
const TF_ERROR: u16 = 202;
const START_OUTSIDE: u16 = 203;
const GOAL_OUTSIDE: u16 = 204;
const START_OCCUPIED: u16 = 205;
const GOAL_OCCUPIED: u16 = 206;
const NO_PATH: u16 = 208;

/// The server of the action: passes goals on to the robot's own navigation.
#[derive(Debug)]
pub(super) struct NavigationServer {
    server: ActionServer,
    /// The frame of the goals.
    map: String,
    trip: Option<Pursued>,
    /// How often the navigator has been restarted.
    restarts: u64,
}

/// A trip to a goal of a client.
#[derive(Debug)]
struct Pursued {
    /// The number of the navigator's trip, counted from 1.
    number: u64,
    since: Duration,
    is_canceled: bool,
    /// How often the navigator has begun to recover.
    recoveries: i16,
    /// Its current recovery.
    recovery: Option<Recovery>,
}

impl NavigationServer {
    pub(super) fn new(map: String) -> Self {
        Self { server: ActionServer::new(format!("/{NAME}")), map, trip: None, restarts: 0 }
    }

    /// Whether a service is one of the action, by its name within the program.
    pub(super) fn serves(service: &str) -> bool {
        service.strip_prefix('/').is_some_and(|name| name.starts_with(&action::service(NAME, "")))
    }

    /// The responses and messages since the last call.
    pub(super) fn take_outbox(&mut self) -> Vec<NodeMessage> {
        self.server.take_outbox()
    }

    /// Updates the current goal and handles requests, unless the robot's navigation is frozen. Returns the command for
    /// the navigation. A restarted navigation has forgotten all goals and earlier requests.
    pub(super) fn act(
        &mut self,
        input: &ControllerInput<'_>,
        mut requested: impl FnMut() -> Option<ServiceRequest>,
    ) -> Option<TripCommand> {
        if input.software.is_frozen(Component::Navigation) {
            return None;
        }
        let navigator = input.software.navigator();
        if std::mem::replace(&mut self.restarts, navigator.restarts()) != self.restarts {
            while requested().is_some() {}
            self.trip = None;
            self.server.restart();
        }
        self.update_trip(input);
        let mut command = None;
        while let Some(request) = requested() {
            command = self.receive(&request, input.now, navigator).or(command);
        }
        command
    }

    /// The run is over: gives up the current goal.
    pub(super) fn leave(&mut self) {
        self.server.end(Ending::GivenUp, |status| result(status, UNKNOWN, "the run is over"));
    }

    fn receive(&mut self, request: &ServiceRequest, now: Duration, navigator: &Navigator) -> Option<TripCommand> {
        let Self { server, map, trip, .. } = self;
        match server.receive(request, |reader| read_goal(reader, map), |status| result(status, NONE, ""))? {
            Demand::Pursue(id, goal) => {
                server.accept(id, now, |status| result(status, UNKNOWN, "another goal has come"));
                // The navigator's next trip is the one to this goal.
                let number = navigator.trips_started() + 1;
                *trip = Some(Pursued { number, since: now, is_canceled: false, recoveries: 0, recovery: None });
                Some(TripCommand::Start(goal))
            }
            Demand::Cancel => trip.as_mut().map(|trip| {
                trip.is_canceled = true;
                TripCommand::End
            }),
        }
    }

    /// Publishes feedback on the trip, or ends the goal as the trip has ended.
    fn update_trip(&mut self, input: &ControllerInput<'_>) {
        let Some(trip) = &mut self.trip else { return };
        let navigator = input.software.navigator();
        let status = navigator.status();
        let aborted = |code, why: &str| (Ending::GivenUp, code, why.to_owned());
        let is_its_own = navigator.trips_started() == trip.number;
        let (how, code, why) = if navigator.trips_started() > trip.number {
            aborted(UNKNOWN, "the robot was sent elsewhere")
        } else if is_its_own && status.is_under_way() {
            return self.publish_feedback(input);
        } else if is_its_own && status == NavigationStatus::GoalReached {
            (Ending::Succeeded, NONE, String::new())
        } else if trip.is_canceled {
            (Ending::Canceled, NONE, String::new())
        } else if !is_its_own {
            aborted(UNKNOWN, "navigation did not accept the goal")
        } else {
            match navigator.reason() {
                Some(reason) => aborted(code(reason), &reason.to_string()),
                None => aborted(UNKNOWN, "navigation has given up"),
            }
        };
        self.server.end(how, |status| result(status, code, &why));
        self.trip = None;
    }

    fn publish_feedback(&mut self, input: &ControllerInput<'_>) {
        let Some(trip) = &mut self.trip else { return };
        let (software, navigator) = (input.software, input.software.navigator());
        let recovery = navigator.recovery();
        if recovery != trip.recovery {
            trip.recoveries = trip.recoveries.saturating_add(i16::from(recovery.is_some()));
            trip.recovery = recovery;
        }
        if !input.now.as_nanos().is_multiple_of(PERIOD.as_nanos()) {
            return;
        }
        let left_m = navigator.remaining_m().unwrap_or_default();
        let speed_mps = software.odometry().map_or(0.0, |odometry| odometry.linear_mps.abs());
        let left_s = if speed_mps > SLOW_MPS { left_m / speed_mps } else { 0.0 };
        let estimate = software.estimate();
        let feedback = NavigateToPoseFeedback {
            current_pose: ros::pose_stamped(estimate.time, self.map.clone(), &estimate.pose),
            navigation_time: input.now.saturating_sub(trip.since).into(),
            estimated_time_remaining: Duration::try_from_secs_f64(left_s).unwrap_or(Duration::MAX).into(),
            number_of_recoveries: trip.recoveries,
            // The message has single precision.
            distance_remaining: left_m as f32,
        };
        self.server.publish_feedback(|id: GoalId| {
            NavigateToPoseFeedbackMessage { goal_id: Uuid { uuid: id }, feedback }.encode()
        });
    }
}

/// The goal of a client. With an orientation of zeros, any heading is right. `None` if it is in another frame, has
/// coordinates that are not finite or too large, or names a behavior tree of Nav2.
fn read_goal(reader: &mut CdrReader<'_>, map: &str) -> Option<Goal> {
    let NavigateToPoseGoal { pose: PoseStamped { header, pose }, behavior_tree } = RosType::read(reader).ok()?;
    let there = ros::in_plane(&pose);
    let is_near = there.translation.vector.iter().all(|number| number.abs() <= LARGEST);
    let is_sound = is_near && header.frame_id == map && behavior_tree.is_empty();
    let Quaternion { x, y, z, w } = pose.orientation;
    let is_turned = [x, y, z, w].iter().any(|number| *number != 0.0);
    let heading_rad = is_turned.then(|| heading(&there));
    (is_sound && heading_rad.is_none_or(f64::is_finite)).then(|| Goal::at(there.translation.vector.into(), heading_rad))
}

/// The response with a goal's result.
fn result(status: i8, error_code: u16, why: &str) -> Vec<u8> {
    let result = NavigateToPoseResult { error_code, error_msg: why.to_owned() };
    NavigateToPoseResultResponse { status, result }.encode()
}

fn code(reason: GiveUpReason) -> u16 {
    match reason {
        GiveUpReason::NoProgress(_) | GiveUpReason::BlockedTooOften(_) => NO_PROGRESS,
        GiveUpReason::BadEstimate => TF_ERROR,
        GiveUpReason::GoalInZone => GOAL_OCCUPIED,
        GiveUpReason::NoPlan(error) => match error {
            PlanError::StartOutside => START_OUTSIDE,
            PlanError::StartInObstacle => START_OCCUPIED,
            PlanError::GoalOutside => GOAL_OUTSIDE,
            PlanError::GoalUnknown | PlanError::GoalInObstacle { .. } => GOAL_OCCUPIED,
            _ => NO_PATH,
        },
        _ => UNKNOWN,
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::rc::Rc;
    use std::sync::Arc;

    use remote::action::{CANCEL_GOAL, SEND_GOAL, STATUS_ABORTED, STATUS_CANCELED, STATUS_EXECUTING, STATUS_SUCCEEDED};
    use ros_messages::CdrWriter;
    use runs::{Controller, ControllerOutput, Partners, Run};
    use scenarios::scenario::{Scenario, find};

    use super::*;

    type Sent = Vec<(String, Vec<u8>)>;

    /// Sends requests at times, in seconds, and keeps what the server sends.
    struct GoalSender {
        server: NavigationServer,
        requests: Vec<(u64, ServiceRequest)>,
        sent: Rc<RefCell<Sent>>,
    }

    impl Controller for GoalSender {
        fn drive(&mut self, input: &ControllerInput<'_>) -> Option<ControllerOutput> {
            let Self { server, requests, sent } = self;
            let is_due = |(at_s, _): &mut (u64, ServiceRequest)| input.now >= Duration::from_secs(*at_s);
            let mut due = requests.extract_if(.., is_due);
            let trip = server.act(input, || due.next().map(|(_, request)| request));
            sent.borrow_mut().extend(server.take_outbox().into_iter().map(|message| match message {
                NodeMessage::Response { body, .. } => ("response".to_owned(), body[4..].to_vec()),
                NodeMessage::Message { topic, body } => {
                    (topic.rsplit('/').next().unwrap_or_default().to_owned(), body[4..].to_vec())
                }
            }));
            Some(ControllerOutput { trip, ..ControllerOutput::default() })
        }
    }

    fn request(part: &str, id: u8, more: impl FnOnce(&mut CdrWriter)) -> ServiceRequest {
        let mut cdr = CdrWriter::reusing(Vec::new());
        cdr.numbers([id; 16].iter().map(|byte| [*byte]));
        more(&mut cdr);
        let service = format!("/{NAME}/_action/{part}");
        ServiceRequest { service, kind: String::new(), number: id.into(), body: cdr.bytes() }
    }

    fn goal(id: u8, frame: &'static str, [x, y]: [f64; 2], tree: &str) -> ServiceRequest {
        request(SEND_GOAL, id, |cdr| {
            ros::pose_stamped(Duration::ZERO, frame, &maps::pose(x, y, 1.0)).write(cdr);
            cdr.text(tree);
        })
    }

    /// The statuses of all goals after some seconds in the paper's house, and everything that the server has sent.
    fn statuses(requests: Vec<(u64, ServiceRequest)>, faults: &str, seconds: u64) -> (Vec<i8>, Sent) {
        let set = [format!("faults=[{faults}]"), "execution.max_time_s=600".to_owned()];
        let scenario = Arc::new(Scenario::load(&find::find("nominal").expect("shipped"), &set).expect("sound"));
        let sent = Rc::default();
        let server = NavigationServer::new("map".to_owned());
        let sender = GoalSender { server, requests, sent: Rc::clone(&sent) };
        let mut run = Run::with_partners(scenario, 1, true, Partners::Controller(Box::new(sender))).expect("a robot");
        while run.time() < Duration::from_secs(seconds) {
            run.step().expect("a step");
        }
        let sent = sent.take();
        let (_, last) = sent.iter().rev().find(|(name, _)| name == "status").expect("a status");
        (last[4..].chunks(28).map(|goal| goal[24] as i8).collect(), sent)
    }

    const NEAR: [f64; 2] = [-10.0, 1.0];
    const FAR: [f64; 2] = [-11.7, 14.2];

    #[test]
    fn the_robot_drives_to_the_goals_of_clients() {
        let (ended, sent) = statuses(vec![(1, goal(1, "map", NEAR, ""))], "", 90);
        assert_eq!(ended, [STATUS_SUCCEEDED]);
        // The remaining distance, at first and at last.
        let left: Vec<f32> = sent
            .iter()
            .filter(|(name, body)| name == "feedback" && !body.is_empty())
            .map(|(_, body)| f32::from_le_bytes(*body.last_chunk().expect("a number")))
            .collect();
        assert!(left[5] > 10.0 && left[left.len() - 1] < 0.3, "{left:?}");
        assert!(left.len() > 300, "{}", left.len());
    }

    #[test]
    fn a_trip_is_canceled_replaced_or_taken_over() {
        let cancel = || request(CANCEL_GOAL, 1, |cdr| cdr.numbers([[0_u8]; 8].into_iter()));
        assert_eq!(statuses(vec![(1, goal(1, "map", FAR, "")), (5, cancel())], "", 7).0, [STATUS_CANCELED]);
        let (ended, sent) = statuses(vec![(1, goal(1, "map", FAR, "")), (1, cancel())], "", 3);
        assert_eq!((ended, sent.len()), (vec![STATUS_CANCELED], 6), "{sent:?}");
        let two = vec![(1, goal(1, "map", FAR, "")), (5, goal(2, "map", NEAR, ""))];
        assert_eq!(statuses(two, "", 7).0, [STATUS_ABORTED, STATUS_EXECUTING]);
        let elsewhere = r#"{ kind = "operator_goal", at_s = 3, to = [-10, 1, 0] }"#;
        assert_eq!(statuses(vec![(1, goal(1, "map", FAR, ""))], elsewhere, 7).0, [STATUS_ABORTED]);
    }

    #[test]
    fn an_unreachable_goal_is_aborted_and_an_invalid_one_is_rejected() {
        let (ended, sent) = statuses(vec![(1, goal(1, "map", [500.0, 0.0], ""))], "", 3);
        assert_eq!(ended, [STATUS_ABORTED]);
        assert!(sent.iter().all(|(name, body)| name != "feedback" || body.is_empty()));
        for none in [
            goal(1, "odom", NEAR, ""),
            goal(1, "map", NEAR, "tree.xml"),
            goal(1, "map", [f64::NAN, 0.0], ""),
            goal(1, "map", [1e308, 0.0], ""),
        ] {
            assert!(statuses(vec![(1, none)], "", 2).0.is_empty());
        }
    }

    #[test]
    fn a_restarted_navigation_has_forgotten_its_goals() {
        let crash = r#"{ kind = "component_crash", at_s = 3, component = "Navigation", lasts_s = 1 }"#;
        let cancel = request(CANCEL_GOAL, 1, |cdr| cdr.numbers([[0_u8]; 8].into_iter()));
        for requests in [vec![], vec![(3, cancel)], vec![(3, goal(2, "map", NEAR, ""))]] {
            let first = (1, goal(1, "map", FAR, ""));
            assert!(statuses([vec![first], requests].concat(), crash, 5).0.is_empty());
        }
    }
}
