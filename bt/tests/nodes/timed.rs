//! Delay, Timeout and Sleep, in the time of the run.

use crate::stage::behaviors;

behaviors! {
    delay_returns_running_until_its_time_has_come: r#"<Delay delay_msec="100"><a/></Delay>"# => [
        "@0 -> R",
        "@99 -> R",
        "@100 a=S -> S",
    ];
    delay_ticks_its_child_until_that_is_done: r#"<Delay delay_msec="100"><a/></Delay>"# => ["@0 -> R", "@100 a=R -> R", "@300 a=S -> S"];
    delay_waits_anew_after_its_child_is_done: r#"<Delay delay_msec="100"><a/></Delay>"# => [
        "@0 -> R",
        "@100 a=F -> F",
        "@120 -> R",
        "@219 -> R",
        "@220 a=S -> S",
    ];
    delay_waits_anew_after_a_halt: r#"<Delay delay_msec="100"><a/></Delay>"# => [
        "@0 -> R",
        "@90 halt tree:",
        "@100 -> R",
        "@199 -> R",
        "@200 a=S -> S",
    ];
    delay_halts_its_child: r#"<Delay delay_msec="10"><a/></Delay>"# => ["@0 -> R", "@10 a=R -> R", "halt tree: a=halt"];
    delay_of_no_time_does_not_wait: r#"<Delay delay_msec="0"><a/></Delay>"# => ["a=S -> S"];
    delay_reads_its_time_when_it_begins:
        r#"<Sequence><RunOnce><Script code="t := 100"/></RunOnce><Delay delay_msec="{t}"><a/></Delay></Sequence>"# => [
            "@0 -> R",
            "@100 a=S -> S",
        ];
    delay_is_skipped_with_its_child: r#"<Sequence><Delay delay_msec="10"><a/></Delay><b/></Sequence>"# => ["@0 -> R", "@10 a=K b=S -> S"];

    timeout_answers_what_its_child_does: r#"<Timeout msec="100"><a/></Timeout>"# => ["a=S -> S", "a=F -> F"];
    timeout_halts_its_child_when_the_time_is_up: r#"<Timeout msec="100"><a/></Timeout>"# => [
        "@0 a=R -> R",
        "@99 a=R -> R",
        "@100 a=halt -> F",
    ];
    timeout_that_was_up_starts_anew: r#"<Timeout msec="100"><a/></Timeout>"# => [
        "@0 a=R -> R",
        "@150 a=halt -> F",
        "@200 a=R -> R",
        "@299 a=S -> S",
    ];
    timeout_starts_anew_when_its_child_is_done: r#"<Timeout msec="100"><a/></Timeout>"# => [
        "@0 a=R -> R",
        "@50 a=S -> S",
        "@60 a=R -> R",
        "@150 a=R -> R",
        "@160 a=halt -> F",
    ];
    timeout_starts_anew_after_a_halt: r#"<Timeout msec="100"><a/></Timeout>"# => [
        "@0 a=R -> R",
        "@90 halt tree: a=halt",
        "@110 a=R -> R",
        "@200 a=R -> R",
        "@210 a=halt -> F",
    ];
    timeout_of_no_time_is_no_limit: r#"<Timeout msec="0"><a/></Timeout>"# => ["@0 a=R -> R", "@100000 a=R -> R"];
    timeout_that_comes_while_its_child_is_not_running_is_spent:
        r#"<ReactiveFallback><Timeout msec="100"><a/></Timeout><b/></ReactiveFallback>"# => [
            "@0 a=K b=R -> R",
            "@150 a=R b=halt -> R",
            "@250 a=halt b=R -> R",
        ];
    timeout_halts_all_below: r#"<Timeout msec="100"><Sequence><a/><Inverter><b/></Inverter></Sequence></Timeout>"# => [
        "@0 a=S b=R -> R",
        "@100 b=halt -> F",
    ];

    sleep_succeeds_when_its_time_has_come: r#"<Sleep msec="100"/>"# => ["@0 -> R", "@99 -> R", "@100 -> S"];
    sleep_of_no_time_succeeds_at_once: r#"<Sleep msec="0"/>"# => ["-> S"];
    sleep_starts_anew_after_a_halt: r#"<Sleep msec="100"/>"# => ["@0 -> R", "@90 halt tree:", "@100 -> R", "@200 -> S"];
    sleep_starts_anew_after_its_success: r#"<Sleep msec="100"/>"# => ["@0 -> R", "@100 -> S", "@100 -> R", "@200 -> S"];
    sleep_is_halted_by_a_reactive_node: r#"<ReactiveSequence><a/><Sleep msec="100"/></ReactiveSequence>"# => [
        "@0 a=S -> R",
        "@50 a=F -> F",
        "@60 a=S -> R",
        "@159 a=S -> R",
        "@160 a=S -> S",
    ];
    sleep_reads_its_time_from_the_blackboard:
        r#"<Sequence><Script code="t := 30"/><Sleep msec="{t}"/></Sequence>"# => ["@0 -> R", "@30 -> S"];
}
