//! SCXML clause 6: sending and canceling.

use crate::stage::{Stage, lenient, stage};

/// A machine that first executes this content and logs the events that follow.
fn sending(content: &str) -> Stage {
    stage(&format!(
        "<datamodel><data id='x' expr='1'/><data id='id'/></datamodel>
         <state id='a'><onentry>{content}</onentry><transition event='*'><log expr='_event.name'/></transition></state>"
    ))
}

#[test]
fn spec_6_2_an_event_without_a_target_comes_back_as_an_external_one() {
    let stage = stage(
        "<state id='a'><onentry><send event='e'/></onentry><transition event='e'><log expr='_event.type'/><log expr='_event.origin'/></transition></state>",
    );
    assert_eq!(stage.log(), "external #_scxml_test");
}

#[test]
fn spec_6_2_the_target_internal_means_the_internal_queue() {
    let stage = sending("<send event='outer'/><send event='inner' target='#_internal'/>");
    assert_eq!(stage.log(), "inner outer");
}

#[test]
fn spec_6_2_an_event_can_be_sent_to_the_location_of_its_own_session() {
    assert_eq!(sending("<send event='e' targetexpr=\"_ioprocessors.scxml.location\"/>").log(), "e");
}

#[test]
fn spec_6_2_name_and_target_may_be_computed() {
    assert_eq!(sending("<send eventexpr=\"'e' + x\" targetexpr=\"'#_internal'\" typeexpr=\"'scxml'\"/>").log(), "e1");
}

