//! Results as Markdown (GitHub's flavor), for the summary that a CI shows.
//!
//! First a table with every case, then of each suite what went wrong, with the stories of violations and with links to
//! pages and pictures. Texts from files are escaped. A summary that is too long for GitHub is cut there, with a note.

use std::fmt::{self, Formatter};
use std::path::{Component, Path, PathBuf};

use crate::results::{Case, CaseResult, FileFinding, FindingKind, Results, Suite};

/// GitHub refuses a summary of a step that is longer than 1 MiB; this many bytes leave the step room for a line or two.
const MOST_BYTES: usize = (1 << 20) - 1024;
/// Longer texts are cut, in bytes.
const MOST_TEXT: usize = 2000;
/// No more findings of a suite than this are listed.
const MOST_FINDINGS: usize = 100;
/// Of the hash of a file, so many digits are shown.
const HASH: usize = 16;

/// How the title begins.
const TITLE: &str = "# steward ";
/// The head of the table.
const COLUMNS: &str = "| of | what | found | result |";

/// Whether a file that begins like this is one of ours.
#[must_use]
pub(crate) fn begins(text: &str) -> bool {
    text.starts_with(TITLE) && text.contains(COLUMNS)
}

/// Results as Markdown, for a file in `folder`, to which its links are relative; and what is left out because of
/// limits, in words.
#[must_use]
pub(crate) fn document(results: &Results, folder: &Path) -> (String, Vec<String>) {
    let whole = fmt::from_fn(|text| {
        write_table(text, results)?;
        results.suites.iter().try_for_each(|suite| write_suite(text, suite, folder))
    });
    cut(whole.to_string())
}

/// The text as far as GitHub accepts it. Each line stands for itself, so it may end after any.
fn cut(mut text: String) -> (String, Vec<String>) {
    if text.len() <= MOST_BYTES {
        return (text, Vec::new());
    }
    let all = text.len();
    let words = |kept| format!("the last {} of {all} bytes are left out: GitHub accepts 1 MiB", all - kept);
    let room = MOST_BYTES - words(0).len() - "\n\n**Cut:** .\n".len();
    let kept = text[..text.floor_char_boundary(room)].rfind('\n').map_or(0, |end| end + 1);
    text.truncate(kept);
    let words = words(kept);
    text += &format!("\n**Cut:** {words}.\n");
    (text, vec![words])
}

fn write_table(text: &mut Formatter<'_>, Results { command, suites }: &Results) -> fmt::Result {
    let cases = || suites.iter().flat_map(|suite| &suite.cases);
    let count = |word: &str| cases().filter(|case| case.result.word() == word).count();
    writeln!(text, "{TITLE}{command}\n")?;
    let counts: Vec<String> = ["passed", "failed", "error", "skipped"]
        .into_iter()
        .filter(|word| count(word) > 0)
        .map(|word| format!("{} {}", count(word), if word == "error" { "not carried out" } else { word }))
        .collect();
    writeln!(text, "{}\n", if counts.is_empty() { "no results".to_owned() } else { counts.join(", ") })?;
    writeln!(text, "{COLUMNS}\n|---|---|---|---|")?;
    for suite in suites {
        for case in &suite.cases {
            let result = match &case.result {
                CaseResult::Passed => "passed".to_owned(),
                bad if bad.is_bad() => format!("**{}**: {}", bad.word(), escaped(bad.reason().unwrap_or_default())),
                other => format!("{}: {}", other.word(), escaped(other.reason().unwrap_or_default())),
            };
            let [of, what, found] = [&suite.name, &case.name, &case.found].map(|text| escaped(text));
            writeln!(text, "| {of} | {what} | {found} | {result} |")?;
        }
    }
    Ok(())
}

