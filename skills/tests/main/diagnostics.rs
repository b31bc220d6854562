//! The messages about broken files: every mistake, with its location.

use std::fmt::Write;

use diagnostics::Problem;
use miette::{Diagnostic, NarratableReportHandler};
use skills::{Chart, SHIPPED, SkillError, SkillProcess, shipped};

use crate::conversation::{skill, topology};
use crate::stage::file;

fn rendered(error: &SkillError) -> String {
    let mut text = String::new();
    NarratableReportHandler::new().with_context_lines(0).render_report(&mut text, error).unwrap();
    text
}

fn refused(text: &str) -> String {
    match Chart::load("broken.scxml", text) {
        Ok(chart) => panic!("loaded: {chart:?}"),
        Err(error) => rendered(&error),
    }
}

/// One line per problem: the labelled text, the message, the help.
pub(crate) fn in_short(text: &str, problems: &[Problem]) -> String {
    let mut short = String::new();
    for problem in problems {
        let labels: Vec<&str> = problem
            .labels()
            .into_iter()
            .flatten()
            .map(|label| &text[label.offset()..label.offset() + label.len()])
            .collect();
        let labels = labels.join(" | ");
        let labels = labels.split_whitespace().collect::<Vec<_>>().join(" ");
        writeln!(short, "«{labels}» {problem}").unwrap();
        if let Some(help) = problem.help() {
            writeln!(short, "    {help}").unwrap();
        }
    }
    short
}

fn problems(text: &str) -> String {
    match Chart::load("broken.scxml", text) {
        Ok(chart) => panic!("loaded: {chart:?}"),
        Err(SkillError::Load { problems, .. }) => in_short(text, &problems),
        Err(other) => panic!("{other}"),
    }
}

#[test]
fn a_report_has_file_line_text_and_help() {
    let text = "<scxml xmlns='http://www.w3.org/2005/07/scxml' version='1.0'>
  <datamodel><data id='threshold' expr='30'/></datamodel>
  <state id='idle'>
    <transition event='tick' cond='_event.data.level &gt; treshold' target='gett'/>
  </state>
  <state id='get'/>
</scxml>";
    insta::assert_snapshot!(refused(text));
}

#[test]
fn every_structural_mistake_is_reported() {
    insta::assert_snapshot!(problems(
        "<scxml xmlns='http://www.w3.org/2005/07/scxml' intial='a' version='2.0'>
         <stat id='a'/>
         <state name='a'><onenter/><raise event='e'/></state>
         <state id='b'>some text<transition><send/><transition/></transition></state>
         <state id='b'><onentry><assign expr='1'/><if><log/></if></onentry></state>
         <state id='c'><invoke type='scxml'><finalize/></invoke></state>
         <final id='d'><transition event='x'/></final>
         <state id='two words'><datamodel><data/><data src='x.json' id='x'/></datamodel></state></scxml>"
    ));
}

#[test]
fn every_mistake_about_states_is_reported() {
    insta::assert_snapshot!(problems(&file(
        "initial='idel' datamodel='xpath' binding='eager'",
        "<state id='idle' initial='x'><transition target='gone'/><transition event='e' target=''/></state>
         <state id='s' initial='t'><initial><transition target='u'/></initial><state id='u'/></state>
         <state id='t'><initial><transition event='e' target='idle'/></initial><state id='v'/><state id='w'/></state>
         <state id='h' initial='idle'><history id='hh' type='total'/><state id='x'/></state>
         <parallel id='p'><history id='ph'><transition cond='true'/></history><state id='p1'><state id='p11'/><state id='p12'/></state>
           <state id='p2'/><transition event='e' target='p11 p12'/><transition event='f' target='p1 p11' type='local'/></parallel>
         <state id='v'/>"
    )));
}

