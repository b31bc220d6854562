//! AsyncSequence, AsyncFallback, and the repeated ticks that they ask for.

use bt::{Execution, Status};

use crate::NOW;
use crate::stage::{Script, behaviors, tree};

const GUARDED: &str = "<ReactiveSequence><c/><AsyncSequence><a/><b/></AsyncSequence></ReactiveSequence>";
const GUARDED_FALLBACK: &str = "<ReactiveSequence><c/><AsyncFallback><a/><b/></AsyncFallback></ReactiveSequence>";

behaviors! {
    async_sequence_lets_conditions_be_asked_between_its_children: GUARDED => ["c=S a=S c=S b=S -> S"];
    async_sequence_is_left_when_a_condition_fails_between_its_children: GUARDED => ["c=S a=S c=F -> F", "c=S a=S c=S b=R -> R"];
    async_sequence_goes_on_at_once_after_a_child_that_was_running: GUARDED => ["c=S a=R -> R", "c=S a=S b=R -> R"];
    async_sequence_does_not_tick_again_after_its_last_child: "<AsyncSequence><a/></AsyncSequence>" => ["a=S -> S"];
    async_sequence_fails_and_starts_over: "<AsyncSequence><a/><b/></AsyncSequence>" => ["a=S b=F -> F", "a=S b=S -> S"];
    async_sequence_starts_over_after_a_halt: "<AsyncSequence><a/><b/></AsyncSequence>" => [
        "a=S b=R -> R",
        "halt tree: b=halt",
        "a=S b=S -> S",
    ];
    async_sequence_passes_over_skipped_children_without_ticking_again: GUARDED => ["c=S a=K b=S -> S"];
    async_fallback_lets_conditions_be_asked_between_its_children: GUARDED_FALLBACK => ["c=S a=F c=S b=S -> S"];
    async_fallback_succeeds_at_once: GUARDED_FALLBACK => ["c=S a=S -> S"];
    async_fallback_goes_on_at_once_after_a_child_that_was_running: GUARDED_FALLBACK => ["c=S a=R -> R", "c=S a=F b=F -> F"];
    async_fallback_is_skipped_when_all_children_are: "<Sequence><AsyncFallback><a/><b/></AsyncFallback><c/></Sequence>" => [
        "a=K b=K c=S -> S",
    ];
    // In parallel, one asks for another tick while the other makes the root succeed: the request is kept for the next
    // tick.
    a_wish_to_be_ticked_again_outlives_a_tick_in_which_the_root_is_done:
        r#"<Parallel success_count="1"><AsyncSequence><a/><b/></AsyncSequence><c/></Parallel>"# => [
            "a=S c=S -> S",
            "a=R c=R a=R c=R -> R",
        ];
}

#[test]
fn a_tree_that_asks_for_endless_ticks_is_stopped() {
    let twice = "<Repeat num_cycles=\"2\"><AlwaysSuccess/></Repeat>";
    let body = &format!("<ReactiveSequence>{twice}{twice}</ReactiveSequence>");
    let tree = tree(body);
    let mut execution = Execution::new(tree.clone());
    for _ in 0..2 {
        assert_eq!(execution.tick(NOW, &mut Script::new(&tree, "")), Status::Running);
        assert_eq!(execution.faults().len(), 1);
        assert!(execution.faults()[0].message.contains("keeps asking"));
    }
}