fn write_suite(text: &mut Formatter<'_>, suite: &Suite, folder: &Path) -> fmt::Result {
    let detailed: Vec<&Case> = suite.cases.iter().filter(|case| !suite.is_about_files() && is_detailed(case)).collect();
    if detailed.is_empty() && suite.findings.is_empty() && suite.notes.is_empty() && suite.page.is_none() {
        return Ok(());
    }
    writeln!(text, "\n## {}", escaped(&suite.name))?;
    let page = suite.page.iter().map(|page| ("report", page.as_path()));
    let pictures = suite.pictures.iter().map(|(picture, about)| (about.as_str(), picture.as_path()));
    write_links(text, page.chain(pictures), folder)?;
    let facts = suite.all_facts().into_iter().map(|(name, value)| format!("{} {}", escaped(name), escaped(&value)));
    writeln!(text, "\n{}", facts.collect::<Vec<_>>().join(" · "))?;
    let inputs = suite.inputs().iter();
    let inputs =
        inputs.map(|input| format!("{} {}", escaped(&input.path), input.blake3.get(..HASH).unwrap_or_default()));
    let inputs: Vec<String> = inputs.collect();
    if !inputs.is_empty() {
        writeln!(text, "\nmade from {}", inputs.join(" · "))?;
    }
    writeln!(text)?;
    suite.notes.iter().try_for_each(|note| writeln!(text, "- {}", prose(note)))?;
    for FileFinding { kind, message, help, place } in suite.findings.iter().take(MOST_FINDINGS) {
        let at = place.as_ref().map_or_else(String::new, |place| format!("{}: ", escaped(&place.to_string())));
        let word = match kind {
            FindingKind::Error => "**error**: ",
            FindingKind::Warning => "warning: ",
            FindingKind::Unreached => "not reached: ",
            FindingKind::Rate => "",
        };
        let help = help.as_ref().map_or_else(String::new, |help| format!(" ({})", prose(help)));
        writeln!(text, "- {at}{word}{}{help}", prose(message))?;
    }
    match suite.findings.len().saturating_sub(MOST_FINDINGS) {
        0 => {}
        more => writeln!(text, "- and {more} more")?,
    }
    detailed.into_iter().try_for_each(|case| write_case(text, case, folder))
}

/// Whether a case has more than its line in the table.
fn is_detailed(case: &Case) -> bool {
    let has_details = matches!(&case.result, CaseResult::Failed { details, .. } if !details.is_empty());
    has_details || !case.story.is_empty()
}

fn write_case(text: &mut Formatter<'_>, case: &Case, folder: &Path) -> fmt::Result {
    let reason = case.result.reason().unwrap_or(&case.found);
    let title = if reason.starts_with(&case.name) { reason.to_owned() } else { format!("{}: {reason}", case.name) };
    writeln!(text, "\n### {}\n", escaped(&title))?;
    match &case.result {
        CaseResult::Failed { details, .. } if case.story.is_empty() => {
            // The blanks at the beginning of a line show what belongs together.
            let lines = details.trim_matches('\n').lines().map(|line| {
                let indent = line.len() - line.trim_start().len();
                "&nbsp;".repeat(indent) + &escaped(line.trim())
            });
            writeln!(text, "{}\n", lines.collect::<Vec<_>>().join("\\\n"))?;
        }
        _ => {
            for sentence in &case.story {
                writeln!(text, "1. {}", prose(sentence))?;
            }
        }
    }
    let links = [("report", &case.page), ("picture", &case.picture)];
    write_links(text, links.into_iter().filter_map(|(name, path)| Some((name, path.as_deref()?))), folder)
}

/// A paragraph of links; nothing if there are none.
fn write_links<'l>(
    text: &mut Formatter<'_>,
    links: impl Iterator<Item = (&'l str, &'l Path)>,
    folder: &Path,
) -> fmt::Result {
    let links: Vec<String> = links.map(|(name, path)| link(name, path, folder)).collect();
    if links.is_empty() { Ok(()) } else { writeln!(text, "\n{}", links.join(" · ")) }
}

/// A link, relative to the folder of the summary.
fn link(name: &str, path: &Path, folder: &Path) -> String {
    let mut target = String::new();
    for byte in relative(path, folder).to_string_lossy().bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' | b'/' => target.push(byte.into()),
            _ => target += &format!("%{byte:02X}"),
        }
    }
    format!("[{}]({target})", escaped(name))
}

