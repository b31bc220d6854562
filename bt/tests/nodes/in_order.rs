//! Sequence, Fallback, their reactive forms and SequenceWithMemory, with skipped children.

use crate::stage::behaviors;

behaviors! {
    sequence_succeeds_when_all_children_have: "<Sequence><a/><b/></Sequence>" => ["a=S b=S -> S"];
    sequence_fails_at_the_first_failure: "<Sequence><a/><b/></Sequence>" => ["a=F -> F"];
    sequence_passes_over_a_skipped_child: "<Sequence><a/><b/></Sequence>" => ["a=K b=S -> S"];
    sequence_is_skipped_when_all_children_are: "<Fallback><Sequence><a/><b/></Sequence><c/></Fallback>" => [
        "a=K b=K c=F -> F",
    ];
    sequence_whose_last_child_is_skipped_succeeds: "<Sequence><a/><b/></Sequence>" => ["a=S b=K -> S"];
    sequence_counts_skipped_children_over_several_ticks: "<Fallback><Sequence><a/><b/></Sequence><c/></Fallback>" => [
        "a=K b=R -> R",
        "b=K b=halt c=S -> S",
    ];
    sequence_forgets_skipped_children_after_its_end: "<Sequence><a/><b/></Sequence>" => ["a=K b=S -> S", "a=S b=K -> S"];
    // As in BehaviorTree.CPP: the sequence fails as a condition, which is not reset, so a skipped child still counts at
    // the next ticks.
    sequence_counts_skips_before_a_failure_until_it_is_reset: "<Sequence><IfThenElse><Sequence><a/><b/></Sequence><c/></IfThenElse></Sequence>" => [
        "a=K b=F -> F",
        "a=K b=S -> F",
        "a=K b=S c=S -> S",
    ];
    sequence_all_skipped_leaves_the_root_skipped: "<Sequence><a/></Sequence>" => ["a=K -> K", "a=K -> K", "a=S -> S"];

    fallback_succeeds_at_the_first_success: "<Fallback><a/><b/></Fallback>" => ["a=S -> S"];
    fallback_fails_when_all_children_have: "<Fallback><a/><b/></Fallback>" => ["a=F b=F -> F"];
    fallback_passes_over_a_skipped_child: "<Fallback><a/><b/></Fallback>" => ["a=K b=S -> S"];
    fallback_whose_last_child_is_skipped_fails: "<Fallback><a/><b/></Fallback>" => ["a=F b=K -> F"];
    fallback_is_skipped_when_all_children_are: "<Sequence><Fallback><a/><b/></Fallback><c/></Sequence>" => [
        "a=K b=K c=S -> S",
    ];
    fallback_does_not_ask_a_failed_child_again_while_a_later_one_runs: "<Fallback><a/><b/></Fallback>" => [
        "a=F b=R -> R",
        "b=R -> R",
        "b=F -> F",
    ];
    fallback_starts_over_after_a_success: "<Fallback><a/><b/></Fallback>" => ["a=F b=S -> S", "a=F b=R -> R"];

    reactive_sequence_succeeds_when_all_children_have: "<ReactiveSequence><a/><b/></ReactiveSequence>" => ["a=S b=S -> S"];
    reactive_sequence_passes_over_a_skipped_child: "<ReactiveSequence><a/><b/></ReactiveSequence>" => [
        "a=K b=R -> R",
        "a=K b=S -> S",
    ];
    reactive_sequence_is_skipped_when_all_children_are:
        "<Fallback><ReactiveSequence><a/><b/></ReactiveSequence><c/></Fallback>" => ["a=K b=K c=S -> S"];
    reactive_sequence_halts_a_child_that_ran_when_an_earlier_one_runs_now:
        "<ReactiveSequence><a/><b/></ReactiveSequence>" => ["a=S b=R -> R", "a=R b=halt -> R", "a=S b=S -> S"];
    reactive_sequence_with_two_running_children_keeps_the_first_that_answers_so:
        "<ReactiveSequence><a/><b/><c/></ReactiveSequence>" => ["a=S b=S c=R -> R", "a=S b=R c=halt -> R"];
    reactive_sequence_asks_a_child_again_that_has_succeeded: "<ReactiveSequence><a/><b/></ReactiveSequence>" => [
        "a=S b=R -> R",
        "a=F b=halt -> F",
    ];

    reactive_fallback_fails_when_all_children_have: "<ReactiveFallback><a/><b/></ReactiveFallback>" => ["a=F b=F -> F"];
    reactive_fallback_passes_over_a_skipped_child: "<ReactiveFallback><a/><b/></ReactiveFallback>" => [
        "a=K b=R -> R",
        "a=K b=F -> F",
    ];
    reactive_fallback_is_skipped_when_all_children_are:
        "<Sequence><ReactiveFallback><a/><b/></ReactiveFallback><c/></Sequence>" => ["a=K b=K c=S -> S"];
    reactive_fallback_asks_a_child_again_that_has_failed: "<ReactiveFallback><a/><b/></ReactiveFallback>" => [
        "a=F b=R -> R",
        "a=S b=halt -> S",
    ];

    sequence_with_memory_goes_on_with_the_child_that_failed:
        "<SequenceWithMemory><a/><b/><c/></SequenceWithMemory>" => ["a=S b=S c=F -> F", "c=S -> S"];
    sequence_with_memory_starts_over_after_its_success: "<SequenceWithMemory><a/><b/></SequenceWithMemory>" => [
        "a=S b=S -> S",
        "a=S b=S -> S",
    ];
    sequence_with_memory_passes_over_a_skipped_child: "<SequenceWithMemory><a/><b/></SequenceWithMemory>" => [
        "a=K b=F -> F",
        "b=S -> S",
    ];
    sequence_with_memory_is_skipped_when_all_children_are:
        "<Fallback><SequenceWithMemory><a/><b/></SequenceWithMemory><c/></Fallback>" => ["a=K b=K c=F -> F"];
    sequence_with_memory_that_resumes_is_not_skipped_because_the_rest_is:
        "<SequenceWithMemory><a/><b/></SequenceWithMemory>" => ["a=S b=F -> F", "b=K -> S"];
}
