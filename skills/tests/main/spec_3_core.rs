//! SCXML clause 3: states, transitions, events and how the machine runs.

use skills::{Chart, HistoryKind, Note, StateKind, Status, Strictness};

use crate::stage::{file, lenient, stage, stage_with};

/// Logs its name when it is entered and left.
fn traced(id: &str, content: &str) -> String {
    format!(
        "<state id='{id}'><onentry><log expr=\"'+{id}'\"/></onentry><onexit><log expr=\"'-{id}'\"/></onexit>{content}</state>"
    )
}

#[test]
fn spec_3_2_the_first_child_in_document_order_is_entered_by_default() {
    assert_eq!(stage("<state id='a'/><state id='b'/>").active(), "a");
}

#[test]
fn spec_3_2_the_initial_attribute_names_the_state_to_enter() {
    assert_eq!(stage_with("initial='b'", "<state id='a'/><state id='b'/>", Strictness::Strict).active(), "b");
}

#[test]
fn spec_3_2_the_initial_attribute_may_name_a_state_deep_inside() {
    let stage = stage_with(
        "initial='b2'",
        "<state id='a'/><state id='b'><state id='b1'/><state id='b2'/></state>",
        Strictness::Strict,
    );
    assert_eq!(stage.active(), "b2");
    assert!(stage.machine.is_in("b"));
}

#[test]
fn spec_3_2_the_initial_attribute_may_name_a_state_in_each_region() {
    let regions = "<parallel id='p'><state id='x'><state id='x1'/><state id='x2'/></state>\
                   <state id='y'><state id='y1'/><state id='y2'/></state></parallel>";
    assert_eq!(stage_with("initial='x2 y2'", regions, Strictness::Strict).active(), "x2 y2");
}

#[test]
fn spec_3_2_a_machine_without_a_name_is_named_after_its_file() {
    let named = Chart::load("skills/Lamp.scxml", &file("name='Bulb'", "<state/>")).unwrap();
    let unnamed = Chart::load("skills/Lamp.scxml", &file("", "<state/>")).unwrap();
    assert_eq!((named.name(), unnamed.name()), ("Bulb", "Lamp"));
}

#[test]
fn spec_3_3_a_compound_state_is_entered_before_and_exited_after_its_children() {
    let inside = traced("b", &traced("b1", ""));
    let mut stage = stage(&format!(
        "<state id='a'><transition event='go' target='b'/></state>{}<state id='c'/>",
        inside.replacen("<onentry>", "<transition event='go' target='c'/><onentry>", 1)
    ));
    stage.send("go").send("go");
    assert_eq!(stage.log(), "+b +b1 -b1 -b");
    assert_eq!(stage.active(), "c");
}

#[test]
fn spec_3_3_the_initial_attribute_of_a_state_chooses_the_child() {
    assert_eq!(stage("<state id='a' initial='a2'><state id='a1'/><state id='a2'/></state>").active(), "a2");
}

#[test]
fn spec_3_4_all_children_of_a_parallel_state_are_active() {
    let stage = stage("<parallel id='p'><state id='a'/><state id='b'><state id='b1'/></state></parallel>");
    assert_eq!(stage.active(), "a b1");
}

#[test]
fn spec_3_4_a_parallel_state_is_done_when_all_its_children_are() {
    let mut stage = stage(
        "<state id='s'><parallel id='p'>
           <state id='a'><state id='a1'><transition event='a' target='af'/></state><final id='af'/></state>
           <state id='b'><state id='b1'><transition event='b' target='bf'/></state><final id='bf'/></state>
         </parallel>
         <transition event='done.state.p' target='end'/></state><state id='end'/>",
    );
    assert_eq!(stage.send("b").active(), "a1 bf");
    assert_eq!(stage.send("a").active(), "end");
}

#[test]
fn spec_3_4_regions_are_entered_in_document_order_and_exited_in_reverse() {
    let regions = format!("{}{}", traced("x", ""), traced("y", ""));
    let mut stage =
        stage(&format!("<parallel id='p'>{regions}<transition event='out' target='end'/></parallel><state id='end'/>"));
    assert_eq!(stage.send("out").log(), "+x +y -y -x");
}

