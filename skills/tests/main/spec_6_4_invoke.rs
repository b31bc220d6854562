//! SCXML clauses 6.4 and 6.5: machines that invoke machines; C.1: events between them.

use std::fs;

use skills::{Chart, Event, Machine, Note, Status, Strictness, Transcript, rehearse};
use std::time::Duration;

use crate::stage::{Stage, file, lenient, stage};

const MACHINE: &str = "<scxml xmlns='http://www.w3.org/2005/07/scxml' version='1.0'";

/// An `<invoke>` with these attributes, a machine with this content inside, and possibly more.
fn invoke(attributes: &str, machine: &str, more: &str) -> String {
    format!("<invoke {attributes}><content>{MACHINE}>{machine}</scxml></content>{more}</invoke>")
}

/// A machine that logs every event it gets and invokes one with this content as `c`, and possibly more.
fn parent(machine: &str, more: &str) -> Stage {
    stage(&parent_file(machine, more))
}

fn parent_file(machine: &str, more: &str) -> String {
    format!(
        "<datamodel><data id='x' expr='1'/><data id='y' expr='2'/></datamodel>
         <state id='busy'>{}{more}<transition event='leave' target='idle'/><transition event='*'><log expr='_event.name'/></transition></state>
         <state id='idle'><transition event='*'><log expr=\"'idle ' + _event.name\"/></transition></state>",
        invoke("id='c'", machine, "")
    )
}

/// The log entries of the invoked machine.
fn inner_log(stage: &Stage) -> Vec<String> {
    let line = |note: &Note| match note {
        Note::Invoked { id, note } => match &**note {
            Note::Log { text, .. } => Some(format!("{id}: {text}")),
            _ => None,
        },
        _ => None,
    };
    stage.host.notes.iter().filter_map(line).collect()
}

const TELLS: &str = "<state id='s'><onentry><send target='#_parent' event='hello'/></onentry>
    <transition event='*'><log expr='_event.name'/></transition></state>";

#[test]
fn spec_6_4_an_invoked_machine_can_send_events_to_its_parent() {
    let stage = parent(TELLS, "");
    assert_eq!(stage.log(), "hello");
    let (id, machine) = stage.machine.invoked().next().unwrap();
    assert_eq!((id, machine.active_ids().collect::<Vec<_>>()), ("c", vec!["s"]));
}

#[test]
fn spec_6_4_an_invoked_machine_that_ends_is_reported_as_done() {
    assert_eq!(parent("<final id='f'/>", "").log(), "done.invoke.c");
}

#[test]
fn spec_6_4_events_of_a_machine_come_before_its_end() {
    let content = "<final id='f'><onentry><send target='#_parent' event='last'/></onentry></final>";
    assert_eq!(parent(content, "").log(), "last done.invoke.c");
}

#[test]
fn spec_6_4_exit_handlers_run_before_the_end_is_reported() {
    let content = "<final id='f'><onexit><send target='#_parent' event='exit'/></onexit></final>";
    assert_eq!(parent(content, "").log(), "exit done.invoke.c");
}

#[test]
fn spec_6_4_3_the_done_event_carries_the_donedata_of_the_final_state() {
    let content = "<final id='f'><donedata><param name='a' expr='5'/></donedata></final>";
    let mut stage = stage(&format!(
        "<datamodel><data id='got'/></datamodel><state id='s'>{}<transition event='done.invoke.c'><assign location='got' expr='_event.data.a'/><log expr='_event.invokeid'/></transition></state>",
        invoke("id='c'", content, "")
    ));
    assert_eq!(stage.datum("got"), 5.0.into());
    assert_eq!(stage.log(), "c");
    stage.send("more");
}

#[test]
fn spec_6_4_nothing_is_invoked_for_a_state_that_is_left_in_the_same_macrostep() {
    let stage = stage(&format!(
        "<state id='a'>{}<transition target='b'/></state><state id='b'><transition event='*'><log expr='_event.name'/></transition></state>",
        invoke("", TELLS, "")
    ));
    assert_eq!(stage.log(), "");
}

#[test]
fn spec_6_4_machines_are_invoked_when_the_macrostep_ends_with_internal_events_done() {
    let stage = parent(TELLS, "<onentry><raise event='first'/><raise event='second'/></onentry>");
    assert_eq!(stage.log(), "first second hello");
}

