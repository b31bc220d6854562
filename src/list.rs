//! `steward list`: the scenarios and campaigns that come with the program.

use std::path::Path;

use campaigns::{CampaignFile, Error};
use scenarios::files::{Files, scenario_names, shipped_campaigns, shipped_scenarios};
use scenarios::scenario::ScenarioFile;

use crate::output::print_wrapped;

/// Prints one line per scenario and campaign.
pub(crate) fn list() -> Result<(), Error> {
    let mut text = String::from("Scenarios, for `steward run NAME`:\n");
    for name in shipped_scenarios() {
        text.push_str(&format!("{name:<15}  {}\n", about(name)?));
    }
    text.push_str(
        "faults/KIND      One kind of fault, as `steward faults` lists them: faults/joypad, faults/kidnap, …\n",
    );
    for (folder, title) in [
        ("guide/", "What can go wrong in `guide`; `steward run 'guide/*'` runs all of them:"),
        ("nav2/", "Defects of Nav2, and how they were fixed; `steward prove 'nav2/*'` finds them:"),
    ] {
        text.push_str(&format!("\n{title}\n"));
        for name in scenario_names().filter(|name| name.starts_with(folder)) {
            text.push_str(&format!("{name:<25}  {}\n", about(name)?));
        }
    }
    text.push_str("\nCampaigns, for `steward campaign NAME`:\n");
    for (name, source) in shipped_campaigns() {
        let file = CampaignFile::parse(name, source).map_err(Error::bad_input)?;
        text.push_str(&format!("{name:<15}  {}\n", file.about));
    }
    print_wrapped(text)
}

/// A shipped scenario's description.
fn about(name: &str) -> Result<String, Error> {
    let path = format!("scenarios/{name}.toml");
    let source = Files::shipped().read_text(Path::new(&path)).unwrap_or_default();
    let file = ScenarioFile::parse(&path, &source, &Files::shipped(), []).map_err(Error::bad_input)?;
    Ok(file.about)
}
