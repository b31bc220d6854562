//! Runs beside nodes of ROS 2 of which DDS loses messages: all results state what is unsure, and a log of the run gives
//! the same verdicts.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

use campaigns::run_and_report;
use channels::Flaw;
use recording::Detail;
use recording::ros::battery_state;
use remote::{Loss, Lost, NodeMessage, ServiceRequest};
use reports::Outputs;
use reports::report::Report;
use reports::results::{CaseResult, Suite, WrittenPlaces};
use ros_messages::RosType as _;
use runs::{Delivery, Partners, RemoteComponents, Run};
use scenarios::scenario::{Scenario, find};
use serde_json::json;

use super::args::{RobotsArgs, VerifyArgs};
use super::{as_json, verify_log};
use crate::bag_tree::BagTreeArgs;
use crate::live::BoardArgs;
use crate::results::ResultsArgs;
use crate::summary;

const PROPERTIES: &str = "
property never_low := always not (Robot, BatteryReader, share < 0.2)
property once_full := eventually (Robot, BatteryReader, share > 0.9)
property falls := always ((Robot, BatteryReader, share < 0.6) implies
    time_until (Robot, BatteryReader, share < 0.3) < 2 s)
property recovers := always ((Robot, BatteryReader, share < 0.4) implies
    time_until (Robot, BatteryReader, share > 0.5) < 3 s)
property told := always not (BatteryReader, BatteryLevel, level < 1)
property pose_first := (not (Robot, BatteryReader, share > 0.1)) until (Robot, Localization, x > 0)
";

/// A step, in milliseconds.
const STEP_MS: u64 = 20;

/// A robot that reports its charge, 50 %, every second, and after 6 s another one; losses are reported, too.
struct LossyRobot {
    charge_pct: f64,
    /// The time of each loss, when it began, and when it is over, in milliseconds.
    losses: &'static [(u64, u64, u64)],
}

impl RemoteComponents for LossyRobot {
    fn run(&self) -> u64 {
        1
    }

    fn receive(&mut self, now: Duration) -> Option<Delivery> {
        let now_ms = u64::try_from(now.as_millis()).unwrap();
        let mut delivery = Delivery::default();
        if now_ms % 1000 == STEP_MS {
            let charge_pct = if now_ms > 6_000 { self.charge_pct } else { 50.0 };
            let body = battery_state(now, charge_pct, false).encode();
            delivery.messages.push(NodeMessage::Message { topic: "/battery_state".to_owned(), body });
        }
        for (at_ms, since_ms, until_ms) in self.losses {
            let what = Lost::Topic("/battery_state".to_owned());
            if *at_ms == now_ms {
                let (since, why) = (Duration::from_millis(*since_ms), format!("lost after {since_ms} ms"));
                delivery.losses.push(Loss { what: what.clone(), flaw: Flaw::Missing, since, why });
            }
            delivery.resumed.extend((*until_ms == now_ms).then_some(what));
        }
        Some(delivery)
    }

    fn resume(&mut self) {}

    fn send(&mut self, _: Vec<ServiceRequest>) {}

    fn leave(&mut self) {}
}

/// What a run reports; it is also recorded.
fn ran(robot: LossyRobot, properties: &Path, folder: &Path, record: &Path) -> Report {
    let set = [format!("properties=[{properties:?}]"), "expect={}".into(), "stop={}".into()];
    let set: Vec<String> = set.into_iter().chain(["execution.max_time_s=12".to_owned()]).collect();
    let scenario = Arc::new(Scenario::load(&find::find("on_a_robot").unwrap(), &set).unwrap());
    let run = Run::with_partners(scenario, 1, true, Partners::Components(Box::new(robot))).unwrap();
    let outputs = Outputs { folder: Some(folder.to_owned()), ..Outputs::default() };
    run_and_report(run, Detail::Full, &outputs, Some(record), |_| {}, |_| ControlFlow::Continue(())).unwrap()
}

fn args(log: &Path, properties: Vec<PathBuf>) -> VerifyArgs {
    VerifyArgs {
        logs: vec![log.to_owned()],
        properties,
        robots: RobotsArgs::default(),
        scenario: None,
        map_channels: None,
        tree: BagTreeArgs::default(),
        out: None,
        results: ResultsArgs::default(),
        follow: false,
        board: BoardArgs::default(),
        list: false,
        json: true,
    }
}

