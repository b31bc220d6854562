//! Writes logs in the format of `FileLogger2`.

use std::io::{self, Write};

use crate::file_logger::{MAGIC, PROTOCOL};
use crate::status::LoggedTransition;
use crate::tree::MAX_XML_BYTES;

/// Writes a log as `FileLogger2` does: a file `.btlog`.
#[derive(Debug)]
pub struct LogWriter<W: Write> {
    output: W,
    began_us: i64,
}

impl<W: Write> LogWriter<W> {
    /// Begins a log with the tree in the form that [`LoggedTree`](crate::LoggedTree) reads, at this time in
    /// microseconds since 1970.
    ///
    /// # Errors
    /// If writing fails, or if the tree is larger than what is read back.
    pub fn begin(mut output: W, xml: &str, began_us: i64) -> io::Result<Self> {
        let length = i32::try_from(xml.len()).ok().filter(|_| xml.len() <= MAX_XML_BYTES);
        let too_large = || format!("its tree has {} bytes in a log, and at most {MAX_XML_BYTES} are read", xml.len());
        let length = length.ok_or_else(|| io::Error::other(too_large()))?;
        output.write_all(MAGIC)?;
        output.write_all(&[PROTOCOL])?;
        output.write_all(&length.to_le_bytes())?;
        output.write_all(xml.as_bytes())?;
        output.write_all(&began_us.to_le_bytes())?;
        Ok(Self { output, began_us })
    }

    /// Writes the next transition.
    ///
    /// # Errors
    /// If writing fails, or if the transition does not fit the format.
    pub fn write(&mut self, transition: LoggedTransition) -> io::Result<()> {
        let bytes = transition.to_bytes(self.began_us);
        let unfit = || io::Error::other(format!("the transition does not fit the format of the log: {transition:?}"));
        self.output.write_all(&bytes.ok_or_else(unfit)?)
    }

    /// Ends the log and returns its file.
    ///
    /// # Errors
    /// If writing fails.
    pub fn finish(mut self) -> io::Result<W> {
        self.output.flush()?;
        Ok(self.output)
    }
}