#[test]
fn spec_3_6_the_content_of_initial_runs_between_the_parents_entry_and_the_childs() {
    let stage = stage(
        "<state id='s'><onentry><log expr='1'/></onentry>
           <initial><transition target='b'><log expr='2'/></transition></initial>
           <state id='a'/><state id='b'><onentry><log expr='3'/></onentry></state></state>",
    );
    assert_eq!((stage.active().as_str(), stage.log().as_str()), ("b", "1 2 3"));
}

#[test]
fn spec_3_6_the_content_of_initial_does_not_run_when_a_child_is_the_target() {
    let mut stage = stage(
        "<state id='z'><transition event='go' target='b'/></state>
         <state id='s'><initial><transition target='b'><log expr='2'/></transition></initial><state id='b'/></state>",
    );
    assert_eq!(stage.send("go").log(), "");
}

#[test]
fn spec_3_7_a_final_state_ends_its_parent() {
    let mut stage = stage(
        "<state id='s'><state id='a'><transition event='go' target='f'/></state><final id='f'/>
           <transition event='done.state.s' target='end'/></state><state id='end'/>",
    );
    assert_eq!(stage.send("go").active(), "end");
}

#[test]
fn spec_3_7_the_entry_handlers_of_a_final_state_run_before_its_done_event() {
    let stage = stage(
        "<state id='s'><final id='f'><onentry><raise event='first'/></onentry></final>
           <transition event='first' target='right'/><transition event='done.state.s' target='wrong'/></state>
         <state id='right'/><state id='wrong'/>",
    );
    assert_eq!(stage.active(), "right");
}

#[test]
fn spec_3_7_a_final_state_of_the_machine_ends_it() {
    let mut stage = stage("<state id='a'><transition event='go' target='f'/></state><final id='f'/>");
    stage.send("go").send("go");
    assert!(stage.is_done());
    assert_eq!(stage.active(), "f", "where it ended can still be seen");
}

#[test]
fn spec_3_8_an_error_in_one_entry_block_leaves_the_next_alone() {
    let stage = stage(
        "<datamodel><data id='x'/></datamodel>
         <state id='a'><onentry><log expr='1'/><log expr='x.y'/><log expr='2'/></onentry><onentry><log expr='3'/></onentry></state>",
    );
    assert_eq!(stage.log(), "1 3");
}

#[test]
fn spec_3_9_exit_blocks_run_in_document_order() {
    let mut stage = stage(
        "<state id='a'><onexit><log expr='1'/></onexit><onexit><log expr='2'/></onexit>
           <transition event='go' target='b'/></state><state id='b'/>",
    );
    assert_eq!(stage.send("go").log(), "1 2");
}

const PLAYER: &str = "
  <state id='player'>
    <history id='back' type='HISTORY'><transition target='cd'><log expr=\"'default'\"/></transition></history>
    <state id='cd'>
      <state id='track1'><transition event='next' target='track2'/></state>
      <state id='track2'><transition event='next' target='track1'/></state>
      <transition event='radio' target='radio'/>
    </state>
    <state id='radio'/>
    <transition event='pause' target='paused'/>
  </state>
  <state id='paused'><transition event='resume' target='back'/></state>";

#[test]
fn spec_3_10_a_history_state_that_remembers_nothing_leads_to_its_default() {
    let machine = PLAYER.replace("HISTORY", "shallow").replace(
        "<state id='player'>",
        "<state id='start'><transition event='go' target='back'/></state><state id='player'>",
    );
    let mut stage = stage(&machine);
    assert_eq!(stage.send("go").active(), "track1");
    assert_eq!(stage.log(), "default");
}

#[test]
fn spec_3_10_shallow_history_remembers_the_child() {
    let mut stage = stage(&PLAYER.replace("HISTORY", "shallow"));
    assert_eq!(stage.send("next").send("pause").send("resume").active(), "track1", "the child, and its default");
    assert_eq!(stage.send("radio").send("pause").send("resume").active(), "radio");
    assert_eq!(stage.log(), "", "the default is not taken");
}

#[test]
fn spec_3_10_deep_history_remembers_the_descendants() {
    let mut stage = stage(&PLAYER.replace("HISTORY", "deep"));
    assert_eq!(stage.send("next").send("pause").send("resume").active(), "track2");
}