#[test]
fn every_mistake_in_events_and_content_is_reported() {
    insta::assert_snapshot!(problems(&file(
        "",
        "<datamodel><data id='x' expr='1'>2</data><data id='x'/><data id='new'/><data id='_event'/></datamodel>
         <state id='a'>
           <transition event='a.*.b *x'/><transition event=''/>
           <onentry>
             <raise event='two words'/>
             <if cond='true'><else/><elseif cond='false'/></if>
             <foreach array='x' item='1st'><log/></foreach>
             <assign location='x'/><assign location='x' expr='1'>2</assign><assign location='3' expr='1'/>
             <send event='e' eventexpr='f'/><send/><send event='e' type='channel'/><send event='e' type='pigeon'/>
             <send type='channel' target='T'><content>1</content></send>
             <send event='e' delay='soon'/><send event='e' delay='1s' target='#_internal'/><send event='e' namelist='y'/>
             <send event='e'><param name='p'/><param name='q' expr='1'/><content/></send>
             <cancel sendid='a' sendidexpr='b'/>
           </onentry>
         </state>"
    )));
}

#[test]
#[cfg(not(feature = "ecmascript"))]
fn every_mistake_in_an_expression_is_reported_with_its_location() {
    let conditions = [
        "1 +",
        "(1 + 2",
        "x = 3",
        "x === 1 and y",
        "thresold > 3",
        "In('wherever')",
        "Math.floor(x)",
        "foo(1)",
        "x ? 1",
        "'never closed",
        "a &lt; 3px",
        "new Date()",
        "x[1",
        "/re/",
        "1 2",
        "",
        "x..y",
        "{a 1}",
        "x++",
        "`t`",
        "a?.b",
        "y &amp;&amp; unknown1 || unknown2",
    ];
    let transitions: Vec<String> =
        conditions.iter().map(|condition| format!("<transition cond=\"{condition}\" target='a'/>")).collect();
    let data = "<datamodel><data id='x'/><data id='y'/><data id='a'/><data id='threshold'/></datamodel>";
    insta::assert_snapshot!(problems(&file("", &format!("{data}<state id='a'>{}</state>", transitions.join("\n")))));
}

#[test]
#[cfg(not(feature = "ecmascript"))]
fn every_mistake_in_a_script_is_reported_with_its_location() {
    insta::assert_snapshot!(problems(&file(
        "",
        "<datamodel><data id='x'/></datamodel>
         <script>x = 1; if (x) { x = 2 }</script><script>y = 3</script><script>x + = 3</script><script>_event = 1</script>
         <script>x = 1 x = 2</script><script>function f() {}</script><state id='a'/>"
    )));
}

#[test]
fn text_that_is_not_scxml_is_refused() {
    let mut all = String::new();
    let deep = format!("{}{}", "<state>".repeat(100), "</state>".repeat(100));
    for text in [
        "",
        "no xml",
        "<scxml",
        "<scxml>\n  <state></scxml>",
        "<scxml>\n  <stat id='a'></state></scxml>",
        "<scxml>\n  <state id='a'></sate></scxml>",
        "<!DOCTYPE x [<!ENTITY a 'aaaa'>]><x>&a;</x>",
        "<robot/>",
        "<scxml version='1.0'><state/></scxml>",
        "<scxml xmlns='http://www.w3.org/2005/07/scxml' version='1.0'/>",
        &file("", &deep),
        &file("", &"<state/>".repeat(100_001)),
    ] {
        writeln!(all, "{}", problems(text).trim_end()).unwrap();
    }
    insta::assert_snapshot!(all);
}

#[test]
fn a_file_with_nothing_but_states_may_be_large() {
    let many: String = (0..20_000).map(|id| format!("<state id='s{id}'/>")).collect();
    assert_eq!(Chart::load("large.scxml", &file("", &many)).unwrap().states().count(), 20_000);
}

#[test]
fn mistakes_that_the_recommendation_forgives_are_warnings_on_request() {
    let text = file(
        "",
        "<state id='a'><transition cond='nothing' target='a'/><onentry><send event='e' delay='x'/></onentry></state>",
    );
    let chart = Chart::load_with("t.scxml", &text, skills::Strictness::Standard).unwrap();
    insta::assert_snapshot!(in_short(&text, chart.warnings()));
}

/// SCXML 3.5.1: a transition must have at least one of `event`, `cond` and `target`.
#[test]
fn a_transition_without_event_condition_or_target_is_refused() {
    let reported = problems(&file("", "<state id='a'><transition/></state>"));
    assert_eq!(
        reported,
        "«transition» a transition needs an event, a condition or a target\n    \
         put actions on entering the state in <onentry>\n"
    );
    for enough in ["event='e'", "cond='false'", "target='a'"] {
        let text = file("", &format!("<state id='a'><transition {enough}/></state>"));
        assert!(Chart::load("t.scxml", &text).is_ok(), "{enough}");
    }
}

