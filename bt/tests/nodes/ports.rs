//! The ports of leaves.

use std::sync::Arc;

use bt::{Execution, Leaf, Leaves, PortError, Status, Tree, Value};

use crate::NOW;
use crate::stage::shown;

/// A leaf that does what a closure says.
struct Doing<F>(F);

impl<F: FnMut(&mut Leaf<'_>) -> Status> Leaves for Doing<F> {
    fn tick(&mut self, mut leaf: Leaf<'_>) -> Status {
        (self.0)(&mut leaf)
    }

    fn halt(&mut self, _: Leaf<'_>) {}
}

const MODEL: &str = r#"<TreeNodesModel><Action ID="Go">
    <input_port name="goal" type="std::string" default="home">where to</input_port>
    <input_port name="speed" type="double" default="{speed}"/>
    <inout_port name="tries" type="int"/>
    <output_port name="found" type="bool"/>
</Action></TreeNodesModel>"#;

fn execution(leaf: &str) -> Execution {
    let text = format!(r#"<root BTCPP_format="4"><BehaviorTree ID="T">{leaf}</BehaviorTree>{MODEL}</root>"#);
    Execution::new(Arc::new(Tree::from_xml("ports.xml", &text).unwrap_or_else(|error| panic!("{error:?}"))))
}

/// The value or error when the leaf reads a port in a tick.
fn read(execution: &mut Execution, port: &str) -> Result<String, PortError> {
    let mut seen = None;
    execution.tick(
        NOW,
        &mut Doing(|leaf: &mut Leaf<'_>| {
            seen = Some(leaf.input(port));
            Status::Success
        }),
    );
    seen.unwrap().map(|value| shown(Some(&value)))
}

/// The result of writing a port in a tick.
fn write(execution: &mut Execution, port: &str, value: Value) -> Result<(), PortError> {
    let mut done = None;
    execution.tick(
        NOW,
        &mut Doing(|leaf: &mut Leaf<'_>| {
            done = Some(leaf.output(port, value.clone()));
            Status::Success
        }),
    );
    done.unwrap()
}

