//! Repeat and RetryUntilSuccessful.

use crate::stage::behaviors;

behaviors! {
    repeat_succeeds_when_its_child_has_so_often: r#"<Repeat num_cycles="3"><a/></Repeat>"# => ["a=S a=S a=S -> S"];
    repeat_fails_when_its_child_fails: r#"<Repeat num_cycles="3"><a/></Repeat>"# => ["a=S a=F -> F", "a=S a=S a=S -> S"];
    repeat_waits_for_its_child: r#"<Repeat num_cycles="2"><a/></Repeat>"# => ["a=R -> R", "a=S a=R -> R", "a=S -> S"];
    repeat_lets_conditions_be_asked_between_its_cycles:
        r#"<ReactiveSequence><c/><Repeat num_cycles="3"><a/></Repeat></ReactiveSequence>"# => ["c=S a=S c=S a=S c=F -> F", "c=S a=S c=S a=S c=S a=S -> S"];
    repeat_goes_on_at_once_after_a_child_that_was_running:
        r#"<ReactiveSequence><c/><Repeat num_cycles="2"><a/></Repeat></ReactiveSequence>"# => ["c=S a=R -> R", "c=S a=S a=S -> S"];
    repeat_starts_over_after_a_halt: r#"<Repeat num_cycles="2"><a/></Repeat>"# => [
        "a=S a=R -> R",
        "halt tree: a=halt",
        "a=S a=S -> S",
    ];
    repeat_of_no_cycles_succeeds_without_its_child: r#"<Repeat num_cycles="0"><a/></Repeat>"# => ["-> S"];
    repeat_for_ever: r#"<Repeat num_cycles="-1"><a/></Repeat>"# => ["a=S a=S a=S a=R -> R", "a=F -> F"];
    repeat_is_skipped_with_its_child_and_keeps_its_count:
        r#"<Fallback><Repeat num_cycles="2"><a/></Repeat><b/></Fallback>"# => ["a=S a=K b=R -> R", "b=F -> F", "a=S a=S -> S"];
    repeat_reads_how_often_from_the_blackboard:
        r#"<Sequence><Script code="n := 2"/><Repeat num_cycles="{n}"><a/></Repeat></Sequence>"# => ["a=S a=S -> S"];

    retry_succeeds_with_its_child: r#"<RetryUntilSuccessful num_attempts="3"><a/></RetryUntilSuccessful>"# => ["a=F a=S -> S"];
    retry_fails_after_so_many_attempts: r#"<RetryUntilSuccessful num_attempts="2"><a/></RetryUntilSuccessful>"# => [
        "a=F a=F -> F",
        "a=F a=S -> S",
    ];
    retry_lets_conditions_be_asked_between_its_attempts:
        r#"<ReactiveSequence><c/><RetryUntilSuccessful num_attempts="3"><a/></RetryUntilSuccessful></ReactiveSequence>"# => ["c=S a=F c=S a=F c=F -> F"];
    retry_goes_on_at_once_after_a_child_that_was_running:
        r#"<RetryUntilSuccessful num_attempts="2"><a/></RetryUntilSuccessful>"# => ["a=R -> R", "a=F a=F -> F"];
    retry_starts_over_after_a_halt: r#"<RetryUntilSuccessful num_attempts="2"><a/></RetryUntilSuccessful>"# => [
        "a=F a=R -> R",
        "halt tree: a=halt",
        "a=F a=F -> F",
    ];
    retry_of_no_attempts_fails_without_its_child: r#"<RetryUntilSuccessful num_attempts="0"><a/></RetryUntilSuccessful>"# => ["-> F"];
    retry_for_ever: r#"<RetryUntilSuccessful num_attempts="-1"><a/></RetryUntilSuccessful>"# => ["a=F a=F a=F a=R -> R", "a=S -> S"];
    retry_is_skipped_with_its_child: r#"<Sequence><RetryUntilSuccessful num_attempts="2"><a/></RetryUntilSuccessful><b/></Sequence>"# => [
        "a=K b=S -> S",
    ];
    retry_reads_the_number_of_attempts_again_after_a_failure:
        r#"<Sequence><Script code="n := 5"/><RetryUntilSuccessful num_attempts="{n}"><a _onFailure="n := 2"/></RetryUntilSuccessful></Sequence>"# => ["a=F a=F -> F"];
    retry_has_an_old_name_with_a_mistake: r#"<RetryUntilSuccesful num_attempts="2"><a/></RetryUntilSuccesful>"# => ["a=F a=S -> S"];
}
