//! README and book: commands print the output shown, links lead somewhere, and the summary has every page.
//!
//! A page is run from top to bottom in its own folder. A `console` block has commands (`$ …`) and their output; a line
//! `…` stands for any lines, and `…` within a line for any text. A block after "`name`:" is a file of that name. A page
//! with `<!-- continues: PAGE -->` continues in the folder of that page. A command that is not run is marked: `<!-- not
//! run: reason -->`. A page with `<!-- needs: python3 -->` is run only where Python is installed. `STEWARD_BLESS=1`
//! writes the output of the commands into the pages.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::{env, fs};

use crate::programs::has_python;
use crate::steward::binary;

/// Ends the output of a command; its exit status follows.
const MARK: char = '\u{1e}';
const END_OF_FILE: &str = "END-OF-FILE";

/// What a reader types.
enum Step {
    /// A file of that name, with that text.
    File(String, String),
    /// A command, and the location of its output in the page.
    Command(String, Range<usize>),
}

struct Page {
    path: PathBuf,
    text: String,
    steps: Vec<Step>,
    continues: Option<PathBuf>,
    needs_python: bool,
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// All Markdown files in a folder and its subfolders, in order.
fn markdown(folder: &Path) -> Vec<PathBuf> {
    let mut entries: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    let below = entries.into_iter().flat_map(|path| if path.is_dir() { markdown(&path) } else { vec![path] });
    below.filter(|path| path.extension().is_some_and(|extension| extension == "md")).collect()
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The text between the other two, if the whole begins and ends with them.
fn between<'a>(text: &'a str, before: &str, after: &str) -> Option<&'a str> {
    text.strip_prefix(before)?.strip_suffix(after)
}

/// A fenced block: the text after its fence, the last line of text above it, and its position in the page.
struct Block<'a> {
    kind: &'a str,
    above: &'a str,
    body: Range<usize>,
}

/// The fenced blocks of a page, and the lines around them.
fn blocks(text: &str) -> (Vec<Block<'_>>, Vec<&str>) {
    let (mut blocks, mut prose, mut open, mut end) = (Vec::new(), vec![""], None, 0);
    for line in text.split_inclusive('\n') {
        let start = end;
        end += line.len();
        match (line.trim().strip_prefix("```"), open.take()) {
            (Some(kind), None) => open = Some(Block { kind, above: prose[prose.len() - 1], body: end..end }),
            (Some(_), Some(Block { kind, above, body })) => {
                blocks.push(Block { kind, above, body: body.start..start });
                prose.push("");
            }
            (None, None) if line.trim().is_empty() => {}
            (None, None) => prose.push(line.trim_end()),
            (None, inside) => open = inside,
        }
    }
    (blocks, prose)
}

impl Page {
    fn parse(path: &Path, text: String) -> Self {
        let (blocks, prose) = blocks(&text);
        let continues = prose.iter().find_map(|line| between(line, "<!-- continues: ", " -->"));
        let continues = continues.map(|other| path.with_file_name(other));
        let needs_python = prose.contains(&"<!-- needs: python3 -->");
        let mut page = Self { path: path.into(), steps: Vec::new(), continues, needs_python, text: String::new() };
        blocks.into_iter().for_each(|block| page.block(block, &text));
        Self { text, ..page }
    }

    fn block(&mut self, Block { kind, above, body }: Block<'_>, text: &str) {
        let not_run = between(above, "<!-- not run: ", " -->").is_some_and(|reason| !reason.is_empty());
        if not_run {
            return;
        }
        assert!(
            !matches!(kind, "sh" | "bash" | "shell" | "python"),
            "{}: the block after {above:?} is neither run (```console) nor marked (<!-- not run: reason -->):\n{}",
            self.path.display(),
            &text[body]
        );
        if kind == "console" {
            self.commands(body, text);
        } else if let Some(name) = between(above, "`", "`:").filter(|name| !name.contains('`')) {
            self.steps.push(Step::File(name.into(), text[body].into()));
        }
    }

    fn commands(&mut self, body: Range<usize>, text: &str) {
        assert!(text[body.clone()].starts_with("$ "), "{}: a console block begins with `$ `", self.path.display());
        let mut end = body.start;
        for line in text[body].split_inclusive('\n') {
            end += line.len();
            match (line.strip_prefix("$ "), self.steps.last_mut()) {
                (None, Some(Step::Command(_, printed))) => printed.end = end,
                (command, _) => self.steps.push(Step::Command(command.unwrap_or_default().into(), end..end)),
            }
        }
    }

