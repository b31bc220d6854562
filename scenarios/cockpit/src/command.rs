//! What the page asks for, as JSON.

use serde::Deserialize;

/// A request of the page.
#[derive(Debug, Deserialize)]
#[serde(tag = "do", rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum Command {
    /// Holds the run.
    Pause,
    /// Lets it go on.
    Resume,
    /// Performs one step and then holds.
    Step,
    /// Goes on to the next tick and then holds.
    Tick,
    /// Runs so many times faster than time passes; as fast as possible without a number.
    Speed {
        /// From 0.1 on.
        times: Option<f64>,
    },
    /// Shows what was at a time.
    Seek {
        /// Since the start of the run, in seconds.
        time: f64,
    },
    /// Shows again what is now.
    Now,
    /// Does something: a fault without trigger.
    Act {
        /// The entry of the fault.
        fault: toml::Table,
        /// What the page calls it. It takes the place of what lasts under the same name.
        #[serde(default)]
        name: String,
    },
    /// Ends what was done, by the name that the page gave to it.
    Release {
        /// The name.
        name: String,
    },
    /// Asks for the scenario that repeats the session.
    Save,
    /// Ends the run.
    End,
}

impl Command {
    /// Whether it is about how fast the run goes.
    pub(crate) fn is_of_pace(&self) -> bool {
        matches!(self, Self::Pause | Self::Resume | Self::Step | Self::Tick | Self::Speed { .. })
    }

    /// Reads a request; the reason if it is none.
    pub(crate) fn read(text: &str) -> Result<Self, String> {
        serde_json::from_str(text).map_err(|error| error.to_string())
    }
}
