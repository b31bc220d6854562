//! A file in MCAP with topics of ROS 2.

use std::collections::BTreeMap;
use std::io::{self, BufWriter, Write};
use std::marker::PhantomData;
use std::time::Duration;

use mcap::records::MessageHeader;
use mcap::write::NoSeek;

use super::cdr::Cdr;
use super::ros::{Field, definition};

/// A file in MCAP that is being written.
pub(crate) struct Output<W: Write> {
    mcap: mcap::Writer<NoSeek<BufWriter<W>>>,
}

/// A topic of a file.
pub(crate) struct Topic<T> {
    channel: u16,
    of: PhantomData<T>,
}

impl<W: Write> Output<W> {
    pub(crate) fn begin(output: W) -> io::Result<Self> {
        let options = mcap::WriteOptions::new()
            .compression(None)
            .profile("ros2")
            .library(concat!("steward/", env!("CARGO_PKG_VERSION")))
            .disable_seeking(true);
        Ok(Self { mcap: options.create(NoSeek::new(BufWriter::new(output))).map_err(unwritten)? })
    }

    /// Adds a topic.
    pub(crate) fn topic<T: Field>(&mut self, topic: &str) -> io::Result<Topic<T>> {
        let channel = self.channel(topic, &T::name(), &definition::<T>())?;
        Ok(Topic { channel, of: PhantomData })
    }

    /// Adds a topic whose type is not known here.
    pub(crate) fn channel(&mut self, topic: &str, name: &str, definition: &str) -> io::Result<u16> {
        let name = name.replacen('/', "/msg/", 1);
        let schema = self.mcap.add_schema(&name, "ros2msg", definition.as_bytes()).map_err(unwritten)?;
        self.mcap.add_channel(schema, topic, "cdr", &BTreeMap::new()).map_err(unwritten)
    }

    pub(crate) fn write<T: Field>(&mut self, topic: &Topic<T>, time: Duration, message: &T) -> io::Result<()> {
        let mut cdr = Cdr::new();
        message.write(&mut cdr);
        self.write_bytes(topic.channel, time, &cdr.bytes())
    }

    pub(crate) fn write_bytes(&mut self, channel_id: u16, time: Duration, bytes: &[u8]) -> io::Result<()> {
        let log_time = u64::try_from(time.as_nanos()).map_err(io::Error::other)?;
        let header = MessageHeader { channel_id, sequence: 0, log_time, publish_time: log_time };
        self.mcap.write_to_known_channel(&header, bytes).map_err(unwritten)
    }

    /// Makes what has been written so far readable, whatever happens next.
    pub(crate) fn flush(&mut self) -> io::Result<()> {
        self.mcap.flush().map_err(unwritten)
    }

    /// Ends the file and returns it.
    pub(crate) fn finish(mut self) -> io::Result<W> {
        self.mcap.finish().map_err(unwritten)?;
        self.mcap.into_inner().into_inner().into_inner().map_err(io::IntoInnerError::into_error)
    }
}

fn unwritten(error: mcap::McapError) -> io::Error {
    match error {
        mcap::McapError::Io(error) => error,
        error => io::Error::other(error),
    }
}
