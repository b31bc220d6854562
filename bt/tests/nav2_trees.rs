//! Trees in the style of Nav2's, whose leaves only Nav2's model declares; and Nav2's own trees, if there is a checkout.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use bt::{
    Direction, Execution, Kind, LeafBehavior, Loader, Rehearsal, RehearsedTick, Status, Tree, Type, Value, table,
};

use crate::forest::{Cast, Script};
use crate::processes::{Form, Stage, calls};

const DELIVER: &str = include_str!("nav2/deliver.xml");
const FOLLOW: &str = include_str!("nav2/follow.xml");

fn load(text: &str) -> Arc<Tree> {
    let tree = Tree::from_xml("tree.xml", text).unwrap_or_else(|error| panic!("{error:?}"));
    assert!(tree.concerns().is_none(), "{:?}", tree.concerns());
    Arc::new(tree)
}

/// Rehearses a tree, half a second per tick; a leaf without a behavior succeeds.
fn rehearse(tree: &Arc<Tree>, behaviors: &[(&str, &str)], ticks: u32) -> Vec<RehearsedTick> {
    let behaviors = tree.leaves().map(|leaf| {
        let behavior = behaviors.iter().find(|(name, _)| *name == leaf.process()).map_or("S", |(_, behavior)| behavior);
        LeafBehavior::new(behavior.split(' ').map(|letter| crate::stage::status(letter).into()))
    });
    let mut rehearsal = Rehearsal::new(Arc::clone(tree), behaviors);
    (0..ticks).map(|tick| rehearsal.tick(tick * Duration::from_millis(500))).collect()
}

#[test]
fn a_tree_without_a_model_replans_and_recovers() {
    let tree = load(DELIVER);
    let behaviors =
        [("FollowPath", "R R R F R S"), ("ComputePathToPose", "S F S"), ("GoalUpdated", "F"), ("Spin", "R S")];
    insta::assert_snapshot!("nav2_deliver", table(&tree, &rehearse(&tree, &behaviors, 7)));
}

#[test]
fn leaves_have_the_ports_of_nav2_s_model() {
    let tree = load(DELIVER);
    let leaf = |name: &str| tree.leaves().find(|leaf| leaf.process() == name).unwrap();
    assert_eq!(leaf("GoalUpdated").kind(), Kind::Condition);
    let port = |leaf: &str, port: &str| {
        let id = tree.leaves().find(|node| node.process() == leaf).unwrap().id();
        tree.ports(id).find(|found| found.name == port).unwrap()
    };
    let path = port("ComputePathToPose", "path");
    assert_eq!((path.direction, path.of), (Direction::Output, &Type::named("nav_msgs::msg::Path")));
    assert_eq!(port("Wait", "wait_duration").source, bt::Source::Constant(&Value::Real(5.0)));
    assert_eq!(port("BackUp", "time_allowance").source, bt::Source::Constant(&Value::Real(10.0)));
    assert_eq!(port("GoalUpdated", "goal").source, bt::Source::Entry("goal"));
}

#[test]
fn a_tree_of_version_3_reads_where_the_robot_is() {
    let tree = load(FOLLOW);
    let script = Script::from(
        [("ComputePathToPose", Status::Success), ("TruncatePath", Status::Success), ("FollowPath", Status::Running)]
            .map(|(leaf, status)| (leaf.to_owned(), vec![status])),
    );
    let mut cast = Cast::new(&tree, &script);
    let mut execution = Execution::new(Arc::clone(&tree));
    let mut plans = Vec::new();
    for tick in 0..8 {
        execution.blackboard_mut().set("robot_pose", &*format!("{};0", 0.4 * f64::from(tick))).unwrap();
        execution.blackboard_mut().set("goal", "kitchen").unwrap();
        execution.tick(Duration::ZERO, &mut cast);
        let plan = tree.leaves().find(|leaf| leaf.type_id() == "ComputePathToPose").unwrap().id();
        plans.push(execution.states()[plan.index()].outcome.is_some());
    }
    assert_eq!(plans, [true, false, false, true, false, false, true, false]);
    assert_eq!(execution.blackboard().get("updated_goal"), Some(&Value::from("kitchen")));
}

