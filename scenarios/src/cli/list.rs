//! `steward list`: the scenarios that come with the program.

use std::path::Path;

use super::print;
use crate::Error;
use crate::files::{Files, shipped_scenarios};
use crate::scenario::ScenarioFile;

/// Prints a line for each scenario.
pub(super) fn list() -> Result<(), Error> {
    let mut text = String::new();
    for name in shipped_scenarios() {
        let path = format!("scenarios/{name}.toml");
        let source = Files::shipped().read_text(Path::new(&path)).unwrap_or_default();
        let file = ScenarioFile::parse(&path, &source, &Files::shipped(), []).map_err(Error::bad_input)?;
        text.push_str(&format!("{name:<16} {}\n", file.about));
    }
    text.push_str(
        "\nfaults/KIND      shows a kind of fault, as `steward faults` lists them: faults/joypad, faults/kidnap, …\n",
    );
    print(&text)
}
