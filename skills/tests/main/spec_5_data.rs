//! SCXML clause 5: the data model, and B.2: ECMAScript in it.

use skills::{Chart, Datum, Event, Machine, SkillError, Strictness, Transcript};

use crate::stage::{file, lenient, stage, stage_with};

fn with_data(data: &str) -> crate::stage::Stage {
    stage(&format!("<datamodel>{data}</datamodel><state id='a'/>"))
}

#[test]
fn spec_5_3_data_have_the_values_of_their_expressions() {
    let stage = with_data("<data id='x' expr='2 * 21'/><data id='y' expr='x + 1'/><data id='z'/>");
    assert_eq!((stage.datum("x"), stage.datum("y"), stage.datum("z")), (42.0.into(), 43.0.into(), Datum::Undefined));
}

#[test]
fn spec_5_3_an_empty_expression_leaves_the_datum_undefined() {
    // One of the two traps of issue 4.
    let mut stage = stage(
        "<datamodel><data id='x' expr=''/><data id='y' expr=' '/></datamodel>
         <state id='a'><transition event='e' cond='x === undefined' target='b'/></state><state id='b'/>",
    );
    assert_eq!((stage.datum("x"), stage.datum("y")), (Datum::Undefined, Datum::Undefined));
    assert_eq!(stage.send("e").active(), "b");
    assert_eq!(stage.errors(), [""; 0]);
}