    /// The shell script that does what a reader would do.
    fn script(&self) -> String {
        let typed = self.steps.iter().map(|step| match step {
            Step::File(name, text) => format!("cat > '{name}' <<'{END_OF_FILE}'\n{text}{END_OF_FILE}\n"),
            Step::Command(line, _) => {
                format!("{line}status=$?; printf '\\n{MARK}%s\\n' $status; (exit $status)\n")
            }
        });
        typed.collect()
    }

    /// Compares the output of commands with the output shown. Returns the corrected page, and the problems.
    fn compare(&self, outcomes: &mut impl Iterator<Item = Outcome>) -> (String, Vec<String>) {
        let (mut text, mut copied, mut problems, mut failed) = (String::new(), 0, Vec::new(), false);
        for step in &self.steps {
            let Step::Command(line, printed) = step else { continue };
            let here = format!("{}: $ {line}", self.path.strip_prefix(root()).unwrap_or(&self.path).display());
            if failed && line != "echo $?\n" {
                problems.push(format!("{here}the command before failed, and no `$ echo $?` says so"));
            }
            let Some(outcome) = outcomes.next() else {
                problems.push(format!("{here}was not reached"));
                continue;
            };
            failed = outcome.status != "0";
            let shown: Vec<&str> = self.text[printed.clone()].lines().collect();
            let lines: Vec<&str> = outcome.printed.trim_end().lines().map(str::trim_end).collect();
            text.push_str(&self.text[copied..printed.start]);
            copied = printed.end;
            if agree(&shown, &lines) {
                text.push_str(&self.text[printed.clone()]);
            } else {
                text.extend(corrected(&shown, &lines).iter().flat_map(|line| [line.as_str(), "\n"]));
                problems.push(format!("{here}prints:\n{}\nand not:\n{}", lines.join("\n"), shown.join("\n")));
            }
        }
        text.push_str(&self.text[copied..]);
        (text, problems)
    }
}

/// The output of a command, and its exit status.
struct Outcome {
    printed: String,
    status: String,
}

/// Runs pages, one after the other, in a new folder.
fn typed(pages: &[&Page]) -> Vec<Outcome> {
    let folder = tempfile::tempdir().unwrap();
    let steward = binary();
    let path = env::join_paths(
        std::iter::once(steward.parent().unwrap().into()).chain(env::split_paths(&env::var_os("PATH").unwrap())),
    );
    // The program that `cargo run` would run is already built.
    let script = "exec 2>&1\ncargo() { shift 2; steward \"$@\"; }\n".to_owned();
    let script = pages.iter().fold(script, |script, page| script + &page.script());
    let mut shell = Command::new("sh");
    shell
        .args(["-c", &script])
        .current_dir(&folder)
        .stdin(Stdio::null())
        .env("PATH", path.unwrap())
        .env("NO_COLOR", "1");
    let output = shell.output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let (mut outcomes, mut printed) = (Vec::new(), String::new());
    for line in text.lines() {
        match line.strip_prefix(MARK) {
            Some(status) => outcomes.push(Outcome { printed: std::mem::take(&mut printed), status: status.into() }),
            None => printed.extend([line, "\n"]),
        }
    }
    outcomes
}

/// Whether the lines match those that are shown.
fn agree(shown: &[&str], lines: &[&str]) -> bool {
    match shown.split_first() {
        None => lines.is_empty(),
        Some((&"…", rest)) => (0..=lines.len()).any(|skipped| agree(rest, &lines[skipped..])),
        Some((first, rest)) => lines.split_first().is_some_and(|(line, lines)| is(first, line) && agree(rest, lines)),
    }
}

/// Whether a line matches the one that is shown.
fn is(shown: &str, line: &str) -> bool {
    let Some((start, rest)) = shown.split_once('…') else { return shown == line };
    let Some(line) = line.strip_prefix(start) else { return false };
    (0..=line.len()).filter(|&at| line.is_char_boundary(at)).any(|at| is(rest, &line[at..]))
}