#[test]
fn spec_6_2_parameters_and_names_become_data() {
    let stage = stage(
        "<datamodel><data id='x' expr='1'/><data id='got'/></datamodel>
         <state id='a'><onentry><send event='e' namelist='x'><param name='y' expr='x + 1'/></send></onentry>
           <transition event='e'><assign location='got' expr='_event.data'/></transition></state>",
    );
    assert_eq!(stage.datum("got").to_string(), r#"{"x": 1, "y": 2}"#);
}

#[test]
fn spec_6_2_content_becomes_data() {
    let stage = stage(
        "<state id='a'><onentry><send event='e'><content>{\"x\": 5}</content></send></onentry><transition event='e'><log expr='_event.data.x'/></transition></state>",
    );
    assert_eq!(stage.log(), "5");
}

#[test]
fn spec_6_2_a_delayed_event_comes_exactly_when_it_is_due() {
    let mut stage = sending("<send event='e' delay='0.5s'/>");
    assert_eq!(stage.machine.next_timer(), Some(std::time::Duration::from_millis(500)));
    assert_eq!(stage.at_ms(499).log(), "");
    assert_eq!(stage.at_ms(500).log(), "e");
    assert_eq!(stage.machine.next_timer(), None);
}

#[test]
fn spec_6_2_delayed_events_come_in_the_order_they_are_due() {
    let mut stage = sending(
        "<send event='c' delay='30ms'/><send event='a' delay='10ms'/><send event='b1' delay='20ms'/><send event='b2' delay='20ms'/>",
    );
    assert_eq!(stage.at_ms(100).log(), "a b1 b2 c");
}

#[test]
fn spec_6_2_the_data_of_a_delayed_event_are_evaluated_when_it_is_sent() {
    let mut stage = stage(
        "<datamodel><data id='x' expr='1'/></datamodel>
         <state id='a'><onentry><send event='e' delay='1s'><param name='x' expr='x'/></send><assign location='x' expr='2'/></onentry>
           <transition event='e'><log expr='_event.data.x'/></transition></state>",
    );
    assert_eq!(stage.at_ms(1000).log(), "1");
}

#[test]
fn spec_6_2_a_delay_may_be_computed() {
    let mut stage = sending("<send event='e' delayexpr=\"x + 's'\"/>");
    assert_eq!(stage.at_ms(999).log(), "");
    assert_eq!(stage.at_ms(1000).log(), "e");
}

#[test]
fn spec_6_2_an_invalid_delay_is_an_error_and_nothing_is_sent() {
    let mut stage = sending("<send event='e' delayexpr=\"'soon'\"/>");
    assert_eq!(stage.at_ms(10_000).log(), "error.execution");
}

#[test]
fn spec_6_2_an_unknown_processor_is_an_error_of_execution() {
    let stage = lenient(
        "<state id='a'><onentry><send event='e' type='pigeon'/></onentry><transition event='error.execution' target='b'/></state><state id='b'/>",
    );
    assert_eq!(stage.active(), "b");
}

#[test]
fn spec_6_2_an_invalid_target_is_an_error_of_execution() {
    assert_eq!(sending("<send event='e' target='!nonsense'/>").errors(), ["error.execution"]);
}

#[test]
fn spec_6_2_an_unknown_session_is_an_error_of_communication() {
    assert_eq!(sending("<send event='e' target='#_scxml_elsewhere'/>").errors(), ["error.communication"]);
}

#[test]
fn spec_6_2_an_event_that_cannot_be_evaluated_is_not_sent() {
    let stage = sending("<send eventexpr='id.x'/><log expr='9'/>");
    assert_eq!(stage.log(), "error.execution", "and the rest of the block is left out");
}

#[test]
fn spec_6_2_an_error_carries_the_id_of_the_send() {
    let stage = stage(
        "<state id='a'><onentry><send event='e' id='me' target='!nonsense'/></onentry><transition event='error'><log expr='_event.sendid'/></transition></state>",
    );
    assert_eq!(stage.log(), "me");
}

#[test]
fn spec_6_2_4_parameters_with_the_same_name_are_all_sent() {
    let stage = stage(
        "<datamodel><data id='Var0' expr='1'/></datamodel><state id='a'><onentry><send event='e' namelist='Var0'><param name='Var1' expr='2'/><param name='Var1' expr=\"'3'\"/></send></onentry>
           <transition event='e'><log expr='_event.data.Var1'/><log expr='_event.raw'/></transition></state>",
    );
    let raw = r##"{"name": "e", "type": "external", "origin": "#_scxml_test", "origintype": "http://www.w3.org/TR/scxml/#SCXMLEventProcessor", "data": {"Var0": 1, "Var1": 2, "Var1": "3"}}"##;
    assert_eq!(stage.log(), format!("3 {raw}"));
}

#[test]
fn spec_6_2_a_generated_id_differs_each_time() {
    let stage = stage(
        "<datamodel><data id='one'/><data id='two'/></datamodel>
         <state id='a'><onentry><send event='e' idlocation='one'/><send event='e' idlocation='two'/></onentry>
           <transition event='e' cond='_event.sendid === one'><log expr='one === two'/></transition></state>",
    );
    assert_eq!(stage.log(), "false");
}

#[test]
fn spec_6_3_cancel_stops_a_delayed_event() {
    let mut stage =
        sending("<send event='e' id='e' delay='1s'/><send event='f' id='f' delay='1s'/><cancel sendid='e'/>");
    assert_eq!(stage.at_ms(1000).log(), "f");
}

#[test]
fn spec_6_3_cancel_may_compute_the_id() {
    let mut stage = sending("<send event='e' idlocation='id' delay='1s'/><cancel sendidexpr='id'/>");
    assert_eq!(stage.at_ms(1000).log(), "");
}

#[test]
fn spec_6_3_cancel_of_an_unknown_id_does_nothing() {
    assert_eq!(sending("<cancel sendid='nothing'/><send event='e'/>").log(), "e");
}

#[test]
fn spec_6_2_a_machine_that_has_ended_sends_nothing() {
    let mut stage = stage(
        "<state id='a'><onentry><send event='e' delay='1s'/></onentry><transition event='go' target='f'/></state><final id='f'/>",
    );
    stage.send("go");
    assert_eq!(stage.machine.next_timer(), None);
}

#[test]
fn channels_get_the_events_sent_to_them() {
    let stage = stage(
        "<datamodel><data id='place' expr=\"'Dock'\"/></datamodel><state id='a'><onentry><send type='channel' target='Navigation' event='go'><param name='place' expr='place'/></send></onentry></state>",
    );
    let sent = &stage.host.sent[0];
    assert_eq!((sent.target.as_deref(), sent.event.as_deref()), (Some("Navigation"), Some("go")));
    assert_eq!(sent.data.to_string(), r#"{"place": "Dock"}"#);
}
