//! `FileLogger2`: what is known before the first transition, then nine bytes for each transition. Its numbers are
//! little-endian.

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};

use crate::error::LogError;
use crate::status::{StatusChange, status_change};
use crate::tree::{MAX_XML_BYTES, Numbers};

/// The first bytes of the file.
pub(crate) const MAGIC: &[u8; 18] = b"BTCPP4-FileLogger2";
/// The version of what follows.
const PROTOCOL: u8 = 1;
/// How many bits a time has.
const TIME_BITS: u32 = 48;

/// The transitions of a file.
#[derive(Debug)]
pub(crate) struct FileLog {
    path: PathBuf,
    input: BufReader<File>,
    began_us: i64,
    numbers: Numbers,
}

impl FileLog {
    /// Reads what comes after the first bytes: the tree's XML, when the log began, and then its transitions, once it is
    /// known which node has which number.
    pub(crate) fn begin(file: File, path: &Path) -> Result<(String, i64, impl FnOnce(Numbers) -> Self), LogError> {
        let mut input = BufReader::new(file);
        let damaged = |problem: String| LogError::Damaged { path: path.to_owned(), problem };
        let mut part = |length: usize, what: &str| {
            let mut bytes = Vec::new();
            let read = (&mut input).take(length as u64).read_to_end(&mut bytes);
            read.map_err(|source| LogError::Read { path: path.to_owned(), source })?;
            let cut_off = || LogError::CutOff { path: path.to_owned(), what: format!("it ends within {what}") };
            if bytes.len() == length { Ok(bytes) } else { Err(cut_off()) }
        };
        let protocol = part(1, "its version")?[0];
        if protocol != PROTOCOL {
            return Err(damaged(format!("it has version {protocol} of the format; this program reads {PROTOCOL}")));
        }
        let length = part(4, "the length of its tree")?;
        let length = i32::from_le_bytes([length[0], length[1], length[2], length[3]]);
        let length = usize::try_from(length)
            .ok()
            .filter(|length| *length <= MAX_XML_BYTES)
            .ok_or_else(|| damaged(format!("its tree would have {length} bytes; at most {MAX_XML_BYTES} are read")))?;
        let xml = part(length, "its tree")?;
        let xml = String::from_utf8(xml).map_err(|_| damaged("its tree is not UTF-8 text".to_owned()))?;
        let began = part(8, "the time at which it began")?;
        let began_us = i64::from_le_bytes(std::array::from_fn(|byte| began[byte]));
        let path = path.to_owned();
        Ok((xml, began_us, move |numbers| Self { path, input, began_us, numbers }))
    }

    pub(crate) fn next_change(&mut self) -> Result<Option<StatusChange>, LogError> {
        let mut record = [0; 9];
        let failed = |source| LogError::Read { path: self.path.clone(), source };
        match read_up_to(&mut self.input, &mut record).map_err(failed)? {
            0 => return Ok(None),
            9 => {}
            _ => {
                let what = "its last transition is not whole".to_owned();
                return Err(LogError::CutOff { path: self.path.clone(), what });
            }
        }
        let [time @ .., uid_low, uid_high, status] = record;
        let time = time.iter().rev().fold(0, |time, byte| time << 8 | i64::from(*byte));
        // If the clock is set back to before the beginning, the time is negative, and the file has its lower bits.
        let unused = i64::BITS - TIME_BITS;
        let at_us = self.began_us.saturating_add(time << unused >> unused);
        let uid = i64::from(u16::from_le_bytes([uid_low, uid_high]));
        status_change(&self.numbers, at_us, uid, i64::from(status), &self.path).map(Some)
    }
}

/// Reads until the buffer is full or the input ends. Returns the number of bytes.
pub(crate) fn read_up_to(input: &mut impl Read, buffer: &mut [u8]) -> io::Result<usize> {
    let mut rest = Vec::new();
    input.take(buffer.len() as u64).read_to_end(&mut rest)?;
    buffer[..rest.len()].copy_from_slice(&rest);
    Ok(rest.len())
}
