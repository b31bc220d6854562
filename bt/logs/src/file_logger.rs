//! `FileLogger2`: what is known before the first transition, then nine bytes for each transition. Its numbers are
//! little-endian.

use std::fs::File;
use std::io::{BufRead as _, BufReader, ErrorKind, Read as _};
use std::path::Path;

use crate::error::LogError;
use crate::status::LoggedTransition;
use crate::tree::MAX_XML_BYTES;

/// The first bytes of the file.
pub(crate) const MAGIC: &[u8] = b"BTCPP4-FileLogger2";
/// The version of what follows.
pub(crate) const PROTOCOL: u8 = 1;

/// The transitions of a file.
#[derive(Debug)]
pub(crate) struct FileLog {
    input: BufReader<File>,
    /// In microseconds since 1970.
    pub(crate) began_us: i64,
}

impl FileLog {
    /// Reads what comes after the first bytes: the tree's XML, and when the log began.
    pub(crate) fn begin(file: File, path: &Path) -> Result<(String, Self), LogError> {
        let mut input = BufReader::new(file);
        let damaged = |problem: String| LogError::Damaged { path: path.to_owned(), problem };
        let [protocol] = whole(&mut input, path, "it ends within its version")?;
        if protocol != PROTOCOL {
            return Err(damaged(format!("it has version {protocol} of the format; this program reads {PROTOCOL}")));
        }
        let length = i32::from_le_bytes(whole(&mut input, path, "it ends within the length of its tree")?);
        let known = usize::try_from(length).ok().filter(|length| *length <= MAX_XML_BYTES);
        let too_large = || damaged(format!("its tree would have {length} bytes; at most {MAX_XML_BYTES} are read"));
        let (known, mut xml) = (known.ok_or_else(too_large)?, Vec::new());
        let read = (&mut input).take(known as u64).read_to_end(&mut xml);
        read.map_err(|source| LogError::Read { path: path.to_owned(), source })?;
        if xml.len() < known {
            return Err(LogError::CutOff { path: path.to_owned(), what: "it ends within its tree".to_owned() });
        }
        let xml = String::from_utf8(xml).map_err(|_| damaged("its tree is not UTF-8 text".to_owned()))?;
        let began_us = i64::from_le_bytes(whole(&mut input, path, "it ends within the time at which it began")?);
        Ok((xml, Self { input, began_us }))
    }

    pub(crate) fn next_transition(&mut self, path: &Path) -> Result<Option<LoggedTransition>, LogError> {
        let rest = self.input.fill_buf().map_err(|source| LogError::Read { path: path.to_owned(), source })?;
        if rest.is_empty() {
            return Ok(None);
        }
        let bytes = whole(&mut self.input, path, "its last transition is not whole")?;
        Ok(Some(LoggedTransition::from_bytes(bytes, self.began_us)))
    }
}

/// The next bytes; `what` is the problem if the file ends before them.
fn whole<const N: usize>(input: &mut BufReader<File>, path: &Path, what: &str) -> Result<[u8; N], LogError> {
    let mut bytes = [0; N];
    match input.read_exact(&mut bytes) {
        Ok(()) => Ok(bytes),
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => {
            Err(LogError::CutOff { path: path.to_owned(), what: what.to_owned() })
        }
        Err(source) => Err(LogError::Read { path: path.to_owned(), source }),
    }
}