/// The output to show instead: as many lines before the first and after the last elision as before, and lines with an
/// elision where they fit.
fn corrected(shown: &[&str], lines: &[&str]) -> Vec<String> {
    let before = shown.iter().position(|&line| line == "…").unwrap_or(lines.len());
    let after = shown.iter().rev().position(|&line| line == "…").unwrap_or(0);
    let kept = |line: &&str| shown.iter().find(|shown| **shown != "…" && is(shown, line)).unwrap_or(line).to_string();
    let keep = |lines: &[&str]| lines.iter().map(kept).collect::<Vec<_>>();
    if before + after >= lines.len() {
        return keep(lines);
    }
    [keep(&lines[..before]), vec!["…".into()], keep(&lines[lines.len() - after..])].concat()
}

fn book() -> PathBuf {
    root().join("docs/src")
}

/// README and book, whose commands are run, and other pages with links; `true` for pages of the book.
fn pages() -> Vec<(PathBuf, bool)> {
    let others = [
        "README.md",
        "ARCHITECTURE.md",
        "CONTRIBUTING.md",
        "CHANGELOG.md",
        "scenarios/campaigns/README.md",
        "tests/README.md",
    ];
    let crates = ["bt", "channels", "diagnostics", "maps", "maps/rasters", "monitors", "nav", "robot", "sim", "skills"];
    let others = others.iter().map(PathBuf::from).chain(crates.iter().map(|name| Path::new(name).join("README.md")));
    let book = markdown(&book()).into_iter().map(|path| (path, true));
    book.chain(others.map(|path| (root().join(path), false))).collect()
}

#[test]
#[ignore = "long: .ci/run runs it"]
fn commands_print_what_the_page_shows() {
    let bless = env::var_os("STEWARD_BLESS").is_some();
    let run = markdown(&book()).into_iter().chain([root().join("README.md")]);
    let mut pages: Vec<Page> = run.map(|path| Page::parse(&path, read(&path))).collect();
    let python = has_python();
    pages.retain(|page| python || !page.needs_python);
    let followed = batch::run(&chains(&pages), |chain| follow(chain, bless), |_| {});
    let problems: Vec<String> = followed.into_iter().flatten().collect();
    assert!(problems.is_empty() || bless, "{}\n\nSTEWARD_BLESS=1 writes it into the pages.", problems.join("\n\n"));
}

/// Runs the commands of pages and reports differences; with `bless`, corrects the pages.
fn follow(pages: &[&Page], bless: bool) -> Vec<String> {
    let mut outcomes = typed(pages).into_iter();
    let compared = pages.iter().flat_map(|page| {
        let (text, problems) = page.compare(&mut outcomes);
        if bless && text != page.text {
            fs::write(&page.path, text).unwrap();
        }
        problems
    });
    compared.collect()
}

/// Pages with commands, each after the one that it continues.
fn chains(pages: &[Page]) -> Vec<Vec<&Page>> {
    let (first, others): (Vec<&Page>, Vec<&Page>) = pages.iter().partition(|page| page.continues.is_none());
    let mut chains: Vec<Vec<&Page>> = first.into_iter().map(|page| vec![page]).collect();
    for chain in &mut chains {
        while let Some(next) = others.iter().find(|page| page.continues == chain.last().map(|last| last.path.clone())) {
            chain.push(next);
        }
    }
    let count: usize = chains.iter().map(Vec::len).sum();
    assert_eq!(count, pages.len(), "a page continues one that does not exist or that another page continues");
    chains.retain(|chain| chain.iter().any(|page| !page.steps.is_empty()));
    chains
}

#[test]
fn the_output_on_a_page_is_compared() {
    assert!(agree(&["a", "…", "d"], &["a", "b", "c", "d"]) && !agree(&["a", "…", "c"], &["a", "b", "c", "d"]));
    assert!(is("wrote … in …s", "wrote a.png in 3.2 s") && !is("wrote … in", "wrote a.png in 3.2 s"));
    assert_eq!(corrected(&["a", "…", "took … s"], &["b", "c", "d", "took 3 s"]), ["b", "…", "took … s"]);

    let text = "`a.txt`:\n\n```text\none\n```\n\n```console\n$ cat a.txt\ntwo\n$ false\n$ echo $?\n1\n```\n";
    let page = Page::parse(Path::new("page.md"), text.into());
    let (corrected, problems) = page.compare(&mut typed(&[&page]).into_iter());
    assert_eq!((corrected, problems.len()), (text.replace("two", "one"), 1), "{problems:?}");
}