/// The verdicts of a run, which are also those of its logs.
fn verdicts(charge_pct: f64, losses: &'static [(u64, u64, u64)]) -> Vec<&'static str> {
    let folder = tempfile::tempdir().unwrap();
    let properties = folder.path().join("robot.scope");
    std::fs::write(&properties, PROPERTIES).unwrap();
    let mut found = Vec::new();
    for (name, of_log) in [("run.jsonl", vec![properties.clone()]), ("run.mcap", Vec::new())] {
        let log = folder.path().join(name);
        let report = ran(LossyRobot { charge_pct, losses }, &properties, folder.path(), &log);
        let verified = verify_log(&args(&log, of_log), &log, None).unwrap();
        let again = &as_json(&verified, &log)["monitors"];
        for (index, monitor) in report.monitors.iter().enumerate() {
            let judged = (&again[index]["verdict"], &again[index]["certainty"], &again[index]["unsure"]);
            let expected = (json!(monitor.found().name()), json!(monitor.certainty.name()), json!(monitor.unsure));
            assert_eq!(judged, (&expected.0, &expected.1, &expected.2), "{} in {name}", monitor.name);
            assert_eq!(again[index]["assumptions"], json!(monitor.assumptions), "{} in {name}", monitor.name);
        }
        found = report.monitors.iter().map(|monitor| monitor.found().name()).collect();
        let is_bad = found.iter().any(|verdict| matches!(*verdict, "unsure" | "violated"));
        let status = summary::print(&report, folder.path(), true).unwrap();
        assert_eq!(format!("{status:?}"), format!("{:?}", ExitCode::from(u8::from(is_bad))));
        assert_eq!(verified.status(), u8::from(is_bad));
    }
    found
}

#[test]
fn verdicts_that_a_lost_message_could_change_are_unsure_in_the_run_and_in_its_logs() {
    let complete = ["satisfied", "inconclusive", "violated", "satisfied", "satisfied", "violated"];
    assert_eq!(verdicts(50.0, &[]), complete);
    // That it did not fall in time was found when it could be; a charge of 50 % came first.
    let unsure = ["unsure", "unsure", "violated", "unsure", "satisfied", "violated"];
    assert_eq!(verdicts(50.0, &[(6_020, 5_020, 6_020)]), unsure);
    // At the beginning, everything about the robot is open.
    let unsure = ["unsure", "unsure", "violated", "unsure", "satisfied", "violated"];
    assert_eq!(verdicts(50.0, &[(3_020, 1_020, 3_020)]), unsure);
    let seen = ["violated", "unsure", "violated", "violated", "satisfied", "violated"];
    assert_eq!(verdicts(10.0, &[(4_020, 3_020, 4_020)]), seen);
    let reached = ["unsure", "satisfied", "violated", "unsure", "satisfied", "violated"];
    assert_eq!(verdicts(95.0, &[(4_020, 3_020, 4_020)]), reached);
    // What is lost goes on to the end.
    assert_eq!(verdicts(95.0, &[(4_020, 3_020, u64::MAX)])[1], "satisfied");
}

#[test]
fn all_results_of_a_run_state_that_a_verdict_is_unsure() {
    let folder = tempfile::tempdir().unwrap();
    let properties = folder.path().join("robot.scope");
    std::fs::write(&properties, PROPERTIES.lines().take(2).collect::<Vec<_>>().join("\n")).unwrap();
    let robot = LossyRobot { charge_pct: 50.0, losses: &[(6_020, 5_020, 6_020)] };
    let report = ran(robot, &properties, folder.path(), &folder.path().join("run.rec"));
    let why = "lost after 5020 ms";
    let json = json!(report);
    let monitor = &json["monitors"][0];
    assert_eq!((&monitor["certainty"], &monitor["unsure"]), (&json!("unsure"), &json!(why)));
    assert_eq!((&json["outcome"], &json["lost"]), (&json!("not_as_expected"), &json!([why])));
    assert_eq!(report.differences, [format!("never_low is unsure: {why}")]);
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(page.contains("never_low unsure") && page.contains(why), "{page}");
    let suite = Suite::of_run(&Default::default(), &report, folder.path(), &WrittenPlaces::default());
    let [case, ..] = &suite.cases[..] else { panic!("{suite:?}") };
    let CaseResult::Failed { message, .. } = &case.result else { panic!("{case:?}") };
    assert_eq!((message.as_str(), case.found.as_str()), ("never_low is unsure: lost after 5020 ms", "unsure"));
}
