//! A machine's use of the texts that it receives: what it compares them with, where it keeps them and passes them on.
//!
//! A proof tries only as many texts as can be told apart, so everything that a machine does with a text that something
//! outside the system chooses is followed here. The machine's own texts may be used in any way.

mod evaluate;
mod family;
mod sources;
mod trigger;
mod walk;

pub use self::sources::{PassedText, ReceivedEvent, TextSources, TextUse};

#[cfg(test)]
mod tests {
    use std::collections::{BTreeMap, BTreeSet};

    use channels::Possible;
    use diagnostics::Problem;

    use super::*;
    use crate::{Chart, Datum};

    fn text_use(data: &str, body: &str) -> TextUse {
        let text = format!(
            r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" datamodel="ecmascript" name="m">
            <datamodel>{data}</datamodel><state id="s">{body}</state></scxml>"#
        );
        let chart = Chart::load("m.scxml", &text).expect("a sound machine");
        let event = |name: &str, fields: Vec<(&str, Possible)>| ReceivedEvent {
            names: vec![name.to_owned()],
            fields: fields.into_iter().map(|(name, value)| (name.to_owned(), value)).collect(),
            others: Possible::default(),
        };
        let received = [
            event("O.v", vec![("v", Possible::choice(0)), ("w", Possible::choice(1)), ("n", Possible::number())]),
            event("P.v", vec![("v", Possible::number()), ("place", Possible::texts(["Dock", "Lab"]))]),
        ];
        let (ports, choices) = (BTreeMap::new(), ["`v` of O".to_owned(), "`w` of O".to_owned()]);
        let given = [("given", Datum::text("from the scenario"))];
        chart.text_use(TextSources { given: &given, ports: &ports, received: &received, choices: &choices })
    }

    /// The texts with which `v` is compared.
    fn compared(data: &str, body: &str) -> Vec<String> {
        let found = text_use(data, body);
        let problems: Vec<&str> = found.problems.iter().map(Problem::message).collect();
        assert!(problems.is_empty(), "{body}: {problems:?}");
        found.comparisons.with.get(&0).into_iter().flatten().map(|text| text.to_string()).collect()
    }