#[test]
fn spec_3_10_deep_history_remembers_every_region() {
    let mut stage = stage(
        "<parallel id='p'><history id='h' type='deep'><transition target='a1 b1'/></history>
           <state id='a'><state id='a1'><transition event='x' target='a2'/></state><state id='a2'/></state>
           <state id='b'><state id='b1'/><state id='b2'/></state>
           <transition event='out' target='off'/></parallel>
         <state id='off'><transition event='in' target='h'/></state>",
    );
    assert_eq!(stage.send("x").send("out").send("in").active(), "a2 b1");
}

#[test]
fn spec_3_10_history_is_recorded_before_exit_handlers_run() {
    let mut stage = stage(
        "<state id='s'><history id='h'><transition target='a'/></history><state id='a'/>
           <state id='b'><onexit><raise event='gone'/></onexit></state>
           <transition event='b' target='b'/><transition event='out' target='off'/></state>
         <state id='off'><transition event='gone' target='h'/></state>",
    );
    assert_eq!(stage.send("b").send("out").active(), "b");
}

#[test]
fn charts_know_the_kinds_of_their_states() {
    let chart = Chart::load("t", &file("", "<state id='c'><history id='h' type='deep'><transition target='a'/></history><state id='a'/></state><parallel id='p'/><final id='f'/>")).unwrap();
    let kinds: Vec<_> = chart.states().map(|state| (chart.state(state).id(), chart.state(state).kind())).collect();
    let expected = [
        ("c", StateKind::Compound),
        ("h", StateKind::History(HistoryKind::Deep)),
        ("a", StateKind::Atomic),
        ("p", StateKind::Parallel),
        ("f", StateKind::Final),
    ];
    assert_eq!(kinds, expected);
}

#[test]
fn spec_3_10_a_transition_to_its_own_history_enters_everything_it_exited() {
    // Appendix D, taken literally, enters only s2 here.
    let mut stage = stage(
        "<parallel id='p'><history id='h' type='deep'><transition target='s1'/></history>
           <state id='s1'><transition event='e' target='h' type='internal'/><state id='s2'/></state></parallel>",
    );
    assert_eq!(stage.send("e").active(), "s2");
    assert!(stage.machine.is_in("s1") && stage.machine.is_in("p"));
}

/// Whether a transition with this descriptor is taken on this event.
fn fires(descriptor: &str, event: &str) -> bool {
    let machine = format!("<state id='a'><transition event='{descriptor}' target='b'/></state><state id='b'/>");
    stage(&machine).send(event).active() == "b"
}

#[test]
fn spec_3_12_1_a_descriptor_matches_by_tokens_at_the_beginning() {
    assert!(fires("error", "error") && fires("error", "error.send") && fires("error", "error.send.failed"));
    assert!(!fires("error", "errors") && !fires("error", "my.error") && !fires("error.send", "error"));
}

#[test]
fn spec_3_12_1_a_dot_or_star_at_the_end_changes_nothing() {
    assert!(fires("error.", "error") && fires("error.*", "error.send"));
}

#[test]
fn spec_3_12_1_a_star_alone_matches_everything() {
    assert!(fires("*", "anything") && fires("*", "any.thing"));
}

#[test]
fn spec_3_12_1_any_of_several_descriptors_is_enough() {
    assert!(fires("one two three", "two") && !fires("one two three", "four"));
}

#[test]
fn spec_3_12_1_names_are_case_sensitive() {
    assert!(!fires("Error", "error"));
}

#[test]
fn spec_3_12_2_an_error_is_an_event_that_can_be_handled() {
    let stage = stage(
        "<datamodel><data id='x'/></datamodel>
         <state id='a'><onentry><assign location='x' expr='x.y.z'/></onentry><transition event='error.execution' target='b'/></state>
         <state id='b'/>",
    );
    assert_eq!(stage.active(), "b");
    assert!(!stage.host.notes.iter().any(|note| matches!(note, Note::UnhandledError { .. })));
}

#[test]
fn spec_3_12_2_an_unhandled_error_is_ignored() {
    let stage =
        stage("<datamodel><data id='x'/></datamodel><state id='a'><onentry><log expr='x.y'/></onentry></state>");
    assert_eq!(stage.active(), "a");
    assert!(stage.host.notes.iter().any(|note| matches!(note, Note::UnhandledError { .. })));
}

