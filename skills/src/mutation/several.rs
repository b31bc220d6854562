//! Several mutations of one machine at once.

use std::sync::Arc;

use diagnostics::{Problem, Source};

use super::edit::{self, Edit};
use super::{Mutation, place};
use crate::chart::Chart;
use crate::load;
use crate::{SkillError, Strictness};

/// A machine to be changed.
pub(super) struct Subject {
    pub(super) chart: Arc<Chart>,
    pub(super) strictness: Strictness,
}

impl Subject {
    /// The machine, read as strictly as it permits.
    pub(super) fn load(file: &str, text: &str) -> Result<Self, SkillError> {
        let strict = Chart::load_with(file, text, Strictness::Strict).map(|chart| (chart, Strictness::Strict));
        let loaded = strict.or_else(|refused| {
            let standard = Chart::load_with(file, text, Strictness::Standard);
            standard.map(|chart| (chart, Strictness::Standard)).map_err(|_| refused)
        });
        loaded.map(|(chart, strictness)| Self { chart, strictness })
    }
}

/// Applies all mutations to a machine's text. Each refers to the original machine, whatever the others change, so their
/// order does not matter. The same mutation given twice counts once. Otherwise, this works like
/// [`mutate`](super::mutate).
///
/// # Errors
/// As for [`mutate`](super::mutate), and [`SkillError::Mutation`] if two of them change the same place differently.
pub fn mutate_all<'m>(
    file: &str,
    text: &str,
    mutations: impl IntoIterator<Item = &'m Mutation>,
) -> Result<String, SkillError> {
    let mut subject = Subject::load(file, text)?;
    let mut all: Vec<&Mutation> = Vec::new();
    for mutation in mutations {
        if !all.contains(&mutation) {
            all.push(mutation);
        }
    }
    all.sort_by_key(|mutation| turn(mutation));
    let mut text = text.to_owned();
    let at_once = |a: &&Mutation, b: &&Mutation| turn(a) == turn(b) && !matches!(a, Mutation::StuckState { .. });
    for mutations in all.chunk_by(at_once) {
        text = changed(&subject.chart, file, &text, mutations)?;
        subject.chart = Chart::load_with(file, &text, subject.strictness)?;
    }
    Ok(text)
}

/// The order of mutations: first those that keep every transition in place, then those that affect all transitions of a
/// state, then removals, after which others would be numbered differently.
fn turn(mutation: &Mutation) -> u8 {
    match mutation {
        Mutation::StuckState { .. } => 1,
        Mutation::DropTransition { .. } => 2,
        _ => 0,
    }
}

pub(super) fn changed(chart: &Chart, file: &str, text: &str, mutations: &[&Mutation]) -> Result<String, SkillError> {
    let refuse = |words: String, problem: Problem| SkillError::Mutation {
        mutation: words,
        text: Source::new(file, text),
        problems: vec![problem],
    };
    let mut all: Vec<(Edit, &Mutation)> = Vec::new();
    for mutation in mutations {
        let refuse = |problem| refuse(mutation.to_string(), problem);
        let document = load::parse_xml(text).map_err(refuse)?;
        let edits = edit::edits(&place::Site::new(chart, &document), mutation).map_err(refuse)?;
        if edits.iter().all(|(range, replacement)| text[range.clone()] == **replacement) {
            return Err(refuse(Problem::new("this changes nothing")));
        }
        let new = edits.into_iter().filter(|edit| !all.iter().any(|(other, _)| other == edit));
        all.extend(new.map(|edit| (edit, *mutation)).collect::<Vec<_>>());
    }
    all.sort_by_key(|((range, _), _)| (range.start, range.end));
    if let Some([(_, one), ((range, _), other)]) = all.array_windows().find(|[(a, _), (b, _)]| b.0.start < a.0.end) {
        let problem = Problem::new("they change the same place differently").at(range.clone(), "here");
        return Err(refuse(format!("{one} and {other}"), problem));
    }
    Ok(edit::apply(text, all.into_iter().map(|(edit, _)| edit).collect()))
}
