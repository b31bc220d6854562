//! Whether rustdds still receives and discovers.
//!
//! Two threads do that. They end silently when a signal interrupts them, as any pause of the process does. Other causes
//! are not known. So this module sends datagrams to the participant itself. Each disposes of a participant that does
//! not exist, a phantom, and rustdds reports any disposal once the datagram has passed through both threads. No other
//! participant receives these datagrams.
//!
//! Source: OMG's DDSI-RTPS 2.5, 8.5.3 (participant discovery), 9.4.5.4 (`Data`), 9.6.2.2 (ports).

use std::net::{Ipv4Addr, UdpSocket};
use std::time::{Duration, Instant};

use super::exchange::{Prefix, prefix};
use super::options::Options;
use crate::clock::now;

/// How often a datagram is sent: normally, while messages arrive more often and advance the clock themselves, and while
/// an answer is overdue.
const PERIOD: Duration = Duration::from_millis(20);
const PERIOD_IF_BUSY: Duration = Duration::from_millis(100);
const PERIOD_IF_LATE: Duration = Duration::from_millis(200);

/// The most datagrams in a row without an answer. More prove that a thread has ended. Datagrams are counted instead of
/// time: a machine that is too busy for rustdds is too busy to send them, and a paused process sends none.
const MOST_UNANSWERED: u32 = 5;

/// The same while messages arrive. Then the thread that receives is alive, and a flood of messages may displace the
/// datagrams.
const MOST_UNANSWERED_IF_BUSY: u32 = 50;

/// How many phantoms take turns. So a late answer is not taken for the answer to a later datagram.
const PHANTOMS: u8 = 64;

/// Probes the threads of a participant.
pub(super) struct Pulse {
    socket: UdpSocket,
    port: u16,
    /// The prefix of the first phantom. The others differ in the last byte.
    phantom: Prefix,
    sent: u32,
    sent_at: Option<Instant>,
    /// The number of the first datagram without an answer, and when it was sent by the clock of messages.
    open: Option<(u32, i64)>,
    unanswered: u32,
    /// When the last message was received.
    message_at: Option<Instant>,
    /// Until when both threads are known to have been alive.
    alive_ns: Option<i64>,
    /// Why the last datagram could not be sent.
    unsent: Option<String>,
}

impl Pulse {
    /// A pulse of the participant with this GUID, the `index`th on this machine.
    ///
    /// # Errors
    /// If nothing can be sent: the reason.
    pub(super) fn of(options: Options, index: u16, participant: &[u8; 16]) -> Result<Self, String> {
        let why = |error: std::io::Error| format!("nothing can be sent on this machine's loopback: {error}");
        let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).map_err(why)?;
        socket.set_nonblocking(true).map_err(why)?;
        let port = u16::try_from(options.port() + 10 + 2 * u32::from(index)).map_err(|error| error.to_string())?;
        let mut phantom: Prefix = prefix(participant);
        // A GUID begins with the id of its vendor. Inverted, it is that of no real participant.
        (phantom[0], phantom[1]) = (!phantom[0], !phantom[1]);
        let (sent_at, open, message_at, alive_ns, unsent) = (None, None, None, None, None);
        Ok(Self { socket, port, phantom, sent: 0, sent_at, open, unanswered: 0, message_at, alive_ns, unsent })
    }

    /// Sends a datagram if one is due. `now_ns` is the time of the clock of messages.
    pub(super) fn beat(&mut self, now_ns: i64) {
        let is_busy = self.message_at.is_some_and(|message| message.elapsed() < PERIOD);
        let period = match self.unanswered {
            0 | 1 if is_busy => PERIOD_IF_BUSY,
            0 | 1 => PERIOD,
            _ => PERIOD_IF_LATE,
        };
        if self.sent_at.is_some_and(|sent| sent.elapsed() < period) {
            return;
        }
        self.sent_at = Some(now());
        self.sent = self.sent.wrapping_add(1);
        self.open.get_or_insert((self.sent, now_ns));
        self.unanswered += 1;
        let datagram = datagram(&self.phantom(self.sent), self.sent);
        self.unsent = self.socket.send_to(&datagram, (Ipv4Addr::LOCALHOST, self.port)).err().map(|why| why.to_string());
    }

    fn phantom(&self, number: u32) -> Prefix {
        let mut phantom = self.phantom;
        phantom[11] = (number % u32::from(PHANTOMS)) as u8;
        phantom
    }

    /// Whether a participant that was disposed of is a phantom. Then both threads were alive when its datagram was
    /// sent.
    pub(super) fn is_answer(&mut self, disposed: &Prefix) -> bool {
        if disposed[..11] != self.phantom[..11] {
            return false;
        }
        if let Some((first, since_ns)) = self.open {
            // An answer to a later datagram answers all before it. Only the time of the first one is known.
            let is_to_it = (first..=self.sent).any(|number| self.phantom(number) == *disposed);
            if is_to_it {
                self.alive_ns = self.alive_ns.max(Some(since_ns));
                (self.open, self.unanswered) = (None, 0);
            }
        }
        true
    }

    /// A message was received.
    pub(super) fn note_message(&mut self) {
        self.message_at = Some(now());
    }

    /// Until when rustdds is known to have received and discovered everything.
    pub(super) fn alive_ns(&self) -> Option<i64> {
        self.alive_ns
    }

    /// Why the participant must be replaced, if one of its threads has ended.
    pub(super) fn is_dead(&self) -> Option<String> {
        let is_overdue = self.sent_at.is_some_and(|sent| sent.elapsed() >= PERIOD_IF_LATE);
        let is_busy = self.message_at.is_some_and(|message| message.elapsed() < 2 * PERIOD_IF_LATE);
        let most = if is_busy { MOST_UNANSWERED_IF_BUSY } else { MOST_UNANSWERED };
        (self.unanswered > most || self.unanswered == most && is_overdue).then(|| {
            // While the loopback is down, datagrams are lost without an error.
            self.unsent.as_ref().map_or_else(
                || {
                    "nothing was received any more: this process was paused, or the loopback down, or it is defective"
                        .to_owned()
                },
                |why| format!("nothing can be sent on this machine's loopback, which must be up: {why}"),
            )
        })
    }
}

