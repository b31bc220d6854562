//! Nav2's control nodes and decorators, with the cases of Nav2's own tests (`nav2_behavior_tree/test/plugins` of August
//! 2026) and further ones for the rules that those leave open. Each case is played by the engine and, as far as skills
//! can play it, by both forms of the tree in a channel system.
//!
//! Not played, because it cannot happen here: a child that answers that it is idle.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use bt::{Execution, Loader, NodeState, Outcome, Request, Status, Tree, Value, blackboard_in, blackboard_in_mut};

use crate::forest::{Called, Script as Answers};
use crate::processes::{Form, Stage, calls};
use crate::stage::{Script, file, play, play_with, shown, status, tree};

/// A child that is never reset, so that the node shows what it does when it is ticked after it has succeeded or failed.
const HOLDER: &str = r#"PauseResumeController pause_service_name="pause" resume_service_name="resume""#;

/// Plays the lines with a node in a tree that never resets it; its answers are those after the arrows.
fn held(body: &str, lines: &[&str]) {
    in_all_forms(&format!("<{HOLDER}>{body}</PauseResumeController>"), 1, lines);
}

/// Plays the lines with the node as the root.
fn as_root(body: &str, lines: &[&str]) {
    in_all_forms(body, 0, lines);
}

/// A line is a tick of [`play`], with the answer of one node, or writes to the blackboard: `write goal=home`.
fn in_all_forms(body: &str, node: usize, lines: &[&str]) {
    let tree = tree(body);
    let mut players = vec![Player::Engine(Box::new(Execution::new(tree.clone())))];
    // Skills cannot be skipped, and trees in a channel system are not halted from outside.
    if !lines.iter().any(|line| line.contains("=K") || line.starts_with("halt")) {
        let forms = [Form::Whole, Form::Nodes].into_iter().zip([1, 2]);
        let stage = |(form, seed)| Player::System(Box::new(Stage::new(&tree, form, &answers(lines), 0, seed)));
        players.extend(forms.map(stage));
    }
    for (number, mut player) in players.into_iter().enumerate() {
        let mut now = Duration::ZERO;
        for line in lines {
            if let Some(writes) = line.strip_prefix("write ") {
                writes.split_whitespace().for_each(|write| player.write(write));
                continue;
            }
            let (line, entries) = line.split_once('|').map_or((*line, ""), |(line, entries)| (line, entries));
            let mut rest = line.trim();
            if let Some((time, after)) = rest.strip_prefix('@').and_then(|timed| timed.split_once(' ')) {
                now = Duration::from_millis(time.parse().unwrap());
                rest = after;
            }
            match rest.split_once("->") {
                Some((calls, expected)) => {
                    let found = player.tick(&tree, now, calls)[node].outcome;
                    let expected = Some(Outcome::Answered(status(expected.trim())));
                    assert_eq!(found, expected, "player {number}: {line}");
                }
                None => play_with(player.engine(), &[rest]),
            }
            for entry in entries.split_whitespace() {
                let (key, value) = entry.split_once('=').unwrap();
                assert_eq!(player.entry(key), value, "player {number}: {line}: {key}");
            }
        }
    }
}

/// The answers of each leaf, in the order of the lines.
fn answers(lines: &[&str]) -> Answers {
    let mut answers = Answers::from(["a", "b", "c", "d"].map(|leaf| (leaf.to_owned(), Vec::new())));
    for line in lines.iter().filter(|line| !line.starts_with("write")) {
        let calls = line.split("->").next().unwrap().split_whitespace().filter_map(|call| call.split_once('='));
        for (leaf, answer) in calls.filter(|(_, answer)| *answer != "halt") {
            answers.get_mut(leaf).unwrap().push(status(answer));
        }
    }
    answers.values_mut().filter(|answers| answers.is_empty()).for_each(|answers| answers.push(Status::Success));
    answers
}

enum Player {
    Engine(Box<Execution>),
    System(Box<Stage>),
}

