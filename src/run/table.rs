//! The table of several runs, with one line for each.

use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use anstyle::Style;
use campaigns::Error;
use reports::report::{OutcomeReport, Report};

use crate::interrupt;
use crate::moment::moment;
use crate::output::{BAD, GOOD, HEAD, OPEN, Text, complain, complain_of, print_wrapped};

/// The results of the runs so far.
pub(super) struct RunsTable {
    quiet: bool,
    began: Instant,
    passed: usize,
    failed: usize,
    interrupted: usize,
    errors: usize,
    /// The exit status of the first error.
    error_status: Option<u8>,
    /// The simulated time of all runs together.
    simulated_s: f64,
}

impl RunsTable {
    /// A table without lines. A quiet table shows only runs that were not as expected, on stderr.
    pub(super) fn new(quiet: bool) -> Self {
        let (passed, failed, interrupted, errors) = (0, 0, 0, 0);
        Self { quiet, began: moment(), passed, failed, interrupted, errors, error_status: None, simulated_s: 0.0 }
    }

    /// Shows the next run, of the scenario with this name and with this argument on the command line.
    pub(super) fn add(&mut self, [name, argument]: [&str; 2], run: &Result<Report, Error>) -> Result<(), Error> {
        let (count, style, word) = match run.as_ref().map(|report| report.outcome) {
            Ok(OutcomeReport::AsExpected) => (&mut self.passed, GOOD, "PASS"),
            Ok(OutcomeReport::NotAsExpected) => (&mut self.failed, BAD, "FAIL"),
            Ok(OutcomeReport::Interrupted) => (&mut self.interrupted, OPEN, "STOP"),
            Err(_) => (&mut self.errors, BAD, "ERROR"),
        };
        *count += 1;
        self.simulated_s += run.as_ref().map_or(0.0, |report| report.sim_time_s);
        if let Err(error) = run {
            self.error_status.get_or_insert(error.exit_status());
            // Files of several scenarios may have the same names.
            complain_of(format!("{argument}:\n"));
            complain(error);
        }
        let line = line(style, word, name, run);
        match run {
            Ok(report) if self.quiet && report.outcome != OutcomeReport::NotAsExpected => Ok(()),
            _ if self.quiet => {
                complain_of(line);
                Ok(())
            }
            _ => print_wrapped(line),
        }
    }

    /// Shows the results of all runs; `all` is the number of planned runs. Returns the exit status.
    pub(super) fn end(self, all: usize, page: &Path) -> Result<ExitCode, Error> {
        let counted = [
            (self.passed, GOOD, "passed"),
            (self.failed, BAD, "failed"),
            (self.errors, BAD, "could not run"),
            (self.interrupted, OPEN, "interrupted"),
            (all - self.passed - self.failed - self.errors - self.interrupted, OPEN, "not begun"),
        ];
        let mut text = Text::default();
        text.paint(HEAD, "     Summary", 0);
        let (simulated_s, wall_s) = (self.simulated_s, self.began.elapsed().as_secs_f64());
        text += format!("  {all} runs, {simulated_s:.0} simulated seconds in {wall_s:.1} s:");
        for (place, (count, style, word)) in counted.into_iter().filter(|(count, ..)| *count > 0).enumerate() {
            text += if place == 0 { " " } else { ", " };
            text.paint(style, &format!("{count} {word}"), 0);
        }
        text += format!("\n     Reports  {}\n", page.display());
        if !self.quiet {
            print_wrapped(text)?;
        }
        let interrupted = interrupt::flow().is_break().then_some(interrupt::STATUS);
        Ok(ExitCode::from(interrupted.or(self.error_status).unwrap_or(u8::from(self.failed > 0))))
    }
}

/// The line of a run, and below it the differences from the expectations.
fn line(style: Style, word: &str, name: &str, run: &Result<Report, Error>) -> Text {
    let mut text = Text::from("       ");
    text.paint(style, word, 5);
    let time = run.as_ref().map_or("-".to_owned(), |report| format!("{:.1} s", report.sim_time_s));
    text += format!("  [{time:>9}]  {name}\n");
    let differences = run.as_ref().map_or_else(|error| vec![error.reasons()], |report| report.differences.clone());
    for difference in differences {
        text += format!("{:27}{difference}\n", "");
    }
    text
}
