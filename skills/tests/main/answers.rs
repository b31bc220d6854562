//! What is wrong with the answers of a machine to the tree, as far as its file shows.

use skills::Chart;

/// The warnings about the answers of a machine with these states, each with the text that it marks.
fn concerns_of(states: &str, can_halt: bool) -> Vec<String> {
    use miette::Diagnostic;

    let text = format!(
        "<scxml xmlns=\"http://www.w3.org/2005/07/scxml\" version=\"1.0\" datamodel=\"ecmascript\">{states}</scxml>"
    );
    let chart = Chart::load("Skill.scxml", &text).unwrap_or_else(|error| panic!("{error:?}\n{text}"));
    let concerns = chart.answer_concerns(can_halt);
    concerns.iter().flat_map(|found| found.related().into_iter().flatten()).map(ToString::to_string).collect()
}

fn concerns(states: &str) -> Vec<String> {
    concerns_of(states, true)
}

fn send(answer: &str) -> String {
    format!("<send type=\"channel\" target=\"BT\" event=\"{answer}\"/>")
}

/// A machine that begins to work with a tick, and what its state `working` has.
fn working(inside: &str) -> String {
    format!(
        "<state id=\"idle\"><transition event=\"BT.tick\" target=\"working\">{}</transition></state>\
         <state id=\"working\">{inside}</state>",
        send("running")
    )
}

/// A transition of `working` that ends the work.
fn done() -> String {
    format!("<transition event=\"BT.tick\" target=\"idle\">{}</transition>", send("success"))
}

fn halted() -> String {
    format!("<transition event=\"BT.halt\" target=\"idle\">{}</transition>", send("halted"))
}

#[test]
fn a_running_state_without_a_transition_for_a_halt_causes_a_warning() {
    let warned = concerns(&working(&done()));
    assert_eq!(warned, ["the state `working` has no transition for `BT.halt`"]);
    assert!(concerns_of(&working(&done()), false).is_empty(), "the tree never halts a condition");
    for handled in [
        done() + &halted(),
        format!("<transition event=\"*\" target=\"idle\">{}</transition>", send("halted")),
        // It may be handled.
        done()
            + &format!(
                "<transition event=\"BT.halt\" cond=\"_event.name == 'x'\" target=\"idle\">{}</transition>",
                send("halted")
            ),
    ] {
        assert!(concerns(&working(&handled)).is_empty(), "{handled}");
    }
}

#[test]
fn a_state_that_follows_a_running_one_is_running_too() {
    let next = format!("<transition event=\"Door.ok\" target=\"moving\"/>{}{}", done(), halted());
    let moving = |inside: &str| working(&next) + &format!("<state id=\"moving\">{inside}</state>");
    assert_eq!(concerns(&moving(&done())), ["the state `moving` has no transition for `BT.halt`"]);
    assert!(concerns(&moving(&(done() + &halted()))).is_empty());
    // A state around both handles it.
    let around = format!(
        "<state id=\"idle\"><transition event=\"BT.tick\" target=\"work\"/></state><state id=\"work\" initial=\"a\">\
         <onentry>{}</onentry>{}<state id=\"a\"><transition event=\"x\" target=\"b\"/></state><state id=\"b\">{}</state></state>",
        send("running"),
        halted(),
        done()
    );
    assert!(concerns(&around).is_empty());
}

#[test]
fn a_halt_that_nothing_confirms_causes_a_warning() {
    let halting = |inside: &str| {
        working(&(done() + "<transition event=\"BT.halt\" target=\"halting\"/>"))
            + &format!("<state id=\"halting\">{inside}</state>")
    };
    assert_eq!(concerns(&halting("<transition event=\"Door.ok\" target=\"idle\"/>")), ["this halt is never confirmed"]);
    assert_eq!(concerns(&halting("")), ["this halt is never confirmed"]);
    let confirms = format!("<transition event=\"Door.ok\" target=\"idle\">{}</transition>", send("halted"));
    assert!(concerns(&halting(&confirms)).is_empty());
    assert!(concerns(&halting(&format!("<onentry>{}</onentry>", send("halted")))).is_empty());
    // Another answer does not confirm it.
    let other = format!("<transition event=\"Door.ok\" target=\"idle\">{}</transition>", send("failure"));
    assert!(concerns(&halting(&other)).contains(&"this halt is never confirmed".to_owned()));
}