/// A `Data` submessage of the writer that announces participants: it disposes of a phantom.
fn datagram(phantom: &Prefix, number: u32) -> Vec<u8> {
    const HEADER: &[u8] = b"RTPS\x02\x03\x01\x12";
    // Little-endian, with a key as payload and without inline QoS; 48 bytes follow.
    const DATA: &[u8] = &[0x15, 0b1001, 48, 0, 0, 0, 16, 0];
    const TO_ALL_FROM_ANNOUNCER: &[u8] = &[0, 0, 0, 0, 0, 1, 0, 0xc2];
    const PARAMETERS: &[u8] = &[0, 3, 0, 0];
    const PARTICIPANT: &[u8] = &[0x50, 0, 16, 0];
    const PARTICIPANT_ENTITY: &[u8] = &[0, 0, 1, 0xc1];
    const END: &[u8] = &[1, 0, 0, 0];
    let number = number.to_le_bytes();
    let addressed = [HEADER, phantom, DATA, TO_ALL_FROM_ANNOUNCER, &[0; 4], &number].concat();
    [&addressed[..], PARAMETERS, PARTICIPANT, phantom, PARTICIPANT_ENTITY, END].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pulse, and the socket that receives its datagrams.
    fn pulse() -> (Pulse, UdpSocket) {
        let to = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port");
        to.set_nonblocking(true).expect("a socket");
        let mut pulse = Pulse::of(Options { domain: 0, is_local: true }, 0, &[7; 16]).expect("a loopback");
        pulse.port = to.local_addr().expect("an address").port();
        (pulse, to)
    }

    /// The phantoms in the datagrams that have been received.
    fn phantoms(to: &UdpSocket) -> Vec<Prefix> {
        let mut datagram = [0; 100];
        let mut next = || to.recv(&mut datagram).ok().map(|length| datagram[..length][8..20].try_into().expect("12"));
        std::iter::from_fn(&mut next).collect()
    }

    /// Makes the next datagram due.
    fn wait(pulse: &mut Pulse) {
        pulse.sent_at = pulse.sent_at.map(|sent| sent - PERIOD_IF_LATE);
    }

    #[test]
    fn an_answer_proves_that_the_threads_were_alive_when_the_first_datagram_was_sent() {
        let (mut pulse, to) = pulse();
        pulse.beat(5);
        pulse.beat(6);
        let [phantom] = phantoms(&to)[..] else { panic!("it is not time for another") };
        assert_eq!((pulse.alive_ns(), pulse.is_answer(&[7; 12]), pulse.alive_ns()), (None, false, None));
        assert!(pulse.is_answer(&phantom) && pulse.alive_ns() == Some(5));
        for now_ns in 10..13 {
            wait(&mut pulse);
            pulse.beat(now_ns);
        }
        let [.., last] = phantoms(&to)[..] else { panic!() };
        // A repeated answer proves nothing about later datagrams.
        assert!(pulse.is_answer(&phantom) && pulse.alive_ns() == Some(5));
        assert!(pulse.is_answer(&last) && pulse.alive_ns() == Some(10));
    }

    #[test]
    fn time_alone_proves_nothing() {
        let (mut pulse, _to) = pulse();
        for sent in 0..MOST_UNANSWERED {
            assert!(pulse.is_dead().is_none(), "after {sent}");
            pulse.beat(i64::from(sent));
            pulse.beat(i64::from(sent));
            assert!(pulse.is_dead().is_none(), "after {sent}");
            wait(&mut pulse);
        }
        assert!(pulse.is_dead().is_some_and(|why| why.contains("paused")));
    }
}
