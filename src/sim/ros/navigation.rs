//! The robot's own navigation as a server of Nav2's action `navigate_to_pose`.

use std::time::Duration;

use maps::{Point, heading, seen_from_above};
use nav::{GiveUpReason, Goal, NavigationStatus, Navigator, PlanError, Recovery};
use recording::ros::{PoseStamped, Span};
use remote::{ActionServer, Call, Demand, Ending, FromNode, GoalId, action};
use ros_messages::{CdrReader, CdrWriter, Mismatch, RosType as _};
use runs::{Sensed, TripOrder};

use super::commands::{LARGEST, header, reals};

/// Its name in a namespace, and its type.
pub(super) const NAME: &str = "navigate_to_pose";
pub(super) const KIND: &str = "nav2_msgs/action/NavigateToPose";

/// How often it tells how a trip is going, and how far the way is, in simulated time.
const PERIOD: Duration = Duration::from_millis(100);

/// Slower than this, a robot does not say when it will arrive, in m/s.
const SLOW_MPS: f64 = 0.01;

/// The errors of Nav2's planners and controllers that fit, and any other one, by their numbers.
const NONE: u16 = 0;
const NO_PROGRESS: u16 = 105;
const UNKNOWN: u16 = 200;
const TF_ERROR: u16 = 202;
const START_OUTSIDE: u16 = 203;
const GOAL_OUTSIDE: u16 = 204;
const START_OCCUPIED: u16 = 205;
const GOAL_OCCUPIED: u16 = 206;
const NO_PATH: u16 = 208;

/// Gives the robot's own navigation the goals that come from outside.
#[derive(Debug)]
pub(super) struct NavigationServer {
    server: ActionServer,
    /// The frame in which goals are given.
    map: String,
    trip: Option<Pursued>,
    /// How often the navigator has been started again.
    restarts: u64,
}

/// A trip to a goal that came from outside.
#[derive(Debug)]
struct Pursued {
    /// Which trip of the navigator it is, counted from 1.
    number: u64,
    since: Duration,
    is_canceled: bool,
    /// How often the navigator has begun to recover, and what it did last.
    recoveries: i16,
    recovery: Option<Recovery>,
}

impl NavigationServer {
    pub(super) fn new(map: String) -> Self {
        Self { server: ActionServer::new(format!("/{NAME}")), map, trip: None, restarts: 0 }
    }

    /// Whether it serves what is called so within.
    pub(super) fn serves(service: &str) -> bool {
        service.strip_prefix('/').is_some_and(|name| name.starts_with(&action::service(NAME, "")))
    }

    /// What it has said since the last call.
    pub(super) fn take_said(&mut self) -> Vec<FromNode> {
        self.server.take_said()
    }

    /// Tells how a trip is going, and hears what is requested, unless the robot's navigation is frozen. Returns what
    /// that is told. One that has been started again has forgotten all goals, and what was requested before.
    pub(super) fn act(
        &mut self,
        sensed: &Sensed<'_>,
        mut requested: impl FnMut() -> Option<Call>,
    ) -> Option<TripOrder> {
        if sensed.software.outages().navigation {
            return None;
        }
        let navigator = sensed.software.navigator();
        if std::mem::replace(&mut self.restarts, navigator.restarts()) != self.restarts {
            while requested().is_some() {}
            self.trip = None;
            self.server.restart();
        }
        self.follow(sensed);
        let mut told = None;
        while let Some(request) = requested() {
            told = self.hear(&request, sensed.now, navigator).or(told);
        }
        told
    }

    /// The run is over: nobody pursues a goal any more.
    pub(super) fn leave(&mut self) {
        self.server.end(Ending::GivenUp, |status| result(status, UNKNOWN, "the run is over"));
    }

    fn hear(&mut self, request: &Call, now: Duration, navigator: &Navigator) -> Option<TripOrder> {
        let Self { server, map, trip, .. } = self;
        match server.hear(request, |reader| read_goal(reader, map), |status| result(status, NONE, ""))? {
            Demand::Pursue(id, goal) => {
                server.accept(id, now, |status| result(status, UNKNOWN, "another goal has come"));
                // It begins with the navigator's next trip.
                let number = navigator.trips_started() + 1;
                *trip = Some(Pursued { number, since: now, is_canceled: false, recoveries: 0, recovery: None });
                Some(TripOrder::Start(goal))
            }
            Demand::Cancel => trip.as_mut().map(|trip| {
                trip.is_canceled = true;
                TripOrder::End
            }),
        }
    }

