//! The skills of the paper's published system: what they say, and when; what they forget, and what they do not notice.

use skills::{Chart, ORIGINAL, SkillProcess};

use crate::conversation::{Conversation, ok, ok_state, topology_with_blackboard};

const RUNNING: &str = "BT [<running>]";
const HALTED: &str = "BT [<halted>]";
const START: &str = "Navigation [<start_navigation>, <Destination>]";
const STATUS: &str = "Navigation [<get_status>, <Destination>]";
const STOP: &str = "Navigation [<stop_navigation>, <Destination>]";
const LOCK: &str = r#"Blackboard [<lock>, "GoToDestination", <navigation>]"#;
const UNLOCK: &str = r#"Blackboard [<unlock>, "GoToDestination", <navigation>]"#;
const READ: &str = r#"Blackboard [<read_data>, "GoToDestination", <navigation>]"#;
const TAKE: &str = r#"Blackboard [<write_data>, "GoToDestination", <navigation>, 0]"#;
const GIVE_BACK: &str = r#"Blackboard [<write_data>, "GoToDestination", <navigation>, 1]"#;

fn original(leaf: &str) -> Conversation {
    let (_, text) = ORIGINAL.into_iter().find(|(name, _)| *name == leaf).unwrap();
    let chart = Chart::load(leaf, text).unwrap();
    Conversation::of(SkillProcess::new(leaf, &chart, &topology_with_blackboard(), []).unwrap())
}

/// Gives the skill these answers, and checks what it says after each of them.
fn go_on<const N: usize>(skill: &mut Conversation, heard_and_sent: [(&str, channels::Message, &str); N]) {
    for (from, heard, sent) in heard_and_sent {
        assert_eq!(skill.reply(from, heard), [sent]);
    }
}

/// Lets the skill take the resource and start its trip.
fn take(skill: &mut Conversation) {
    go_on(
        skill,
        [
            ("Blackboard", ok(true), READ),
            ("Blackboard", ok(1_i64), TAKE),
            ("Blackboard", ok(true), UNLOCK),
            ("Blackboard", ok(true), START),
        ],
    );
}

/// The skill after its first tick, with its trip started 20 ms later.
fn under_way() -> Conversation {
    let mut skill = original("GoToDestination");
    assert_eq!(skill.tick(), [LOCK]);
    assert!(skill.at_ms(20).is_empty());
    take(&mut skill);
    assert!(skill.reply("Navigation", ok_state("running")).is_empty());
    assert_eq!(skill.at_ms(100), [RUNNING]);
    skill
}

/// Gives the resource back, and returns what the skill says then.
fn give_back(skill: &mut Conversation) -> Vec<String> {
    go_on(
        skill,
        [("Blackboard", ok(true), READ), ("Blackboard", ok(0_i64), GIVE_BACK), ("Blackboard", ok(true), UNLOCK)],
    );
    skill.reply("Blackboard", ok(true))
}

#[test]
fn the_machines_load_without_warnings_and_twins_differ_only_in_name_and_place() {
    let text = |leaf: &str| {
        let (_, text) = ORIGINAL.into_iter().find(|(name, _)| *name == leaf).unwrap();
        let chart = Chart::load(leaf, text).unwrap();
        assert_eq!((chart.name(), chart.warnings().len()), (leaf, 0));
        text.replace(leaf, "LEAF")
    };
    // A tag with a longer name may have more lines.
    let twin = |leaf: &str, place: &str| skills::layout(leaf, &text(leaf).replace(place, "PLACE"), None).unwrap();
    for (one, other) in [("AtRechargingStation", "AtDestination"), ("GotoRechargingStation", "GoToDestination")] {
        assert_eq!(twin(one, "'RechargingStation'"), twin(other, "'Destination'"));
    }
    for leaf in ["BatteryLevel", "BatteryNotCharging"] {
        text(leaf);
    }
}

#[test]
fn a_condition_is_checked_every_tenth_of_a_second_until_it_is_known() {
    let mut skill = original("BatteryLevel");
    for start_ms in [0, 1000] {
        assert!(skill.at_ms(start_ms).is_empty());
        assert_eq!(skill.tick(), ["BatteryReader [<get_level>]"]);
        assert!(skill.at_ms(start_ms + 100).is_empty());
        assert!(skill.reply("BatteryReader", ok(30.0)).is_empty());
        assert_eq!(skill.location(), "failure");
        assert_eq!(skill.at_ms(start_ms + 200), ["BT [<failure>]"]);
        assert_eq!(skill.location(), "idle");
    }
}

