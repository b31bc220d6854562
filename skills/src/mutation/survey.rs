//! Every mutation of a machine that is worth trying.

use super::edit::leaving;
use super::place::{Site, WrittenSend, events_of, reacts};
use super::several::{Subject, changed};
use super::{Mutation, SendPlace, TransitionPlace};
use crate::SkillError;
use crate::chart::{Chart, StateKind, Transition};
use crate::ids::StateId;
use crate::load::{self, Written};

/// Every mutation that leaves the machine loadable, in the order of the file. `file` names the text in messages.
///
/// - Numbers in data are halved and doubled, Booleans negated, delays made ten times longer and shorter.
/// - Every condition is negated, and removed.
/// - Every transition is removed, and redirected to each sibling of its target.
/// - Every state is made stuck.
/// - Every message is removed, and replaced with each of the other messages that the machine sends to the same
///   receiver.
///
/// A mutation is a mistake in the file, which need not change the machine's behavior: a stuck state may be one that is
/// never entered.
///
/// # Errors
/// [`SkillError::Load`] if the original machine cannot be loaded.
///
/// ```
/// use skills::{Mutation, mutations, shipped};
///
/// let all = mutations("BatteryLevel.scxml", shipped("BatteryLevel").ok_or("not shipped")?)?;
/// assert!(all.contains(&Mutation::StuckState { state: "get".into() }));
/// assert!(all.iter().any(|mutation| mutation.to_string() == "the <send> of `success` in `success` sends `failure`"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn mutations(file: &str, text: &str) -> Result<Vec<Mutation>, SkillError> {
    let subject = Subject::load(file, text)?;
    let mut found = candidates(&subject, text);
    found.retain(|mutation| loads(&subject, file, text, mutation));
    Ok(found)
}

/// The one of the [`mutations`] that these words describe.
///
/// # Errors
/// [`SkillError::Load`] if the original machine cannot be loaded.
pub fn find_mutation(file: &str, text: &str, words: &str) -> Result<Option<Mutation>, SkillError> {
    let subject = Subject::load(file, text)?;
    let is_meant = |mutation: &Mutation| mutation.to_string() == words && loads(&subject, file, text, mutation);
    Ok(candidates(&subject, text).into_iter().find(is_meant))
}

/// All mutations, including those with which the machine cannot be loaded.
fn candidates(subject: &Subject, text: &str) -> Vec<Mutation> {
    let Ok(document) = load::parse_xml(text) else { return Vec::new() };
    let site = Site::new(&subject.chart, &document);
    let mut found = of_data(&site);
    for state in subject.chart.states() {
        of_state(&subject.chart, state, &mut found);
    }
    found.extend(of_sends(&site));
    found
}

fn loads(subject: &Subject, file: &str, text: &str, mutation: &Mutation) -> bool {
    let mutant = changed(&subject.chart, file, text, &[mutation]);
    mutant.is_ok_and(|mutant| Chart::load_with(file, &mutant, subject.strictness).is_ok())
}

fn of_data(site: &Site<'_>) -> Vec<Mutation> {
    let others = site.data().flat_map(|(node, id)| {
        let written = Written::attribute(node, "expr").or_else(|| Written::text(node));
        let values = written.map(|written| other_values(written.value.trim())).unwrap_or_default();
        values.into_iter().map(move |expr| Mutation::Data { id: id.value.to_owned(), expr })
    });
    others.collect()
}

/// Plausible wrong values.
fn other_values(expr: &str) -> Vec<String> {
    if let Ok(number) = expr.parse::<f64>() {
        let others = if number == 0.0 { [1.0, -1.0] } else { [number / 2.0, number * 2.0] };
        return others.iter().map(f64::to_string).collect();
    }
    match expr {
        "true" => return vec!["false".to_owned()],
        "false" => return vec!["true".to_owned()],
        _ => {}
    }
    let text = ['\'', '"'].iter().find_map(|quote| expr.strip_prefix(*quote)?.strip_suffix(*quote));
    let Some(delay) = text.and_then(crate::delay::parse) else { return Vec::new() };
    [delay / 10, delay * 10].iter().map(|other| format!("'{}ms'", other.as_secs_f64() * 1e3)).collect()
}

fn of_state(chart: &Chart, state: StateId, found: &mut Vec<Mutation>) {
    let own: Vec<&Transition> = chart.state(state).transitions().iter().map(|id| chart.transition(*id)).collect();
    for (index, transition) in own.iter().enumerate() {
        let event = events_of(transition);
        let nth = own[..=index].iter().filter(|other| reacts(other, &event)).count();
        let place = || TransitionPlace { state: chart.state(state).id().to_owned(), event: event.clone(), nth };
        if transition.condition().is_some() {
            found.extend([Mutation::NegateGuard { transition: place() }, Mutation::DropGuard { transition: place() }]);
        }
        let swap = |target: &str| Mutation::SwapTarget { transition: place(), target: target.to_owned() };
        found.extend(siblings_of_target(chart, transition).map(swap));
        found.push(Mutation::DropTransition { transition: place() });
    }
    if leaving(chart, state).next().is_some() {
        found.push(Mutation::StuckState { state: chart.state(state).id().to_owned() });
    }
}

/// The ids of the siblings of a transition's only target.
fn siblings_of_target<'c>(chart: &'c Chart, transition: &Transition) -> impl Iterator<Item = &'c str> {
    let target = match transition.targets() {
        [target] if !matches!(chart.state(*target).kind(), StateKind::History(_)) => Some(*target),
        _ => None,
    };
    let around = target.and_then(|target| chart.state(target).parent());
    let siblings = around.map_or(&[][..], |around| chart.state(around).children());
    siblings.iter().filter(move |sibling| Some(**sibling) != target).map(|sibling| chart.state(*sibling).id())
}

fn of_sends(site: &Site<'_>) -> Vec<Mutation> {
    let sends: Vec<WrittenSend<'_>> = site.sends().collect();
    let receiver = |send: &WrittenSend<'_>| {
        ["type", "target"].map(|name| send.node.attribute(name).unwrap_or_default().to_owned())
    };
    let mut found = Vec::new();
    for (index, send) in sends.iter().enumerate() {
        let (state, event) = (site.chart.state(send.state).id(), send.event.value);
        let same = sends[..=index].iter().filter(|other| other.state == send.state && other.event.value == event);
        let place = SendPlace { state: state.to_owned(), event: event.to_owned(), nth: same.count() };
        let beside = sends.iter().filter(|other| receiver(other) == receiver(send));
        let mut events: Vec<&str> = beside.map(|other| other.event.value).filter(|other| *other != event).collect();
        events.sort_unstable();
        events.dedup();
        let swap = |event: &str| Mutation::SwapSend { send: place.clone(), event: event.to_owned() };
        found.extend(events.into_iter().map(swap));
        found.push(Mutation::DropSend { send: place });
    }
    found
}
