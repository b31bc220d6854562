//! SCXML clause 4: executable content.

use crate::stage::stage;

fn logged(content: &str) -> String {
    let data = "<datamodel><data id='x'/><data id='list' expr='[10, 20, 30]'/><data id='sum' expr='0'/></datamodel>";
    stage(&format!("{data}<state id='a'><onentry>{content}</onentry></state>")).log()
}

#[test]
fn spec_4_2_raise_appends_an_event_to_the_internal_queue() {
    let stage = stage(
        "<state id='a'><onentry><raise event='one'/><raise event='two'/></onentry>
           <transition event='one'><raise event='three'/></transition>
           <transition event='three' target='wrong'/>
           <transition event='two' target='right'/></state><state id='right'/><state id='wrong'/>",
    );
    assert_eq!(stage.active(), "right");
}

#[test]
fn spec_4_3_if_takes_the_first_branch_that_holds() {
    assert_eq!(
        logged(
            "<if cond='false'><log expr='1'/><elseif cond='true'/><log expr='2'/><elseif cond='true'/><log expr='3'/><else/><log expr='4'/></if>"
        ),
        "2"
    );
}

#[test]
fn spec_4_3_if_takes_else_when_nothing_holds() {
    assert_eq!(logged("<if cond='false'><log expr='1'/><else/><log expr='2'/><log expr='3'/></if>"), "2 3");
}

#[test]
fn spec_4_3_if_without_a_branch_that_holds_does_nothing() {
    assert_eq!(logged("<if cond='false'><log expr='1'/></if><log expr='2'/>"), "2");
}

#[test]
fn spec_4_3_if_a_failing_condition_is_false_and_the_block_continues() {
    assert_eq!(logged("<if cond='x.y'><log expr='1'/><else/><log expr='2'/></if><log expr='3'/>"), "2 3");
}

#[test]
fn spec_4_3_if_an_error_inside_ends_the_whole_block() {
    assert_eq!(logged("<if cond='true'><log expr='x.y'/><log expr='1'/></if><log expr='2'/>"), "");
}

#[test]
fn spec_4_6_foreach_visits_the_items_with_their_indices() {
    let body = "<foreach array='list' item='i' index='n'><log expr='n'/><log expr='i'/></foreach><log expr='i'/>";
    assert_eq!(logged(body), "0 10 1 20 2 30 30");
}

#[test]
fn spec_4_6_foreach_visits_a_copy() {
    let body = "<foreach array='list' item='i'><assign location='list' expr='[]'/><assign location='sum' expr='sum + i'/></foreach><log expr='sum'/>";
    assert_eq!(logged(body), "60");
}

#[test]
fn spec_4_6_foreach_needs_an_array() {
    assert_eq!(logged("<foreach array='sum' item='i'><log expr='1'/></foreach><log expr='2'/>"), "");
}

#[test]
fn spec_4_6_foreach_an_error_inside_ends_it_and_the_block() {
    let body = "<foreach array='list' item='i'><assign location='sum' expr='sum + 1'/><log expr='sum'/><log expr='x.y'/></foreach><log expr='9'/>";
    assert_eq!(logged(body), "1");
}

#[test]
fn spec_4_7_log_shows_label_and_value() {
    assert_eq!(
        logged("<log label='level' expr='1 + 1'/><log label='bare'/><log expr='list'/>"),
        "level: 2 bare:  [10, 20, 30]"
    );
}

#[test]
fn spec_4_9_content_runs_in_document_order() {
    assert_eq!(logged("<log expr='1'/><assign location='x' expr='2'/><log expr='x'/><log expr='3'/>"), "1 2 3");
}

#[test]
fn spec_4_10_elements_of_other_namespaces_are_ignored() {
    let stage = stage("<state id='a'><onentry><q:dance xmlns:q='urn:q' steps='3'/><log expr='1'/></onentry></state>");
    assert_eq!(stage.log(), "1");
    assert!(stage.machine.chart().warnings().is_empty());
}
