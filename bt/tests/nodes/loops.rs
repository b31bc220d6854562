//! LoopInt, LoopBool, LoopDouble and LoopString.

use bt::{Execution, Status, Value};

use crate::NOW;
use crate::stage::{Script, behaviors, play_with, tree};

behaviors! {
    loop_int_takes_one_thing_a_tick: r#"<LoopInt queue="1;2" value="{x}"><a/></LoopInt>"# => [
        "a=S -> R | x=1",
        "a=S -> R | x=2",
        "-> S | x=2",
    ];
    loop_waits_for_its_child: r#"<LoopInt queue="1;2" value="{x}"><a/></LoopInt>"# => [
        "a=R -> R | x=1",
        "a=S -> R | x=1",
        "a=S -> R | x=2",
        "-> S",
    ];
    loop_fails_with_its_child_and_starts_over: r#"<LoopInt queue="1;2" value="{x}"><a/></LoopInt>"# => [
        "a=S -> R | x=1",
        "a=F -> F | x=2",
        "a=S -> R | x=1",
    ];
    loop_starts_over_after_a_halt: r#"<LoopInt queue="1;2" value="{x}"><a/></LoopInt>"# => [
        "a=S -> R | x=1",
        "halt tree:",
        "a=S -> R | x=1",
    ];
    loop_starts_over_after_its_end: r#"<LoopInt queue="7" value="{x}"><a/></LoopInt>"# => ["a=S -> R", "-> S", "a=S -> R | x=7"];
    loop_takes_the_next_thing_when_its_child_is_skipped: r#"<LoopInt queue="1;2" value="{x}"><a/></LoopInt>"# => [
        "a=K -> R | x=1",
        "a=S -> R | x=2",
    ];
    loop_over_nothing_succeeds: r#"<LoopInt queue="" value="{x}"><a/></LoopInt>"# => ["-> S | x=-"];
    loop_over_nothing_answers_what_it_is_told_to: r#"<LoopInt queue="" value="{x}" if_empty="FAILURE"><a/></LoopInt>"# => ["-> F"];
    loop_over_nothing_can_be_skipped: r#"<Fallback><LoopInt queue="" if_empty="SKIPPED"><a/></LoopInt><b/></Fallback>"# => ["b=S -> S"];
    loop_string_takes_texts: r#"<LoopString queue="home;away" value="{x}"><a/></LoopString>"# => ["a=S -> R | x='home'", "a=S -> R | x='away'"];
    loop_double_takes_real_numbers: r#"<LoopDouble queue="1.5;2" value="{x}"><a/></LoopDouble>"# => ["a=S -> R | x=1.5", "a=S -> R | x=2.0"];
    loop_bool_takes_truth_values: r#"<LoopBool queue="true;0" value="{x}"><a/></LoopBool>"# => ["a=S -> R | x=1", "a=S -> R | x=0"];
    loop_goes_through_a_copy_of_a_text_on_the_blackboard:
        r#"<Sequence><RunOnce><Script code="q := '1;2'"/></RunOnce><LoopInt queue="{q}" value="{x}"><a/></LoopInt></Sequence>"# => [
            "a=S -> R | x=1 q='1;2'",
            "a=S -> R | x=2",
            "-> S | q='1;2'",
        ];
    loop_does_without_a_place_for_the_value: r#"<LoopInt queue="1"><a/></LoopInt>"# => ["a=S -> R", "-> S"];
}

#[test]
fn loop_removes_items_from_a_list_on_the_blackboard() {
    let mut execution = Execution::new(tree(r#"<LoopInt queue="{q}" value="{x}"><a/></LoopInt>"#));
    execution.blackboard_mut().set("q", [1, 2].into_iter().map(Value::Int).collect::<Value>()).unwrap();
    play_with(&mut execution, &["a=S -> R | x=1 q=2", "a=S -> R | x=2", "-> S"]);
    execution.blackboard_mut().set("q", [9].into_iter().map(Value::Int).collect::<Value>()).unwrap();
    play_with(&mut execution, &["a=S -> R | x=9"]);
}

#[test]
fn loop_over_something_other_than_a_queue_is_a_fault() {
    for (queue, text) in [("{q}", "3"), ("{q}", "1;two")] {
        let tree = tree(&format!(r#"<LoopInt queue="{queue}" value="{{x}}"><a/></LoopInt>"#));
        let mut execution = Execution::new(tree.clone());
        if text == "3" {
            execution.blackboard_mut().set("q", 3).unwrap();
        } else {
            execution.blackboard_mut().set("q", text).unwrap();
        }
        assert_eq!(execution.tick(NOW, &mut Script::new(&tree, "")), Status::Failure);
        assert_eq!(execution.faults().len(), 1);
    }
}
