//! Which reader judges a log.

use std::path::Path;

use campaigns::Error;
use recording::{Recording, RecordingError};

use crate::judge::VerificationResult;
use crate::log_request::LogRequest;
use crate::wanted::Wanted;
use crate::{bag, event_log};

/// Judges a log, in constant memory.
///
/// # Errors
/// If it cannot be read or judged.
pub fn verify(request: &LogRequest<'_>, wanted: Wanted<'_>) -> Result<VerificationResult, Error> {
    let LogRequest { path, tree, .. } = *request;
    let is_bag = tree.is_none() && bags::is_bag(path);
    // A recording of a run in MCAP is also a bag. It needs no mapping, but accepts one.
    let is_mapped = is_bag && request.mapping.is_some();
    // A name without a file may denote a part of a recording. A pipe can be read only once.
    let is_file = path != Path::new("-") && std::fs::metadata(path).map_or(true, |about| about.is_file());
    let recording = (tree.is_some() || is_file && !is_mapped).then(|| Recording::open_with(path, tree));
    let recording = match recording {
        Some(Ok(recording)) => Some(recording),
        Some(Err(error)) if tree.is_some() => return Err(reports::Error::from(error).into()),
        Some(Err(RecordingError::Foreign(_) | RecordingError::Read { .. })) | None => None,
        // A bag may be damaged, or compressed, in another way than a recording.
        Some(Err(error)) if !is_bag || matches!(error, RecordingError::Version { .. }) => {
            return Err(event_log::unreadable(path, &error));
        }
        Some(Err(_)) => None,
    };
    if request.is_followed && recording.is_some() {
        let message = format!("{} is a recording by steward, which cannot be followed", path.display());
        return Err(Error::refused(message, "check it when the run is over, without `--follow`"));
    }
    match is_bag && recording.is_none() {
        true => bag::verify(request, wanted),
        false => event_log::verify(request, recording, wanted),
    }
}
