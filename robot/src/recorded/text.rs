//! The text of a log, which may be compressed.

use std::io::{self, Read as _};

use flate2::read::MultiGzDecoder;

use super::complaint::{Complaints, Flaw, RecordingError};

/// Longer logs, in bytes, are refused.
const LONGEST: u64 = 1 << 30;

/// The log's text. A truncated compressed log is used up to where it ends, since everything before could be decoded. If
/// the compressed data is inconsistent, none of it can be trusted.
pub(super) fn decompressed(bytes: &[u8], complaints: &mut Complaints) -> Result<Vec<u8>, RecordingError> {
    if !bytes.starts_with(&[0x1f, 0x8b]) {
        return Ok(bytes.to_vec());
    }
    let mut text = Vec::new();
    let read = MultiGzDecoder::new(bytes).take(LONGEST + 1).read_to_end(&mut text);
    let line = 1 + text.iter().filter(|byte| **byte == b'\n').count();
    match read {
        Ok(_) if text.len() as u64 > LONGEST => Err(RecordingError::TooLong),
        Ok(_) => Ok(text),
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
            complaints.add(line, Flaw::CompressionBreaksOff);
            Ok(text)
        }
        Err(source) => Err(RecordingError::Damaged { line, source: source.into() }),
    }
}