#[test]
fn go_to_asks_about_its_trip_and_tells_the_tree_its_last_answer() {
    let mut skill = under_way();
    assert_eq!(skill.at_ms(519), [""; 0]);
    assert_eq!(skill.at_ms(520), [STATUS]);
    assert_eq!(skill.tick(), [RUNNING]);
    assert!(skill.reply("Navigation", ok_state("running")).is_empty());
    assert_eq!(skill.at_ms(1020), [STATUS]);
}

#[test]
fn go_to_waits_while_another_skill_has_the_resource() {
    let mut skill = original("GoToDestination");
    skill.tick();
    let turn = [("Blackboard", ok(true), READ), ("Blackboard", ok(0_i64), UNLOCK), ("Blackboard", ok(true), LOCK)];
    go_on(&mut skill, turn);
    assert_eq!(skill.at_ms(100), [RUNNING]);
    go_on(&mut skill, [("Blackboard", ok(true), READ), ("Blackboard", ok(1_i64), TAKE)]);
}

#[test]
fn go_to_halts_navigation_before_it_gives_the_resource_back() {
    let mut skill = under_way();
    let mut sent = skill.halt();
    sent.sort();
    assert_eq!(sent, [HALTED, STOP], "the tree does not wait");
    assert_eq!(skill.reply("Navigation", ok_state("stopped")), [LOCK]);
    assert_eq!(skill.tick(), [RUNNING], "it is not idle yet");
    assert!(give_back(&mut skill).is_empty());
    assert_eq!(skill.location(), "idle");
}

#[test]
fn a_stop_during_a_call_is_noticed_when_the_call_returns() {
    let mut skill = under_way();
    assert_eq!(skill.at_ms(520), [STATUS]);
    assert_eq!(skill.halt(), [HALTED]);
    assert_eq!(skill.reply("Navigation", ok_state("running")), [STOP]);
}

/// The cause of `late_halt`.
#[test]
fn a_stop_after_the_trip_halts_navigation_although_the_resource_is_free() {
    let mut skill = under_way();
    skill.at_ms(520);
    assert_eq!(skill.reply("Navigation", ok_state("success")), [LOCK]);
    assert!(give_back(&mut skill).is_empty());
    let mut sent = skill.halt();
    sent.sort();
    assert_eq!(sent, [HALTED, STOP]);
    assert!(skill.reply("Navigation", ok_state("stopped")).is_empty());
    assert_eq!(skill.location(), "idle");
}

#[test]
fn a_stop_while_the_resource_is_given_back_halts_navigation_last() {
    let mut skill = under_way();
    skill.at_ms(520);
    assert_eq!(skill.reply("Navigation", ok_state("failure")), [LOCK]);
    assert_eq!(skill.halt(), [HALTED]);
    assert_eq!(skill.reply("Blackboard", ok(true)), [LOCK], "from the beginning");
    assert_eq!(give_back(&mut skill), [STOP]);
    assert!(skill.reply("Navigation", ok_state("stopped")).is_empty());
    assert_eq!(skill.location(), "internal_halted");
    skill.at_ms(1020);
    assert_eq!(skill.location(), "idle");
}

#[test]
fn a_stop_while_waiting_for_the_lock_is_dropped_and_the_trip_starts() {
    let mut skill = original("GoToDestination");
    skill.tick();
    assert_eq!(skill.halt(), [HALTED]);
    take(&mut skill);
}

#[test]
fn a_trip_that_has_ended_does_not_start_again_until_the_skill_is_stopped() {
    for (ended, answer) in [("success", "BT [<success>]"), ("failure", "BT [<failure>]"), ("idle", "BT [<failure>]")] {
        let mut skill = under_way();
        skill.at_ms(520);
        assert_eq!(skill.reply("Navigation", ok_state(ended)), [LOCK]);
        assert!(give_back(&mut skill).is_empty());
        for _ in 0..3 {
            assert_eq!(skill.tick(), [answer], "{ended}");
        }
        skill.halt();
        skill.reply("Navigation", ok_state("stopped"));
        assert_eq!(skill.tick(), [LOCK]);
    }
}