/// The way from a folder to a file.
fn relative(path: &Path, folder: &Path) -> PathBuf {
    let (Ok(path), Ok(folder)) = (std::path::absolute(path), std::path::absolute(folder)) else {
        return path.to_owned();
    };
    let (path, folder): (Vec<Component<'_>>, Vec<Component<'_>>) =
        (path.components().collect(), folder.components().collect());
    let common = path.iter().zip(&folder).take_while(|(one, other)| one == other).count();
    let up = folder[common..].iter().map(|_| Component::ParentDir);
    up.chain(path[common..].iter().copied()).collect()
}

/// Text that a reader of Markdown shows as it is, on one line.
fn escaped(text: &str) -> String {
    let shown = &text[..text.floor_char_boundary(MOST_TEXT)];
    let mut escaped = String::with_capacity(shown.len());
    for character in shown.chars() {
        match character {
            '\\' | '`' | '*' | '_' | '{' | '}' | '[' | ']' | '<' | '>' | '#' | '+' | '-' | '=' | '!' | '|' | '&'
            | '~' | '$' => escaped.extend(['\\', character]),
            // A number at the beginning would begin a list.
            '.' | ')' if !escaped.is_empty() && escaped.bytes().all(|byte| byte.is_ascii_digit()) => {
                escaped.extend(['\\', character])
            }
            _ if is_control(character) => escaped.push(' '),
            _ => escaped.push(character),
        }
    }
    if shown.len() < text.len() {
        escaped.push('…');
    }
    escaped
}

/// Whether a character ends lines, or changes how others are shown.
fn is_control(character: char) -> bool {
    character.is_control()
        || matches!(character, '\u{2028}' | '\u{2029}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// Sentences with code between backquotes.
fn prose(words: &str) -> String {
    let mut text = String::new();
    let mut rest = words;
    while let Some((before, (code, after))) =
        rest.split_once('`').and_then(|(before, after)| Some((before, after.split_once('`')?)))
    {
        text += &escaped(before);
        if code.trim().is_empty() {
            text += &escaped(&format!("`{code}`"));
        } else {
            let shown: String = code.chars().map(|c| if is_control(c) { ' ' } else { c }).collect();
            let cut = &shown[..shown.floor_char_boundary(MOST_TEXT)];
            text += &format!("`{cut}{}`", if cut.len() < shown.len() { "…" } else { "" });
        }
        rest = after;
    }
    text + &escaped(rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_from_files_is_not_markdown() {
        assert_eq!(escaped("a|b `c` <img> **d** [e](f)"), r"a\|b \`c\` \<img\> \*\*d\*\* \[e\](f)");
        assert_eq!(escaped("1. x\n2. y"), r"1\. x 2. y");
        assert_eq!(escaped("- x\u{202e}"), r"\- x ");
        assert_eq!(prose("told `[<ok>, 9]`. <b>"), r"told `[<ok>, 9]`. \<b\>");
        assert_eq!(prose("``two`` and ` odd"), r"\`\`two\`\` and \` odd");
    }

    #[test]
    fn links_are_relative_to_the_summary() {
        let link = |path: &str, folder: &str| link("p", Path::new(path), Path::new(folder));
        assert_eq!(link("out/a b/01.png", ""), "[p](out/a%20b/01.png)");
        assert_eq!(link("out/a/01.png", "out"), "[p](a/01.png)");
        assert_eq!(link("out/a/01.png", "results/x"), "[p](../../out/a/01.png)");
    }

    #[test]
    fn a_summary_that_is_too_long_ends_with_a_sentence() {
        let case = |number: usize| Case { name: format!("case {number}"), ..Case::default() };
        let suite = Suite { name: "many".to_owned(), cases: (0..60_000).map(case).collect(), ..Suite::default() };
        let (text, cut) = document(&Results { command: "check", suites: vec![suite] }, Path::new(""));
        assert!(text.len() <= MOST_BYTES && text.len() > MOST_BYTES - 200, "{}", text.len());
        let last = text.lines().next_back().unwrap_or_default();
        assert_eq!(cut.len(), 1);
        assert_eq!(last, format!("**Cut:** {}.", cut[0]));
    }
}