    /// Tells how the trip is going, and how it has ended.
    fn follow(&mut self, sensed: &Sensed<'_>) {
        let Some(trip) = &mut self.trip else { return };
        let navigator = sensed.software.navigator();
        let status = navigator.status();
        let aborted = |code, why: &str| (Ending::GivenUp, code, why.to_owned());
        let is_its_own = navigator.trips_started() == trip.number;
        let (how, code, why) = if navigator.trips_started() > trip.number {
            aborted(UNKNOWN, "the robot was sent elsewhere")
        } else if is_its_own && status.is_under_way() {
            return self.feed_back(sensed);
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

    /// `nav2_msgs/action/NavigateToPose_Feedback`
    fn feed_back(&mut self, sensed: &Sensed<'_>) {
        let Some(trip) = &mut self.trip else { return };
        let (software, navigator) = (sensed.software, sensed.software.navigator());
        let recovery = navigator.recovery();
        if recovery != trip.recovery {
            trip.recoveries = trip.recoveries.saturating_add(i16::from(recovery.is_some()));
            trip.recovery = recovery;
        }
        if !sensed.now.as_nanos().is_multiple_of(PERIOD.as_nanos()) {
            return;
        }
        let left_m = navigator.remaining_m().unwrap_or_default();
        let speed_mps = software.odometry().map_or(0.0, |odometry| odometry.linear_mps.abs());
        let left_s = if speed_mps > SLOW_MPS { left_m / speed_mps } else { 0.0 };
        let (estimate, recoveries, since) = (software.estimate(), trip.recoveries, trip.since);
        let map = self.map.clone();
        self.server.feed_back(|id: GoalId| {
            let mut cdr = CdrWriter::reusing(Vec::new());
            cdr.numbers(id.iter().map(|byte| [*byte]));
            PoseStamped::new(estimate.time, map, &estimate.pose).write(&mut cdr);
            span(sensed.now.saturating_sub(since)).write(&mut cdr);
            span(Duration::try_from_secs_f64(left_s).unwrap_or(Duration::MAX)).write(&mut cdr);
            recoveries.write(&mut cdr);
            // The message has single precision.
            (left_m as f32).write(&mut cdr);
            cdr.bytes()
        });
    }
}

/// The goal in a `nav2_msgs/action/NavigateToPose_Goal`. An orientation of zeros asks for none. None if it is in
/// another frame, or nowhere, or asks for a tree of Nav2.
fn read_goal(reader: &mut CdrReader<'_>, map: &str) -> Option<Goal> {
    let mut read = || -> Result<_, Mismatch> {
        let (_, frame) = header(reader)?;
        let numbers = reals::<7>(reader)?;
        Ok((frame == map.as_bytes(), numbers, reader.string(None)?.is_empty()))
    };
    let (is_on_map, [x, y, _, a, b, c, w], is_plain) = read().ok()?;
    let is_sound = is_on_map && is_plain && [x, y].iter().all(|number| number.abs() <= LARGEST);
    let there = seen_from_above([x, y], [a, b, c, w]);
    let is_turned = [a, b, c, w].iter().any(|number| *number != 0.0);
    let heading_rad = is_turned.then(|| heading(&there));
    (is_sound && heading_rad.is_none_or(f64::is_finite)).then(|| Goal::at(Point::new(x, y), heading_rad))
}

/// `nav2_msgs/action/NavigateToPose_GetResult_Response`
fn result(status: i8, code: u16, why: &str) -> Vec<u8> {
    let mut cdr = CdrWriter::reusing(Vec::new());
    status.write(&mut cdr);
    code.write(&mut cdr);
    cdr.text(why);
    cdr.bytes()
}

fn span(of: Duration) -> Span {
    Span { sec: i32::try_from(of.as_secs()).unwrap_or(i32::MAX), nanosec: of.subsec_nanos() }
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
    use runs::{Orders, Others, Pilot, Run};
    use scenarios::scenario::{Scenario, find};

    use super::*;

    type Said = Vec<(String, Vec<u8>)>;

    /// Who sends requests at times, in seconds, and what the server has said by then.
    struct Giver {
        server: NavigationServer,
        requests: Vec<(u64, Call)>,
        said: Rc<RefCell<Said>>,
    }

    impl Pilot for Giver {
        fn drive(&mut self, sensed: &Sensed<'_>) -> Option<Orders> {
            let Self { server, requests, said } = self;
            let is_due = |(at_s, _): &mut (u64, Call)| sensed.now >= Duration::from_secs(*at_s);
            let mut due = requests.extract_if(.., is_due);
            let trip = server.act(sensed, || due.next().map(|(_, request)| request));
            said.borrow_mut().extend(server.take_said().into_iter().map(|said| match said {
                FromNode::Response { body, .. } => ("response".to_owned(), body[4..].to_vec()),
                FromNode::Message { topic, body } => {
                    (topic.rsplit('/').next().unwrap_or_default().to_owned(), body[4..].to_vec())
                }
            }));
            Some(Orders { trip, ..Orders::default() })
        }
    }

    fn request(part: &str, id: u8, more: impl FnOnce(&mut CdrWriter)) -> Call {
        let mut cdr = CdrWriter::reusing(Vec::new());
        cdr.numbers([id; 16].iter().map(|byte| [*byte]));
        more(&mut cdr);
        let service = format!("/{NAME}/_action/{part}");
        Call { service, kind: String::new(), number: id.into(), body: cdr.bytes() }
    }

    fn goal(id: u8, frame: &'static str, [x, y]: [f64; 2], tree: &str) -> Call {
        request(SEND_GOAL, id, |cdr| {
            PoseStamped::new(Duration::ZERO, frame, &maps::pose(x, y, 1.0)).write(cdr);
            cdr.text(tree);
        })
    }

    /// The statuses of all goals at the end, and everything that was said, after so many seconds in the paper's house.
    fn statuses(requests: Vec<(u64, Call)>, faults: &str, seconds: u64) -> (Vec<i8>, Said) {
        let set = [format!("faults=[{faults}]"), "execution.max_time_s=600".to_owned()];
        let scenario = Arc::new(Scenario::load(&find::find("nominal").expect("shipped"), &set).expect("sound"));
        let said = Rc::default();
        let server = NavigationServer::new("map".to_owned());
        let giver = Giver { server, requests, said: Rc::clone(&said) };
        let mut run = Run::among(scenario, 1, true, Others::Pilot(Box::new(giver))).expect("a robot");
        while run.time() < Duration::from_secs(seconds) {
            run.step().expect("a step");
        }
        let said = said.take();
        let (_, last) = said.iter().rev().find(|(name, _)| name == "status").expect("a status");
        (last[4..].chunks(28).map(|goal| goal[24] as i8).collect(), said)
    }

    const NEAR: [f64; 2] = [-10.0, 1.0];
    const FAR: [f64; 2] = [-11.7, 14.2];

    #[test]
    fn the_robot_drives_to_goals_from_outside() {
        let (ended, said) = statuses(vec![(1, goal(1, "map", NEAR, ""))], "", 90);
        assert_eq!(ended, [STATUS_SUCCEEDED]);
        // How far it is still to go, at first and at last.
        let left: Vec<f32> = said
            .iter()
            .filter(|(name, body)| name == "feedback" && !body.is_empty())
            .map(|(_, body)| f32::from_le_bytes(*body.last_chunk().expect("a number")))
            .collect();
        assert!(left[5] > 10.0 && left[left.len() - 1] < 0.3, "{left:?}");
        assert!(left.len() > 300, "{}", left.len());
    }

    #[test]
    fn a_trip_is_canceled_replaced_and_taken_over() {
        let cancel = || request(CANCEL_GOAL, 1, |cdr| cdr.numbers([[0_u8]; 8].into_iter()));
        assert_eq!(statuses(vec![(1, goal(1, "map", FAR, "")), (5, cancel())], "", 7).0, [STATUS_CANCELED]);
        let (ended, said) = statuses(vec![(1, goal(1, "map", FAR, "")), (1, cancel())], "", 3);
        assert_eq!((ended, said.len()), (vec![STATUS_CANCELED], 6), "{said:?}");
        let two = vec![(1, goal(1, "map", FAR, "")), (5, goal(2, "map", NEAR, ""))];
        assert_eq!(statuses(two, "", 7).0, [STATUS_ABORTED, STATUS_EXECUTING]);
        let elsewhere = r#"{ kind = "operator_goal", at_s = 3, to = [-10, 1, 0] }"#;
        assert_eq!(statuses(vec![(1, goal(1, "map", FAR, ""))], elsewhere, 7).0, [STATUS_ABORTED]);
    }

    #[test]
    fn a_goal_that_nobody_can_reach_is_aborted_and_one_that_is_none_is_rejected() {
        let (ended, said) = statuses(vec![(1, goal(1, "map", [500.0, 0.0], ""))], "", 3);
        assert_eq!(ended, [STATUS_ABORTED]);
        assert!(said.iter().all(|(name, body)| name != "feedback" || body.is_empty()));
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
    fn a_navigation_that_was_started_again_has_forgotten_its_goals() {
        let crash = r#"{ kind = "component_crash", at_s = 3, component = "Navigation", lasts_s = 1 }"#;
        let cancel = request(CANCEL_GOAL, 1, |cdr| cdr.numbers([[0_u8]; 8].into_iter()));
        for requests in [vec![], vec![(3, cancel)], vec![(3, goal(2, "map", NEAR, ""))]] {
            let first = (1, goal(1, "map", FAR, ""));
            assert!(statuses([vec![first], requests].concat(), crash, 5).0.is_empty());
        }
    }
}
