//! The blackboard, seen from outside.

use bt::{Execution, Type, Value};

use crate::stage::{behaviors, shown, tree};

behaviors! {
    an_at_sign_means_the_main_tree: r#"<Script code="@x := 1; y := @x + 1"/>"# => ["-> S | x=1 y=2.0 @x=1"];
    an_entry_keeps_the_kind_of_its_first_value: r#"<Script code="x := 1; x := 2.0; y := 1.0; y := 3"/>"# => ["-> S | x=2 y=3.0"];
    a_text_becomes_a_number_where_one_was: r#"<Script code="x := 1.5; x = '2.5'"/>"# => ["-> S | x=2.5"];
    set_blackboard_writes_an_equals_sign: r#"<SetBlackboard value="=" output_key="x"/>"# => ["-> S | x='='"];
    a_port_gives_its_entry_a_type: r#"<Sequence><Script code="n := '2'"/><Repeat num_cycles="{n}"><a/></Repeat></Sequence>"# => ["a=S a=S -> S | n=2"];
}

#[test]
fn an_entry_that_was_never_written_does_not_exist() {
    let execution = Execution::new(tree("<AlwaysSuccess/>"));
    assert_eq!(execution.blackboard().get("x"), None);
    assert_eq!(execution.blackboard().entries().count(), 0);
}

#[test]
fn entries_can_be_written_from_outside() {
    let mut execution = Execution::new(tree("<AlwaysSuccess/>"));
    let board = execution.blackboard_mut();
    board.set("x", 1).unwrap();
    board.set("@y", "a").unwrap();
    board.set("z", true).unwrap();
    let entries: Vec<(usize, String, String)> =
        board.entries().map(|(scope, key, value)| (scope, key.to_owned(), shown(Some(value)))).collect();
    let entry = |key: &str, value: &str| (0, key.to_owned(), value.to_owned());
    assert_eq!(entries, [entry("x", "1"), entry("y", "'a'"), entry("z", "1")]);
}

#[test]
fn a_typed_entry_refuses_values_of_other_types() {
    let mut execution = Execution::new(tree(r#"<Repeat num_cycles="{n}"><a/></Repeat>"#));
    let board = execution.blackboard_mut();
    assert_eq!(board.set("n", "many").unwrap_err().to_string(), "`many` is not a whole number in range");
    assert!(board.set("n", 1e12).is_err());
    board.set("n", "3").unwrap();
    assert_eq!(board.get("n"), Some(&Value::Int(3)));
}

#[test]
fn an_entry_of_a_status_takes_no_string_of_a_program() {
    let mut execution = Execution::new(tree(r#"<Precondition if="false" else="{s}"><a/></Precondition>"#));
    let error = execution.blackboard_mut().set("s", "SUCCESS").unwrap_err().to_string();
    assert!(error.contains("has the type BT::NodeStatus and cannot take a value of type std::string"), "{error}");
}

#[test]
fn a_message_about_an_integer_out_of_range_does_not_name_one_type_twice() {
    let mut execution = Execution::new(tree(r#"<Repeat num_cycles="{n}"><a/></Repeat>"#));
    let error = execution.blackboard_mut().set("n", 5_000_000_000).unwrap_err().to_string();
    assert!(error.contains("has the type int and cannot take one of a different width or range"), "{error}");
}

#[test]
fn blackboards_are_values() {
    let mut one = Execution::new(tree(r#"<Script code="x := 1"/>"#));
    let mut other = one.clone();
    assert_eq!(one, other);
    one.blackboard_mut().set("x", 1.5).unwrap();
    assert_ne!(one, other);
    other.blackboard_mut().set("x", 1.5).unwrap();
    assert_eq!(one, other);
}

#[test]
fn types_are_known_by_their_cpp_names() {
    for name in
        ["bool", "int", "unsigned int", "double", "float", "std::string", "std::vector<double>", "int64_t", "Pose2D"]
    {
        assert_eq!(Type::named(name).to_string(), name);
    }
    assert_eq!(Type::named("BT::NodeStatus"), Type::Status);
    assert_eq!(Type::named("BT::SharedQueue<int>"), Type::named("std::vector<int>"));
    assert_eq!(Type::named("float"), Type::Float);
    assert_eq!(Type::named(""), Type::Any);
}

#[test]
fn types_read_texts() {
    let read = |of: &str, text: &str| Type::named(of).parse(text).ok().map(|value| shown(Some(&value)));
    let some = |text: &str| Some(text.to_owned());
    assert_eq!(read("int", "-3"), some("-3"));
    assert_eq!((read("int", "3000000000"), read("unsigned int", "-1"), read("uint8_t", "256")), (None, None, None));
    assert_eq!((read("bool", "TRUE"), read("bool", "0"), read("bool", "yes")), (some("1"), some("0"), None));
    assert_eq!((read("double", "1e3"), read("double", "x")), (some("1000.0"), None));
    assert_eq!(read("std::vector<int>", "1;2;3"), some("1;2;3"));
    assert_eq!((read("BT::NodeStatus", "SUCCESS"), read("BT::NodeStatus", "success")), (some("'SUCCESS'"), None));
    assert_eq!(read("Pose2D", "1;2"), some("'1;2'"));
}