impl Player {
    fn engine(&mut self) -> &mut Execution {
        match self {
            Self::Engine(execution) => execution,
            Self::System(_) => panic!("only the engine is halted from outside"),
        }
    }

    /// Ticks the tree, which makes these calls, and returns the states of its nodes.
    fn tick(&mut self, tree: &Arc<Tree>, now: Duration, expected: &str) -> Vec<NodeState> {
        match self {
            Self::Engine(execution) => {
                let mut script = Script::new(tree, expected);
                execution.tick(now, &mut script);
                assert!(script.is_over(), "not all called: {expected}");
                execution.states()
            }
            Self::System(stage) => {
                stage.system.advance(now);
                let call = |call: &str| -> Called {
                    let (leaf, answer) = call.split_once('=').unwrap();
                    (leaf.to_owned(), if answer == "halt" { Request::Halt } else { Request::Tick })
                };
                let expected: Vec<Called> = expected.split_whitespace().map(call).collect();
                assert_eq!(calls(&stage.tick()), expected);
                stage.states()
            }
        }
    }

    /// `goal=home`, `index=1`
    fn write(&mut self, entry: &str) {
        let (key, value) = entry.split_once('=').unwrap();
        let value = value.parse().map_or_else(|_| Value::from(value), Value::Int);
        let board = match self {
            Self::Engine(execution) => Some(execution.blackboard_mut()),
            Self::System(stage) => blackboard_in_mut(&mut stage.system, stage.bt),
        };
        board.unwrap().set(key, value).unwrap();
    }

    fn entry(&self, key: &str) -> String {
        shown(match self {
            Self::Engine(execution) => execution.blackboard().get(key),
            Self::System(stage) => blackboard_in(&stage.system, stage.bt).unwrap().get(key),
        })
    }
}

fn with_abc(tag: &str) -> String {
    format!("<{tag}><a/><b/><c/></{}>", tag.split(' ').next().unwrap())
}

#[test]
fn pipeline_sequence_fails_with_any_child_and_resets_all() {
    let lines = ["a=F -> F", "a=S b=F -> F", "a=S b=S c=F -> F", "a=S b=S c=R -> R", "a=F c=halt -> F"];
    held(&with_abc("PipelineSequence"), &lines);
}

#[test]
fn pipeline_sequence_ticks_earlier_children_again_and_moves_past_them_while_they_run() {
    let lines = ["a=R -> R", "a=S b=R -> R", "a=R b=S c=R -> R", "a=R b=S c=S a=halt -> S"];
    held(&with_abc("PipelineSequence"), &lines);
}

#[test]
fn pipeline_sequence_passes_over_skipped_children() {
    let lines = ["a=K b=S c=S -> S", "a=K b=S c=F -> F", "a=K b=K c=K -> K"];
    held(&with_abc("PipelineSequence"), &lines);
}

#[test]
fn pipeline_sequence_forgets_its_position_when_it_is_halted() {
    let lines = ["a=S b=R -> R", "halt tree: b=halt", "a=R -> R", "a=S b=R -> R"];
    held(&with_abc("PipelineSequence"), &lines);
}

#[test]
fn nonblocking_sequence_fails_with_any_child_and_resets_all() {
    let lines = ["a=F -> F", "a=S b=F -> F", "a=S b=S c=F -> F", "a=S b=S c=R -> R", "a=F c=halt -> F"];
    held(&with_abc("NonblockingSequence"), &lines);
}

#[test]
fn nonblocking_sequence_succeeds_when_all_children_succeed_in_one_tick() {
    let lines = [
        "a=R b=S c=R -> R",
        "a=S b=S c=R -> R",
        "a=R b=S c=S -> R",
        "a=S b=S c=S -> S",
        "a=R b=R c=F a=halt b=halt -> F",
    ];
    held(&with_abc("NonblockingSequence"), &lines);
}

