//! Scripts that would exhaust time, memory or stack.

use skills::{Datum, Status};

use crate::stage::{file, lenient};

#[test]
fn executable_content_is_counted_without_an_engine() {
    let ten = "[0, 1, 2, 3, 4, 5, 6, 7, 8, 9]";
    let nested = (0..12).fold("<assign location='n' expr='n + 1'/>".to_owned(), |inner, _| {
        format!("<foreach array='ten' item='i'>{inner}</foreach>")
    });
    let empty = (0..12).fold(String::new(), |inner, _| format!("<foreach array='ten' item='i'>{inner}</foreach>"));
    let sending = nested.replace("<assign location='n' expr='n + 1'/>", "<send event='e' delay='1s'/>");
    let raising = nested.replace("<assign location='n' expr='n + 1'/>", "<raise event='e'/>");
    let growing =
        nested.replace("expr='n + 1'", "expr=\"text = text + 'xxxxxxxxxxxxxxxx' + text\"").replace("'n'", "'text'");
    let noisy = nested.replace("<assign location='n' expr='n + 1'/>", "<log expr='long'/>");
    for content in [nested, empty, sending, raising, growing, noisy] {
        let stage = lenient(&format!(
            "<datamodel><data id='ten' expr='{ten}'/><data id='i'/><data id='n' expr='0'/><data id='text' expr=\"'a'\"/>
             <data id='long' expr=\"'{}'\"/></datamodel>
             <state id='s'><onentry>{content}</onentry><transition event='f'/></state>",
            "x".repeat(1 << 16)
        ));
        assert_eq!(stage.errors(), ["error.execution"], "{:?}", stage.host.notes.last());
        assert!(stage.host.notes.len() < 2_000);
    }
}

#[test]
fn a_machine_that_keeps_doing_too_much_is_stopped() {
    let stage = lenient(
        "<datamodel><data id='list' expr='[1, 2, 3, 4, 5, 6, 7, 8, 9, 10]'/><data id='i'/></datamodel>
         <state id='s'><onentry><raise event='error.execution'/></onentry>
         <transition event='error.execution'><foreach array='list' item='i'><foreach array='list' item='i'><foreach array='list' item='i'>
         <foreach array='list' item='i'><foreach array='list' item='i'><foreach array='list' item='i'/></foreach></foreach></foreach></foreach></foreach></transition></state>",
    );
    assert_eq!(stage.machine.status(), Status::Stuck);
}

#[test]
fn only_a_limited_number_of_events_can_wait() {
    let machine = |action: &str, more: &str| {
        let data = "<data id='ten' expr='[1, 2, 3, 4, 5, 6, 7, 8, 9, 10]'/><data id='i'/><data id='n' expr='0'/>";
        let count = "<transition event='e'><assign location='n' expr='n + 1'/></transition>";
        let all = (0..4).fold(action.to_owned(), |inner, _| format!("<foreach array='ten' item='i'>{inner}</foreach>"));
        format!(
            "<datamodel>{data}</datamodel><state id='s'>{more}{count}
             <transition event='more'>{all}</transition><transition event='error'/></state>"
        )
    };
    let child = file("", &machine("<send event='e' target='#_parent'/>", ""));
    let ask = format!(
        "<invoke><content>{child}</content></invoke><transition event='more'><send event='more' target='#_s.1'/></transition>"
    );
    let actions = ["<raise event='e'/>", "<send event='e'/>", "<send event='e' delay='1s'/>"];
    let machines = actions.map(|action| machine(action, "")).into_iter();
    for machine in machines.chain([machine("", &ask)]) {
        let mut stage = lenient(&machine);
        for round in 1..=2 {
            stage.send("more").at_ms(1_000 * round);
            assert_eq!(
                (stage.datum("n"), stage.machine.status()),
                (Datum::from(4096.0 * round as f64), Status::Running)
            );
        }
    }
    // Those that are delayed wait from one rest to the next.
    let mut patient = lenient(&machine("<send event='e' delay='1h'/>", ""));
    let rounds = [1, 2, 3].map(|_| patient.send("more").errors().len());
    assert_eq!(rounds, [1, 2, 3]);
    assert_eq!(patient.at_ms(3_600_000).datum("n"), Datum::from(4096.0));
}

#[cfg(feature = "ecmascript")]
pub(crate) mod scripts {
    use std::thread;

    use crate::stage::lenient;

    /// One script per line.
    const BOMBS: &str = include_str!("bombs.js");

    /// The outcome of a script: what it leaves in `x`, or the error.
    fn outcome(script: &str) -> String {
        let script = script.replace('&', "&amp;").replace('<', "&lt;");
        let content = format!(
            "<datamodel><data id='x'/></datamodel><state id='s'><onentry><script>x = (() => {{{script}\n}})()</script></onentry></state>"
        );
        let stage = lenient(&content);
        let reasons = stage.host.notes.iter().filter_map(|note| match note {
            skills::Note::Error { reason, .. } => Some(reason.as_str()),
            _ => None,
        });
        match reasons.collect::<Vec<_>>().join("; ") {
            reason if reason.is_empty() => format!("{:.80}", stage.datum("x").to_string()),
            reason => reason,
        }
    }

    /// The outcomes of all scripts.
    pub(crate) fn outcomes() -> Vec<String> {
        BOMBS.lines().filter(|line| !line.is_empty()).map(|line| format!("{} <= {line}", outcome(line))).collect()
    }

    /// The same on a thread with a stack of this size.
    fn outcomes_on(stack_mib: usize) -> Vec<String> {
        thread::Builder::new().stack_size(stack_mib << 20).spawn(outcomes).unwrap().join().unwrap()
    }

    #[test]
    fn memory_may_run_out_anywhere() {
        for bomb in [
            "var x = {}; for (var i = 0; ; i++) x['k' + i] = i",
            "var f = Function.prototype.call; for (;;) f = f.bind(f)",
            "var o = {}; for (var i = 0; i < 30000; i++) o['k' + i] = {i}; for (;;) o = {...o, o}",
            "var a = []; for (;;) a.push(class { #a = 1 }, () => a, new Map([[a, a]]), /a/, Promise.resolve(a))",
        ] {
            for ballast in 0..60 {
                let text = outcome(&format!("var ballast = 'x'.repeat({}); {bomb}", ballast * 50_021));
                assert_eq!(text, "the code needs more memory than 4 MiB", "{bomb} over {ballast}");
            }
        }
    }

    #[test]
    #[ignore = "long: .ci/run runs it"]
    fn every_bomb_ends_the_same_way_on_every_thread() {
        let other = thread::spawn(|| outcomes_on(8));
        let here = outcomes_on(2);
        assert_eq!(here, other.join().unwrap());
        insta::assert_snapshot!(here.join("\n"));
    }
}