/// The anchors of a page: those that mdBook and GitHub derive from headings, and those that the page sets itself.
fn anchors(text: &str) -> BTreeSet<String> {
    let mut anchors = BTreeSet::new();
    for line in blocks(text).1 {
        if line.starts_with('#') {
            let words = line.trim_start_matches('#').trim().to_lowercase().replace(' ', "-");
            let anchor: String = words.chars().filter(|c| c.is_alphanumeric() || "-_".contains(*c)).collect();
            let numbered = (1..).map(|n| format!("{anchor}-{n}")).find(|other| !anchors.contains(other));
            anchors.insert(if anchors.contains(&anchor) { numbered.unwrap() } else { anchor });
        }
        let named = line.split("id=\"").skip(1).filter_map(|rest| rest.split_once('"'));
        anchors.extend(named.map(|(id, _)| id.to_owned()));
    }
    anchors
}

/// The links and pictures of a page, `[…](link)`, except those in code.
fn links(text: &str) -> Vec<String> {
    let prose = blocks(text).1.join("\n");
    let outside_code: String = prose.split('`').step_by(2).collect();
    let links = outside_code.split("](").skip(1).filter_map(|rest| rest.split_once(')'));
    links.map(|(link, _)| link.to_owned()).collect()
}

#[test]
fn links_lead_somewhere() {
    let (mut known, mut problems) = (BTreeMap::new(), Vec::new());
    for (path, in_book) in pages() {
        for link in links(&read(&path)).into_iter().filter(|link| !link.contains("://")) {
            let (file, anchor) = link.split_once('#').unwrap_or((&link, ""));
            let target = if file.is_empty() { path.clone() } else { path.with_file_name(file) };
            let target = target.canonicalize().ok().filter(|target| !in_book || target.starts_with(book()));
            let mut has_anchor = |target: PathBuf| {
                anchor.is_empty()
                    || known.entry(target).or_insert_with_key(|page| anchors(&read(page))).contains(anchor)
            };
            if !target.is_some_and(&mut has_anchor) {
                problems.push(format!("{}: {link}", path.display()));
            }
        }
    }
    assert!(problems.is_empty(), "these links lead nowhere:\n{}", problems.join("\n"));
}

#[test]
fn the_summary_has_every_page() {
    let folder = book();
    let listed: BTreeSet<PathBuf> =
        links(&read(&folder.join("SUMMARY.md"))).iter().map(|link| folder.join(link)).collect();
    let missing: Vec<PathBuf> =
        markdown(&folder).into_iter().filter(|path| !listed.contains(path) && !path.ends_with("SUMMARY.md")).collect();
    assert!(missing.is_empty(), "SUMMARY.md does not list {missing:?}");
}

#[test]
fn every_place_that_says_well_has_its_test() {
    let page = read(&root().join("tests/README.md"));
    let rows = page.lines().skip_while(|line| !line.starts_with("|---")).skip(1);
    let rows: Vec<&str> = rows.take_while(|line| line.starts_with('|')).collect();
    let mut sources = String::new();
    collect_sources(root(), &mut sources);
    for row in &rows {
        let tests = row.trim_end_matches('|').rsplit('|').next().expect("a row has cells");
        let names: Vec<&str> = tests.split('`').skip(1).step_by(2).collect();
        assert!(!names.is_empty(), "{row} names no test");
        for name in names {
            assert!(sources.contains(&format!("fn {name}(")), "there is no test {name}");
        }
    }
    assert!(rows.len() > 20);
}

/// Appends the text of all Rust files of the workspace.
fn collect_sources(folder: &Path, text: &mut String) {
    for entry in fs::read_dir(folder).expect("the folder can be read") {
        let path = entry.expect("the entry can be read").path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if path.is_dir() && !name.starts_with('.') && name != "target" && name != "node_modules" {
            collect_sources(&path, text);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            text.push_str(&read(&path));
        }
    }
}

#[test]
fn the_readme_is_short() {
    let size = read(&root().join("README.md")).len();
    assert!(size <= 8192, "README.md has {size} bytes; what it explains belongs in the book");
}
