//! Outputs made from a run's records: the report as JSON and as a page, pictures, an animation; and results for CI.
//!
//! Everything here reads a [`RunView`](recording::RunView) and nothing else of a run, so live and recorded runs give
//! the same outputs: [`report_recording`] reads a recording.
//!
//! # Inside
//! `presentation` follows a run's view and writes the requested outputs; `timeline` keeps what has changed; `bounds`
//! finds the numbers with which properties compare something; `html` makes the page from all this, with charts drawn
//! on the canvas of `drawing`, and a script that draws the timeline anew as one explores it; `reporting` makes
//! `report.json`, whose fields `report` lists. `report_recording` does all of this from a file.
//!
//! `results` is what commands have found, with places in files (`file_place`); `junit`, `sarif` and `markdown` write
//! it, and `results_file` chooses the format.

pub mod bounds;
mod error;
mod file_name;
pub mod file_place;
pub mod html;
mod junit;
mod markdown;
pub mod pictures;
mod presentation;
pub mod report;
mod reporting;
pub mod results;
mod results_file;
mod sarif;
pub mod timeline;
mod unheard;
mod witness;

pub use error::Error;
pub use file_name::file_name;
pub use presentation::{Outputs, Presentation, REPORT, report_recording};
pub use results_file::{ResultsFile, ResultsFormat};
pub use unheard::unheard_level;
pub use witness::{WitnessReport, witness, witness_in_words};
