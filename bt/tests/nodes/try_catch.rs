//! TryCatch.

use crate::stage::behaviors;

const PLAIN: &str = "<TryCatch><a/><b/><c/></TryCatch>";
const ON_HALT: &str =
    r#"<ReactiveFallback><f/><TryCatch catch_on_halt="true"><a/><b/><c/></TryCatch></ReactiveFallback>"#;

behaviors! {
    try_catch_succeeds_when_all_but_the_last_child_have: PLAIN => ["a=S b=S -> S"];
    try_catch_goes_on_with_the_child_that_was_running: PLAIN => ["a=S b=R -> R", "b=S -> S"];
    try_catch_ticks_its_last_child_after_a_failure_and_fails: PLAIN => ["a=F c=S -> F"];
    try_catch_fails_whatever_its_last_child_answers: PLAIN => ["a=S b=F c=F -> F", "a=F c=K -> F"];
    try_catch_waits_for_its_last_child: PLAIN => ["a=F c=R -> R", "c=R -> R", "c=S -> F", "a=S b=S -> S"];
    try_catch_passes_over_a_skipped_child: PLAIN => ["a=K b=S -> S"];
    try_catch_is_skipped_when_all_but_the_last_child_are: "<Fallback><TryCatch><a/><b/><c/></TryCatch><d/></Fallback>" => [
        "a=K b=K d=S -> S",
    ];
    try_catch_does_not_catch_a_halt_by_default: PLAIN => ["a=R -> R", "halt tree: a=halt"];
    try_catch_that_is_halted_in_its_catch_block_starts_over: PLAIN => ["a=F c=R -> R", "halt tree: c=halt", "a=S b=S -> S"];
    try_catch_with_catch_on_halt_ticks_its_last_child_when_it_is_halted: ON_HALT => ["f=F a=S b=R -> R", "f=S b=halt c=S -> S"];
    try_catch_with_catch_on_halt_halts_its_last_child_if_that_runs: ON_HALT => [
        "f=F a=R -> R",
        "f=S a=halt c=R c=halt -> S",
    ];
    try_catch_with_catch_on_halt_does_not_catch_twice: ON_HALT => ["f=F a=F c=R -> R", "f=S c=halt -> S"];
    try_catch_with_catch_on_halt_catches_when_the_tree_is_halted:
        r#"<TryCatch catch_on_halt="true"><a/><c/></TryCatch>"# => ["a=R -> R", "halt tree: a=halt c=S", "halt tree:"];
    try_catch_with_catch_on_halt_does_nothing_when_it_is_not_running:
        r#"<TryCatch catch_on_halt="true"><a/><c/></TryCatch>"# => ["a=S -> S", "halt tree:"];
    try_catch_reads_catch_on_halt_when_it_is_halted:
        r#"<Sequence><Script code="x := 0"/><TryCatch catch_on_halt="{x}"><b/><c/></TryCatch></Sequence>"# => [
            "b=R -> R",
            "halt tree: b=halt",
        ];
    try_catch_inside_another_is_halted_before_the_outer_one_catches:
        r#"<TryCatch catch_on_halt="true"><TryCatch catch_on_halt="true"><a/><b/></TryCatch><c/></TryCatch>"# => [
            "a=R -> R",
            "halt tree: a=halt b=S c=S",
        ];
    try_catch_whose_catch_block_is_a_tree_runs_it_until_it_waits:
        r#"<TryCatch catch_on_halt="true"><a/><Sequence><b/><ReactiveFallback><c/><d/></ReactiveFallback></Sequence></TryCatch>"# => [
            "a=R -> R",
            "halt tree: a=halt b=S c=F d=R d=halt",
            "a=S -> S",
        ];
}