#[test]
fn nonblocking_sequence_does_not_allow_a_child_to_be_skipped() {
    let tree = tree(&with_abc("NonblockingSequence"));
    let mut execution = Execution::new(tree.clone());
    assert_eq!(execution.tick(Duration::ZERO, &mut Script::new(&tree, "a=R b=K a=halt")), Status::Failure);
    assert_eq!(execution.faults()[0].message, "a child was skipped");
}

#[test]
fn persistent_sequence_keeps_its_position_on_the_blackboard() {
    as_root(
        r#"<PersistentSequence current_child_idx="{i}"><AlwaysSuccess/></PersistentSequence>"#,
        &["write i=0", "-> S | i=0"],
    );
    held(
        &with_abc(r#"PersistentSequence current_child_idx="{i}""#),
        &[
            "write i=0",
            "a=R -> R | i=0",
            "a=S b=R -> R | i=1",
            "b=F -> F | i=0",
            "write i=1",
            "b=K c=R -> R | i=2",
            "c=S -> S | i=0",
        ],
    );
}

#[test]
fn persistent_sequence_continues_where_it_was_halted() {
    held(
        &with_abc(r#"PersistentSequence current_child_idx="{i}""#),
        &["write i=0", "a=S b=R -> R | i=1", "halt tree: b=halt", "b=S c=R -> R | i=2"],
    );
}

#[test]
fn persistent_sequence_follows_its_entry() {
    held(
        &with_abc(r#"PersistentSequence current_child_idx="{i}""#),
        &[
            "write i=2",
            "c=R -> R",
            "write i=0",
            "a=S b=S c=S -> S | i=0",
            "write i=3",
            "-> S | i=0",
            "write i=7",
            "-> S | i=0",
            "write i=-1",
            "-> F",
        ],
    );
}

#[test]
fn persistent_sequence_continues_after_a_child_that_changes_the_entry() {
    let body = r#"<PersistentSequence current_child_idx="{i}"><a/><Script code="i := 0"/><b/></PersistentSequence>"#;
    as_root(body, &["write i=0", "a=S b=R -> R | i=2", "b=S -> S | i=0"]);
}

#[test]
fn persistent_sequence_needs_a_position() {
    let tree = tree(&with_abc(r#"PersistentSequence current_child_idx="{i}""#));
    let mut execution = Execution::new(tree.clone());
    assert_eq!(execution.tick(Duration::ZERO, &mut Script::new(&tree, "")), Status::Failure);
    assert_eq!(execution.faults()[0].message, "the entry `i` has no value");
}

const RECOVERY: &str = r#"<RecoveryNode number_of_retries="1"><a/><b/></RecoveryNode>"#;

#[test]
fn recovery_node_runs_while_its_child_or_the_recovery_runs() {
    held(RECOVERY, &["a=R -> R", "a=F b=R -> R", "b=R -> R", "b=S a=R -> R"]);
}

#[test]
fn recovery_node_succeeds_with_its_first_child() {
    held(RECOVERY, &["a=S -> S", "a=F b=S a=S -> S", "a=F b=S a=S -> S"]);
}

#[test]
fn recovery_node_fails_if_the_recovery_fails_or_retries_run_out() {
    held(RECOVERY, &["a=F b=F -> F", "a=F b=S a=F -> F", "a=F b=S a=R -> R", "a=F -> F"]);
    held(r#"<RecoveryNode number_of_retries="0"><a/><b/></RecoveryNode>"#, &["a=F -> F"]);
    let lines = ["a=F b=S a=F b=S a=F b=S a=F -> F"];
    held(r#"<RecoveryNode number_of_retries="3"><a/><b/></RecoveryNode>"#, &lines);
    held("<RecoveryNode><a/><b/></RecoveryNode>", &["a=F b=S a=F -> F"]);
}

#[test]
fn recovery_node_is_skipped_with_its_first_child_and_fails_if_the_recovery_is_skipped() {
    held(RECOVERY, &["a=K -> K", "a=F b=K -> F"]);
    let tree = tree(RECOVERY);
    let mut execution = Execution::new(tree.clone());
    play_with(&mut execution, &["a=R -> R", "a=K a=halt -> K"]);
    assert_eq!(execution.states()[0].status, None, "it is idle");
}

#[test]
fn recovery_node_keeps_the_count_of_retries_when_the_recovery_is_skipped() {
    held(RECOVERY, &["a=F b=S a=R -> R", "a=F -> F"]);
    let twice = r#"<RecoveryNode number_of_retries="2"><a/><b/></RecoveryNode>"#;
    held(twice, &["a=F b=S a=F b=K -> F", "a=F b=S a=F -> F", "a=F b=S a=F b=S a=F -> F"]);
}

#[test]
fn recovery_node_starts_over_after_it_was_halted() {
    held(RECOVERY, &["a=F b=S a=R -> R", "halt tree: a=halt", "a=F b=R -> R", "halt tree: b=halt", "a=F b=S a=S -> S"]);
}

#[test]
fn recovery_node_reads_the_number_of_retries_at_every_tick() {
    held(
        r#"<RecoveryNode number_of_retries="{n}"><a/><b/></RecoveryNode>"#,
        &["write n=2", "a=F b=S a=F b=S a=R -> R", "write n=1", "a=halt -> F", "a=F b=S a=F -> F"],
    );
}

const ROUND: &str = r#"RoundRobin wrap_around="true""#;

#[test]
fn round_robin_fails_when_all_children_have_failed() {
    held(&with_abc(ROUND), &["a=F b=R -> R", "b=F c=R -> R", "c=F -> F", "a=R -> R"]);
}

#[test]
fn round_robin_begins_with_the_child_after_the_one_that_succeeded() {
    let lines =
        ["a=R -> R", "a=F b=R -> R", "b=S -> S", "c=R -> R", "c=F a=R -> R", "a=F b=S -> S", "c=S -> S", "a=S -> S"];
    held(&with_abc(ROUND), &lines);
}

#[test]
fn round_robin_passes_over_skipped_children() {
    let lines = ["a=K b=S -> S", "c=F a=K b=K -> F", "a=K b=K c=K -> K"];
    held(&with_abc(ROUND), &lines);
}

#[test]
fn round_robin_starts_over_after_it_was_halted() {
    held(&with_abc(ROUND), &["a=S -> S", "b=R -> R", "halt tree: b=halt", "a=R -> R"]);
}

#[test]
fn round_robin_that_does_not_wrap_around_ends_after_its_last_child() {
    let round = r#"RoundRobin wrap_around="false""#;
    held(&with_abc(round), &["a=F b=F c=F -> F", "halt tree:", "a=K b=K c=K -> K"]);
    held(&with_abc(round), &["a=S -> S", "b=F c=R -> R", "c=F -> F", "a=S -> S"]);
    // Nav2 does this, too: the success of the last child is lost.
    held(&with_abc(round), &["a=S -> S", "b=S -> S", "c=S -> F", "a=S -> S"]);
}

#[test]
fn round_robin_wraps_around_by_default_in_files_of_version_3() {
    let round = |format: &str| {
        let text = format!("<root{format}><BehaviorTree><RoundRobin><a/><b/></RoundRobin></BehaviorTree></root>");
        let tree = Loader::default().leaves(["a", "b"]).load("round.xml", &text).unwrap();
        let concern = tree.concerns().map(|concerns| concerns.problems()[0].message().to_owned());
        play_with(&mut Execution::new(Arc::new(tree)), &["a=S -> S"]);
        concern
    };
    assert_eq!(round(""), None);
    let concern = "Nav2's RoundRobin wraps around up to Kilted, but not since Lyrical";
    assert_eq!(round(" BTCPP_format=\"4\"").as_deref(), Some(concern));
    let tree =
        Tree::from_xml("r.xml", "<root><BehaviorTree><RoundRobin><AlwaysSuccess/></RoundRobin></BehaviorTree></root>");
    assert!(tree.unwrap().to_xml().contains("<RoundRobin wrap_around=\"true\">"));
}

fn pausable(children: &str) -> String {
    format!("<{HOLDER}>{children}</PauseResumeController>")
}

#[test]
fn pause_resume_controller_without_other_children_only_stops_its_first() {
    as_root(
        &pausable("<a/>"),
        &["a=R -> R", "write pause=1", "a=halt -> R", "-> R", "write resume=1", "-> R", "a=R -> R"],
    );
}

#[test]
fn pause_resume_controller_ticks_the_child_of_its_state() {
    as_root(
        &pausable("<a/><b/><c/><d/>"),
        &[
            "a=R -> R",
            "write pause=1",
            "a=halt c=R -> R",
            "c=S -> R",
            "b=S -> R",
            "b=K -> R",
            "write pause=1",
            "b=K -> R",
            "write resume=1",
            "d=F -> F",
            "halt tree:",
            "a=R -> R",
            "a=S -> S",
            "write resume=1",
            "a=S -> S",
        ],
    );
}

#[test]
fn pause_resume_controller_resumes_after_its_last_child() {
    as_root(
        &pausable("<a/><b/><c/><d/>"),
        &[
            "a=R -> R",
            "write pause=1",
            "a=halt c=S -> R",
            "b=R -> R",
            "write resume=1 pause=1",
            "b=halt d=R -> R",
            "write pause=1",
            "d=halt c=F -> F",
            "a=R -> R",
        ],
    );
}

const RATE: &str = r#"<RateController hz="1.0"><a/></RateController>"#;

#[test]
fn rate_controller_ticks_its_child_once_per_period() {
    let mut lines = vec!["@0 a=S -> S".to_owned()];
    for half in 1..=10 {
        let answer = if half % 2 == 0 { "a=S -> S" } else { "-> R" };
        lines.push(format!("@{} {answer}", 500 * half));
    }
    held(RATE, &lines.iter().map(String::as_str).collect::<Vec<_>>());
}

#[test]
fn rate_controller_ticks_a_running_child_at_every_tick_and_counts_from_its_success() {
    held(RATE, &["@0 a=R -> R", "@100 a=R -> R", "@700 a=S -> S", "@1600 -> R", "@1700 a=F -> F", "@1800 a=F -> F"]);
}

#[test]
fn rate_controller_counts_from_the_first_tick_while_its_child_has_not_succeeded() {
    held(RATE, &["@0 a=F -> F", "@900 -> R", "@1000 a=F -> F"]);
    held(RATE, &["@0 a=K -> K", "@900 -> R", "@1000 a=S -> S"]);
}

#[test]
fn rate_controller_starts_over_when_it_is_reset() {
    as_root(RATE, &["@0 a=S -> S", "@1 a=S -> S"]);
    held(RATE, &["@0 a=S -> S", "halt tree:", "@1 a=S -> S"]);
}

#[test]
fn rate_controller_has_exact_periods() {
    let third = r#"<RateController hz="0.333"><a/></RateController>"#;
    held(third, &["@0 a=S -> S", "@3003 -> R", "@3004 a=S -> S"]);
    held("<RateController><a/></RateController>", &["@0 a=S -> S", "@99 -> R", "@100 a=S -> S"]);
    let entry = r#"<RateController hz="{hz}"><a/></RateController>"#;
    held(entry, &["write hz=2", "@0 a=S -> S", "@499 -> R", "@500 a=S -> S"]);
}

#[test]
fn a_rate_is_greater_than_0() {
    for body in
        [r#"<RateController hz="0"><a/></RateController>"#, r#"<SpeedController min_rate="-1"><a/></SpeedController>"#]
    {
        let text = format!("<root BTCPP_format=\"4\"><BehaviorTree ID=\"T\">{body}</BehaviorTree></root>");
        let error = Loader::default().leaves(["a"]).load("rate.xml", &text).unwrap_err();
        assert!(error.problems()[0].message().ends_with("is not a rate greater than 0"), "{error:?}");
    }
    let tree = tree(r#"<RateController hz="{hz}"><a/></RateController>"#);
    let mut execution = Execution::new(tree.clone());
    execution.blackboard_mut().set("hz", 0).unwrap();
    assert_eq!(execution.tick(Duration::ZERO, &mut Script::new(&tree, "")), Status::Failure);
    assert_eq!(execution.faults()[0].message, "`0` is not a rate greater than 0");
}

const DISTANCE: &str = r#"<DistanceController distance="1.0"><a/></DistanceController>"#;

#[test]
fn distance_controller_ticks_its_child_once_per_distance() {
    let mut lines = vec!["write robot_pose=0;0".to_owned(), "a=S -> S".to_owned()];
    for step in 1..=20 {
        lines.push(format!("write robot_pose={};0", f64::from(step) * 0.51));
        lines.push(if step % 2 == 0 { "a=S -> S" } else { "-> R" }.to_owned());
    }
    held(DISTANCE, &lines.iter().map(String::as_str).collect::<Vec<_>>());
}

#[test]
fn distance_controller_measures_from_where_its_child_succeeded() {
    held(
        DISTANCE,
        &[
            "write robot_pose=0;0",
            "a=R -> R",
            "write robot_pose=1;map;2;0;0;0;0;0;1",
            "a=S -> S",
            "write robot_pose=2;0.9",
            "-> R",
            "write robot_pose=2;1",
            "a=F -> F",
            "a=F -> F",
        ],
    );
}

#[test]
fn distance_controller_fails_while_the_pose_is_unknown() {
    held(DISTANCE, &["-> F", "write robot_pose=0;0", "a=S -> S", "-> R"]);
    let tree = tree(DISTANCE);
    let mut execution = Execution::new(tree.clone());
    execution.blackboard_mut().set("robot_pose", "in the kitchen").unwrap();
    assert_eq!(execution.tick(Duration::ZERO, &mut Script::new(&tree, "")), Status::Failure);
    assert_eq!(execution.faults()[0].message, "`in the kitchen` is not a pose, such as `1.5;2`");
}

const SPEED: &str =
    r#"<SpeedController min_rate="0.1" max_rate="1.0" min_speed="0.0" max_speed="0.5"><a/></SpeedController>"#;

#[test]
fn speed_controller_has_longer_periods_at_lower_speed() {
    let mut lines: Vec<String> = [
        "write robot_speed=0.223",
        "@0 a=S -> S",
        "@0 -> R",
        "@1000 a=S -> S", // the period becomes 1.994 s
        "write robot_speed=0",
        "@2000 -> R",
        "@3000 a=S -> S", // the period becomes 10 s
    ]
    .map(str::to_owned)
    .into();
    lines.extend((4..13).map(|second| format!("@{second}000 -> R")));
    lines.push("@13000 a=S -> S".to_owned());
    held(SPEED, &lines.iter().map(String::as_str).collect::<Vec<_>>());
}

#[test]
fn speed_controller_starts_over_with_a_new_goal() {
    held(
        SPEED,
        &[
            "@0 a=S -> S",
            "@1000 a=S -> S", // the robot stands still: 10 s
            "@2000 -> R",
            "write goal=there",
            "@3000 a=S -> S",
            "@4000 a=R -> R",
            "@4100 a=R -> R",
            "@4200 a=F -> F",
        ],
    );
}

#[test]
fn goal_updated_controller_ticks_its_child_when_a_goal_has_changed() {
    held(
        "<GoalUpdatedController><a/></GoalUpdatedController>",
        &[
            "write goal=g1 goals=g1;g1",
            "a=S -> S",
            "write goal=g2",
            "a=S -> S",
            "-> R",
            "write goals=g2;g2",
            "a=S -> S",
        ],
    );
}

#[test]
fn goal_updated_controller_compares_values_and_ticks_a_running_child() {
    held(
        r#"<GoalUpdatedController goal="{aim}"><a/></GoalUpdatedController>"#,
        &[
            "a=R -> R",
            "a=F -> F",
            "write goal=g1",
            "-> R",
            "write aim=g1",
            "a=R -> R",
            "a=S -> S",
            "write aim=g1",
            "-> R",
            "halt tree:",
            "a=S -> S",
        ],
    );
}

const UPDATER: &str = r#"<GoalUpdater input_goal="{goal}" input_goals="{goals}" output_goal="{new}"
    output_goals="{news}"> <AlwaysSuccess/> </GoalUpdater>"#;

#[test]
fn goal_updater_passes_the_goals_on() {
    as_root(UPDATER, &["-> S | new=- news=-", "write goal=g goals=g;g", "-> S | new='g' news='g;g'"]);
}

#[test]
fn goal_updater_ignores_updates_that_are_older_than_the_goals() {
    as_root(
        UPDATER,
        &[
            "write goal=5;map;1;0;0;0;0;0;1 goals=5;map;5;map;1;0;0;0;0;0;1",
            "write goal_update=4;map;2;0;0;0;0;0;1 goals_update=4;map;4;map;2;0;0;0;0;0;1",
            "-> S | new='5;map;1;0;0;0;0;0;1' news='5;map;5;map;1;0;0;0;0;0;1'",
            "write goal_update=0;map;2;0;0;0;0;0;1 goals_update=9;map",
            "-> S | new='5;map;1;0;0;0;0;0;1' news='5;map;5;map;1;0;0;0;0;0;1'",
        ],
    );
}

#[test]
fn goal_updater_takes_the_latest_update() {
    as_root(
        UPDATER,
        &[
            "write goal=5;map;1;0;0;0;0;0;1 goals=5;map;5;map;1;0;0;0;0;0;1",
            "write goal_update=5;map;2;0;0;0;0;0;1 goals_update=5;map;5;map;2;0;0;0;0;0;1",
            "write goal_update=6;map;3;0;0;0;0;0;1 goals_update=6;map;6;map;3;0;0;0;0;0;1",
            "-> S | new='6;map;3;0;0;0;0;0;1' news='6;map;6;map;3;0;0;0;0;0;1'",
            "write goal_update=kitchen",
            "-> S | new='kitchen'",
        ],
    );
}

#[test]
fn goal_updater_answers_as_its_child_does() {
    held("<GoalUpdater><a/></GoalUpdater>", &["a=R -> R", "a=S -> S", "a=F -> F", "a=K -> K"]);
}

/// Waypoints on a line, this far apart.
fn path(from: usize, to: usize, apart: f64) -> String {
    (from..=to).map(|point| format!("{};0", apart * point as f64)).collect::<Vec<_>>().join(";")
}

#[test]
fn path_longer_on_approach_succeeds_without_a_longer_path() {
    let body = r#"<PathLongerOnApproach path="{path}" prox_len="5.0" length_factor="2.0"><a/></PathLongerOnApproach>"#;
    held(body, &[&format!("write path={}", path(0, 9, 1.5)), "-> S"]);
}

#[test]
fn path_longer_on_approach_ticks_its_child_when_the_path_to_the_same_goal_is_longer() {
    let body = r#"<PathLongerOnApproach path="{path}" prox_len="20.0" length_factor="1.0"><a/></PathLongerOnApproach>"#;
    let old = format!("write path={}", path(1, 5, 3.0));
    let new = format!("write path={}", path(0, 10, 1.5));
    held(body, &[&old, "-> S", &new, "a=F -> F", "-> S"]);
    held(body, &[&old, "-> S", &new, "a=R -> R", "a=S -> S", "-> S"]);
    let elsewhere = format!("write path={}", path(0, 11, 1.5));
    held(body, &[&old, "-> S", &elsewhere, "-> S", &new, "-> S"]);
    // As in Nav2, the child keeps running.
    held(body, &[&old, "-> S", &new, "a=R -> R", &elsewhere, "-> S", &old, "-> S", &new, "a=S -> S"]);
}

#[test]
fn path_longer_on_approach_ignores_detours_far_from_the_goal_and_short_ones() {
    let old = format!("write path={}", path(1, 5, 3.0));
    let new = format!("write path={}", path(0, 10, 1.5));
    let far = r#"<PathLongerOnApproach path="{path}" prox_len="12" length_factor="1.0"><a/></PathLongerOnApproach>"#;
    held(far, &[&old, "-> S", &new, "-> S"]);
    let short = r#"<PathLongerOnApproach path="{path}" prox_len="20" length_factor="1.25"><a/></PathLongerOnApproach>"#;
    held(short, &[&old, "-> S", &new, "-> S"]);
}

#[test]
fn single_trigger_ticks_its_child_until_it_is_done_once() {
    held(
        "<SingleTrigger><a/></SingleTrigger>",
        &["a=S -> S", "-> F", "-> F", "halt tree:", "a=R -> R", "a=S -> S", "-> F"],
    );
    held("<SingleTrigger><a/></SingleTrigger>", &["a=K -> K", "a=R -> R", "a=F -> F", "-> F"]);
    as_root("<SingleTrigger><a/></SingleTrigger>", &["a=S -> S", "a=S -> S"]);
}

#[test]
fn wrong_numbers_of_children_and_missing_ports_are_refused() {
    let no_children = pausable("");
    let refused: BTreeMap<&str, &str> = [
        ("<RecoveryNode><a/></RecoveryNode>", "<RecoveryNode> must have two children, but has 1"),
        ("<RecoveryNode><a/><b/><c/></RecoveryNode>", "<RecoveryNode> must have two children, but has 3"),
        (&*no_children, "<PauseResumeController> must have one to four children, but has 0"),
        (
            "<PauseResumeController><a/></PauseResumeController>",
            "PauseResumeController needs the port `pause_service_name`",
        ),
        ("<PersistentSequence><a/></PersistentSequence>", "PersistentSequence needs the port `current_child_idx`"),
        (
            r#"<PersistentSequence current_child_idx="0"><a/></PersistentSequence>"#,
            "the port `current_child_idx`: it must be an entry of the blackboard",
        ),
        ("<RateController/>", "<RateController> must have exactly one child, but has 0"),
        (r#"<RateController herz="1"><a/></RateController>"#, "RateController has no port `herz`"),
    ]
    .into();
    for (body, message) in refused {
        let text = format!("<root BTCPP_format=\"4\"><BehaviorTree ID=\"T\">{body}</BehaviorTree></root>");
        let error = Loader::default().leaves(["a", "b", "c"]).load("refused.xml", &text).unwrap_err();
        assert_eq!(error.problems()[0].message(), message, "{body}");
    }
}

#[test]
fn entries_of_the_robot_are_read_from_the_main_tree() {
    let trees = r#"<BehaviorTree ID="T"><SubTree ID="S"/></BehaviorTree>
        <BehaviorTree ID="S"><DistanceController><a/></DistanceController></BehaviorTree>"#;
    let mut execution = Execution::new(file(trees));
    execution.blackboard_mut().set("robot_pose", "0;0").unwrap();
    play_with(&mut execution, &["a=R -> R"]);
}

#[test]
fn the_standard_arrangement_replans_once_per_second_while_the_robot_drives() {
    let body = r#"<PipelineSequence><RateController hz="1.0"><a/></RateController><b/></PipelineSequence>"#;
    play(body, &["@0 a=S b=R -> R", "@500 b=R -> R", "@1000 a=R b=R -> R", "@1500 a=S b=R -> R", "@2000 b=S -> S"]);
}