    #[test]
    fn a_text_is_compared_with_whatever_the_other_side_may_be() {
        let data = r#"<data id="given"/><data id="want">secret</data><data id="n" expr="7"/><data id="kept" expr="''"/>
            <data id="list" expr="['x', {a: 'y'}]"/><data id="joined" expr="'a'"/>"#;
        let on = |cond: &str| format!(r#"<transition event="O.v" cond="{cond}"/>"#);
        for (cond, texts) in [
            ("_event.data.v == 'R&amp;D'", vec!["R&D"]),
            ("want === _event.data.v", vec!["secret"]),
            ("_event.data['v'] != given", vec!["from the scenario"]),
            ("!_event.data.v || _event.data.v == null", vec![]),
            ("_event.data.v ? true : n &lt; _event.data.n", vec![]),
            ("_event.data.v == 'a' + 'b'", vec!["ab"]),
            ("_event.data.v == (In('s') ? 'left' : 'right')", vec!["left", "right"]),
            ("_event.data.v == list[1].a", vec!["x", "y"]),
            ("typeof _event.data.v == 'string'", vec![]),
            ("_event.data.v === 7", vec![]),
            ("n + 1 &lt; 3 &amp;&amp; given + n == 'x'", vec![]),
        ] {
            assert_eq!(compared(data, &on(cond)), texts, "{cond}");
        }
        let kept = r#"<transition event="O"><assign location="kept" expr="_event.data.v"/></transition>
            <transition cond="kept == want"><assign location="want" expr="'other'"/></transition>"#;
        assert_eq!(compared(data, kept), ["other", "secret"]);
    }

    #[test]
    fn only_the_events_of_a_transition_count() {
        // The field `v` of P is a number, and a place is one of a few texts.
        let body = r#"<transition event="P.v" cond="_event.data.v + 1 &lt; 7 &amp;&amp; _event.data.place &lt; 'x'"/>
            <transition event="O.*" cond="_event.data.v == 'a'"/>"#;
        assert_eq!(compared("", body), ["a"]);
    }

    #[test]
    fn chosen_texts_that_are_compared_with_each_other_are_noted_with_where_they_are_kept() {
        let data = r#"<data id="last" expr="''"/><data id="spare"/>"#;
        let body = r#"<transition event="O.v" cond="_event.data.w == last">
            <assign location="last" expr="_event.data.v"/><assign location="spare" expr="last"/></transition>"#;
        let found = text_use(data, body);
        assert_eq!(found.comparisons.among, BTreeSet::from([(0, 1)]));
        assert_eq!(found.kept, [BTreeSet::from([0]), BTreeSet::from([0])]);
    }

    #[test]
    fn anything_more_is_refused_at_its_place() {
        let data = r#"<data id="n" expr="7"/><data id="kept"/><data id="unknown" expr="_sessionid"/>"#;
        for (cond, what) in [
            ("_event.data.v &lt; 'b'", "compares `v` of O by order"),
            ("_event.data.v.length == 5", "takes the length of `v` of O"),
            ("_event.data.v == 7", "compares `v` of O with a number"),
            ("_event.data.v == n", "compares `v` of O with a number"),
            ("_event.data.w + 'b' == 'ab'", "computes with `w` of O"),
            ("-_event.data.v", "computes with `v` of O"),
            ("_event.data.v[0] == 'a'", "looks into `v` of O"),
            ("_event.data.v == unknown", "compares `v` of O with a text that is computed"),
            ("[_event.data.v] == 'a'", "compares a list or an object that has `v` of O in it"),
            ("In(_event.data.v)", "takes the name of a state from `v` of O"),
        ] {
            let found = text_use(data, &format!(r#"<transition event="O.v" cond="{cond}"/>"#));
            let messages: Vec<&str> = found.problems.iter().map(Problem::message).collect();
            assert_eq!(messages, [format!("the machine {what}, which a proof cannot follow")], "{cond}");
            assert!(found.problems[0].offset() > 0);
        }
        let later = r#"<transition event="O.v"><send event="later" delay="1s"><param name="t" expr="_event.data.v"/></send></transition>"#;
        assert!(text_use(data, later).problems[0].message().contains("keeps `v` of O in an event with a delay"));
        let sent = r#"<transition event="O.v"><send eventexpr="_event.data.v"/></transition>"#;
        assert!(text_use(data, sent).problems[0].message().contains("takes the name of an event from `v` of O"));
    }

    #[test]
    fn a_text_is_followed_to_whom_it_is_sent() {
        let body = r#"<transition event="O.v">
            <send type="channel" target="X" event="say"><param name="t" expr="_event.data.v"/></send>
            <send event="again"><param name="u" expr="_event.data.v"/></send></transition>
            <transition event="again" cond="_event.data.u == 'b'"/>"#;
        let found = text_use("", body);
        let passed = PassedText {
            target: Some("X".into()),
            head: Some("say".into()),
            field: Some("t".into()),
            value: Possible::choice(0),
        };
        assert_eq!(found.passed, [passed]);
        assert_eq!(found.comparisons.with[&0], BTreeSet::from(["b".into()]));
        let inner = r#"<invoke type="scxml"><param name="x" expr="'q'"/><content><scxml version="1.0"
            datamodel="ecmascript"><datamodel><data id="x"/></datamodel><state id="i">
            <transition event="to" cond="_event.data.y == x"/></state></scxml></content></invoke>
            <transition event="O.v"><send target="\#_i" event="to"><param name="y" expr="_event.data.v"/></send></transition>"#;
        let found = text_use("", &inner.replace("\\#", "#"));
        assert_eq!(found.comparisons.with[&0], BTreeSet::from(["q".into()]));
    }
}
