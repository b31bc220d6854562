//! Mutations change exactly what they describe, and every line stays where it is.

use std::time::Duration;

use miette::Diagnostic;
use proptest::prelude::*;
use proptest::sample::Index;
use skills::{
    Chart, Datum, Event, Machine, Mutation, SHIPPED, SendPlace, SkillError, SkillProcess, Transcript, TransitionPlace,
    mutate, mutate_all, mutations,
};

use crate::conversation::topology;
use crate::diagnostics::in_short;
use crate::properties::machine_text;
use crate::stage::file;

fn place(state: &str, event: &str, nth: usize) -> TransitionPlace {
    TransitionPlace { state: state.to_owned(), event: event.to_owned(), nth }
}

fn send(state: &str, event: &str, nth: usize) -> SendPlace {
    SendPlace { state: state.to_owned(), event: event.to_owned(), nth }
}

/// Every mutation of every shipped machine: its text, the mutation, the mutant's text.
fn shipped_mutants() -> impl Iterator<Item = (&'static str, &'static str, Mutation, String)> {
    SHIPPED.into_iter().flat_map(|(leaf, text)| {
        let all = mutations(leaf, text).unwrap();
        all.into_iter().map(move |mutation| {
            let mutant = mutate(leaf, text, &mutation).unwrap();
            (leaf, text, mutation, mutant)
        })
    })
}

fn outline(text: &str) -> Vec<String> {
    Chart::load("outlined", text).unwrap().outline().lines().map(str::to_owned).collect()
}

/// The messages sent over channels, in the order of the file.
fn messages(text: &str) -> Vec<(String, String)> {
    let chart = Chart::load("messages", text).unwrap();
    chart.channel_messages().iter().map(|(to, what)| ((*to).to_owned(), (*what).to_owned())).collect()
}

/// The lines that differ between two texts with the same number of lines: before and after, without their context.
fn changes<'t>(before: &'t [String], after: &'t [String]) -> Vec<(&'t str, &'t str)> {
    assert_eq!(before.len(), after.len());
    let pairs = before.iter().zip(after).filter(|(old, new)| old != new);
    pairs.map(|(old, new)| (old.trim(), new.trim())).collect()
}

#[test]
fn every_mutant_of_the_seven_machines_fits_their_channels() {
    let topology = topology();
    let mut counted = 0;
    for (leaf, text, mutation, mutant) in shipped_mutants() {
        let chart = Chart::load(leaf, &mutant).unwrap();
        let fits = SkillProcess::new(leaf, &chart, &topology, []);
        assert!(fits.is_ok(), "{leaf}: {mutation}: {:?}", fits.err());
        assert_eq!(mutant.lines().count(), text.lines().count(), "{leaf}: {mutation}");
        counted += 1;
    }
    assert!(counted > 200, "{counted}");
}

#[test]
fn every_mutation_of_a_machine_is_described_on_one_line() {
    let (_, text) = SHIPPED.into_iter().find(|(leaf, _)| *leaf == "BatteryLevel").unwrap();
    let lines: Vec<String> = mutations("BatteryLevel", text).unwrap().iter().map(ToString::to_string).collect();
    insta::assert_snapshot!(lines.join("\n"));
}

