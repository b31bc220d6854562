//! The answers of the seven skills, and when they give them.

use channels::{Message, Process, RequestNumber};
use proptest::prelude::*;
use skills::{Datum, Note, SHIPPED};

use crate::conversation::{Conversation, chart, error, ok, ok_state};

const TO_TREE: [&str; 3] = ["BT [<success>]", "BT [<failure>]", "BT [<running>]"];
const SUCCESS: &str = TO_TREE[0];
const FAILURE: &str = TO_TREE[1];
const RUNNING: &str = TO_TREE[2];
const HALTED: &str = "BT [<halted>]";
const START: &str = "Navigation [<start_navigation>, <Destination>]";
const STATUS: &str = "Navigation [<get_status>, <Destination>]";
const STOP: &str = "Navigation [<stop_navigation>, <Destination>]";

#[test]
fn every_file_is_named_after_its_leaf_and_loads_without_a_warning() {
    for (leaf, _) in SHIPPED {
        let chart = chart(leaf);
        assert_eq!(chart.name(), leaf);
        assert!(chart.warnings().is_empty(), "{leaf}: {:?}", chart.warnings());
    }
}

#[test]
fn twins_differ_only_in_name_and_place() {
    let text = |leaf: &str| skills::shipped(leaf).unwrap().replace(leaf, "LEAF");
    for (one, other) in [("AtRechargingStation", "AtDestination"), ("GotoRechargingStation", "GoToDestination")] {
        assert_eq!(text(one).replace("'RechargingStation'", "PLACE"), text(other).replace("'Destination'", "PLACE"));
    }
}

#[test]
fn battery_level_succeeds_above_thirty_percent() {
    for (level, answer) in [(83.2, SUCCESS), (30.1, SUCCESS), (30.0, FAILURE), (10.0, FAILURE)] {
        let mut skill = Conversation::with("BatteryLevel");
        assert_eq!(skill.tick(), ["BatteryReader [<get_level>]"]);
        assert_eq!(skill.location(), "get");
        assert_eq!(skill.reply("BatteryReader", ok(level)), [answer], "{level}");
    }
}

#[test]
fn battery_level_has_a_threshold_that_can_be_set() {
    let mut skill = Conversation::with_parameters("BatteryLevel", &[("threshold", 20.0.into())]);
    skill.tick();
    assert_eq!(skill.reply("BatteryReader", ok(25.0)), [SUCCESS]);
}

#[test]
fn battery_level_fails_when_the_reader_does() {
    let mut skill = Conversation::with("BatteryLevel");
    skill.tick();
    assert_eq!(skill.reply("BatteryReader", error("no sensor")), [FAILURE]);
    let notes = skill.process.take_notes();
    assert_eq!(notes, [Note::Log { label: "BatteryReader".into(), text: "no sensor".into() }]);
}

#[test]
fn battery_level_shows_its_state() {
    let mut skill = Conversation::with("BatteryLevel");
    assert_eq!(skill.location(), "idle");
    skill.tick();
    skill.reply("BatteryReader", ok(50.0));
    assert_eq!(skill.location(), "success");
    assert_eq!(skill.halt(), [HALTED]);
    assert_eq!(skill.location(), "idle");
}

#[test]
fn battery_not_charging_succeeds_when_the_battery_does_not_charge() {
    for (charging, answer) in [(false, SUCCESS), (true, FAILURE)] {
        let mut skill = Conversation::with("BatteryNotCharging");
        assert_eq!(skill.tick(), ["BatteryReader [<get_charging>]"]);
        assert_eq!(skill.reply("BatteryReader", ok(charging)), [answer]);
    }
}

#[test]
fn at_skills_ask_for_their_place() {
    for (leaf, place) in [("AtRechargingStation", "RechargingStation"), ("AtDestination", "Destination")] {
        for (at, answer) in [(true, SUCCESS), (false, FAILURE)] {
            let mut skill = Conversation::with(leaf);
            assert_eq!(skill.tick(), [format!("Localization [<is_at>, <{place}>]")]);
            assert_eq!(skill.reply("Localization", ok(at)), [answer]);
        }
    }
}

#[test]
fn conditions_fail_without_an_answer_in_time_and_drop_late_answers() {
    let mut skill = Conversation::with("BatteryLevel");
    skill.tick();
    let late = skill.last_request("BatteryReader");
    assert!(skill.at_ms(499).is_empty());
    assert_eq!(skill.at_ms(500), [FAILURE]);
    assert_eq!(skill.tick(), ["BatteryReader [<get_level>]"]);
    skill.deliver("BatteryReader", ok(80.0), late);
    assert_eq!(skill.sent(), [""; 0], "nobody expects the answer to the previous request");
    assert_eq!(skill.location(), "get");
    assert_eq!(skill.reply("BatteryReader", ok(20.0)), [FAILURE]);
}

