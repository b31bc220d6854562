//! The page's requests, as JSON.

use serde::Deserialize;

/// A request of the page.
#[derive(Debug, Deserialize)]
#[serde(tag = "do", rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum Command {
    Pause,
    Resume,
    /// Performs one step, then pauses.
    Step,
    /// Goes on to the next tick, then pauses.
    Tick,
    /// Runs at this multiple of real time, or as fast as possible if there is no number.
    Speed {
        /// At least 0.1.
        times: Option<f64>,
    },
    /// Shows the run as it was at a time.
    Seek {
        /// Since the start of the run, in seconds.
        time: f64,
    },
    /// Shows the present again.
    Now,
    /// Performs an act: a fault without a trigger.
    Act {
        /// The entry of the fault.
        fault: toml::Table,
        /// The page's name for it. It replaces the lasting act of the same name.
        #[serde(default)]
        name: String,
    },
    /// Ends an act, by the name that the page gave it.
    Release {
        name: String,
    },
    /// Shows all children of a node of the tree, however large the tree is, or no longer.
    Unfold {
        /// The node, by its index.
        node: usize,
        /// The run in whose tree it is, if there are several. In the others, the node of the same name is meant.
        #[serde(default)]
        side: usize,
        /// Whether it is opened, or folded again where there is no room.
        open: bool,
    },
    /// Aligns recordings beside each other where they agree, or shows each from its own start.
    Align {
        /// Whether they are aligned.
        on: bool,
    },
    /// Asks for a scenario that repeats the session.
    Save,
    End,
    /// Starts the scenario anew, without what was done by hand.
    Restart,
    /// Asks for the page of the report of a run that has ended.
    Report,
}

impl Command {
    /// Whether it is about the pace of the run.
    pub(crate) fn is_of_pace(&self) -> bool {
        matches!(self, Self::Pause | Self::Resume | Self::Step | Self::Tick | Self::Speed { .. })
    }

    /// Reads a request. The error is in words.
    pub(crate) fn read(text: &str) -> Result<Self, String> {
        serde_json::from_str(text).map_err(|error| error.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_are_read_strictly() {
        assert!(matches!(Command::read(r#"{"do":"speed","times":null}"#), Ok(Command::Speed { times: None })));
        let act = Command::read(r#"{"do":"act","fault":{"kind":"joypad","linear_mps":-0.2}}"#);
        assert!(matches!(act, Ok(Command::Act { fault, name }) if fault.len() == 2 && name.is_empty()));
        for wrong in ["", "[]", r#"{"do":"fly"}"#, r#"{"do":"seek"}"#, r#"{"do":"seek","time":1,"speed":2}"#] {
            assert!(Command::read(wrong).is_err(), "{wrong}");
        }
    }
}