#[test]
fn a_mutation_changes_the_machine_as_described_and_in_no_other_way() {
    for (leaf, text, mutation, mutant) in shipped_mutants() {
        let (before, after) = (outline(text), outline(&mutant));
        let (original, mutated) = (messages(text), messages(&mutant));
        let sends_change = matches!(mutation, Mutation::SwapSend { .. });
        let transition_drops = matches!(mutation, Mutation::DropTransition { .. });
        assert!(original == mutated || sends_change || transition_drops, "{leaf}: {mutation}");
        let context = format!("{leaf}: {mutation}\n{mutant}");
        match &mutation {
            Mutation::Data { id, expr } => {
                assert_eq!(before, after, "{context}");
                let datum = |text: &str| {
                    let mut machine = Machine::new(Chart::load(leaf, text).unwrap());
                    machine.start(Duration::ZERO, &mut Transcript::default());
                    machine.datum(id).cloned()
                };
                let expected = match expr.parse::<f64>() {
                    Ok(number) => Datum::from(number),
                    Err(_) => Datum::from(expr.trim_matches('\'')),
                };
                assert_eq!(datum(&mutant), Some(expected), "{context}");
                assert_ne!(datum(&mutant), datum(text), "{context}");
            }
            Mutation::NegateGuard { .. } => {
                let [(old, new)] = changes(&before, &after)[..] else { panic!("{context}") };
                let (start, rest) = old.split_once('[').unwrap();
                let (guard, end) = rest.rsplit_once(']').unwrap();
                assert_eq!(new, format!("{start}[!({guard})]{end}"), "{context}");
            }
            Mutation::DropGuard { .. } => {
                let [(old, new)] = changes(&before, &after)[..] else { panic!("{context}") };
                let (start, rest) = old.split_once('[').unwrap();
                assert_eq!(new, format!("{start}{}", rest.rsplit_once("] ").unwrap().1), "{context}");
            }
            Mutation::SwapTarget { transition, target } => {
                let [(old, new)] = changes(&before, &after)[..] else { panic!("{context}") };
                assert_eq!(new, format!("{} {target}", old.rsplit_once(' ').unwrap().0), "{context}");
                assert!(old.starts_with(&transition.event), "{context}");
            }
            Mutation::DropTransition { transition } => {
                let same = before.iter().zip(&after).take_while(|(old, new)| old == new).count();
                assert!(before[same].trim().starts_with(&transition.event), "{context}");
                assert_eq!(before[same + 1..], after[same..], "{context}");
            }
            Mutation::StuckState { state } => {
                let changed = changes(&before, &after);
                assert!(!changed.is_empty() && changed.iter().all(|(_, new)| new.contains(&format!("!In('{state}')"))));
            }
            Mutation::SwapSend { send, event } => {
                let changed: Vec<_> = original.iter().zip(&mutated).filter(|(old, new)| old != new).collect();
                assert!(changed.len() == 1 && original.len() == mutated.len(), "{context}");
                assert_eq!((&changed[0].0.1, &changed[0].1.1), (&send.event, event), "{context}");
                assert_eq!(before, after, "{context}");
            }
            Mutation::DropSend { send } => {
                let (_, rest) = mutant.split_once("<if cond=\"false\">").unwrap();
                let (dropped, _) = rest.split_once("</if>").unwrap();
                assert!(dropped.starts_with("<send") && dropped.contains(&format!("event=\"{}\"", send.event)));
                assert_eq!(mutant.replace("<if cond=\"false\">", "").replace("</if>", ""), text, "{context}");
            }
            other => panic!("a mutation that nobody has looked at: {other:?}"),
        }
    }
}

/// A machine that gets one event after another.
struct Actor {
    machine: Machine,
    host: Transcript,
}

impl Actor {
    fn new(text: &str) -> Self {
        let mut actor =
            Self { machine: Machine::new(Chart::load("actor", text).unwrap()), host: Transcript::default() };
        actor.machine.start(Duration::ZERO, &mut actor.host);
        actor
    }

    fn handle(&mut self, event: &str) {
        self.machine.handle(Event::external(event), Duration::ZERO, &mut self.host);
    }

    fn is_in(&self, state: &str) -> bool {
        let chart = self.machine.chart();
        self.machine.configuration().any(|active| chart.state(active).id() == state)
    }
}

proptest! {
    /// Until the state is active, a machine that is stuck in it behaves as before; from then on, the state is active.
    #[test]
    fn a_stuck_state_is_entered_as_before_and_never_left(
        text in machine_text(),
        which: Index,
        events in prop::collection::vec(0..4_usize, 0..20),
    ) {
        let Ok(all) = mutations("random", &text) else { return Ok(()) };
        let stuck: Vec<(&Mutation, &String)> = all
            .iter()
            .filter_map(|mutation| match mutation {
                Mutation::StuckState { state } => Some((mutation, state)),
                _ => None,
            })
            .collect();
        if stuck.is_empty() {
            return Ok(());
        }
        let (mutation, state) = stuck[which.index(stuck.len())];
        let (mut original, mut mutant) = (Actor::new(&text), Actor::new(&mutate("random", &text, mutation).unwrap()));
        for event in events {
            if mutant.is_in(state) {
                mutant.handle(["e0", "e1", "e2", "done"][event]);
                prop_assert!(mutant.is_in(state), "left {}", state);
                continue;
            }
            let active = |actor: &Actor| actor.machine.active_ids().map(str::to_owned).collect::<Vec<_>>();
            prop_assert_eq!(active(&original), active(&mutant));
            for actor in [&mut original, &mut mutant] {
                actor.handle(["e0", "e1", "e2", "done"][event]);
            }
        }
    }

    /// For any machine, its mutants can be loaded, differ from the original, and keep their lines.
    #[test]
    fn every_listed_mutation_can_be_applied(text in machine_text(), which: Index) {
        let Ok(all) = mutations("random", &text) else { return Ok(()) };
        if !all.is_empty() {
            let mutant = mutate("random", &text, &all[which.index(all.len())]).unwrap();
            prop_assert_ne!(&mutant, &text);
            prop_assert_eq!(mutant.matches('\n').count(), text.matches('\n').count());
        }
    }
}