#[test]
fn spec_6_4_machines_are_invoked_in_document_order() {
    let lines =
        |event: &str| format!("<final id='f'><onentry><send target='#_parent' event='{event}'/></onentry></final>");
    let stage = stage(&format!(
        "<state id='s'>{}{}<transition event='one two'><log expr='_event.name'/></transition></state>",
        invoke("", &lines("one"), ""),
        invoke("", &lines("two"), "")
    ));
    assert_eq!(stage.log(), "one two");
}

#[test]
fn spec_6_4_leaving_the_state_ends_the_machine_and_runs_its_exit_handlers() {
    let mut stage = parent("<state id='s'><onexit><log expr=\"'left'\"/></onexit></state>", "");
    stage.send("leave");
    assert_eq!(inner_log(&stage), ["c: left"]);
    assert_eq!(stage.machine.invoked().count(), 0);
}

#[test]
fn spec_6_4_a_canceled_machine_reports_no_end() {
    let mut stage = parent("<state id='s'/>", "");
    stage.send("leave").send("other");
    assert_eq!(stage.log(), "idle other");
}

#[test]
fn spec_6_4_events_of_a_canceled_machine_on_exit_are_dropped() {
    let mut stage = parent("<state id='s'><onexit><send target='#_parent' event='bye'/></onexit></state>", "");
    stage.send("leave");
    assert_eq!(stage.log(), "");
}

#[test]
fn spec_6_4_the_delayed_events_of_a_canceled_machine_never_come() {
    let mut stage =
        parent("<state id='s'><onentry><send target='#_parent' event='late' delay='1s'/></onentry></state>", "");
    stage.send("leave").at_ms(2_000);
    assert_eq!(stage.log(), "");
    assert_eq!(stage.machine.next_timer(), None);
}

#[test]
fn spec_6_4_entering_the_state_again_invokes_again() {
    let mut stage = stage(&format!(
        "<state id='s'>{}<transition event='again' target='s'/><transition event='hello'><log expr='_event.invokeid'/></transition></state>",
        invoke("", TELLS, "")
    ));
    stage.send("again");
    assert_eq!(stage.log(), "s.1 s.2");
}

#[test]
fn spec_6_4_1_a_generated_id_begins_with_that_of_the_state() {
    let stage = stage(&format!(
        "<datamodel><data id='id'/></datamodel><state id='s'>{}</state>",
        invoke("idlocation='id'", "<state id='t'/>", "")
    ));
    assert_eq!(stage.datum("id"), "s.1".into());
}

#[test]
fn spec_6_4_1_a_type_may_be_computed() {
    let content = format!(
        "<state id='s'>{}<transition event='hello'><log expr=\"'ok'\"/></transition></state>",
        invoke("typeexpr=\"'http://www.w3.org/TR/' + 'scxml/'\"", TELLS, "")
    );
    assert_eq!(stage(&content).log(), "ok");
}

#[test]
fn spec_6_4_1_an_unknown_type_is_an_error_of_execution() {
    let content = format!("<state id='s'>{}</state>", invoke("type='http://example.org/voice'", TELLS, ""));
    assert_eq!(lenient(&content).errors(), ["error.execution"]);
}

#[test]
fn spec_6_4_2_parameters_and_names_replace_the_initial_values_of_data() {
    let child = "<datamodel><data id='x' expr='7'/><data id='z' expr='8'/></datamodel>
        <state id='s'><onentry><send target='#_parent' eventexpr=\"'got.' + x + '.' + z\"/></onentry></state>";
    let stage = stage(&format!(
        "<datamodel><data id='x' expr='1'/></datamodel><state id='s'>{}<transition event='got'><log expr='_event.name'/></transition></state>",
        invoke("namelist='x'", child, "<param name='z' expr='x + 1'/>")
    ));
    assert_eq!(stage.log(), "got.1.2");
}

#[test]
fn spec_6_4_2_a_name_without_a_datum_is_ignored() {
    let stage = stage(&format!(
        "<datamodel><data id='x' expr='1'/></datamodel><state id='s'>{}</state>",
        invoke("id='c' namelist='x'", "<state id='t'/>", "")
    ));
    assert_eq!(stage.machine.invoked().next().unwrap().1.datum("x"), None);
}

#[test]
fn spec_6_4_a_machine_whose_arguments_fail_is_not_invoked() {
    let content = format!("<state id='s'>{}</state>", invoke("namelist='nothing'", "<state id='t'/>", ""));
    let stage = lenient(&content);
    assert_eq!(stage.errors(), ["error.execution"]);
    assert_eq!(stage.machine.invoked().count(), 0);
}