#[test]
fn an_answer_in_time_cancels_the_timeout() {
    let mut skill = Conversation::with("BatteryLevel");
    skill.tick();
    skill.reply("BatteryReader", ok(80.0));
    assert_eq!(skill.process.next_timer(), None);
    assert!(skill.at_ms(10_000).is_empty());
}

#[test]
fn a_repeated_answer_counts_once() {
    let mut skill = Conversation::with("BatteryLevel");
    skill.tick();
    assert_eq!(skill.reply("BatteryReader", ok(80.0)), [SUCCESS]);
    assert!(skill.reply("BatteryReader", ok(10.0)).is_empty());
    assert_eq!(skill.location(), "success");
}

#[test]
fn the_timeout_can_be_set() {
    let mut skill = Conversation::with_parameters("AtDestination", &[("timeout", "2s".into())]);
    skill.tick();
    assert!(skill.at_ms(1999).is_empty());
    assert_eq!(skill.at_ms(2000), [FAILURE]);
}

#[test]
fn wait_for_user_runs_until_it_is_halted() {
    let mut skill = Conversation::with("WaitForUser");
    assert_eq!(skill.tick(), [RUNNING]);
    assert_eq!(skill.tick(), [RUNNING]);
    assert_eq!(skill.halt(), [HALTED]);
    assert_eq!(skill.halt(), [HALTED]);
    assert_eq!(skill.tick(), [RUNNING]);
}

fn under_way() -> Conversation {
    let mut skill = Conversation::with("GoToDestination");
    assert_eq!(skill.tick(), [START]);
    assert_eq!(skill.reply("Navigation", ok_state("running")), [RUNNING]);
    skill
}

#[test]
fn go_to_starts_once_and_asks_once_per_tick() {
    let mut skill = under_way();
    for _ in 0..3 {
        assert_eq!(skill.tick(), [STATUS]);
        assert_eq!(skill.reply("Navigation", ok_state("running")), [RUNNING]);
    }
    assert_eq!(skill.tick(), [STATUS]);
    assert_eq!(skill.reply("Navigation", ok_state("success")), [SUCCESS]);
    assert_eq!(skill.tick(), [START], "a trip that has ended is started again");
}

#[test]
fn go_to_succeeds_if_the_robot_is_there_already() {
    let mut skill = Conversation::with("GoToDestination");
    skill.tick();
    assert_eq!(skill.reply("Navigation", ok_state("success")), [SUCCESS]);
}

#[test]
fn go_to_fails_when_the_trip_fails_or_is_lost_and_tries_again() {
    for state in ["failure", "stopped", "idle"] {
        let mut skill = under_way();
        skill.tick();
        assert_eq!(skill.reply("Navigation", ok_state(state)), [FAILURE], "{state}");
        assert_eq!(skill.tick(), [START], "{state}");
    }
}

#[test]
fn go_to_cancels_the_trip_when_navigation_reports_an_error() {
    let mut skill = under_way();
    skill.tick();
    let mut sent = skill.reply("Navigation", error("lost"));
    sent.sort();
    assert_eq!(sent, [FAILURE, STOP]);
    assert!(skill.reply("Navigation", ok_state("stopped")).is_empty());
    assert_eq!(skill.tick(), [START]);
}

#[test]
fn go_to_cancels_the_trip_when_navigation_is_silent() {
    let mut skill = Conversation::with("GoToDestination");
    skill.tick();
    let late = skill.last_request("Navigation");
    let mut sent = skill.at_ms(500);
    sent.sort();
    assert_eq!(sent, [FAILURE, STOP]);
    skill.deliver("Navigation", ok_state("running"), late);
    assert!(skill.sent().is_empty());
    assert_eq!(skill.location(), "failure");
}

#[test]
fn go_to_returns_from_a_halt_when_navigation_has_confirmed_it() {
    let mut skill = under_way();
    assert_eq!(skill.halt(), [STOP]);
    assert_eq!(skill.location(), "halting");
    assert_eq!(skill.reply("Navigation", ok_state("stopped")), [HALTED]);
    assert_eq!(skill.location(), "halted");
    assert_eq!(skill.tick(), [START]);
}

#[test]
fn go_to_returns_from_a_halt_when_navigation_is_silent() {
    let mut skill = under_way();
    skill.halt();
    assert!(skill.at_ms(499).is_empty());
    assert_eq!(skill.at_ms(500), [HALTED]);
}