#[test]
fn a_state_with_two_initial_states_has_no_unreachable_ones() {
    let reported = problems(&file(
        "",
        "<state id='a' initial='a1'><initial><transition target='a2'/></initial><state id='a1'/><state id='a2'/></state>",
    ));
    assert_eq!(reported, "«a1 | initial» the initial state is given twice\n");
    let reported = problems(&file(
        "",
        "<state id='a' initial='b1'><initial><transition target='b2'/></initial><state id='a1'/></state>",
    ));
    assert!(reported.contains("unknown state `b1`") && reported.contains("unknown state `b2`"), "{reported}");
}

#[test]
fn a_machine_without_a_namespace_gives_one_problem() {
    let reported = problems("<scxml version='1.0'><state id='a'/></scxml>");
    assert!(reported.starts_with("«scxml» this <scxml> has no namespace\n"), "{reported}");
    assert_eq!(reported.matches('«').count(), 1, "{reported}");
}

/// Problems that SCXML makes error events (3.13, 5.4, 6.2.4) do not mean that the machine could not be loaded.
#[test]
fn a_machine_that_standard_scxml_would_run_is_refused_as_such() {
    let forgiven = |content: &str| {
        let text = file("", &format!("<state id='a'><onentry>{content}</onentry></state>"));
        assert!(Chart::load_with("t.scxml", &text, skills::Strictness::Standard).is_ok(), "{content}");
        rendered(&Chart::load("t.scxml", &text).unwrap_err())
    };
    for content in ["<send event='e' type='pigeon'/>", "<assign location='nothing' expr='1'/>"] {
        let reported = forgiven(content);
        assert!(
            reported.starts_with("the skill t.scxml is refused, although standard SCXML would run it: "),
            "{reported}"
        );
        assert!(reported.contains("`error.execution` when the machine gets there"), "{reported}");
    }
    let reported =
        refused(&file("", "<state id='a'><onentry><send event='e' type='pigeon'/><sned/></onentry></state>"));
    assert!(reported.starts_with("the skill broken.scxml cannot be loaded: 2 problems"), "{reported}");
    assert!(!reported.contains("gets there"), "{reported}");
}

