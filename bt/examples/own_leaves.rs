//! Ticks a tree with your own leaves: `cargo run --example own_leaves`.
//!
//! A robot pushes a door open and drives through it. On its way the door falls shut once: the drive is halted, and the
//! robot opens the door again.

use std::sync::Arc;
use std::time::Duration;

use bt::{Execution, Leaf, Leaves, Status, Tree, Value};

/// In the format of BehaviorTree.CPP and Groot. The tree is reactive: it checks the door at every tick.
const TREE: &str = r#"
<root BTCPP_format="4">
  <BehaviorTree ID="PassDoor">
    <ReactiveSequence>
      <ReactiveFallback>
        <IsDoorOpen/>
        <OpenDoor/>
      </ReactiveFallback>
      <DriveThrough way_m="2.0"/>
    </ReactiveSequence>
  </BehaviorTree>
  <TreeNodesModel>
    <Condition ID="IsDoorOpen"/>
    <Action ID="OpenDoor"/>
    <Action ID="DriveThrough"><input_port name="way_m" type="double"/></Action>
  </TreeNodesModel>
</root>"#;

/// The robot and its door. Replace this with the code that runs your leaves.
#[derive(Default)]
struct Robot {
    is_pushing: bool,
    is_door_open: bool,
    driven_m: f64,
}

impl Leaves for Robot {
    fn tick(&mut self, leaf: Leaf<'_>) -> Status {
        match leaf.node().type_id() {
            "IsDoorOpen" if self.is_door_open => Status::Success,
            "IsDoorOpen" => Status::Failure,
            "OpenDoor" if self.is_pushing => {
                (self.is_pushing, self.is_door_open) = (false, true);
                Status::Success
            }
            "OpenDoor" => {
                self.is_pushing = true;
                Status::Running
            }
            "DriveThrough" => {
                self.driven_m += 0.5;
                match leaf.input("way_m") {
                    Ok(Value::Real(way_m)) if self.driven_m < way_m => Status::Running,
                    Ok(_) => Status::Success,
                    Err(_) => Status::Failure,
                }
            }
            _ => Status::Failure,
        }
    }

    fn halt(&mut self, leaf: Leaf<'_>) {
        // A real robot stops its motors here. Only `DriveThrough` is ever halted: `OpenDoor` always finishes.
        assert_eq!(leaf.node().type_id(), "DriveThrough");
    }
}

#[expect(clippy::print_stdout, reason = "an example that prints to the terminal")]
fn main() -> Result<(), bt::TreeError> {
    let tree = Arc::new(Tree::from_xml("pass_door.xml", TREE)?);
    let mut execution = Execution::new(Arc::clone(&tree));
    let mut robot = Robot::default();
    for tick in 1.. {
        if tick == 4 {
            robot.is_door_open = false;
        }
        let status = execution.tick(Duration::from_secs(tick), &mut robot);
        let states = execution.states();
        let reached = tree.leaves().filter_map(|leaf| {
            let outcome = states[leaf.id().index()].outcome?;
            Some(format!("{} {outcome}", leaf.label()))
        });
        println!("tick {tick}: {:8} {}", status.name(), reached.collect::<Vec<_>>().join(", "));
        if status != Status::Running {
            break;
        }
    }
    Ok(())
}