#[test]
fn a_constant_is_read_with_its_type() {
    let mut declared = execution(r#"<Go goal="7" tries="7"/>"#);
    assert_eq!(read(&mut declared, "goal").unwrap(), "'7'");
    assert_eq!(read(&mut declared, "tries").unwrap(), "7");
    let mut undeclared = execution(r#"<Action ID="Come" tries="7"/>"#);
    assert_eq!(read(&mut undeclared, "tries").unwrap(), "'7'", "an undeclared port is a string");
}

#[test]
fn an_omitted_port_has_its_default() {
    let mut execution = execution("<Go/>");
    assert_eq!(read(&mut execution, "goal").unwrap(), "'home'");
    execution.blackboard_mut().set("speed", 2).unwrap();
    assert_eq!(read(&mut execution, "speed").unwrap(), "2.0");
}

#[test]
fn a_port_reads_and_writes_an_entry() {
    let mut execution = execution(r#"<Go tries="{n}" found="{=}"/>"#);
    assert_eq!(
        read(&mut execution, "tries").unwrap_err().to_string(),
        "the port `tries` of `Go`: the entry `n` has no value"
    );
    write(&mut execution, "tries", Value::Int(3)).unwrap();
    write(&mut execution, "found", true.into()).unwrap();
    assert_eq!(read(&mut execution, "tries").unwrap(), "3");
    assert_eq!(shown(execution.blackboard().get("n")), "3");
    assert_eq!(shown(execution.blackboard().get("found")), "1", "the entry has the port's name");
}

#[test]
fn an_entry_of_another_kind_is_read_with_the_ports_type() {
    let mut execution = execution(r#"<Go goal="{x}" tries="{y}"/>"#);
    execution.blackboard_mut().set("y", "12").unwrap();
    assert_eq!(read(&mut execution, "tries").unwrap(), "12");
    execution.blackboard_mut().set("x", "there").unwrap();
    assert_eq!(read(&mut execution, "goal").unwrap(), "'there'");
}

#[test]
fn a_port_that_does_not_exist_is_an_error() {
    let mut execution = execution("<Go/>");
    assert_eq!(read(&mut execution, "gaol").unwrap_err().to_string(), "`Go` has no port `gaol`");
    assert!(matches!(write(&mut execution, "gaol", Value::Int(1)), Err(PortError::Missing { .. })));
}

#[test]
fn a_constant_cannot_be_written() {
    let mut execution = execution(r#"<Go tries="3"/>"#);
    let error = write(&mut execution, "tries", Value::Int(1)).unwrap_err();
    assert_eq!(error.to_string(), "the port `tries` of `Go` is not connected to a blackboard entry");
}

#[test]
fn a_value_of_another_type_cannot_be_written() {
    let mut execution = execution(r#"<Go tries="{n}"/>"#);
    assert!(matches!(write(&mut execution, "tries", Value::Real(1.5)), Err(PortError::Value { .. })));
    write(&mut execution, "tries", Value::Real(2.0)).unwrap();
    assert_eq!(shown(execution.blackboard().get("n")), "2");
}

#[test]
fn a_leaf_can_write_when_it_is_halted() {
    struct Goodbye;
    impl Leaves for Goodbye {
        fn tick(&mut self, _: Leaf<'_>) -> Status {
            Status::Running
        }
        fn halt(&mut self, mut leaf: Leaf<'_>) {
            leaf.output("tries", 99).unwrap();
        }
    }
    let mut execution = execution(r#"<Go tries="{n}"/>"#);
    execution.tick(NOW, &mut Goodbye);
    execution.halt(NOW, &mut Goodbye);
    assert_eq!(shown(execution.blackboard().get("n")), "99");
}

#[test]
fn a_leaf_knows_the_time() {
    let mut execution = execution("<Go/>");
    let now = std::time::Duration::from_millis(1234);
    execution.tick(
        now,
        &mut Doing(|leaf: &mut Leaf<'_>| {
            assert_eq!(leaf.now(), now);
            assert_eq!(leaf.node().type_id(), "Go");
            Status::Success
        }),
    );
}

/// The faults of a tree with a leaf that writes this value to the entry `x`, of this type, and then this script.
fn faults_of(of: &str, value: impl Into<Value>, code: &str) -> Vec<String> {
    let text = format!(
        "<root BTCPP_format=\"4\"><BehaviorTree ID=\"T\"><Sequence><Find out=\"{{x}}\"/><Script code=\"{code}\"/></Sequence>\
         </BehaviorTree><TreeNodesModel><Action ID=\"Find\"><output_port name=\"out\" type=\"{of}\"/></Action></TreeNodesModel></root>"
    );
    let tree = Tree::from_xml("tree.xml", &text).unwrap();
    let (mut execution, value) = (Execution::new(Arc::new(tree)), value.into());
    let mut find =
        Doing(|leaf: &mut Leaf<'_>| leaf.output("out", value.clone()).map_or(Status::Failure, |()| Status::Success));
    execution.tick(NOW, &mut find);
    execution.faults().iter().map(|fault| fault.message.clone()).collect()
}

#[test]
fn a_script_only_copies_the_value_of_a_custom_type() {
    for code in ["y := x == 'a'", "y := x + 'a'", "y := x .. 'a'", "x += 'a'", "y := x ? 1 : 2", "y := -x"] {
        let faults = faults_of("Pose2D", "1;2", code);
        assert_eq!(faults, ["a script can only copy the entry `x`, which holds a Pose2D"], "{code}");
    }
    assert!(faults_of("Pose2D", "1;2", "y := x").is_empty());
    assert!(faults_of("std::string", "1;2", "y := x == 'a'").is_empty());
}

#[test]
fn only_an_unsigned_integer_of_64_bits_stays_at_least_zero_in_a_script() {
    assert_eq!(faults_of("uint64_t", 3, "x -= 5"), ["the entry `x` holds `3` and cannot take `-2.000000`"]);
    assert!(faults_of("uint32_t", 3, "x -= 5").is_empty());
}
