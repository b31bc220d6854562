//! The matrix as a page.

use std::path::Path;

use diagnostics::Staging;
use maud::{Markup, html};
use monitors::Outcome;
use reports::html::{document, section, table, text};

use super::table::{detected, false_alarms, onset, robot};
use super::{Matrix, Row, Sign};
use crate::Error;

const FILES: [&str; 2] = ["matrix.json", "index.html"];

impl Matrix {
    /// Checks before the runs that [`write`](Self::write) overwrites no input.
    ///
    /// # Errors
    /// [`Error::Scenario`] if it would.
    pub fn check(folder: &Path) -> Result<(), Error> {
        Ok(FILES.iter().try_for_each(|name| diagnostics::check_unread(&folder.join(name)))?)
    }

    /// Writes the matrix as `matrix.json` and as a page, `index.html`, to a folder.
    ///
    /// # Errors
    /// [`Error::Scenario`] if they cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), Error> {
        let staging = Staging::begin(folder)?;
        let [data, shown] = FILES;
        staging.write(data, serde_json::to_string_pretty(self).expect("a matrix is always JSON") + "\n")?;
        staging.write(shown, page(self))?;
        Ok(staging.publish(&FILES)?)
    }
}

/// One self-contained page: the table, the faults that no property detects, and the runs without a fault.
fn page(matrix: &Matrix) -> String {
    let main = html! {
        header.head {
            p.over { "A service robot under runtime monitors" }
            h1 { "Faults and properties" }
            p.about {
                "Which property detects which fault, and after how many ticks. " (detected(matrix))
            }
        }
        section #matrix { (rows(matrix)) }
        (section("unnoticed", "Faults that no property detects", unnoticed(matrix)))
        (section("fault-free", "Without a fault", fault_free(matrix)))
    };
    document("Faults and properties", &main)
}

fn rows(matrix: &Matrix) -> Markup {
    let columns = ["fault", "from"].into_iter().chain(matrix.properties.iter().map(String::as_str)).chain(["robot"]);
    let lines = html! { @for row in &matrix.rows { (line(matrix, row)) } };
    html! {
        div.panel tabindex="0" {
            (table("matrix", columns, &lines))
            p.quiet {
                "+n: the property was violated n ticks after the fault took effect; –: it was satisfied"
                @if matrix.shows(|sign| *sign == Sign::Vacuous) {
                    "; (–): it was vacuously satisfied, since a condition in it never occurred"
                }
                @if matrix.shows(|sign| *sign == Sign::Inconclusive) {
                    "; ?: it was inconclusive at the end of the run"
                }
                @if matrix.shows(|sign| matches!(sign, Sign::AlsoWithoutFault(_))) {
                    "; (+n): the same, but it was also violated without a fault, so it detects nothing"
                }
                @if matrix.shows(|sign| *sign == Sign::Early) {
                    "; early: it was violated before the fault took effect"
                }
                ". Every row is a scenario: " code { "steward run NAME" } " runs it and writes its report."
            }
        }
    }
}

fn line(matrix: &Matrix, row: &Row) -> Markup {
    html! {
        tr {
            th scope="row" {
                code { (row.scenario) }
                span.note { (text(fault(row))) }
                @if !row.as_expected { span.note.bad { (text(&row.differences.join("; "))) } }
            }
            td data-of="from" { (onset(row)) }
            @for (name, sign) in matrix.properties.iter().zip(matrix.signs(row)) { (cell(name, sign)) }
            td data-of="robot" { (robot(row)) }
        }
    }
}

fn fault(row: &Row) -> &str {
    row.fault.as_deref().unwrap_or(if row.has_fault { "no fault took effect" } else { "no faults" })
}

/// A property's verdict. On a narrow page, a row is a card, and every cell names its column.
fn cell(property: &str, sign: Option<Sign>) -> Markup {
    let Some(sign) = sign else { return html! { td {} } };
    let (verdict, words, title) = match sign {
        Sign::Detected(ticks) => (Outcome::Violated, format!("+{ticks}"), "violated"),
        Sign::AlsoWithoutFault(ticks) => (Outcome::Violated, format!("(+{ticks})"), "violated, as without a fault"),
        Sign::Early => (Outcome::Violated, "early".to_owned(), "violated before the fault"),
        Sign::WithoutFault => (Outcome::Violated, "violated".to_owned(), "violated without a fault"),
        Sign::Satisfied => (Outcome::Satisfied, "–".to_owned(), "satisfied"),
        Sign::Vacuous => (Outcome::Satisfied, "(–)".to_owned(), "vacuously satisfied"),
        Sign::Inconclusive => (Outcome::Inconclusive, "?".to_owned(), "inconclusive"),
    };
    html! { td.(verdict) title=(title) data-of=(property) { (words) } }
}

fn unnoticed(matrix: &Matrix) -> Markup {
    let line = |row: &Row| {
        let fault = text(fault(row));
        html! { li { code { (row.scenario) } ": " (fault) "; robot: " (robot(row)) } }
    };
    html! {
        @if matrix.unnoticed().next().is_some() {
            div.panel { ul { @for row in matrix.unnoticed() { (line(row)) } } }
        }
    }
}

fn fault_free(matrix: &Matrix) -> Markup {
    let alarms = matrix.false_alarms();
    html! {
        div.panel {
            @if alarms.is_empty() {
                p {
                    "No false alarm in " (matrix.fault_free.runs) " runs of " code { (matrix.fault_free.scenario) }
                    ", which has no fault."
                }
            } @else {
                p.note.bad { (false_alarms(alarms.len())) }
                ul { @for alarm in alarms { li { (alarm) } } }
            }
        }
    }
}