#[test]
fn every_wiring_mistake_is_reported() {
    let text = file(
        "",
        "<datamodel><data id='place' expr=\"'Moon'\"/><data id='here' expr=\"'Destination'\"/></datamodel>
         <state id='a'>
           <transition event='BT.tic Navigtion.ok Localization.ok Navigation.ok go'/>
           <transition event='timeout Navigation BT.* error'/>
           <onentry>
             <send type='channel' target='Navigaton' event='get_status'/>
             <send type='channel' target='BatteryReader' event='get_level'/>
             <send type='channel' target='Navigation' event='get_statu'/>
             <send type='channel' target='Navigation' event='get_status'/>
             <send type='channel' target='Navigation' event='get_status'><param name='plaice' expr='here'/></send>
             <send type='channel' target='Navigation' event='get_status'><param name='place' expr='place'/></send>
             <send type='channel' target='Navigation' event='get_status'><param name='place' expr='here'/></send>
             <send type='channel' target='BT' event='succes'/>
             <send event='timeout' delay='1s'/>
           </onentry>
         </state>",
    );
    let chart = Chart::load("broken.scxml", &text).unwrap();
    match SkillProcess::new("GoToDestination", &chart, &topology(), []) {
        Err(SkillError::Wiring { problems, .. }) => insta::assert_snapshot!(in_short(&text, &problems)),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_parameter_that_no_message_can_carry_is_found_before_the_run() {
    let error = skill("GoToDestination", &[("place", "Kitchen".into())]).unwrap_err();
    let SkillError::Wiring { problems, .. } = &error else { panic!("{error}") };
    let first = in_short(shipped("GoToDestination").unwrap(), &problems[..1]);
    assert!(first.starts_with("«place» the field `place` of <stop_navigation> cannot be \"Kitchen\""), "{first}");
}

#[test]
fn unknown_names_are_refused() {
    let mut all = String::new();
    for error in [
        skill("BatteryLevel", &[("treshold", 30.0.into())]).unwrap_err(),
        SkillProcess::new("BatteryLvel", &crate::conversation::chart("BatteryLevel"), &topology(), []).unwrap_err(),
    ] {
        all += &rendered(&error);
    }
    insta::assert_snapshot!(all);
}

#[test]
fn shipped_names_are_leaves() {
    assert_eq!(shipped("Nobody"), None);
    assert!(SHIPPED.iter().all(|(leaf, text)| shipped(leaf) == Some(*text)));
}

/// A file of another kind is reported once, as such, whatever else in it is not SCXML.
#[test]
fn a_foreign_dialect_is_named_once() {
    let roaml = |namespace: &str| {
        format!(
            "<scxml xmlns=\"{namespace}\" version='1.0' datamodel='ecmascript' name='Go' initial='idle'>
               <datamodel><data id='far' type='float32' expr='0.5'/></datamodel>
               <ros_service_server service_name='/Go/tick' type='TickAction'/>
               <state id='idle'><ros_service_handle_request name='/Go/tick' target='go'/></state> <state id='go'/>
             </scxml>"
        )
    };
    let reported = problems(&roaml("http://www.w3.org/2005/07/scxml"));
    assert!(reported.starts_with("«ros_service_server» this is a machine of RoAML"), "{reported}");
    assert_eq!(reported.matches('«').count(), 1, "{reported}");

    let reported = problems(&roaml("..."));
    assert!(reported.contains("xmlns=\"...\"") && reported.contains("this is a machine of RoAML"), "{reported}");
    assert_eq!(reported.matches('«').count(), 1, "{reported}");

    let reported = problems("<ascxml name='Go'><state id='idle'><bt_tick/></state></ascxml>");
    assert!(reported.starts_with("«ascxml» this is a machine of RoAML"), "{reported}");
    assert!(problems("<roaml><parameters/></roaml>").starts_with("«roaml» this is a whole RoAML model"));

    let reported = problems("<scxml version='1.0' xmlns='http://example.org/other'><state id='a'/></scxml>");
    assert!(
        reported.starts_with(
            "«xmlns='http://example.org/other'» `xmlns=\"http://example.org/other\"` is not the namespace"
        )
    );
    assert_eq!(reported.matches('«').count(), 1, "{reported}");

    let reported = problems(&file(
        "datamodel='cplusplus:GoData:GoData.h'",
        "<state id='a'><transition event='e' cond='isFar(m_place.c_str())'/><onentry><script>drive(&amp;x);</script></onentry></state>",
    ));
    assert!(reported.contains("this is a Qt machine with a C++ data model"), "{reported}");
    assert_eq!(reported.matches('«').count(), 1, "{reported}");
}

#[test]
fn a_blank_line_before_the_xml_declaration_is_reported_as_such() {
    let reported = problems(
        "\n<?xml version='1.0'?><scxml xmlns='http://www.w3.org/2005/07/scxml' version='1.0'><state id='a'/></scxml>",
    );
    assert!(
        reported.contains("`<?xml …?>` must be at the very beginning of the file\n    remove the blanks and lines"),
        "{reported}"
    );
}

#[test]
fn an_event_that_a_machine_sends_itself_and_never_handles_is_reported() {
    let answer = "<send event='TICK_RESPONSE'><param name='status' expr='1'/></send>";
    let text = file(
        "",
        &format!(
            "<state id='a'><onentry><send event='heard'/></onentry><transition event='TICK'>{answer}</transition>
           <transition event='HALT'>{answer}</transition><transition event='heard'/></state>"
        ),
    );
    let chart = Chart::load("t.scxml", &text).unwrap();
    let reported = in_short(&text, chart.warnings());
    assert_eq!(
        reported.lines().next(),
        Some(
            "«send» the machine sends itself the event `TICK_RESPONSE`, here and in one other place, but no \
             transition handles it"
        )
    );
    assert_eq!(chart.warnings().len(), 1, "{reported}");
}