#[test]
fn spec_6_4_data_are_not_shared() {
    let child = "<datamodel><data id='x' expr='5'/></datamodel><state id='t'><onentry><assign location='x' expr='6'/></onentry></state>";
    let stage = parent(child, "");
    assert_eq!(stage.datum("x"), 1.0.into());
    assert_eq!(stage.machine.invoked().next().unwrap().1.datum("x"), Some(&6.0.into()));
}

#[test]
fn spec_6_4_a_parent_sends_to_its_machine_by_its_id() {
    let more = "<transition event='ask'><send target='#_c' event='question'/></transition>";
    let mut stage = parent(TELLS, more);
    stage.send("ask");
    assert_eq!(inner_log(&stage), ["c: question"]);
}

#[test]
fn spec_6_4_the_id_of_a_machine_that_has_ended_is_unknown() {
    let mut stage =
        parent("<final id='f'/>", "<transition event='ask'><send target='#_c' event='question'/></transition>");
    stage.send("ask");
    assert_eq!(stage.errors(), ["error.communication"]);
}

#[test]
fn spec_6_4_autoforward_passes_external_events_on_unchanged() {
    let child =
        "<state id='s'><transition event='*'><log expr=\"_event.name + ' ' + _event.data.a\"/></transition></state>";
    let mut stage = stage(&format!("<state id='s'>{}</state>", invoke("id='c' autoforward='true'", child, "")));
    stage.send_with("tick", &[("a", 4.0.into())]);
    assert_eq!(inner_log(&stage), ["c: tick 4"]);
}

#[test]
fn spec_6_4_without_autoforward_nothing_is_passed_on() {
    let mut stage = parent(TELLS, "");
    stage.send("tick");
    assert_eq!(inner_log(&stage), Vec::<String>::new());
}

#[test]
fn spec_6_4_internal_events_are_not_forwarded() {
    let child = "<state id='s'><transition event='*'><log expr='_event.name'/></transition></state>";
    let mut stage = stage(&format!(
        "<state id='s'>{}<transition event='go'><raise event='inner'/></transition></state>",
        invoke("id='c' autoforward='true'", child, "")
    ));
    stage.send("go");
    assert_eq!(inner_log(&stage), ["c: go"]);
}

#[test]
fn spec_6_5_finalize_runs_before_transitions_are_selected() {
    let child =
        "<final id='f'><onentry><send target='#_parent' event='r'><param name='v' expr='2'/></send></onentry></final>";
    let stage = stage(&format!(
        "<datamodel><data id='x' expr='1'/></datamodel><state id='s'>{}<transition event='r' cond='x === 2'><log expr=\"'ok'\"/></transition></state>",
        invoke("", child, "<finalize><assign location='x' expr='_event.data.v'/></finalize>")
    ));
    assert_eq!(stage.log(), "ok");
}

#[test]
fn spec_6_5_finalize_runs_only_for_events_of_its_own_machine() {
    let finalize = "<finalize><log expr=\"'finalized ' + _event.name\"/></finalize>";
    let mut stage = stage(&format!(
        "<state id='s'>{}{}</state>",
        invoke("", "<state id='quiet'/>", finalize),
        invoke("", TELLS, "")
    ));
    stage.send("outside");
    assert_eq!(stage.log(), "");
}

#[test]
fn spec_6_5_an_empty_finalize_assigns_returned_values_to_the_names_sent() {
    let child = "<final id='f'><onentry><send target='#_parent' event='r'><param name='x' expr='9'/><param name='y' expr='8'/><param name='z' expr='7'/></send></onentry></final>";
    let stage = stage(&format!(
        "<datamodel><data id='x' expr='1'/><data id='here' expr='2'/><data id='z' expr='3'/></datamodel><state id='s'>{}</state>",
        invoke("namelist='x'", child, "<param name='y' location='here'/><finalize/>")
    ));
    assert_eq!([stage.datum("x"), stage.datum("here"), stage.datum("z")], [9.0.into(), 8.0.into(), 3.0.into()]);
}

#[test]
fn spec_6_4_machines_invoke_machines_and_communicate_by_session() {
    let grandchild = "<state id='g'><onentry><send targetexpr=\"'#_scxml_test'\" event='deep'/></onentry></state>";
    let child = format!("<state id='s'>{}</state>", invoke("", grandchild, ""));
    let stage = parent(&child, "");
    assert_eq!(stage.log(), "deep");
}