/// A machine with everything that makes editing awkward.
const AWKWARD: &str = r##"<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" datamodel="ecmascript">
  <datamodel>
    <data id="level"
          expr="1 +
                2"/>
    <data id="text">
      4
    </data>
    <data id="nothing"/>
  </datamodel>
  <state id="a">
    <transition event="go
                       walk" cond='level &lt; 4 &amp;&amp; text != "ä"' target="b"/>
    <transition event="go" target="c">
      <!-- a comment -->
      <send event="é" target="#_internal"/>
    </transition>
  </state>
  <state id="b"/>
  <state id="c"/>
</scxml>"##;

fn mutant(mutation: &Mutation) -> String {
    mutate("awkward.scxml", AWKWARD, mutation).unwrap_or_else(|error| panic!("{:?}", miette::Report::new(error)))
}

#[test]
fn lines_are_kept_in_awkward_places() {
    let data = |id: &str, expr: &str| Mutation::Data { id: id.into(), expr: expr.into() };
    let text = mutant(&data("level", "'<\"&'"));
    assert!(text.contains("expr=\"&apos;&lt;&quot;&amp;&apos;\n\"/>"), "{text}");
    let text = mutant(&data("text", "5"));
    assert!(text.contains("<data id=\"text\" expr=\"5\">\n       \n    </data>"), "{text}");
    let text = mutant(&data("nothing", "5"));
    assert!(text.contains("<data id=\"nothing\" expr=\"5\"/>"), "{text}");
    let text = mutant(&Mutation::NegateGuard { transition: place("a", "walk", 1) });
    assert!(text.contains(r#"cond='!(level &lt; 4 &amp;&amp; text != "ä")' target="b""#), "{text}");
    let text = mutant(&Mutation::DropGuard { transition: place("a", "go walk", 1) });
    assert!(text.contains("walk\"                                             target=\"b\"/>"), "{text}");
    let text = mutant(&Mutation::StuckState { state: "a".into() });
    assert!(text.contains(r#"cond='(level &lt; 4 &amp;&amp; text != "ä") &amp;&amp; !In(&apos;a&apos;)' target="b""#));
    assert!(text.contains("<transition cond=\"!In(&apos;a&apos;)\" event=\"go\" target=\"c\">"), "{text}");
    for mutation in mutations("awkward.scxml", AWKWARD).unwrap() {
        let text = mutant(&mutation);
        let ends = |text: &str| text.lines().map(|line| line.trim_start().starts_with("</scxml")).collect::<Vec<_>>();
        assert_eq!(ends(&text), ends(AWKWARD), "{mutation}");
    }
    // When something is removed, everything after it keeps its position, byte for byte.
    let text = mutant(&Mutation::DropTransition { transition: place("a", "go", 2) });
    assert_eq!(text.find("<state id=\"b\""), AWKWARD.find("<state id=\"b\""));
    assert!(!text.contains("comment") && !text.contains('é'));
}

#[test]
fn messages_are_replaced_or_removed() {
    let (leaf, text) = SHIPPED.into_iter().find(|(leaf, _)| *leaf == "BatteryLevel").unwrap();
    let sent = |mutation: &Mutation| {
        let mut actor = Actor::new(&mutate(leaf, text, mutation).unwrap());
        actor.handle("BT.tick");
        actor.handle("BatteryReader.error");
        let channel = actor.host.sent.iter().filter(|outgoing| outgoing.target.is_some());
        channel.map(|outgoing| outgoing.event.as_deref().unwrap_or_default().to_owned()).collect::<Vec<_>>()
    };
    let failure = || send("failure", "failure", 1);
    assert_eq!(sent(&Mutation::DropSend { send: failure() }), ["get_level"]);
    assert_eq!(sent(&Mutation::SwapSend { send: failure(), event: "success".into() }), ["get_level", "success"]);
    assert_eq!(sent(&Mutation::DropSend { send: send("get", "get_level", 1) }), ["failure"]);
}

fn refused(text: &str, mutation: &Mutation) -> String {
    match mutate("refused.scxml", text, mutation) {
        Err(SkillError::Mutation { problems, .. }) => in_short(text, &problems),
        Err(other) => format!("{other}\n"),
        Ok(mutant) => panic!("{mutant}"),
    }
}

#[test]
fn a_missing_part_is_reported_with_the_existing_ones() {
    let null = file(
        "datamodel='null'",
        "<state id='a'><transition event='go' cond=\"In('a')\" target='b'/></state><state id='b'/>",
    );
    let data = |id: &str, expr: &str| Mutation::Data { id: id.into(), expr: expr.into() };
    let negate = |event: &str, nth| Mutation::NegateGuard { transition: place("a", event, nth) };
    let swap = |target: &str| Mutation::SwapTarget { transition: place("a", "go", 2), target: target.into() };
    let mut refusals: Vec<String> = [
        data("levle", "5"),
        data("level", "5 +"),
        data("nothing", "unknown"),
        Mutation::DropTransition { transition: place("aa", "go", 1) },
        Mutation::DropTransition { transition: place("a", "goo", 1) },
        Mutation::DropTransition { transition: place("a", "go", 3) },
        Mutation::DropTransition { transition: place("a", "walk", 0) },
        negate("go", 2),
        swap("d"),
        swap("c"),
        Mutation::StuckState { state: "b".into() },
        Mutation::DropSend { send: send("a", "e", 1) },
        Mutation::SwapSend { send: send("a", "é", 2), event: "e".into() },
    ]
    .iter()
    .map(|mutation| format!("{mutation}\n{}", refused(AWKWARD, mutation)))
    .collect();
    refusals.push(refused(&null, &negate("go", 1)));
    refusals.push(refused(&null, &Mutation::StuckState { state: "a".into() }));
    insta::assert_snapshot!(refusals.join("\n"));
}

#[test]
fn a_refused_mutation_renders_with_the_file() {
    let error = mutate("awkward.scxml", AWKWARD, &Mutation::StuckState { state: "b".into() }).unwrap_err();
    assert!(error.source_code().is_some());
    let expected = "the skill awkward.scxml cannot be changed so that no transition leaves `b`: no transition leaves `b` \
                    anyway";
    assert_eq!(error.to_string(), expected);
}

#[test]
fn mutations_of_one_machine_can_be_combined_in_any_order() {
    let data = Mutation::Data { id: "level".into(), expr: "9".into() };
    let negated = Mutation::NegateGuard { transition: place("a", "walk", 1) };
    let swapped = Mutation::SwapTarget { transition: place("a", "go", 2), target: "b".into() };
    let stuck = |state: &str| Mutation::StuckState { state: state.into() };
    let dropped = |nth| Mutation::DropTransition { transition: place("a", "go", nth) };
    let all = |mutations: &[&Mutation]| {
        let mut orders = [mutations.to_vec(), mutations.iter().rev().copied().collect()];
        orders[1].push(mutations[0]);
        let [one, other] = orders.map(|order| mutate_all("awkward.scxml", AWKWARD, order).unwrap());
        assert_eq!(one, other);
        assert_eq!(one.lines().count(), AWKWARD.lines().count());
        one
    };
    let text = all(&[&data, &negated, &swapped]);
    assert!(
        text.contains("expr=\"9\n") && text.contains("cond='!(level") && text.contains("event=\"go\" target=\"b\"")
    );
    let text = all(&[&stuck("a"), &negated]);
    let guard = r#"cond='(!(level &lt; 4 &amp;&amp; text != "ä")) &amp;&amp; !In(&apos;a&apos;)'"#;
    assert!(text.contains(guard), "{text}");
    // The second is still the second when the first is gone.
    let text = all(&[&dropped(1), &swapped]);
    assert!(!text.contains("walk") && text.contains("event=\"go\" target=\"b\""), "{text}");
    let text = all(&[&dropped(1), &dropped(2), &stuck("a"), &negated]);
    assert!(!text.contains("<transition"), "{text}");
    assert_eq!(all(&[&stuck("a")]), mutant(&stuck("a")));
}

#[test]
fn two_states_can_be_stuck_by_one_transition() {
    let text = file(
        "datamodel='ecmascript'",
        "<state id='all'><transition event='go' target='end'/><state id='a'/><state id='b'/></state><state id='end'/>",
    );
    let stuck = |state: &str| Mutation::StuckState { state: state.into() };
    let mutant = mutate_all("stuck", &text, [&stuck("a"), &stuck("all")]).unwrap();
    assert_eq!(mutant.matches("!In(").count(), 2, "{mutant}");
    let mut actor = Actor::new(&mutant);
    actor.handle("go");
    assert!(actor.is_in("a"));
}

#[test]
fn contradicting_mutations_are_refused() {
    let data = |expr: &str| Mutation::Data { id: "level".into(), expr: expr.into() };
    let transition = || place("a", "walk", 1);
    let (negated, unguarded) =
        (Mutation::NegateGuard { transition: transition() }, Mutation::DropGuard { transition: transition() });
    for (one, other) in [(&data("5"), &data("6")), (&negated, &unguarded)] {
        let error = mutate_all("awkward.scxml", AWKWARD, [one, other]).unwrap_err().to_string();
        assert!(error.ends_with("they change the same place differently"), "{error}");
        assert!(error.contains(&one.to_string()) && error.contains(&other.to_string()), "{error}");
    }
}