#[test]
fn spec_3_13_of_two_enabled_transitions_the_first_in_document_order_is_taken() {
    let mut stage = stage(
        "<state id='a'><transition event='e' target='b'/><transition event='e' target='c'/></state><state id='b'/><state id='c'/>",
    );
    assert_eq!(stage.send("e").active(), "b");
}

#[test]
fn spec_3_13_a_transition_whose_condition_is_false_is_skipped() {
    let mut stage = stage(
        "<state id='a'><transition event='e' cond='1 > 2' target='b'/><transition event='e' target='c'/></state>
         <state id='b'/><state id='c'/>",
    );
    assert_eq!(stage.send("e").active(), "c");
}

#[test]
fn spec_3_13_the_transition_of_the_inner_state_preempts_that_of_the_outer() {
    let mut stage = stage(
        "<state id='s'><transition event='e' target='out'/><state id='a'><transition event='e' target='b'/></state><state id='b'/></state>
         <state id='out'/>",
    );
    assert_eq!(stage.send("e").active(), "b");
    assert_eq!(stage.send("e").active(), "out", "where the inner one has none, the outer one is taken");
}

#[test]
fn spec_3_13_transitions_of_orthogonal_regions_are_taken_together() {
    let mut stage = stage(
        "<parallel id='p'><state id='x'><state id='x1'><transition event='e' target='x2'/></state><state id='x2'/></state>
           <state id='y'><state id='y1'><transition event='e' target='y2'/></state><state id='y2'/></state></parallel>",
    );
    assert_eq!(stage.send("e").active(), "x2 y2");
}

#[test]
fn spec_3_13_conflicting_regions_are_preempted_in_document_order() {
    let mut stage = stage(
        "<parallel id='p'><state id='x'><transition event='e' target='out1'/></state>
           <state id='y'><transition event='e' target='out2'/></state></parallel><state id='out1'/><state id='out2'/>",
    );
    assert_eq!(stage.send("e").active(), "out1");
}

#[test]
fn spec_3_13_a_deeper_source_preempts_an_earlier_one() {
    // The transition of p is found first, through x. It gives way to that of y1, which lies inside p.
    let mut stage = stage(
        "<parallel id='p'><transition event='e' target='out'/><state id='x'/>
           <state id='y'><state id='y1'><transition event='e' target='y2'/></state><state id='y2'/></state></parallel>
         <state id='out'/>",
    );
    assert_eq!(stage.send("e").active(), "x y2");
}

#[test]
fn spec_3_13_a_transition_without_a_target_exits_no_state() {
    let mut stage = stage(&traced("a", "<transition event='e'><log expr=\"'e'\"/></transition>"));
    assert_eq!(stage.send("e").log(), "+a e");
}

#[test]
fn spec_3_13_a_transition_to_its_own_state_exits_and_enters_it() {
    let mut stage = stage(&traced("a", "<transition event='e' target='a'><log expr=\"'e'\"/></transition>"));
    assert_eq!(stage.send("e").log(), "+a -a e +a");
}

#[test]
fn spec_3_13_an_external_transition_to_a_child_exits_the_parent() {
    let mut stage =
        stage(&traced("s", &format!("<transition event='e' target='b'/>{}{}", traced("a", ""), traced("b", ""))));
    assert_eq!(stage.send("e").log(), "+s +a -a -s +s +b");
}

#[test]
fn spec_3_13_an_internal_transition_to_a_child_stays_in_the_parent() {
    let transition = "<transition event='e' type='internal' target='b'/>";
    let mut stage = stage(&traced("s", &format!("{transition}{}{}", traced("a", ""), traced("b", ""))));
    assert_eq!(stage.send("e").log(), "+s +a -a +b");
}

#[test]
fn spec_3_13_an_internal_transition_to_the_outside_is_external() {
    let transition = "<transition event='e' type='internal' target='o'/>";
    let mut stage = stage(&format!("{}<state id='o'/>", traced("s", &format!("{transition}{}", traced("a", "")))));
    assert_eq!(stage.send("e").log(), "+s +a -a -s");
}