#[test]
fn spec_c_1_an_event_from_another_session_has_a_return_address() {
    let child = "<state id='s'><onentry><send target='#_parent' event='ping'/></onentry><transition event='pong'><log expr='_event.name'/></transition></state>";
    let stage = stage(&format!(
        "<state id='s'>{}<transition event='ping'><send event='pong' targetexpr='_event.origin' typeexpr='_event.origintype'/></transition></state>",
        invoke("id='c'", child, "")
    ));
    assert_eq!(inner_log(&stage), ["c: pong"]);
}

#[test]
fn spec_c_1_a_machine_that_was_not_invoked_has_no_parent() {
    let stage = stage(
        "<state id='s'><onentry><send id='n' target='#_parent' event='e'/></onentry><transition event='error.communication'><log expr='_event.sendid'/></transition></state>",
    );
    assert_eq!(stage.errors(), ["error.communication"]);
    assert_eq!(stage.log(), "n");
}

#[test]
fn spec_6_4_timers_of_an_invoked_machine_are_those_of_the_whole() {
    let child = "<state id='s'><onentry><send event='e' delay='2s'/></onentry><transition event='e'><send target='#_parent' event='late'/></transition></state>";
    let mut stage = parent(child, "<onentry><send event='early' delay='1s'/></onentry>");
    assert_eq!(stage.machine.next_timer(), Some(Duration::from_secs(1)));
    stage.at_ms(3_000);
    assert_eq!(stage.log(), "early late");
}

#[test]
fn spec_6_4_2_a_machine_may_come_from_a_file_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let child = file("", "<final id='f'/>");
    fs::write(folder.path().join("child.scxml"), child).unwrap();
    for source in ["src='file:child.scxml'", "srcexpr=\"'child' + '.scxml'\""] {
        let content = format!(
            "<state id='s'><invoke id='c' {source}/><transition event='done.invoke.c' target='e'/></state><final id='e'/>"
        );
        let path = folder.path().join("parent.scxml");
        fs::write(&path, file("", &content)).unwrap();
        let mut machine = Machine::new(Chart::open(&path, Strictness::Strict).unwrap());
        machine.start(Duration::ZERO, &mut Transcript::default());
        assert_eq!(machine.status(), Status::Done, "{source}");
    }
}

#[test]
fn spec_6_4_recursion_of_machines_is_limited() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("self.scxml");
    let content = "<state id='s'><invoke src='self.scxml'/><invoke src='self.scxml'/></state>";
    fs::write(&path, file("", content)).unwrap();
    let chart = Chart::open(&path, Strictness::Strict).unwrap();
    let mut lines = Vec::new();
    rehearse(&chart, &skills::Cues::default(), Duration::from_secs(1), &mut |line| lines.push(line.to_string()));
    assert!(lines.iter().any(|line| line.contains("too many machines invoke each other")));
}

#[test]
fn spec_6_4_2_a_missing_file_is_an_error() {
    assert!(Chart::load("m.scxml", &file("", "<state id='s'><invoke src='missing.scxml'/></state>")).is_err());
    assert_eq!(lenient("<state id='s'><invoke src='missing.scxml'/></state>").errors(), ["error.execution"]);
}

#[test]
fn spec_6_4_2_a_machine_may_be_computed() {
    let content = format!(
        "<datamodel><data id='m'>{MACHINE}><final id='f'/></scxml></data></datamodel><state id='s'><invoke id='c'><content expr='m'/></invoke><transition event='done.invoke.c' target='e'/></state><final id='e'/>"
    );
    assert!(stage(&content).is_done());
}

#[test]
fn spec_6_4_content_that_is_not_a_machine_is_not_invoked() {
    let content = "<state id='s'><invoke><content expr='5'/></invoke></state>";
    assert_eq!(stage(content).errors(), ["error.execution"]);
}

#[test]
fn a_machine_with_machines_inside_is_a_value() {
    let child = "<datamodel><data id='n' expr='0'/></datamodel><state id='s'><transition event='e'><assign location='n' expr='n + 1'/></transition></state>";
    let mut one = stage(&format!("<state id='s'>{}</state>", invoke("id='c' autoforward='true'", child, "")));
    let copy = one.machine.clone();
    assert_eq!(one.machine, copy);
    one.machine.handle(Event::external("e"), Duration::ZERO, &mut one.host);
    assert_ne!(one.machine, copy);
    assert_eq!(copy.invoked().next().unwrap().1.datum("n"), Some(&0.0.into()));
}
