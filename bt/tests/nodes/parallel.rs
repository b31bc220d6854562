//! Parallel and ParallelAll.

use crate::stage::behaviors;

behaviors! {
    parallel_ticks_all_children: "<Parallel><a/><b/><c/></Parallel>" => ["a=R b=R c=R -> R"];
    parallel_succeeds_when_all_have_by_default: "<Parallel><a/><b/></Parallel>" => ["a=S b=R -> R", "b=S -> S"];
    parallel_does_not_tick_a_child_again_that_is_done:
        r#"<Parallel success_count="2" failure_count="2"><a/><b/><c/></Parallel>"# => ["a=S b=F c=R -> R", "c=S -> S"];
    parallel_fails_at_the_first_failure_by_default: "<Parallel><a/><b/><c/></Parallel>" => ["a=R b=F a=halt -> F"];
    parallel_fails_when_too_few_children_are_left_to_succeed:
        r#"<Parallel success_count="2" failure_count="3"><a/><b/><c/></Parallel>"# => ["a=F b=R c=R -> R", "b=F c=halt -> F"];
    parallel_succeeds_as_soon_as_enough_children_have: r#"<Parallel success_count="1"><a/><b/><c/></Parallel>"# => [
        "a=R b=S a=halt -> S",
    ];
    parallel_halts_those_that_run_in_their_order: r#"<Parallel success_count="1"><a/><b/><c/></Parallel>"# => [
        "a=R b=R c=R -> R",
        "a=R b=S a=halt c=halt -> S",
    ];
    parallel_with_a_negative_count_counts_from_the_end: r#"<Parallel success_count="-2"><a/><b/><c/></Parallel>"# => [
        "a=S b=R c=S b=halt -> S",
    ];
    parallel_with_a_negative_failure_count: r#"<Parallel success_count="1" failure_count="-1"><a/><b/></Parallel>"# => [
        "a=F b=R -> R",
        "b=F -> F",
    ];
    parallel_counts_skipped_children_towards_all: "<Parallel><a/><b/></Parallel>" => ["a=K b=S -> S"];
    parallel_does_not_count_skipped_children_towards_a_number: r#"<Parallel success_count="2"><a/><b/></Parallel>"# => [
        "a=K b=S -> R",
        "a=S -> S",
    ];
    parallel_with_a_number_is_skipped_when_all_children_are:
        r#"<Fallback><Parallel success_count="1"><a/><b/></Parallel><c/></Fallback>"# => ["a=K b=K c=F -> F"];
    parallel_forgets_who_is_done_when_it_is_halted: "<Parallel><a/><b/></Parallel>" => [
        "a=S b=R -> R",
        "halt tree: b=halt",
        "a=R b=R -> R",
    ];
    parallel_forgets_who_is_done_when_it_is_done: "<Parallel><a/><b/></Parallel>" => ["a=S b=S -> S", "a=R b=R -> R"];
    parallel_reads_its_counts_from_the_blackboard:
        r#"<Sequence><Script code="n := 1"/><Parallel success_count="{n}"><a/><b/></Parallel></Sequence>"# => ["a=R b=S a=halt -> S"];
    parallel_with_a_success_count_of_zero_succeeds_after_its_first_child:
        r#"<Parallel success_count="0"><a/><b/></Parallel>"# => ["a=R a=halt -> S"];

    parallel_all_waits_for_all_children: "<ParallelAll><a/><b/></ParallelAll>" => ["a=F b=R -> R", "b=S -> F"];
    parallel_all_succeeds_when_fewer_have_failed: r#"<ParallelAll max_failures="2"><a/><b/></ParallelAll>"# => [
        "a=F b=S -> S",
    ];
    parallel_all_fails_when_as_many_have_failed: r#"<ParallelAll max_failures="2"><a/><b/></ParallelAll>"# => ["a=F b=F -> F"];
    parallel_all_with_a_negative_limit_fails_when_all_have: r#"<ParallelAll max_failures="-1"><a/><b/></ParallelAll>"# => [
        "a=F b=S -> S",
        "a=F b=F -> F",
    ];
    parallel_all_does_not_tick_a_child_again_that_is_done: "<ParallelAll><a/><b/><c/></ParallelAll>" => [
        "a=S b=R c=R -> R",
        "b=S c=R -> R",
        "c=S -> S",
    ];
    parallel_all_takes_a_skipped_child_for_done: "<ParallelAll><a/><b/></ParallelAll>" => ["a=K b=S -> S"];
    parallel_all_asks_a_skipped_child_again_while_others_run: "<ParallelAll><a/><b/></ParallelAll>" => [
        "a=K b=R -> R",
        "a=S b=S -> S",
    ];
    parallel_all_is_skipped_when_all_children_are: "<Fallback><ParallelAll><a/><b/></ParallelAll><c/></Fallback>" => [
        "a=K b=K c=F -> F",
    ];
    parallel_all_starts_over_after_a_halt: "<ParallelAll><a/><b/></ParallelAll>" => [
        "a=F b=R -> R",
        "halt tree: b=halt",
        "a=S b=S -> S",
    ];
}