#[test]
fn spec_3_13_an_internal_transition_of_a_parallel_state_is_external() {
    let mut stage = stage(
        "<parallel id='p'><onexit><log expr=\"'-p'\"/></onexit><transition event='e' type='internal' target='b'/>
         <state id='x'><state id='a'/><state id='b'/></state><state id='y'/></parallel>",
    );
    assert_eq!(stage.send("e").active(), "b y");
    assert_eq!(stage.log(), "-p");
}

#[test]
fn spec_3_13_eventless_transitions_go_before_internal_events() {
    let stage = stage(
        "<state id='a'><onentry><raise event='e'/></onentry><transition target='b'/><transition event='e' target='wrong'/></state>
         <state id='b'><transition event='e' target='right'/></state><state id='right'/><state id='wrong'/>",
    );
    assert_eq!(stage.active(), "right");
}

#[test]
fn spec_3_13_internal_events_go_before_external_ones() {
    let stage = stage(
        "<state id='a'><onentry><send event='outer'/><raise event='inner'/></onentry>
           <transition event='outer' target='wrong'/><transition event='inner' target='right'/></state>
         <state id='right'/><state id='wrong'/>",
    );
    assert_eq!(stage.active(), "right");
}

#[test]
fn spec_3_13_states_are_exited_then_content_runs_then_states_are_entered() {
    let mut stage = stage(&format!(
        "{}{}",
        traced("a", "<transition event='e' target='b'><log expr=\"'act'\"/></transition>"),
        traced("b", "")
    ));
    assert_eq!(stage.send("e").log(), "+a -a act +b");
}

#[test]
fn spec_3_13_all_transitions_of_a_microstep_run_before_any_state_is_entered() {
    // One of the two traps of issue 4: the content of the first region's target sees what the second region assigns.
    let mut stage = stage(
        "<datamodel><data id='x' expr='0'/><data id='seen'/></datamodel>
         <parallel id='p'>
           <state id='a'><state id='a1'><transition event='e' target='a2'/></state>
             <state id='a2'><onentry><assign location='seen' expr='x'/></onentry></state></state>
           <state id='b'><state id='b1'><transition event='e' target='b2'><assign location='x' expr='1'/></transition></state>
             <state id='b2'/></state></parallel>",
    );
    stage.send("e");
    assert_eq!(stage.datum("seen"), 1.0.into());
}

#[test]
fn spec_3_13_an_event_that_enables_nothing_is_dropped() {
    let mut stage = stage("<state id='a'><transition event='e' target='b'/></state><state id='b'/>");
    assert_eq!(stage.send("other").active(), "a");
    assert_eq!(stage.send("e").active(), "b");
}

#[test]
fn spec_3_13_several_targets_enter_several_regions() {
    let mut stage = stage(
        "<state id='z'><transition event='e' target='x2 y2'/></state>
         <parallel id='p'><state id='x'><state id='x1'/><state id='x2'/></state><state id='y'><state id='y1'/><state id='y2'/></state>
           <state id='w'><state id='w1'/></state></parallel>",
    );
    assert_eq!(stage.send("e").active(), "x2 y2 w1");
}

#[test]
fn spec_d_exit_interpreter_runs_the_exit_handlers_from_the_inside_out() {
    let mut stage = stage(&format!(
        "{}<final id='f'><onexit><log expr=\"'-f'\"/></onexit></final>",
        traced("s", "<transition event='e' target='f'/>")
    ));
    assert_eq!(stage.send("e").log(), "+s -s -f");
}

#[test]
fn spec_d_a_machine_that_never_comes_to_rest_is_stopped() {
    let stage = stage("<state id='a'><transition target='b'/></state><state id='b'><transition target='a'/></state>");
    assert_eq!(stage.machine.status(), Status::Stuck);
    assert!(stage.host.notes.iter().any(|note| matches!(note, Note::Stuck { .. })));
}

#[test]
fn spec_d_a_machine_that_sends_itself_events_forever_is_stopped() {
    let mut stage = stage("<state id='a'><transition event='e'><send event='e'/></transition></state>");
    assert_eq!(stage.send("e").machine.status(), Status::Stuck);
}

#[test]
fn spec_3_13_an_invalid_condition_is_false_and_an_error() {
    let stage = lenient(
        "<state id='a'><transition cond='return' target='b'/><transition event='error' target='c'/></state><state id='b'/><state id='c'/>",
    );
    assert_eq!(stage.active(), "c");
}
