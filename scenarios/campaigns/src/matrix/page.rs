//! The matrix as a page.

use std::path::Path;

use diagnostics::Staging;
use monitors::Outcome;
use reports::html::{document, escape, text};

use super::table::{onset, robot};
use super::{Matrix, Notice, Row};
use crate::Error;

impl Matrix {
    /// Writes the matrix as `matrix.json` and as a page, `index.html`, to a folder.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn write(&self, folder: &Path) -> Result<(), Error> {
        let staging = Staging::begin(folder)?;
        staging.write("matrix.json", serde_json::to_string_pretty(self).expect("a matrix is always JSON") + "\n")?;
        staging.write("index.html", page(self))?;
        Ok(staging.publish(&["matrix.json", "index.html"])?)
    }
}

/// One self-contained page: the table, what no property notices, and the runs without a fault.
fn page(matrix: &Matrix) -> String {
    let noticed = matrix.rows.len() - matrix.unnoticed().count();
    let main = format!(
        "<header class=\"head\">\n<p class=\"over\">A service robot under runtime monitors</p>\n<h1>Faults and properties</h1>\n\
         <p class=\"about\">Which property notices which fault, and after how many ticks. {noticed} of {} faults are noticed \
         by a property.</p>\n</header>\n{}{}{}",
        matrix.rows.len(),
        rows(matrix),
        unnoticed(matrix),
        fault_free(matrix),
    );
    document("Faults and properties", &main)
}

fn rows(matrix: &Matrix) -> String {
    let names: String =
        matrix.properties.iter().map(|name| format!("<th scope=\"col\">{}</th>", escape(name))).collect();
    let lines: String = matrix.rows.iter().map(|row| line(row, &matrix.properties)).collect();
    format!(
        "<section id=\"matrix\">\n<div class=\"panel\">\n<table class=\"matrix\"><thead><tr><th scope=\"col\">fault</th>\
         <th scope=\"col\">from</th>{names}<th scope=\"col\">robot</th></tr></thead><tbody>\n{lines}</tbody></table>\n\
         <p class=\"quiet\">+n: violated n ticks after the fault took hold. Every row is a scenario: <code>steward --scenario \
         NAME</code> runs it and writes its report.</p>\n</div>\n</section>\n"
    )
}

fn line(row: &Row, properties: &[String]) -> String {
    let cells: String = properties.iter().zip(&row.notices).map(|(name, notice)| cell(name, notice.as_ref())).collect();
    let unexpected = match row.as_expected {
        true => String::new(),
        false => format!("<span class=\"note bad\">{}</span>", text(&row.differences.join("; "))),
    };
    format!(
        "<tr><th scope=\"row\"><code>{}</code><span class=\"note\">{}</span>{unexpected}</th><td data-of=\"from\">{}</td>{cells}<td data-of=\"robot\">{}</td></tr>\n",
        escape(&row.scenario),
        text(row.fault.as_deref().unwrap_or("no fault took hold")),
        escape(&onset(row)),
        escape(&robot(row)),
    )
}

/// What a property says. On a narrow page a row is a card, and every cell names its column.
fn cell(property: &str, notice: Option<&Notice>) -> String {
    let Some(notice) = notice else { return "<td></td>".to_owned() };
    let (words, title) = match (notice.verdict, notice.ticks_after_onset) {
        (Outcome::Violated, Some(ticks)) => (format!("+{ticks}"), "violated"),
        (Outcome::Violated, None) => ("early".to_owned(), "violated before the fault"),
        (Outcome::Satisfied, _) => ("–".to_owned(), "satisfied"),
        (Outcome::Inconclusive, _) => ("?".to_owned(), "inconclusive"),
    };
    let property = escape(property);
    format!("<td class=\"{}\" title=\"{title}\" data-of=\"{property}\">{words}</td>", notice.verdict)
}

fn unnoticed(matrix: &Matrix) -> String {
    let items: String = matrix
        .unnoticed()
        .map(|row| {
            let fault = text(row.fault.as_deref().unwrap_or_default());
            format!("<li><code>{}</code>: {fault}; the robot {}</li>\n", escape(&row.scenario), escape(&robot(row)))
        })
        .collect();
    if items.is_empty() {
        return String::new();
    }
    format!(
        "<section id=\"unnoticed\">\n<h2>What no property notices</h2>\n<div class=\"panel\"><ul>\n{items}</ul></div>\n</section>\n"
    )
}

fn fault_free(matrix: &Matrix) -> String {
    let alarms = matrix.false_alarms();
    let runs = matrix.fault_free.runs;
    let scenario = escape(&matrix.fault_free.scenario);
    let words = match alarms.len() {
        0 => format!("<p>No false alarm in {runs} runs of <code>{scenario}</code> with nothing wrong.</p>"),
        count => {
            let items: String = alarms.iter().map(|alarm| format!("<li>{}</li>\n", escape(alarm))).collect();
            format!("<p class=\"note bad\">{count} false alarms</p><ul>\n{items}</ul>")
        }
    };
    format!(
        "<section id=\"fault-free\">\n<h2>With nothing wrong</h2>\n<div class=\"panel\">{words}</div>\n</section>\n"
    )
}
