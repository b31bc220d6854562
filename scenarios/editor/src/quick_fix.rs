//! Changes after which a finding is gone: of a name that was misspelled, and of keys that are missing.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use checks::FileKind;
use checks::findings::{Finding, Findings};
use diagnostics::document::Key;
use diagnostics::{Disk, nearest};

use crate::answers::EditedFile;
use crate::project::{Documents, FileContext, Project};
use crate::proposal::{Proposal, ProposalKind};
use crate::toml_keys::{header, key_at, keys_at, name_of, simplest};
use crate::toml_place::{TomlPlace, place};
use crate::xml_place::end_name;

/// A change after which a finding is gone.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct QuickFix {
    /// What it does, in a few words.
    pub title: String,
    /// The range to replace, in bytes.
    pub range: Range<usize>,
    /// The text instead.
    pub text: String,
    /// Whether nothing is found instead. A key that is added may need another value.
    pub is_certain: bool,
}

/// How many words of a finding are looked up: a person who opens a menu waits for it.
const MAX_WORDS: usize = 12;
/// How many replacements are checked.
const MAX_CANDIDATES: usize = 4;

/// The keys that a finding misses, each with the simplest value that its reader accepts; or the nearest of the names
/// that may be where it is, if nothing is found there then. Only what a check confirms: the finding is gone.
#[must_use]
pub fn quick_fix(documents: &Documents, context: &FileContext, file: &Path, finding: &Finding) -> Option<QuickFix> {
    let text = documents.open.get(file)?;
    let disk = documents.disk();
    let added = missing_keys(text, &disk, file, finding);
    let adds = added.is_some();
    let subject = EditedFile { disk: &disk, file, context };
    let candidates = added.map_or_else(|| nearest_names(text, &subject, finding), |fix| vec![fix]);
    if candidates.is_empty() {
        return None;
    }
    let before = Project::default().check(documents).findings;
    let count = |findings: &Findings| -> usize {
        let alike = |found: &&Finding| found.is_error == finding.is_error;
        findings.values().map(|found| found.findings.iter().filter(alike).count()).sum()
    };
    let same = |findings: &Findings| {
        let found = findings.get(file).into_iter().flat_map(|found| &found.findings);
        found.filter(|other| other.message == finding.message).count()
    };
    candidates.into_iter().find_map(|fix| {
        let mut fixed = documents.clone();
        let mut changed = text.to_string();
        changed.replace_range(fix.range.clone(), &fix.text);
        fixed.open.insert(file.to_owned(), Arc::from(changed));
        let after = Project::default().check(&fixed).findings;
        let is_certain = count(&after) < count(&before);
        let is_gone = same(&after) < same(&before);
        // It may have hidden others, elsewhere.
        let is_elsewhere = || {
            let at = |other: &Finding| other.range.start < fix.range.end && fix.range.start < other.range.end;
            !after.get(file).is_some_and(|found| found.findings.iter().any(at))
        };
        (is_gone && (adds || is_certain || is_elsewhere())).then_some(QuickFix { is_certain, ..fix })
    })
}

/// Each name in a finding's range with the nearest of those that may be in its place.
fn nearest_names(text: &str, subject: &EditedFile<'_>, finding: &Finding) -> Vec<QuickFix> {
    let fix = |end: usize| {
        let proposals = subject.proposals(text, end);
        let range = proposals.first()?.replaces.clone();
        let written = &text[range.clone()];
        let others = proposals.iter().filter(|proposal| proposal.replaces == range && proposal.name != written);
        // A name of one letter is near every other one.
        let written = Some(written).filter(|written| written.chars().count() > 1)?;
        let meant = nearest(written, others.clone().map(|proposal| proposal.name.as_str()))?;
        let Proposal { kind, insert, .. } = others.clone().find(|proposal| proposal.name == meant)?;
        let end = Some(range.end).filter(|_| *kind == ProposalKind::Element).and_then(|end| end_name(text, end));
        let title = format!("Replace `{written}` with `{meant}`");
        let (range, text) = match end.filter(|end| text[end.clone()] == *written) {
            Some(end) => (range.start..end.end, format!("{insert}{}{insert}", &text[range.end..end.start])),
            None => (range, insert.clone()),
        };
        Some(QuickFix { title, range, text, is_certain: false })
    };
    let mut fixes: Vec<QuickFix> = word_ends(text, &finding.range).take(MAX_WORDS).filter_map(fix).collect();
    fixes.dedup_by(|one, other| one.range == other.range);
    fixes.truncate(MAX_CANDIDATES);
    fixes
}

