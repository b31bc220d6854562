//! The matrix as text for the terminal.

use std::fmt::{self, Formatter};

use diagnostics::counted;

use super::{Matrix, Row, Sign};

/// The matrix as a table, then undetected faults, then false alarms.
pub fn table(matrix: &Matrix) -> String {
    fmt::from_fn(|text| write_table(text, matrix)).to_string()
}

/// What fits beside each other on a terminal.
const WIDTH: usize = 80;

fn write_table(text: &mut Formatter<'_>, matrix: &Matrix) -> fmt::Result {
    // A very long name extends beyond its column.
    let widest = matrix.rows.iter().map(|row| row.scenario.chars().count()).max().unwrap_or(0).clamp(8, 60);
    let widths: Vec<usize> = matrix.properties.iter().map(|name| name.chars().count().clamp(7, 60)).collect();
    // Signs below their properties, or if there are too many, each with its property.
    let is_table = widest + 12 + widths.iter().map(|width| width + 2).sum::<usize>() <= WIDTH;
    let columns = || matrix.properties.iter().zip(&widths).filter(|_| is_table);
    write!(text, "{:<widest$}  {:>8}", "scenario", "onset")?;
    for (name, width) in columns() {
        write!(text, "  {name:>width$}")?;
    }
    writeln!(text, "  robot")?;
    for row in &matrix.rows {
        write!(text, "{:<widest$}  {:>8}", row.scenario, onset(row))?;
        for (sign, (_, width)) in matrix.signs(row).zip(columns()) {
            write!(text, "  {:>width$}", sign.map_or_else(String::new, symbol))?;
        }
        writeln!(text, "  {}", robot(row))?;
        if !is_table {
            writeln!(text, "    {}", listed(matrix, row))?;
        }
    }
    writeln!(
        text,
        "\n+n: violated n ticks after the fault took effect; -: satisfied; ?: inconclusive at the end of the run"
    )?;
    if matrix.shows(|sign| *sign == Sign::Vacuous) {
        writeln!(text, "(-): vacuously satisfied: a condition in it never occurred")?;
    }
    if matrix.shows(|sign| matches!(sign, Sign::AlsoWithoutFault(_))) {
        writeln!(text, "(+n): the same, but it is also violated without a fault, so it detects nothing")?;
    }
    if matrix.shows(|sign| *sign == Sign::Early) {
        writeln!(text, "early: violated before the fault took effect")?;
    }
    if matrix.shows(|sign| *sign == Sign::WithoutFault) {
        writeln!(text, "x: violated although no fault took effect")?;
    }
    write_conclusions(text, matrix)
}

/// The signs of a scenario in one line, each with its property; of those that are satisfied, how many they are.
fn listed(matrix: &Matrix, row: &Row) -> String {
    let mut satisfied = 0;
    let mut signs = Vec::new();
    for (sign, name) in matrix.signs(row).zip(&matrix.properties) {
        match sign {
            None => {}
            Some(Sign::Satisfied) => satisfied += 1,
            Some(sign) => signs.push(format!("{name} {}", symbol(sign))),
        }
    }
    signs.extend((satisfied > 0).then(|| format!("{satisfied} satisfied")));
    signs.join(", ")
}

fn write_conclusions(text: &mut Formatter<'_>, matrix: &Matrix) -> fmt::Result {
    let unnoticed: Vec<&str> = matrix.unnoticed().map(|row| row.scenario.as_str()).collect();
    writeln!(text, "\n{}", detected(matrix))?;
    if !unnoticed.is_empty() {
        writeln!(text, "No property detects {}.", unnoticed.join(", "))?;
    }
    for row in matrix.rows.iter().filter(|row| !row.as_expected) {
        writeln!(text, "  ! {}: {}", row.scenario, row.differences.join("; "))?;
    }
    let alarms = matrix.false_alarms();
    let runs = counted(matrix.fault_free.runs, "run");
    match alarms.len() {
        0 => writeln!(text, "No false alarm in {runs} of {} without a fault.", matrix.fault_free.scenario),
        count => {
            writeln!(text, "{}:", false_alarms(count))?;
            alarms.iter().try_for_each(|alarm| writeln!(text, "  ! {alarm}"))
        }
    }
}

