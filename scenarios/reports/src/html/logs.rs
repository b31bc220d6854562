//! The page that leads to the reports of several logs.

use std::collections::{BTreeMap, BTreeSet};

use diagnostics::counted;
use maud::{Markup, html};
use recording::ShownVerdict;

use super::document;
use super::markup::{section, table};

/// A log on the page.
#[derive(Clone, Debug, Default)]
pub struct LogRow {
    /// Its name.
    pub log: String,
    /// Where its report is, if there is one.
    pub page: Option<String>,
    /// When it begins, and how long it lasts, in words.
    pub begins: String,
    /// How long it lasts, in words.
    pub lasts: String,
    /// For each property its name, its verdict, and the verdict in words.
    pub verdicts: Vec<(String, ShownVerdict, String)>,
    /// What is missing from it, in words.
    pub notes: Vec<String>,
    /// Why it could not be checked, if it could not.
    pub refused: Option<String>,
}

/// The results of all logs of a day.
#[derive(Clone, Debug, Default)]
pub struct Day {
    /// The day: `2026-03-01`.
    pub date: String,
    /// How many logs there are.
    pub logs: usize,
    /// For each property, in how many logs it was violated or unsure, and in how many it was checked.
    pub bad: BTreeMap<String, [usize; 2]>,
}

/// The page: a line for each log, with a column for each property of one of them; if they are of several days, also a
/// line for each day.
#[must_use]
pub fn logs(rows: &[LogRow], days: &[Day]) -> String {
    let mut seen = BTreeSet::new();
    let all = rows.iter().flat_map(|row| &row.verdicts).map(|(property, ..)| property.as_str());
    let properties: Vec<&str> = all.filter(|name| seen.insert(*name)).collect();
    let is_dated = rows.iter().any(|row| !row.begins.is_empty());
    let lines = html! { @for log in rows { (line(log, &properties, is_dated)) } };
    let columns = ["log"].into_iter().chain(is_dated.then_some("begins")).chain(["lasts"]);
    let columns = columns.chain(properties.iter().copied());
    let title = "Recordings under runtime monitors";
    let main = html! {
        header.head {
            p.over { (title) }
            h1 { (counted(rows.len(), "log")) }
        }
        (section("logs", "Results", html! { div.panel { (table("matrix", columns, &lines)) } }))
        @if !days.is_empty() { (section("days", "Day by day", day_by_day(days, &properties))) }
    };
    document(title, &main)
}

fn day_by_day(days: &[Day], properties: &[&str]) -> Markup {
    let line = |day: &Day| {
        html! {
            tr {
                th scope="row" { (day.date) }
                td data-of="logs" { (day.logs) }
                @for &name in properties {
                    @match day.bad.get(name) {
                        Some([0, of]) => td.satisfied data-of=(name) { "0 of " (of) },
                        Some([bad, of]) => td.violated data-of=(name) { (bad) " of " (of) },
                        None => td {},
                    }
                }
            }
        }
    };
    let columns = ["day", "logs"].into_iter().chain(properties.iter().copied());
    html! {
        div.panel {
            (table("matrix", columns, &html! { @for day in days { (line(day)) } }))
            p.quiet { "In how many logs each property was violated or unsure." }
        }
    }
}

fn line(row: &LogRow, properties: &[&str], is_dated: bool) -> Markup {
    let verdict = |name: &str| row.verdicts.iter().find(|(property, ..)| property == name);
    html! {
        tr {
            th scope="row" {
                @match &row.page { Some(page) => a href=(url(page)) { (row.log) }, None => (row.log) }
                @for note in &row.notes { span.note { (note) } }
                @if let Some(reason) = &row.refused { span.note.bad { "not checked: " (reason) } }
            }
            @if is_dated { td data-of="begins" { (row.begins) } }
            td data-of="lasts" { (row.lasts) }
            @for name in properties {
                @match verdict(name) {
                    Some((_, verdict, words)) => {
                        td.(if let ShownVerdict::Of(of) = verdict { of.name() } else { "violated" }) data-of=(name) { (words) }
                    }
                    None => td {},
                }
            }
        }
    }
}

/// A path as a link.
fn url(path: &str) -> String {
    path.replace('%', "%25").replace('#', "%23").replace('?', "%3F").replace(' ', "%20")
}