#[test]
fn spec_5_3_a_value_between_tags_is_json_or_text_with_white_space_collapsed() {
    let stage = with_data(
        "<data id='x'>[1, {\"a\": null}]</data><data id='y'> all   work\n no play </data><data id='z'><![CDATA[7]]></data>",
    );
    assert_eq!(stage.datum("x").to_string(), r#"[1, {"a": null}]"#);
    assert_eq!(stage.datum("y"), "all work no play".into());
    assert_eq!(stage.datum("z"), 7.0.into());
}

#[test]
fn spec_5_3_a_datum_whose_expression_fails_is_undefined_and_an_error() {
    let stage = lenient(
        "<datamodel><data id='x' expr='return'/></datamodel>
         <state id='a'><transition event='error.execution' cond='x === undefined' target='b'/></state><state id='b'/>",
    );
    assert_eq!(stage.active(), "b");
}

#[test]
fn spec_5_3_all_data_share_one_scope() {
    let stage = stage(
        "<state id='a'><onentry><log expr='x'/></onentry></state><state id='b'><datamodel><data id='x' expr='7'/></datamodel></state>",
    );
    assert_eq!(stage.log(), "7");
}

#[test]
fn spec_5_3_3_late_binding_waits_until_the_state_is_entered_and_happens_once() {
    let machine = "<datamodel><data id='n' expr='1'/></datamodel>
         <state id='a'><onentry><log expr='typeof x'/></onentry><transition event='e' target='b'/></state>
         <state id='b'><datamodel><data id='x' expr='n'/></datamodel><onentry><log expr='x'/><assign location='x' expr='x + 10'/></onentry>
           <transition event='e' target='a'/></state>";
    let mut stage = stage_with("binding='late'", machine, Strictness::Strict);
    stage.send("e").send("e").send("e");
    assert_eq!(stage.log(), "undefined 1 number 11");
}

#[test]
fn spec_5_4_assign_changes_a_datum() {
    let mut stage = stage(
        "<datamodel><data id='x' expr='1'/></datamodel><state id='a'><transition event='e'><assign location='x' expr='x + 1'/></transition></state>",
    );
    stage.send("e").send("e");
    assert_eq!(stage.datum("x"), 3.0.into());
}

#[test]
fn spec_5_4_assign_changes_a_part_of_a_datum() {
    let stage = stage(
        "<datamodel><data id='x' expr='{a: {b: 1}, list: [1, 2]}'/><data id='i' expr='1'/></datamodel>
         <state id='a'><onentry><assign location='x.a.b' expr='2'/><assign location='x.list[i]' expr='9'/><assign location='x.c' expr='3'/></onentry></state>",
    );
    assert_eq!(stage.datum("x").to_string(), r#"{"a": {"b": 2}, "list": [1, 9], "c": 3}"#);
}

#[test]
fn spec_5_4_assign_with_content() {
    let stage = stage(
        "<datamodel><data id='x'/></datamodel><state id='a'><onentry><assign location='x'>{\"a\": 1}</assign></onentry></state>",
    );
    assert_eq!(stage.datum("x").to_string(), r#"{"a": 1}"#);
}

#[test]
fn spec_5_4_assign_to_an_undeclared_datum_is_an_error_and_ends_the_block() {
    let stage = lenient(
        "<state id='a'><onentry><assign location='nowhere' expr='1'/><raise event='not'/></onentry><transition event='not' target='wrong'/><transition event='error.execution' target='right'/></state><state id='right'/><state id='wrong'/>",
    );
    assert_eq!(stage.active(), "right");
}

#[test]
fn spec_5_4_a_failing_assignment_changes_nothing() {
    let stage = stage(
        "<datamodel><data id='x' expr='{a: 1}'/></datamodel><state id='a'><onentry><assign location='x.a.b.c' expr='2'/></onentry></state>",
    );
    assert_eq!(stage.datum("x").to_string(), r#"{"a": 1}"#);
    assert_eq!(stage.errors(), ["error.execution"]);
}

#[test]
fn spec_5_5_donedata_is_the_data_of_the_done_event() {
    let stage = stage(
        "<datamodel><data id='x' expr='1'/></datamodel>
         <state id='s'><final id='f'><donedata><param name='p' expr='x + 1'/><param name='q' location='x'/></donedata></final>
           <transition event='done.state.s' target='end'><assign location='x' expr='_event.data'/></transition></state><state id='end'/>",
    );
    assert_eq!(stage.datum("x").to_string(), r#"{"p": 2, "q": 1}"#);
}

#[test]
fn spec_5_6_content_is_the_data_of_the_event() {
    let stage = stage(
        "<datamodel><data id='x'/></datamodel>
         <state id='s'><final id='f'><donedata><content expr='[1, 2]'/></donedata></final>
           <transition event='done.state.s'><assign location='x' expr='_event.data'/></transition></state>",
    );
    assert_eq!(stage.datum("x").to_string(), "[1, 2]");
}

#[test]
fn spec_5_7_a_failing_parameter_is_an_error_and_left_out() {
    let stage = stage(
        "<datamodel><data id='x'/></datamodel>
         <state id='s'><final id='f'><donedata><param name='p' expr='x.y'/><param name='q' expr='2'/></donedata></final>
           <transition event='done.state.s'><assign location='x' expr='_event.data'/></transition></state>",
    );
    assert_eq!(stage.datum("x").to_string(), r#"{"q": 2}"#);
    assert_eq!(stage.errors(), ["error.execution"]);
}

#[test]
fn spec_5_8_a_script_of_the_machine_runs_before_anything_is_entered() {
    let stage = stage(
        "<datamodel><data id='x' expr='1'/></datamodel><script>x += 1; var y = x * 10</script><state id='a'><onentry><log expr='x'/><log expr='y'/></onentry></state>",
    );
    assert_eq!(stage.log(), "2 20");
}

#[test]
fn spec_5_8_scripts_assign_in_every_way() {
    let stage = stage(
        "<datamodel><data id='x' expr='10'/><data id='o' expr='{n: 1}'/></datamodel>
         <state id='a'><onentry><script>
           x++
           ++x // comment
           x -= 2; x *= 3; x /= 2; x %= 8
           o.n += 4; o['m'] = 'a'; x + 1;
           let unused
         </script></onentry></state>",
    );
    assert_eq!(stage.datum("x"), 7.0.into());
    assert_eq!(stage.datum("o").to_string(), r#"{"n": 5, "m": "a"}"#);
}

#[test]
fn spec_5_9_1_a_condition_may_be_of_any_type() {
    for (condition, holds) in
        [("'text'", true), ("''", false), ("0", false), ("[]", true), ("null", false), ("undefined", false)]
    {
        let machine =
            format!("<state id='a'><transition event='e' cond=\"{condition}\" target='b'/></state><state id='b'/>");
        assert_eq!(stage(&machine).send("e").active() == "b", holds, "{condition}");
    }
}

#[test]
fn spec_5_9_1_a_failing_condition_is_false_and_an_error() {
    let mut stage = stage(
        "<state id='a'><transition event='e' cond='_event.data.x.y' target='wrong'/><transition event='error.execution' target='right'/></state>
         <state id='right'/><state id='wrong'/>",
    );
    assert_eq!(stage.send("e").active(), "right");
}

#[test]
fn spec_5_9_2_in_tells_which_states_are_active() {
    let mut stage = stage(
        "<datamodel><data id='which' expr=\"'x2'\"/></datamodel>
         <parallel id='p'><state id='x'><state id='x1'><transition event='e' target='x2'/></state><state id='x2'/></state>
           <state id='y'><state id='y1'><transition cond=\"In('x2') &amp;&amp; In(which) &amp;&amp; !In('x1')\" target='y2'/></state><state id='y2'/></state></parallel>",
    );
    assert_eq!(stage.active(), "x1 y1");
    assert_eq!(stage.send("e").active(), "x2 y2");
}

#[test]
fn spec_5_10_1_event_has_its_fields() {
    let mut stage = stage(
        "<state id='a'><transition event='*'><log expr='_event.name'/><log expr='_event.type'/><log expr='_event.sendid'/>
           <log expr='_event.origin'/><log expr='_event.origintype'/><log expr='_event.invokeid'/><log expr='_event.data.level'/></transition></state>",
    );
    let data = Datum::object([("level", Datum::from(83.2))]).unwrap();
    stage.send_event(Event::external("Reader.ok").with_data(data).with_origin("Reader", "channel"));
    assert_eq!(stage.log(), "Reader.ok external undefined Reader channel undefined 83.2");
}

#[test]
fn spec_5_10_1_event_types_are_platform_internal_and_external() {
    let mut stage = stage(
        "<datamodel><data id='x'/></datamodel>
         <state id='a'><onentry><raise event='i'/><log expr='x.y'/></onentry><transition event='*'><log expr='_event.type'/></transition></state>",
    );
    stage.send("e");
    assert_eq!(stage.log(), "internal platform external");
}

#[test]
fn spec_5_10_1_event_is_not_bound_before_the_first_event() {
    assert_eq!(stage("<state id='a'><onentry><log expr='typeof _event'/></onentry></state>").log(), "undefined");
}

#[test]
fn spec_5_10_1_event_stays_bound_while_the_states_are_entered() {
    let mut stage = stage(
        "<state id='a'><transition event='e' target='b'/></state><state id='b'><onentry><log expr='_event.name'/></onentry></state>",
    );
    assert_eq!(stage.send("e").log(), "e");
}

#[test]
fn spec_5_10_name_and_session_are_known() {
    let machine = "<state id='a'><onentry><log expr='_name'/><log expr='typeof _sessionid'/><log expr=\"_ioprocessors['http://www.w3.org/TR/scxml/#SCXMLEventProcessor'].location\"/></onentry></state>";
    assert_eq!(stage_with("name='Lamp'", machine, Strictness::Strict).log(), "Lamp string #_scxml_Lamp");
}

#[test]
fn spec_5_10_system_variables_cannot_be_assigned_to() {
    for variable in ["_event", "_event.data", "_name", "_sessionid", "_ioprocessors"] {
        let machine = format!(
            "<state id='a'><onentry><assign location='{variable}' expr='1'/></onentry><transition event='error.execution' target='b'/></state><state id='b'/>"
        );
        assert_eq!(lenient(&machine).active(), "b", "{variable}");
    }
}

#[test]
fn spec_b_1_the_null_data_model_has_in() {
    let mut stage = stage_with(
        "datamodel='null'",
        "<parallel><state id='x'><state id='x1'><transition event='e' target='x2'/></state><state id='x2'/></state>
         <state id='y'><state id='y1'><transition cond=\"In('x2')\" target='y2'/></state><state id='y2'/></state></parallel>",
        Strictness::Strict,
    );
    assert_eq!(stage.send("e").active(), "x2 y2");
}

#[test]
fn spec_b_2_undefined_is_not_greater_than_anything() {
    let mut stage = stage(
        "<state id='a'><transition event='e' cond='_event.data.level > 30' target='wrong'/><transition event='e' target='right'/></state><state id='right'/><state id='wrong'/>",
    );
    assert_eq!(stage.send_with("e", &[("charge", 50.0.into())]).active(), "right");
}

#[test]
fn spec_b_2_strings_concatenate_with_numbers() {
    assert_eq!(stage("<datamodel><data id='t' expr='0.5'/></datamodel><state id='a'><onentry><log expr=\"'in ' + t + ' s'\"/></onentry></state>").log(), "in 0.5 s");
}

#[test]
fn spec_6_4_2_the_caller_that_starts_a_machine_may_set_its_data() {
    let content = "<datamodel><data id='x' expr='1'/><data id='y' expr='x + 1'/></datamodel><state id='a'><datamodel><data id='inner'/></datamodel></state>";
    let chart = Chart::load("t.scxml", &file("", content)).unwrap();
    let mut machine = Machine::with_parameters(chart.clone(), [("x", 10.0.into())]).unwrap();
    machine.start(std::time::Duration::ZERO, &mut Transcript::default());
    assert_eq!(machine.datum("y"), Some(&11.0.into()));
    for name in ["z", "inner"] {
        let refused = Machine::with_parameters(chart.clone(), [(name, 1.0.into())]);
        assert!(matches!(refused, Err(SkillError::UnknownParameter { .. })), "{name}");
    }
}
