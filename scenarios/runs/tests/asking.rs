//! Leaves whose machine is written from what they ask, begin or wait for.

use std::path::PathBuf;

use runs::Run;
use serde_json::Value;
use skills::Chart;
use tempfile::{TempDir, tempdir};

use crate::{concerns, load, problems, recorded, report};

const INTERFACE: &str = "
[services.weigh]
request = { what = \"text\" }
reply = { grams = \"real\" }
[services.rest]
[services.look]
reply = { state = [\"open\", \"shut\"] }
[topics.light]
fields = { lux = \"real\" }
[actions.pick]
goal = { what = \"text\" }
feedback = { share = \"real\" }
result = { grams = \"real\" }
";

/// An arm that weighs in 1.5 s, picks in 4 s, refuses a stone and never has done with sand. It publishes how light it
/// is.
const ARM: &str = r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" datamodel="ecmascript" name="Arm">
  <datamodel><data id="client"/><data id="what"/><data id="lux" expr="0"/><data id="rest" expr="'1ms'"/></datamodel>
  <parallel id="arm">
    <state id="lamp">
      <state id="on">
        <onentry><send event="second" delay="1s"/></onentry>
        <transition event="second" target="on">
          <assign location="lux" expr="lux + 10"/>
          <send type="channel" event="light"><param name="lux" expr="lux"/></send>
        </transition>
      </state>
    </state>
    <state id="hand" initial="idle">
      <transition event="rest">
        <assign location="client" expr="_event.origin"/>
        <send event="rested" delayexpr="rest"/>
      </transition>
      <transition event="rested"><send type="channel" targetexpr="client" event="ok"/></transition>
      <state id="idle">
        <transition event="weigh" target="weighing">
          <assign location="client" expr="_event.origin"/>
          <assign location="what" expr="_event.data.what"/>
        </transition>
        <transition event="pick.goal" cond="_event.data.what == 'stone'">
          <send type="channel" targetexpr="_event.origin" event="pick.rejected"><param name="reason" expr="'too heavy'"/></send>
        </transition>
        <transition event="pick.goal" target="picking">
          <assign location="client" expr="_event.origin"/>
          <assign location="what" expr="_event.data.what"/>
          <send type="channel" targetexpr="client" event="pick.accepted"/>
        </transition>
      </state>
      <state id="weighing">
        <onentry><send event="weighed" id="weighed" delay="1500ms"/></onentry>
        <transition event="weighed" cond="what == 'sand'" target="idle">
          <send type="channel" targetexpr="client" event="error"><param name="reason" expr="'it trickles away'"/></send>
        </transition>
        <transition event="weighed" target="idle">
          <send type="channel" targetexpr="client" event="ok"><param name="grams" expr="what.length"/></send>
        </transition>
      </state>
      <state id="picking">
        <onentry><send event="half" id="half" delay="2s"/><send event="done" id="done" delay="4s"/></onentry>
        <onexit><cancel sendid="half"/><cancel sendid="done"/></onexit>
        <transition event="half">
          <send type="channel" targetexpr="client" event="pick.feedback"><param name="share" expr="0.5"/></send>
        </transition>
        <transition event="done" cond="what != 'sand'" target="idle">
          <send type="channel" targetexpr="client" event="pick.succeeded"><param name="grams" expr="what.length"/></send>
        </transition>
        <transition event="pick.cancel" target="idle">
          <send type="channel" targetexpr="client" event="pick.canceled"/>
        </transition>
      </state>
    </state>
  </parallel>
</scxml>"#;

/// A folder with a scenario: this tree around the leaf `Do`, and these lines.
fn folder(tree: &str, lines: &str) -> (TempDir, PathBuf) {
    let folder = tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let model = "<Action ID=\"Do\"><input_port name=\"what\"/><output_port name=\"grams\" type=\"double\"/>\
                 <output_port name=\"share\" type=\"double\"/></Action><Condition ID=\"Is\"/>";
    write(
        "tree.xml",
        &format!(
            "<root BTCPP_format=\"4\"><BehaviorTree ID=\"T\">{tree}</BehaviorTree><TreeNodesModel>{model}</TreeNodesModel></root>"
        ),
    );
    write("arm.toml", INTERFACE);
    write("Arm.scxml", ARM);
    std::fs::create_dir(folder.path().join("skills")).unwrap();
    let parts = "tree = \"tree.xml\"\nskills = \"skills\"\nexecution.max_time_s = 12\n\
                 components.Arm.machine = \"Arm.scxml\"\ncomponents.Arm.interface = \"arm.toml\"";
    write("own.toml", &format!("{parts}\n{lines}\n"));
    let path = folder.path().join("own.toml");
    (folder, path)
}

/// A message on a channel: when, from, to, and its fields.
struct Sent {
    time_s: f64,
    line: String,
}

/// The messages of a run that go to or come from the leaf.
fn messages((folder, scenario): &(TempDir, PathBuf)) -> Vec<Sent> {
    let warned = concerns(&load(scenario, &[]).unwrap()).concat();
    assert!(!warned.contains("is never entered"), "{warned}");
    let log = folder.path().join("run.jsonl");
    let report = recorded(scenario, &[], &log);
    assert_eq!(report["outcome"], "as_expected", "{report}");
    let word = |field: &Value| field["sym"].as_str().map_or_else(|| field.to_string(), str::to_owned);
    let log = std::fs::read_to_string(log).unwrap();
    let events = log.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
    let messages = events.filter(|event| event["from"].is_string()).map(|event| {
        let fields: Vec<String> = event["message"].as_array().unwrap().iter().map(word).collect();
        let [from, to] = ["from", "to"].map(|end| event[end].as_str().unwrap().to_owned());
        Sent { time_s: event["time_s"].as_f64().unwrap(), line: format!("{from} {to} {}", fields.join(" ")) }
    });
    messages.filter(|sent| !sent.line.starts_with("TickGenerator")).collect()
}

/// When a message that begins so was first sent.
fn first(messages: &[Sent], begin: &str) -> f64 {
    let found = messages.iter().find(|sent| sent.line.starts_with(begin));
    found.unwrap_or_else(|| panic!("no {begin} in {:#?}", lines(messages))).time_s
}

fn lines(messages: &[Sent]) -> Vec<&str> {
    messages.iter().map(|sent| sent.line.as_str()).collect()
}

#[test]
fn a_request_succeeds_with_its_reply_and_writes_its_fields() {
    let tree = "<Sequence><Do what=\"feather\" grams=\"{g}\"/><Do name=\"Again\" what=\"{g}\"/></Sequence>";
    let leaves = "leaves.Do = { request = \"Arm.weigh\", arguments.what = \"{what}\", outputs.grams = \"grams\" }\n\
                  leaves.Again = { request = \"Arm.weigh\", arguments.what = \"sand\" }";
    let sent = messages(&folder(tree, leaves));
    // It is asked at once, answers `running` meanwhile, and succeeds with the tick after the reply.
    assert_eq!(first(&sent, "Do Arm weigh \"feather\""), 0.02);
    assert_eq!(first(&sent, "Do BT running"), 0.02);
    assert!((first(&sent, "Do BT success 7.0") - 2.02).abs() < 1e-9, "{:#?}", lines(&sent));
    // The error of the second one is a failure.
    assert!((first(&sent, "Again BT failure") - 4.02).abs() < 1e-9, "{:#?}", lines(&sent));
}

#[test]
fn a_condition_on_the_reply_and_the_time_decide() {
    let leaf = |more: &str| {
        let leaves = format!("leaves.Do = {{ request = \"Arm.weigh\", arguments.what = \"feather\", {more} }}");
        messages(&folder("<Do/>", &leaves))
    };
    let light = leaf("success_when = \"reply.grams < 7 || 'reply.grams' == ''\"");
    assert!((first(&light, "Do BT failure") - 2.02).abs() < 1e-9);
    let late = leaf("timeout_s = 0.7");
    assert!((first(&late, "Do BT failure") - 1.02).abs() < 1e-9);
    // The late reply of the first request is not that of the second one.
    assert!(!lines(&late).iter().any(|line| line.starts_with("Do BT success")), "{:#?}", lines(&late));
}

#[test]
fn a_halted_request_asks_for_something_else_and_begins_anew() {
    let tree = "<Timeout msec=\"500\"><Do/></Timeout>";
    let leaves = "leaves.Do = { request = \"Arm.weigh\", arguments.what = \"feather\", on_halt = \"Arm.rest\" }";
    let sent = messages(&folder(tree, leaves));
    let lines = lines(&sent);
    let halted = lines.iter().position(|line| line.starts_with("Do BT halted")).expect("it is halted");
    // A client asks one thing at a time: this waits for the first reply, which is not needed any more.
    let reply = lines.iter().position(|line| line.starts_with("Arm Do ok 7.0")).expect("it comes late");
    let rest = lines.iter().position(|line| *line == "Do Arm rest").expect("it is asked");
    assert!(reply < rest || halted < rest, "{lines:#?}");
    assert!(!lines.iter().any(|line| line.starts_with("Do BT success")), "{lines:#?}");
    assert!(lines[halted..].iter().any(|line| line.starts_with("Do Arm weigh")), "{lines:#?}");
}

#[test]
fn an_action_reports_feedback_and_succeeds_with_its_result() {
    let tree = "<Do what=\"feather\" grams=\"{g}\" share=\"{s}\"/>";
    let leaves = "leaves.Do = { action = \"Arm.pick\", arguments.what = \"{what}\", outputs.grams = \"grams\", \
                  feedback.share = \"share\", success_when = \"result.grams > 6\" }";
    let sent = messages(&folder(tree, leaves));
    assert!((first(&sent, "Do BT running none 0.5") - 2.02).abs() < 1e-9, "{:#?}", lines(&sent));
    assert!((first(&sent, "Do BT success 7.0") - 5.02).abs() < 1e-9, "{:#?}", lines(&sent));
    // The next trip begins without the feedback of the last one.
    let lines = lines(&sent);
    let again = lines.iter().rposition(|line| line.starts_with("Do Arm pick.goal")).unwrap();
    let stale = lines[again..].iter().take_while(|line| !line.starts_with("Arm Do pick.feedback"));
    assert!(stale.clone().all(|line| !line.contains("0.5")), "{lines:#?}");
}

#[test]
fn an_action_that_is_rejected_or_late_fails_and_a_halt_cancels_it() {
    let leaf = |tree: &str, what: &str, more: &str| {
        let leaves = format!("leaves.Do = {{ action = \"Arm.pick\", arguments.what = \"{what}\"{more} }}");
        messages(&folder(tree, &leaves))
    };
    let rejected = leaf("<Do/>", "stone", "");
    assert!((first(&rejected, "Do BT failure") - 1.02).abs() < 1e-9, "{:#?}", lines(&rejected));
    let late = leaf("<Do/>", "sand", ", timeout_s = 1.5");
    assert!(first(&late, "Do Arm pick.cancel") < first(&late, "Do BT failure"), "{:#?}", lines(&late));
    assert!((first(&late, "Do BT failure") - 2.02).abs() < 1e-9, "{:#?}", lines(&late));
    let halted = leaf("<Timeout msec=\"900\"><Do/></Timeout>", "sand", "");
    let [cancel, canceled, over] =
        ["Do Arm pick.cancel", "Arm Do pick.canceled", "Do BT halted"].map(|begin| first(&halted, begin));
    assert!(cancel <= canceled && canceled <= over, "{:#?}", lines(&halted));
}

#[test]
fn a_leaf_waits_for_a_topic_and_a_condition_knows_its_last_message() {
    let waits = "leaves.Do = { topic = \"Arm.light\", success_when = \"message.lux >= 30\" }";
    let sent = messages(&folder("<Do/>", waits));
    assert!((first(&sent, "Do BT success") - 3.02).abs() < 1e-9, "{:#?}", lines(&sent));
    let never = "leaves.Do = { topic = \"Arm.light\", success_when = \"message.lux < 0\", timeout_s = 2.5 }";
    assert!((first(&messages(&folder("<Do/>", never)), "Do BT failure") - 3.02).abs() < 1e-9);
    let is = "leaves.Is = { topic = \"Arm.light\", success_when = \"message.lux >= 30\" }";
    let sent = messages(&folder("<Is/>", is));
    assert_eq!(first(&sent, "Is BT failure"), 0.02);
    assert!((first(&sent, "Is BT success") - 3.02).abs() < 1e-9, "{:#?}", lines(&sent));
}

#[test]
fn a_condition_that_asks_answers_the_same_tick() {
    let is = "leaves.Is = { request = \"Arm.rest\" }";
    assert!((first(&messages(&folder("<Is/>", is)), "Is BT success") - 0.04).abs() < 0.021);
    // One that asks for what takes longer keeps the tree waiting, at most until its timeout.
    let slow = "leaves.Is = { request = \"Arm.weigh\", arguments.what = \"a\", timeout_s = 0.5 }";
    assert!((first(&messages(&folder("<Is/>", slow)), "Is BT failure") - 0.52).abs() < 0.021);
}

/// Why the tree failed, in the report.
fn failure(tree: &str, lines: &str, until_s: &str) -> Value {
    let (_folder, scenario) = folder(tree, lines);
    report(&scenario, &[&format!("execution.max_time_s={until_s}")])["tree_failure"].clone()
}

#[test]
fn a_leaf_that_failed_by_its_timeout_is_told_from_one_that_was_answered() {
    let told = |failure: &Value| {
        let text = |key: &str| failure[key].as_str().unwrap_or("-").to_owned();
        (text("message"), text("unmet"), failure["is_called_off"].as_bool().unwrap(), failure["ran_s"].as_f64())
    };
    let told_of = |tree: &str, lines: &str| told(&failure(tree, lines, "12"));
    let weigh = "request = \"Arm.weigh\", arguments.what =";
    let dash = || "-".to_owned();
    let request = |what: &str| format!("Do → Arm [<weigh>, {what:?}]");
    let late = format!("leaves.Do = {{ {weigh} \"feather\", timeout_s = 0.7 }}");
    assert_eq!(told_of("<Do/>", &late), (dash(), request("feather"), false, Some(1.0)));
    // It could not even ask, as the request before has no answer.
    let too_late = format!("{}\nexecution.tick_s = 0.4", late.replace("0.7", "0.3"));
    let (message, unmet, _, _) = told(&failure("<Do/>", &too_late, "1.5"));
    assert_eq!((message, unmet), (dash(), request("feather")));
    let error = told_of("<Do/>", &format!("leaves.Do = {{ {weigh} \"sand\" }}"));
    assert_eq!(error, ("Arm → Do [<error>, \"it trickles away\"]".to_owned(), dash(), false, Some(2.0)));
    // The first attempt has succeeded.
    let twice = "<Sequence><Script code=\"w := 'feather'\"/><Repeat num_cycles=\"2\"><Sequence><Do what=\"{w}\"/>\
                 <Script code=\"w := 'sand'\"/></Sequence></Repeat></Sequence>";
    let picks = "leaves.Do = { action = \"Arm.pick\", arguments.what = \"{what}\", timeout_s = 4.5 }";
    let (message, unmet, is_called_off, _) = told_of(twice, picks);
    assert_eq!(unmet, "Do → Arm [<pick.goal>, \"sand\"]");
    assert!(is_called_off && message.contains("pick.canceled"), "{message}");
    let waits = "leaves.Do = { topic = \"Arm.light\", success_when = \"message.lux < 0\", timeout_s = 2.5 }";
    let (message, unmet, _, ran_s) = told_of("<Do/>", waits);
    assert!(message.starts_with("Arm → Do [<light>") && unmet == "-" && ran_s == Some(3.0), "{message} {unmet}");
    let knows = "leaves.Is = { topic = \"Arm.light\", success_when = \"message.lux < 0\" }";
    let (message, unmet, _, ran_s) = told_of("<Is/>", knows);
    assert!(message.starts_with("Arm → Is [<light>") || message == "-", "{message}");
    assert_eq!((unmet, ran_s), (dash(), None));
}

/// The reply of what a halt asked is not that of the next request, which waits for it.
#[test]
fn no_reply_is_taken_for_another_one() {
    let tree = "<Timeout msec=\"500\"><Do/></Timeout>";
    let leaves =
        "leaves.Do = { request = \"Arm.rest\", on_halt = \"Arm.rest\" }\ncomponents.Arm.data.rest = \"1300ms\"";
    let sent = messages(&folder(tree, leaves));
    assert!(!lines(&sent).iter().any(|line| line.starts_with("Do BT success")), "{:#?}", lines(&sent));
    assert!(lines(&sent).iter().filter(|line| **line == "Arm Do ok").count() > 3, "{:#?}", lines(&sent));
}

#[test]
fn the_machine_is_a_machine_like_any_other() {
    let files = folder("<Do/>", "leaves.Do = { request = \"Arm.weigh\", arguments.what = \"a < 'b'\" }");
    let shown = load(&files.1, &[]).unwrap().skills["Do"].machine.file().text().to_owned();
    let machine = files.0.path().join("skills/Do.scxml");
    std::fs::write(&machine, &shown).unwrap();
    assert!(Chart::load("Do.scxml", &shown).is_ok());
    let written = messages(&files);
    // The same machine as a file gives the same run.
    std::fs::write(&files.1, std::fs::read_to_string(&files.1).unwrap().split("leaves.Do").next().unwrap()).unwrap();
    let from_file = messages(&files);
    assert_eq!(lines(&written), lines(&from_file));
    assert!(written.len() > 20);
}

#[test]
fn what_does_not_fit_is_refused_with_its_place() {
    for (lines, problem) in [
        ("leaves.Do = { request = \"Arm\" }", "`Arm` names no component and what it offers"),
        ("leaves.Do = { request = \"Arm.rest\", machine = \"Do.scxml\" }", "a leaf has either"),
        ("leaves.Do = { request = \"Arm.rest\", topic = \"Arm.light\" }", "a leaf has either"),
        ("leaves.Do = { request = \"Leg.rest\" }", "unknown component `Leg`"),
        ("leaves.Do = { request = \"Arm.rset\" }", "did you mean `rest`?"),
        ("leaves.Do = { request = \"Arm.pick\" }", "`pick` is not a service of Arm, but an action"),
        ("leaves.Do = { topic = \"Arm.light\", arguments.lux = 3 }", "unknown field of light `lux`"),
        ("leaves.Do = { request = \"Arm.weigh\" }", "`weigh` needs the field `what`"),
        ("leaves.Do = { request = \"Arm.weigh\", arguments.what = 5 }", "the field `what` of weigh cannot be 5"),
        ("leaves.Do = { request = \"Arm.weigh\", arguments.whats = \"x\" }", "unknown field of weigh `whats`"),
        ("leaves.Do = { request = \"Arm.weigh\", arguments.what = \"{whats}\" }", "did you mean `what`?"),
        (
            "leaves.Do = { request = \"Arm.weigh\", arguments.what = \"x\", outputs.grams = \"gram\" }",
            "did you mean `grams`?",
        ),
        (
            "leaves.Do = { request = \"Arm.weigh\", arguments.what = \"x\", outputs.what = \"grams\" }",
            "unknown output port",
        ),
        (
            "leaves.Do = { request = \"Arm.weigh\", arguments.what = \"x\", success_when = \"reply.gram > 1\" }",
            "did you mean `grams`?",
        ),
        (
            "leaves.Do = { request = \"Arm.look\", success_when = \"reply.state == 'opeen'\" }",
            "the field `state` is never `opeen`",
        ),
        (
            "leaves.Do = { request = \"Arm.weigh\", arguments.what = \"x\", success_when = \"reply.grams == 'few'\" }",
            "the field `grams` cannot be compared with \"few\"",
        ),
        (
            "leaves.Do = { request = \"Arm.look\", outputs.grams = \"state\" }",
            "the port `grams` of `Do` is real, and `state` of Arm is <open> | <shut>",
        ),
        ("leaves.Do = { request = \"Arm.weigh\", arguments.what = \"{what}\" }", "`Do` needs the port `what`"),
        (
            "leaves.Do = { action = \"Arm.pick\", arguments.what = \"x\", feedback.share = \"part\" }",
            "unknown field of <pick.feedback>",
        ),
        ("leaves.Do = { request = \"Arm.rest\", timeout_s = 0 }", "`timeout_s` must be above 0"),
        ("leaves.Do = { request = \"Arm.rest\", on_halt = \"Arm.stop\" }", "unknown service of Arm `stop`"),
        ("leaves.Do = { request = \"Arm.rest\", on_halt = \"Arm.weigh\" }", "`weigh` needs the field `what`"),
    ] {
        let files = folder("<Do/>", lines);
        let said = problems(&files.1, &[]).concat();
        assert!(said.contains(problem) && !said.contains("<send"), "{lines}: {said}");
    }
    let files = folder("<Is/>", "leaves.Is = { action = \"Arm.pick\", arguments.what = \"x\" }");
    let said = problems(&files.1, &[]).concat();
    assert!(said.contains("a condition cannot begin an action"), "{said}");
}

#[test]
fn a_mistake_in_success_when_is_shown_once_where_it_is_written() {
    let lines = |when: &str| {
        format!("[leaves.Do]\nrequest = \"Arm.weigh\"\narguments.what = \"{{what}}\"\nsuccess_when = \"{when}\"\n")
    };
    let two = "<Sequence><Do name=\"First\" what=\"x\"/><Do name=\"Second\" what=\"x\"/></Sequence>";
    for (when, message, help) in [
        ("repy.grams > 1", "unknown name `repy`", "did you mean `reply`?"),
        ("grams > 1", "unknown name `grams`", "`reply` is the answer, and `{PORT}` the value of a port"),
        ("reply.grams > (1", "`)` is missing", "to close what was opened at character 15"),
        ("reply.grams > ", "a value is missing", ""),
        ("reply.grams = 1", "`=` assigns; it does not compare", "use `==`"),
    ] {
        let (_folder, scenario) = folder(two, &lines(when));
        let said = problems(&scenario, &[]).concat();
        assert_eq!(said.matches(message).count(), 1, "{when}: {said}");
        assert!(said.contains(help) && said.contains("own.toml:9:16") && !said.contains("_event"), "{when}: {said}");
        assert!(said.contains(&format!("success_when = \"{when}\"")), "{when}: {said}");
    }
    let (_folder, scenario) = folder(two, &lines("reply.grams > what.length && {what} != 'reply.'"));
    assert!(load(&scenario, &[]).and_then(|scenario| Run::prepare(scenario, 1, true)).is_ok());
}
