//! A recording with ROS 2 topics.

use std::collections::BTreeMap;
use std::io::{self, BufWriter, Write};
use std::marker::PhantomData;
use std::time::Duration;

use mcap::McapError;
use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use ros_messages::{Bundle, CdrWriter, RosMessage, TypeName};

/// A chunk usually fits, so it is written at once.
const BUFFER_BYTES: usize = 1 << 16;

/// The library that a file names as its writer, before the version.
pub(crate) const LIBRARY: &str = "steward/";

/// An MCAP file that is being written.
pub(crate) struct Output<W: Write> {
    mcap: mcap::Writer<NoSeek<BufWriter<W>>>,
    /// The bytes of the last message; their memory is reused.
    message: Vec<u8>,
}

pub(crate) struct Topic<T> {
    channel: u16,
    of: PhantomData<T>,
}

impl<W: Write> Output<W> {
    pub(crate) fn begin(output: W) -> io::Result<Self> {
        let options = mcap::WriteOptions::new()
            .compression(None)
            .profile("ros2")
            .library(format!("{LIBRARY}{}", env!("CARGO_PKG_VERSION")))
            .disable_seeking(true)
            // The records have a checksum of their own.
            .calculate_chunk_crcs(false)
            .calculate_data_section_crc(false);
        let output = NoSeek::new(BufWriter::with_capacity(BUFFER_BYTES, output));
        let mut mcap = options.create(output).map_err(unwritten)?;
        // With this, later distributions read profiles as in Humble.
        let metadata = BTreeMap::from([("ROS_DISTRO".to_owned(), "humble".to_owned())]);
        mcap.write_metadata(&Metadata { name: "rosbag2".to_owned(), metadata }).map_err(unwritten)?;
        Ok(Self { mcap, message: Vec::new() })
    }

    pub(crate) fn topic<T: RosMessage>(&mut self, topic: &str) -> io::Result<Topic<T>> {
        self.typed(topic, Durability::Volatile)
    }

    /// Adds a topic whose last message holds until the next: late subscribers get it, too.
    pub(crate) fn latched<T: RosMessage>(&mut self, topic: &str) -> io::Result<Topic<T>> {
        self.typed(topic, Durability::TransientLocal)
    }

    fn typed<T: RosMessage>(&mut self, topic: &str, durability: Durability) -> io::Result<Topic<T>> {
        let channel = self.add(topic, &T::name(), &T::definition(), durability)?;
        Ok(Topic { channel, of: PhantomData })
    }

    /// Adds a topic whose type is only known at run time.
    pub(crate) fn channel(&mut self, topic: &str, name: &TypeName, definition: &Bundle) -> io::Result<u16> {
        self.add(topic, name, definition, Durability::Volatile)
    }

    fn add(&mut self, topic: &str, name: &TypeName, definition: &Bundle, durability: Durability) -> io::Result<u16> {
        let schema =
            self.mcap.add_schema(&name.full(), "ros2msg", definition.to_string().as_bytes()).map_err(unwritten)?;
        let metadata = BTreeMap::from([("offered_qos_profiles".to_owned(), durability.profiles())]);
        self.mcap.add_channel(schema, topic, "cdr", &metadata).map_err(unwritten)
    }

    pub(crate) fn write<T: RosMessage>(&mut self, topic: &Topic<T>, time: Duration, message: &T) -> io::Result<()> {
        self.write_with(topic.channel, time, |cdr| message.write(cdr))
    }

    /// Writes a message whose type is only known at run time.
    pub(crate) fn write_with(
        &mut self,
        channel: u16,
        time: Duration,
        write: impl FnOnce(&mut CdrWriter),
    ) -> io::Result<()> {
        let mut cdr = CdrWriter::reusing(std::mem::take(&mut self.message));
        write(&mut cdr);
        self.message = cdr.bytes();
        let log_time = u64::try_from(time.as_nanos()).map_err(io::Error::other)?;
        let header = MessageHeader { channel_id: channel, sequence: 0, log_time, publish_time: log_time };
        self.mcap.write_to_known_channel(&header, &self.message).map_err(unwritten)
    }

    /// Makes what has been written so far readable, whatever happens next.
    pub(crate) fn flush(&mut self) -> io::Result<()> {
        self.mcap.flush().map_err(unwritten)
    }

    pub(crate) fn finish(mut self) -> io::Result<W> {
        self.mcap.finish().map_err(unwritten)?;
        self.mcap.into_inner().into_inner().into_inner().map_err(io::IntoInnerError::into_error)
    }
}

fn unwritten(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        error => io::Error::other(error),
    }
}

/// Whether late subscribers get earlier messages. The values are those of ROS 2.
#[derive(Clone, Copy, Debug)]
enum Durability {
    TransientLocal = 1,
    Volatile = 2,
}

impl Durability {
    /// The publisher's QoS profile, for bag players: reliable, with the usual defaults.
    fn profiles(self) -> String {
        const FOREVER: &str = "{sec: 9223372036, nsec: 854775807}";
        let depth = if let Self::TransientLocal = self { 1 } else { 10 };
        format!(
            "- {{history: 1, depth: {depth}, reliability: 1, durability: {}, deadline: {FOREVER}, lifespan: {FOREVER}, \
             liveliness: 1, liveliness_lease_duration: {FOREVER}, avoid_ros_namespace_conventions: false}}\n",
            self as u8
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ros::Text;

    #[test]
    fn a_file_has_an_index_metadata_and_profiles() {
        let mut output = Output::begin(Vec::new()).unwrap();
        let [plain, latched] = [output.topic("/plain").unwrap(), output.latched("/latched").unwrap()];
        for (second, topic) in [(1, &plain), (2, &latched), (3, &plain)] {
            let data = second.to_string();
            output.write(topic, Duration::from_secs(second), &Text { data }).unwrap();
            output.flush().unwrap();
        }
        let bytes = output.finish().unwrap();
        let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
        let mut found = Vec::new();
        for chunk in &summary.chunk_indexes {
            for entry in summary.read_message_indexes(&bytes, chunk).unwrap().values().flatten() {
                let message = summary.seek_message(&bytes, chunk, entry).unwrap();
                found.push((message.log_time / 1_000_000_000, message.channel.topic.clone(), message.data[8]));
            }
        }
        let expected = [(1, "/plain", b'1'), (2, "/latched", b'2'), (3, "/plain", b'3')];
        assert_eq!(found, expected.map(|(second, topic, digit)| (second, topic.to_owned(), digit)));
        let durability = |topic: &str| {
            let channel = summary.channels.values().find(|channel| channel.topic == topic).unwrap();
            let schema = channel.schema.as_ref().unwrap();
            assert_eq!(
                (schema.name.as_str(), schema.data.as_ref()),
                ("std_msgs/msg/String", b"string data\n".as_slice())
            );
            let words = channel.metadata["offered_qos_profiles"].split(", ");
            words.filter_map(|word| word.strip_prefix("durability: ")).collect::<String>()
        };
        assert_eq!([durability("/plain"), durability("/latched")], ["2", "1"]);
        let metadata = mcap::read::metadata(&bytes, &summary.metadata_indexes[0]).unwrap();
        assert_eq!((metadata.name.as_str(), metadata.metadata["ROS_DISTRO"].as_str()), ("rosbag2", "humble"));
    }
}