#[test]
fn what_a_file_declares_takes_precedence_over_nav2_s_model() {
    let with = |model: &str| {
        format!("<root BTCPP_format=\"4\"><BehaviorTree ID=\"T\"><Wait seconds=\"5\"/></BehaviorTree>{model}</root>")
    };
    let own = with(r#"<TreeNodesModel><Condition ID="Wait"><input_port name="seconds"/></Condition></TreeNodesModel>"#);
    assert_eq!(load(&own).nodes()[0].kind(), Kind::Condition);
    let tree = Loader::default().leaves(["Wait"]).load("t.xml", &with("")).unwrap();
    assert_eq!(tree.nodes()[0].kind(), Kind::Action);
    let error = Tree::from_xml("t.xml", &with("")).unwrap_err();
    let [problem] = error.problems() else { panic!("{error:?}") };
    assert_eq!(problem.message(), "Wait has no port `seconds`");
    let help =
        "in Nav2's model, its ports are `wait_duration`, `server_name`, `server_timeout`, `error_code_id`, `error_msg`";
    assert_eq!(miette::Diagnostic::help(problem).unwrap().to_string(), help);
}

#[test]
fn a_tree_is_written_with_the_models_of_all_its_nodes() {
    for text in [DELIVER, FOLLOW] {
        let tree = load(text);
        let written = tree.to_xml();
        assert_eq!(load(&written).to_string(), tree.to_string());
        assert_eq!(load(&written).to_xml(), written);
        for model in [r#"<Control ID="PipelineSequence"/>"#, r#"<Action ID="FollowPath" editable="true">"#] {
            assert!(written.contains(model), "{written}");
        }
    }
}

#[test]
fn nav2_s_own_trees_load_and_tick_in_all_forms() {
    let Some(checkout) = std::env::var_os("STEWARD_NAV2") else {
        println!("not run here: STEWARD_NAV2 names no checkout of ros-navigation/navigation2");
        return;
    };
    let mut files = Vec::new();
    find_trees(Path::new(&checkout), &mut files);
    files.sort();
    assert!(!files.is_empty(), "there are no trees");
    let refused: Vec<String> = files.iter().filter_map(|file| try_tree(file).err()).collect();
    assert!(refused.is_empty(), "{}", refused.join("\n"));
}

/// All trees of Nav2's navigator.
fn find_trees(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            find_trees(&path, files);
        } else if folder.ends_with("nav2_bt_navigator/behavior_trees")
            && path.extension().is_some_and(|extension| extension == "xml")
        {
            files.push(path);
        }
    }
}

/// Ticks a tree with two casts in all its forms, and prints the outcome.
fn try_tree(file: &Path) -> Result<(), String> {
    let tree = match Loader::default().load_file(file) {
        Ok(tree) => Arc::new(tree),
        Err(error) => return Err(format!("{}: {error:?}", file.display())),
    };
    let casts = [("S", "R R S"), ("F S F", "R F S S")].map(|(conditions, actions)| {
        let answers = |letters: &str| letters.split(' ').map(crate::stage::status).collect::<Vec<_>>();
        let of = |kind| if kind == Kind::Condition { answers(conditions) } else { answers(actions) };
        tree.leaves().map(|leaf| (leaf.type_id().to_owned(), of(leaf.kind()))).collect::<Script>()
    });
    let mut columns = Vec::new();
    for (script, seed) in casts.iter().zip([1, 2]) {
        let mut cast = Cast::of_processes(&tree, script);
        let mut execution = Execution::new(Arc::clone(&tree));
        let mut systems = [Form::Whole, Form::Nodes].map(|form| Stage::new(&tree, form, script, 0, seed));
        let mut answers = String::new();
        for tick in 0..40 {
            let (now, made) = (Duration::from_millis(100 * tick), cast.calls().len());
            let pose = format!("{};0", 0.1 * tick as f64);
            let entries = [("robot_pose", &*pose), ("goal", "1;1"), ("goals", "1;1"), ("path", "0;0;1;1")];
            let mut boards: Vec<&mut bt::Blackboard> = systems
                .iter_mut()
                .filter_map(|system| bt::blackboard_in_mut(&mut system.system, system.bt))
                .chain([execution.blackboard_mut()])
                .collect();
            for (key, value) in entries {
                boards.iter_mut().for_each(|board| board.set(key, value).unwrap());
            }
            let status = execution.tick(now, &mut cast);
            answers += &status.name()[..1];
            for system in &mut systems {
                system.system.advance(now);
                let messages = system.tick();
                if calls(&messages) != cast.calls()[made..] || system.states() != execution.states() {
                    return Err(format!("{}: its forms differ at tick {tick}", file.display()));
                }
            }
            if let Some(fault) = execution.faults().first() {
                return Err(format!("{}: {}", file.display(), fault.message));
            }
        }
        columns.push(answers);
    }
    let reached = tree.nodes().len();
    eprintln!("{}: {reached} nodes, {} leaves: {}", file.display(), tree.leaves().count(), columns.join(" "));
    Ok(())
}
