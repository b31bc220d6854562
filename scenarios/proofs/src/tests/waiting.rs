//! Leaves in which more messages or delayed events wait than a search follows: what a run can do after that is neither
//! proved nor violated.

use std::path::Path;
use std::sync::Arc;

use channels::{NoNormalForm, NormalForm, Verdict};
use explorer::{Limits, Order, Outcome, Reduction};
use scenarios::scenario::{ProofOutcome, Scenario, find};
use tempfile::{TempDir, tempdir};

use super::Proof;

const PROVED: Option<ProofOutcome> = Some(ProofOutcome::Proved);
const VIOLATED: Option<ProofOutcome> = Some(ProofOutcome::Violated);
const UNDECIDED: Option<ProofOutcome> = None;

const ASKS: &str = r#"<send type="channel" target="K" event="ask"/>"#;
const DELAYS: &str = r#"<send event="late" delay="1000s"/>"#;
const ANSWERS: &str = r#"<send type="channel" targetexpr="_event.origin" event="ok"/>"#;

/// How the component K behaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Component {
    /// It answers the first request and none after it.
    AnswersOnce,
    AnswersNothing,
    /// It answers, but may freeze at any time.
    MayFreeze,
    /// There is none.
    Missing,
}

/// Its only leaf fails `count` times and does something each time; from then on it succeeds. `p` is violated by its
/// success, and `q` only if it takes longer than a second to answer a tick, which it never does.
fn application(count: usize, does: &str, component: Component) -> TempDir {
    let scxml = r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" datamodel="ecmascript">"#;
    let heard = if component == Component::Missing { "" } else { "<transition event=\"K.*\"/>" };
    let leaf = format!(
        r#"{scxml}<datamodel><data id="n" expr="0"/></datamodel>
<state id="here"><transition event="BT.tick" cond="n &lt; {count}"><assign location="n" expr="n + 1"/>{does}
<send type="channel" target="BT" event="failure"/></transition>
<transition event="BT.tick"><send type="channel" target="BT" event="success"/></transition>{heard}
<transition event="BT.halt"><send type="channel" target="BT" event="halted"/></transition></state></scxml>"#
    );
    let states = match component {
        Component::AnswersOnce => format!("<transition event=\"ask\" target=\"silent\">{ANSWERS}</transition>"),
        Component::AnswersNothing => "<transition event=\"ask\" target=\"silent\"/>".to_owned(),
        Component::MayFreeze | Component::Missing => format!("<transition event=\"ask\">{ANSWERS}</transition>"),
    };
    let silent = if states.contains("silent") { "<state id=\"silent\"/>" } else { "" };
    let mut scenario = "tree = \"tree.xml\"\nskills = \".\"\nproperties = [\"p.scope\"]\n".to_owned();
    if component != Component::Missing {
        scenario += "[components.K]\nmachine = \"K.scxml\"\ninterface = \"K.toml\"\n";
    }
    scenario += "[prove]\n";
    if component == Component::MayFreeze {
        scenario += "faults.component_frozen = \"K\"\n";
    }
    let tree = r#"<root BTCPP_format="4"><BehaviorTree ID="M"><Action ID="L0"/></BehaviorTree></root>"#;
    let properties = "property p := always not (L0, BT, m[1] = <success>)\n\
                      property q := always ((BT, L0, true) implies time_until (L0, BT, true) < 1)\n";
    let folder = tempdir().expect("a folder");
    for (name, text) in [
        ("s.toml", scenario.as_str()),
        ("tree.xml", tree),
        ("p.scope", properties),
        ("L0.scxml", &leaf),
        ("K.scxml", &format!("{scxml}<state id=\"first\">{states}</state>{silent}</scxml>")),
        ("K.toml", "[services.ask]\nrequest = {}\nreply = {}\n"),
    ] {
        std::fs::write(folder.path().join(name), text).expect("room for a file");
    }
    folder
}

/// The results for these properties. Each run that is shown is replayed.
fn results<const N: usize>(folder: &Path, properties: [&str; N], limits: &Limits) -> [Option<ProofOutcome>; N] {
    let found = find::find(folder.join("s.toml").to_str().expect("UTF-8")).expect("it was written");
    let scenario = Arc::new(Scenario::load_for_proof(&found, &[]).expect("a sound scenario"));
    properties.map(|property| {
        let proof = Proof::new(Arc::clone(&scenario), &[property.to_owned()]).expect("it can be proved");
        let question = &proof.questions()[0];
        let answer = proof.prove(question, limits, &mut |_| {}).expect("it can be explored");
        let replay =
            |path: &explorer::Path| path.replay(&answer.model, proof.monitor(question)).expect("a run of the system");
        match &answer.exploration.outcome {
            Outcome::Violated(path) => assert_eq!(replay(path).verdict(), Verdict::False, "{property}"),
            Outcome::Endless(path) => {
                let end = replay(path).system.fork().normalize();
                assert!(matches!(end, Err((_, NoNormalForm::Endless { .. }))), "{property}: {end:?}");
            }
            _ => {}
        }
        answer.outcome()
    })
}

/// With every order of the search, and with the reduction.
fn all_results(application: &TempDir) -> [Option<ProofOutcome>; 3] {
    let of = |order, reduction| {
        let limits = Limits { order, reduction, ..Limits::default() };
        results(application.path(), ["p", "q", "progress"], &limits)
    };
    let found = of(Order::Breadth, Reduction::Off);
    assert_eq!(of(Order::Breadth, Reduction::On), found);
    assert_eq!(of(Order::Depth, Reduction::Off), found);
    found
}

#[test]
fn a_leaf_with_more_waiting_messages_than_the_search_follows_proves_nothing() {
    // K takes one message more than it answers, another one waits in the channel, and the others in the leaf.
    for (component, most) in
        [(Component::AnswersOnce, NormalForm::QUEUE + 3), (Component::AnswersNothing, NormalForm::QUEUE + 2)]
    {
        let with = |count| all_results(&application(count, ASKS, component));
        assert_eq!(with(most), [VIOLATED, PROVED, PROVED], "{component:?}");
        assert_eq!(with(most + 1), [UNDECIDED, UNDECIDED, VIOLATED], "{component:?}");
        assert_eq!(with(45), [UNDECIDED, UNDECIDED, VIOLATED], "{component:?}");
    }
}

#[test]
fn a_leaf_with_more_delayed_events_than_the_search_follows_proves_nothing() {
    let with = |count| all_results(&application(count, DELAYS, Component::Missing));
    assert_eq!(with(NormalForm::QUEUE), [VIOLATED, PROVED, PROVED]);
    assert_eq!(with(NormalForm::QUEUE + 1), [UNDECIDED, UNDECIDED, VIOLATED]);
    assert_eq!(with(45), [UNDECIDED, UNDECIDED, VIOLATED]);
}

#[test]
fn a_violation_is_found_beside_runs_in_which_messages_pile_up() {
    // While K is frozen, messages pile up before the leaf first succeeds; while it is not, none do.
    let application = application(NormalForm::QUEUE + 4, ASKS, Component::MayFreeze);
    let found = results(application.path(), ["p", "progress"], &Limits::default());
    assert_eq!(found, [VIOLATED, VIOLATED]);
}