#[test]
fn go_to_drops_a_running_status_of_a_halted_trip() {
    let mut skill = under_way();
    skill.tick();
    let status = skill.last_request("Navigation");
    assert_eq!(skill.halt(), [STOP]);
    skill.deliver("Navigation", ok_state("running"), status);
    assert!(skill.sent().is_empty());
    assert_eq!(skill.reply("Navigation", ok_state("stopped")), [HALTED]);
}

#[test]
fn go_to_has_nothing_to_stop_before_the_first_tick() {
    assert_eq!(Conversation::with("GoToDestination").halt(), [HALTED]);
}

#[test]
fn the_place_can_be_set() {
    let mut skill = Conversation::with_parameters("GoToDestination", &[("place", "RechargingStation".into())]);
    assert_eq!(skill.tick(), ["Navigation [<start_navigation>, <RechargingStation>]"]);
}

#[test]
fn states_are_values() {
    let mut one = under_way();
    let mut other = one.clone();
    assert_eq!(one.process, other.process);
    one.tick();
    assert_ne!(one.process, other.process);
    other.tick();
    assert_eq!(one.process, other.process);
    let hash = |skill: &Conversation| {
        let mut hasher = std::hash::DefaultHasher::new();
        channels::ProcessState::hash_state(&skill.process, &mut hasher);
        std::hash::Hasher::finish(&hasher)
    };
    assert_eq!(hash(&one), hash(&other));
}

/// Things that can happen to a skill.
#[derive(Clone, Debug)]
enum Happening {
    Call(&'static str),
    Reply(Message),
    Stale(Message),
    Time(u64),
}

fn happening() -> impl Strategy<Value = Happening> {
    let message = prop_oneof![
        any::<bool>().prop_map(ok),
        (0.0..100.0).prop_map(ok),
        prop::sample::select(vec!["running", "success", "failure", "stopped", "idle"]).prop_map(ok_state),
        Just(error("why")),
    ];
    prop_oneof![
        3 => prop::sample::select(vec!["tick", "tick", "halt"]).prop_map(Happening::Call),
        3 => message.clone().prop_map(Happening::Reply),
        1 => message.prop_map(Happening::Stale),
        1 => (0_u64..700).prop_map(Happening::Time),
    ]
}

proptest! {
    /// Whatever the partners do, a call is answered exactly once, at the latest when the timeout is over.
    #[test]
    fn every_call_is_answered_exactly_once(
        leaf in 0..SHIPPED.len(),
        happenings in prop::collection::vec(happening(), 0..40),
    ) {
        let leaf = SHIPPED[leaf].0;
        let mut skill = Conversation::with(leaf);
        let component = match leaf {
            "WaitForUser" => None,
            name if name.starts_with("Battery") => Some("BatteryReader"),
            name if name.starts_with("At") => Some("Localization"),
            _ => Some("Navigation"),
        };
        let topology = crate::conversation::topology();
        let fits = |message: &Message| component.is_some_and(|from| {
            topology.carries(topology.find_channel(from, leaf).unwrap(), message)
        });
        let (mut now, mut waiting, mut asked) = (0, false, false);
        for happening in happenings {
            let sent = match happening {
                // The tree calls again only after it was answered.
                Happening::Call(_) if waiting => continue,
                Happening::Call(what) => {
                    waiting = true;
                    if what == "tick" { skill.tick() } else { skill.halt() }
                }
                Happening::Reply(message) if asked && fits(&message) => skill.reply(component.unwrap(), message),
                Happening::Stale(message) if fits(&message) => {
                    skill.deliver(component.unwrap(), message, RequestNumber(999_999));
                    skill.sent()
                }
                Happening::Time(passed) => {
                    now += passed;
                    skill.at_ms(now)
                }
                Happening::Reply(_) | Happening::Stale(_) => continue,
            };
            asked |= sent.iter().any(|line| !line.starts_with("BT "));
            let answers = sent.iter().filter(|line| line.starts_with("BT ")).count();
            prop_assert!(answers <= usize::from(waiting), "{sent:?}");
            waiting &= answers == 0;
        }
        let last = skill.at_ms(now + 500);
        let answers = last.iter().filter(|line| line.starts_with("BT ")).count();
        prop_assert_eq!(answers, usize::from(waiting));
        let went_wrong = skill.process.take_notes().into_iter().any(|note| !matches!(note, Note::Log { .. }));
        prop_assert!(!went_wrong);
    }
}

#[test]
fn numbers_and_texts_in_parameters_are_used_unchanged() {
    let skill = Conversation::with_parameters("BatteryLevel", &[("threshold", Datum::from(12.5))]);
    assert_eq!(skill.process.machine().datum("threshold"), Some(&12.5.into()));
}