/// The keys without which the reader of a TOML file refuses a table.
fn missing_keys(text: &str, disk: &Disk, file: &Path, finding: &Finding) -> Option<QuickFix> {
    let Some(FileKind::Toml(kind)) = FileKind::of(disk, file) else { return None };
    let named = [" is missing", " are missing"].iter().find_map(|end| finding.message.strip_suffix(end))?;
    let space = Space::in_table(text, &finding.range)?;
    let begun = format!("{}{}", &text[..space.at], space.before);
    let Some((TomlPlace::Key { table, .. }, _)) = place(&begun, begun.len()) else { return None };
    let known = keys_at(kind, text, space.at);
    let names = named.split('`').skip(1).step_by(2);
    let keys: Option<Vec<&Key>> =
        names.map(|name| key_at(&known, &[table.as_slice(), &[name.to_owned()]].concat())).collect();
    let keys = keys.filter(|keys| !keys.is_empty())?;
    // A table gets its header, behind everything else.
    let (headers, entries): (Vec<&Key>, Vec<&Key>) = keys.iter().partition(|key| table.is_empty() && key.is_table());
    let entries = entries.into_iter().map(|key| format!("{} = {}", name_of(key), simplest(key)));
    let (at, text) = match headers.as_slice() {
        [] => {
            let entries: Vec<String> = entries.collect();
            (space.at, format!("{}{}{}", space.before, entries.join(space.between), space.after))
        }
        _ if entries.len() > 0 => return None,
        headers => {
            let end = if text.is_empty() || text.ends_with('\n') { "" } else { "\n" };
            (text.len(), end.to_owned() + &headers.iter().map(|key| header(key)).collect::<String>())
        }
    };
    Some(QuickFix { title: format!("Add {named}"), range: at..at, text, is_certain: false })
}

/// A place for keys in a table, and what is written before, between and behind them.
struct Space {
    at: usize,
    before: &'static str,
    between: &'static str,
    after: &'static str,
}

impl Space {
    /// The table is at this range: in braces, below a header, or the whole file.
    fn in_table(text: &str, range: &Range<usize>) -> Option<Self> {
        let written = text.get(range.clone())?;
        if let Some(inside) = written.strip_prefix('{').and_then(|rest| rest.strip_suffix('}')) {
            let inside = inside.trim_end();
            let (before, after) = match inside.trim_start() {
                "" => (" ", " "),
                inside if inside.ends_with(',') => (" ", ""),
                _ => (", ", ""),
            };
            return Some(Self { at: range.start + 1 + inside.len(), before, between: ", ", after });
        }
        let lines = || text[range.start..].split_inclusive('\n');
        let of_header = if written.starts_with('[') && *range != (0..text.len()) { lines().next() } else { None };
        // What the file is about stays its beginning.
        let above =
            of_header.map_or_else(|| lines().take_while(|line| line.starts_with('#')).map(str::len).sum(), str::len);
        let at = range.start + above;
        let before = if text[..at].ends_with('\n') || at == 0 { "" } else { "\n" };
        Some(Self { at, before, between: "\n", after: "\n" })
    }
}

/// The ends of the words in a finding's range.
fn word_ends<'t>(text: &'t str, range: &Range<usize>) -> impl Iterator<Item = usize> + use<'t> {
    let is_word = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-');
    // What has several lines is a table or an element, not a name.
    let inside = text.get(range.clone()).filter(|inside| !inside.contains('\n')).unwrap_or_default();
    let first = range.start;
    let ends = inside.char_indices().filter(move |(_, c)| is_word(*c)).map(|(at, c)| at + c.len_utf8());
    ends.filter(move |end| !inside[*end..].starts_with(is_word)).map(move |end| first + end)
}
