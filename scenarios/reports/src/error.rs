//! Why a run cannot be shown.

use std::fmt::Display;

use miette::Diagnostic;
use recording::{LogError, RecordingError};

/// Why a run cannot be shown.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be written.
    #[error(transparent)]
    File(#[from] diagnostics::Error),
    /// A picture could not be made.
    #[error("cannot draw a picture of the run")]
    Draw(#[from] drawing::Error),
    /// The recording cannot be shown.
    #[error(transparent)]
    Recording(#[from] RecordingError),
}

impl Diagnostic for Error {
    fn help<'a>(&'a self) -> Option<Box<dyn Display + 'a>> {
        let Self::Recording(error) = self else { return None };
        match error {
            RecordingError::TreeLog(LogError::Unfit { help, .. }) => return Some(Box::new(help)),
            RecordingError::TreeLog(LogError::Bag(error)) => return Some(Box::new(error.help())),
            _ => {}
        }
        Some(Box::new(match error {
            RecordingError::Foreign(_) => {
                "`steward run … --record FILE` writes a recording, as FILE.rec or FILE.mcap; of a ROS 2 bag, Nav2's tree is \
                 shown with `--tree FILE`"
            }
            RecordingError::Compressed { .. } => "decompress it, for example with `mcap decompress`",
            RecordingError::Version { .. } => {
                "run the scenario again with this version, or make the report with the recording's version"
            }
            RecordingError::Truncated { .. } => "an unfinished run has no report: run it again to its end",
            RecordingError::TreeLog(LogError::Damaged { .. } | LogError::CutOff { .. }) => {
                "a log is what FileLogger2 or SqliteLogger of BehaviorTree.CPP 4.6.2 or later wrote"
            }
            _ => "record the run again",
        }))
    }
}
