//! A recording with ROS 2 topics.

use std::io::{self, Write};
use std::marker::PhantomData;
use std::time::Duration;

use super::cdr::Cdr;
use super::container::Container;
use super::ros::{Field, definition};

/// An MCAP file that is being written.
pub(crate) struct Output<W: Write>(Container<W>);

/// A topic of a file.
pub(crate) struct Topic<T> {
    channel: u16,
    of: PhantomData<T>,
}

impl<W: Write> Output<W> {
    pub(crate) fn begin(output: W) -> io::Result<Self> {
        let mut container = Container::begin(output, "ros2", concat!("steward/", env!("CARGO_PKG_VERSION")))?;
        // This tells later distributions that profiles are written as in Humble.
        container.metadata("rosbag2", "ROS_DISTRO", "humble")?;
        Ok(Self(container))
    }

    /// Adds a topic.
    pub(crate) fn topic<T: Field>(&mut self, topic: &str) -> io::Result<Topic<T>> {
        self.typed(topic, Durability::Volatile)
    }

    /// Adds a topic whose last message holds until the next: late subscribers get it, too.
    pub(crate) fn latched<T: Field>(&mut self, topic: &str) -> io::Result<Topic<T>> {
        self.typed(topic, Durability::TransientLocal)
    }

    fn typed<T: Field>(&mut self, topic: &str, durability: Durability) -> io::Result<Topic<T>> {
        let channel = self.add(topic, &T::name(), &definition::<T>(), durability)?;
        Ok(Topic { channel, of: PhantomData })
    }

    /// Adds a topic whose type is only known at run time.
    pub(crate) fn channel(&mut self, topic: &str, name: &str, definition: &str) -> io::Result<u16> {
        self.add(topic, name, definition, Durability::Volatile)
    }

    fn add(&mut self, topic: &str, name: &str, definition: &str, durability: Durability) -> io::Result<u16> {
        let name = name.replacen('/', "/msg/", 1);
        self.0.channel(topic, (&name, definition), ("offered_qos_profiles", &durability.profiles()))
    }

    pub(crate) fn write<T: Field>(&mut self, topic: &Topic<T>, time: Duration, message: &T) -> io::Result<()> {
        self.write_with(topic.channel, time, |cdr| message.write(cdr))
    }

    /// Writes a message whose type is only known at run time.
    pub(crate) fn write_with(&mut self, channel: u16, time: Duration, write: impl FnOnce(&mut Cdr)) -> io::Result<()> {
        let time_ns = u64::try_from(time.as_nanos()).map_err(io::Error::other)?;
        self.0.message(channel, time_ns, write);
        Ok(())
    }

    /// Makes what has been written so far readable, whatever happens next.
    pub(crate) fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }

    /// Ends the file and returns it.
    pub(crate) fn finish(self) -> io::Result<W> {
        self.0.finish()
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