/// How many of the faults are detected, and how many rows have none.
pub(super) fn detected(matrix: &Matrix) -> String {
    let of = matrix.rows.iter().filter(|row| row.has_fault).count();
    let noticed = of - matrix.unnoticed().count();
    let rest = match matrix.rows.len() - of {
        0 => String::new(),
        1 => " 1 scenario has no faults and does not count.".to_owned(),
        more => format!(" {more} scenarios have no faults and do not count."),
    };
    let faults = if of == 1 { "1 fault is" } else { &format!("{of} faults are") };
    format!("{noticed} of {faults} detected by a property.{rest}")
}

pub(super) fn false_alarms(count: usize) -> String {
    counted(count, "false alarm")
}

pub(super) fn onset(row: &Row) -> String {
    let none = if row.has_fault { "never" } else { "no fault" };
    row.onset.map_or(none.to_owned(), |onset| format!("{:.2} s", onset.time_s))
}

/// The robot's result, in a word or two; a dash if there is none.
pub(super) fn robot(row: &Row) -> String {
    let arrived = if row.arrived { "arrived" } else { "did not arrive" };
    match row.collisions {
        None => "–".to_owned(),
        Some(0) => arrived.to_owned(),
        Some(1) => format!("{arrived}, 1 collision"),
        Some(count) => format!("{arrived}, {count} collisions"),
    }
}

/// A sign as a short symbol.
fn symbol(sign: Sign) -> String {
    match sign {
        Sign::Detected(ticks) => format!("+{ticks}"),
        Sign::AlsoWithoutFault(ticks) => format!("(+{ticks})"),
        Sign::Early => "early".to_owned(),
        Sign::WithoutFault => "x".to_owned(),
        Sign::Satisfied => "-".to_owned(),
        Sign::Vacuous => "(-)".to_owned(),
        Sign::Inconclusive => "?".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use monitors::Outcome;

    use super::*;
    use crate::matrix::{FaultFree, Notice, Onset};

    /// A scenario with these properties, of which the first one is violated.
    fn matrix(properties: Vec<String>) -> Matrix {
        let notice = |index| Notice {
            verdict: if index == 0 { Outcome::Violated } else { Outcome::Satisfied },
            ticks_after_onset: Some(3),
            false_alarm: false,
            vacuous: index == 1,
        };
        let provenance = recording::Provenance::default();
        let row = Row {
            provenance: provenance.clone(),
            scenario: "stuck".to_owned(),
            seed: 1,
            has_fault: true,
            fault: None,
            onset: Some(Onset { tick: Some(7), time_s: 7.5 }),
            notices: (0..properties.len()).map(|index| Some(notice(index))).collect(),
            as_expected: true,
            differences: Vec::new(),
            monitors: Vec::new(),
            differs_otherwise: false,
            collisions: None,
            arrived: true,
        };
        let fault_free =
            FaultFree { scenario: "errand".to_owned(), provenance, runs: 0, violated: Vec::new(), alarms: Vec::new() };
        Matrix { properties, rows: vec![row], fault_free }
    }

    #[test]
    fn a_name_may_be_longer_than_any_column() {
        let name = "p".repeat(70_000);
        assert!(table(&matrix(vec![name.clone()])).contains(&name));
    }

    #[test]
    fn many_properties_are_listed_below_their_scenario() {
        let text = |count| table(&matrix((0..count).map(|index| format!("property_{index}")).collect()));
        assert!(text(3).contains("stuck       7.50 s          +3         (-)           -  –\n"), "{}", text(3));
        let listed = "stuck       7.50 s  –\n    property_0 +3, property_1 (-), 9 satisfied\n";
        assert!(text(11).contains(listed) && text(11).contains("(-): vacuously"), "{}", text(11));
    }
}