#[test]
fn an_answer_without_a_question_causes_a_warning() {
    let twice = format!(
        "<state id=\"idle\"><transition event=\"BT.tick\" target=\"done\">{}</transition></state>\
         <state id=\"done\"><onentry>{}</onentry><transition event=\"BT.tick\" target=\"done\"/></state>",
        send("success"),
        send("success")
    );
    assert_eq!(concerns(&twice).len(), 1, "the second answers later ticks, but not the first one");
    let twice = format!(
        "<state id=\"idle\"><transition event=\"BT.tick\">{}{}</transition></state>",
        send("success"),
        send("success")
    );
    assert_eq!(concerns(&twice), ["the tree does not wait for this answer"]);
    // The result is sent when it is known, and not when it is asked for.
    let early = format!("<transition event=\"Door.ok\" target=\"idle\">{}</transition>{}", send("success"), halted());
    let warned = concerns(&working(&early));
    assert_eq!(warned[1], "the tree does not wait for this answer");
    assert_eq!(warned[0], "the state `idle` has no transition for `BT.halt`", "the leaf is still running there");
    let kept = format!("<transition event=\"Door.ok\" target=\"known\"/>{}", halted());
    let kept = working(&kept) + &format!("<state id=\"known\">{}{}</state>", done(), halted());
    assert!(concerns(&kept).is_empty());
    // One of two branches answers, and the other has done so.
    let branches = format!(
        "<state id=\"idle\"><transition event=\"BT.tick\"><if cond=\"_event.name == 'x'\">{}<else/>{}</if></transition></state>",
        send("success"),
        send("failure")
    );
    assert!(concerns(&branches).is_empty());
}

#[test]
fn a_machine_whose_answers_are_not_in_its_file_is_not_judged() {
    let computed = working("").replace("event=\"running\"", "eventexpr=\"'run' + 'ning'\"");
    assert!(concerns(&computed).is_empty());
    let delayed = working("").replace("event=\"running\"", "event=\"running\" delay=\"1s\"");
    assert!(concerns(&delayed).is_empty());
    let parallel = format!("<parallel id=\"p\"><state id=\"q\">{}</state></parallel>", working(""));
    assert!(concerns(&parallel).is_empty());
    assert!(concerns("<state id=\"s\"><transition event=\"press\"/></state>").is_empty(), "no skill");
}

#[test]
fn shipped_skills_answer_as_they_should() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("machines");
    let mut folders = vec![folder];
    let mut judged = 0;
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "scxml") {
                let text = std::fs::read_to_string(&path).unwrap();
                let chart = Chart::load(&path.display().to_string(), &text).unwrap();
                assert!(chart.answer_concerns(true).is_none(), "{:?}", chart.answer_concerns(true));
                judged += usize::from(chart.is_skill());
            }
        }
    }
    assert!(judged >= 20, "{judged}");
}

/// The warnings about a machine with this content.
fn warnings(content: &str) -> Vec<String> {
    let text = format!("<scxml xmlns=\"http://www.w3.org/2005/07/scxml\" version=\"1.0\">{content}</scxml>");
    let chart = Chart::load("Machine.scxml", &text).unwrap_or_else(|error| panic!("{error:?}"));
    chart.warnings().iter().map(ToString::to_string).collect()
}

#[test]
fn the_end_of_a_parallel_state_around_another_one_depends_on_the_order() {
    let region = |id: &str| format!("<state id=\"{id}\"><final id=\"end_of_{id}\"/></state>");
    let inner = format!("<parallel id=\"inner\">{}{}</parallel>", region("a"), region("b"));
    let outer = |event: &str, inner: &str| {
        let waits = format!("<transition event=\"{event}\" target=\"over\"/>");
        warnings(&format!("<parallel id=\"outer\">{waits}{inner}{}</parallel><state id=\"over\"/>", region("c")))
    };
    assert_eq!(outer("done.state.outer", &inner), ["`done.state.outer` does not occur if `inner` is done last"]);
    assert!(outer("done.state.inner", &inner).is_empty(), "nothing waits for the outer one");
    let ends = "<transition event=\"done.state.inner\" target=\"end_of_w\"/><final id=\"end_of_w\"/>";
    let wrapped = format!("<state id=\"w\">{inner}{ends}</state>");
    assert_eq!(outer("done.state.outer", &wrapped), [""; 0]);
}

#[test]
fn elements_of_other_namespaces_are_ignored_without_a_word() {
    let drawn = "<state id=\"s\"><q:editorinfo xmlns:q=\"http://www.qt.io/2015/02/scxml-ext\" initialGeometry=\"1;2\"/></state>";
    assert!(warnings(drawn).is_empty());
    let meant = "<state id=\"s\"><q:onentry xmlns:q=\"http://www.qt.io/2015/02/scxml-ext\"/></state>";
    assert_eq!(warnings(meant), ["<onentry> is not an SCXML element and is ignored"]);
}
