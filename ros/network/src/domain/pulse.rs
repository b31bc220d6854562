//! Whether rustdds still receives and discovers.
//!
//! Two threads do that, and end without a word when a signal interrupts them, as any pause of the process does; what
//! else can stop them is not known. So a datagram is sent to the participant itself, again and again, which has an
//! effect only after it has passed through both: it bids farewell for a stranger, and rustdds tells of any farewell.
//! The stranger is in no domain, and no other participant receives its datagrams.
//!
//! Source: OMG's DDSI-RTPS 2.5, 8.5.3 (participant discovery), 9.4.5.4 (`Data`), 9.6.2.2 (ports).

use std::net::{Ipv4Addr, UdpSocket};
use std::time::{Duration, Instant};

use super::heard::Prefix;
use super::options::Options;
use crate::clock::now;

/// How often a datagram is sent; how often while messages come more often, which tell the time themselves; and how
/// often while an answer is overdue.
const PERIOD: Duration = Duration::from_millis(20);
const PERIOD_IF_BUSY: Duration = Duration::from_millis(100);
const PERIOD_IF_LATE: Duration = Duration::from_millis(200);

/// So many in a row without an answer are proof of death. They are counted, and not the time: a machine that is too
/// busy for rustdds is too busy to send them, and a process that was paused sends none meanwhile.
const MOST_UNANSWERED: u32 = 5;

/// The same while messages come: then one of the threads lives, and a flood of them pushes out the datagrams.
const MOST_UNANSWERED_IF_BUSY: u32 = 50;

/// So many strangers take turns, so that a late answer is not taken for that to a later datagram.
const STRANGERS: u8 = 64;

/// Probes a participant.
pub(super) struct Pulse {
    socket: UdpSocket,
    port: u16,
    /// What the GUIDs of strangers begin with.
    stranger: Prefix,
    sent: u32,
    sent_at: Option<Instant>,
    /// What the first datagram without an answer was, and when it was sent by the clock of messages.
    open: Option<(u32, i64)>,
    unanswered: u32,
    /// When the last message came.
    message_at: Option<Instant>,
    /// Until when both threads are known to have lived.
    lived_ns: Option<i64>,
    /// Why the last one could not be sent.
    unsent: Option<String>,
}

impl Pulse {
    /// Of the participant with this GUID, the `index`th on this machine.
    ///
    /// # Errors
    /// Why nothing can be sent.
    pub(super) fn of(options: Options, index: u16, participant: &[u8; 16]) -> Result<Self, String> {
        let why = |error: std::io::Error| format!("nothing can be sent on this machine's loopback: {error}");
        let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).map_err(why)?;
        socket.set_nonblocking(true).map_err(why)?;
        let port = u16::try_from(options.port() + 10 + 2 * u32::from(index)).map_err(|error| error.to_string())?;
        let mut stranger: Prefix = super::heard::prefix(participant);
        // A GUID begins with the number of the vendor that has made it.
        (stranger[0], stranger[1]) = (!stranger[0], !stranger[1]);
        let (sent_at, open, message_at, lived_ns, unsent) = (None, None, None, None, None);
        Ok(Self { socket, port, stranger, sent: 0, sent_at, open, unanswered: 0, message_at, lived_ns, unsent })
    }

    /// Sends a datagram if it is time. The time is that of the clock of messages.
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
        let datagram = datagram(&self.stranger(self.sent), self.sent);
        self.unsent = self.socket.send_to(&datagram, (Ipv4Addr::LOCALHOST, self.port)).err().map(|why| why.to_string());
    }

    fn stranger(&self, number: u32) -> Prefix {
        let mut stranger = self.stranger;
        stranger[11] = (number % u32::from(STRANGERS)) as u8;
        stranger
    }

    /// Whether a farewell is that of a stranger. Then both threads lived when it was sent.
    pub(super) fn is_answer(&mut self, farewell: &Prefix) -> bool {
        if farewell[..11] != self.stranger[..11] {
            return false;
        }
        if let Some((first, since_ns)) = self.open {
            // An answer to a later one is one to all before it; which was sent when is not kept.
            let is_to_it = (first..=self.sent).any(|number| self.stranger(number) == *farewell);
            if is_to_it {
                self.lived_ns = self.lived_ns.max(Some(since_ns));
                (self.open, self.unanswered) = (None, 0);
            }
        }
        true
    }

    /// A message has come.
    pub(super) fn note_message(&mut self) {
        self.message_at = Some(now());
    }

    /// Until when rustdds is known to have received and discovered all that came.
    pub(super) fn lived_ns(&self) -> Option<i64> {
        self.lived_ns
    }

    /// Why it must be replaced, if it does not live.
    pub(super) fn is_dead(&self) -> Option<String> {
        let is_overdue = self.sent_at.is_some_and(|sent| sent.elapsed() >= PERIOD_IF_LATE);
        let is_busy = self.message_at.is_some_and(|message| message.elapsed() < 2 * PERIOD_IF_LATE);
        let most = if is_busy { MOST_UNANSWERED_IF_BUSY } else { MOST_UNANSWERED };
        (self.unanswered > most || self.unanswered == most && is_overdue).then(|| {
            // What is sent while the loopback is down is lost without an error.
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

/// A `Data` submessage of a writer that announces participants: this one is disposed of.
fn datagram(stranger: &Prefix, number: u32) -> Vec<u8> {
    const HEADER: &[u8] = b"RTPS\x02\x03\x01\x12";
    // Little-endian, with a key as payload and without inline QoS; 48 bytes follow.
    const DATA: &[u8] = &[0x15, 0b1001, 48, 0, 0, 0, 16, 0];
    const TO_ALL_FROM_ANNOUNCER: &[u8] = &[0, 0, 0, 0, 0, 1, 0, 0xc2];
    const PARAMETERS: &[u8] = &[0, 3, 0, 0];
    const PARTICIPANT: &[u8] = &[0x50, 0, 16, 0];
    const PARTICIPANT_ENTITY: &[u8] = &[0, 0, 1, 0xc1];
    const END: &[u8] = &[1, 0, 0, 0];
    let number = number.to_le_bytes();
    let addressed = [HEADER, stranger, DATA, TO_ALL_FROM_ANNOUNCER, &[0; 4], &number].concat();
    [&addressed[..], PARAMETERS, PARTICIPANT, stranger, PARTICIPANT_ENTITY, END].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One whose datagrams reach this socket.
    fn pulse() -> (Pulse, UdpSocket) {
        let to = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port");
        to.set_nonblocking(true).expect("a socket");
        let mut pulse = Pulse::of(Options { domain: 0, is_local: true }, 0, &[7; 16]).expect("a loopback");
        pulse.port = to.local_addr().expect("an address").port();
        (pulse, to)
    }

    /// The strangers whose farewells have come.
    fn farewells(to: &UdpSocket) -> Vec<Prefix> {
        let mut datagram = [0; 100];
        let mut come = || to.recv(&mut datagram).ok().map(|length| datagram[..length][8..20].try_into().expect("12"));
        std::iter::from_fn(&mut come).collect()
    }

    /// Lets the next one be sent at once.
    fn wait(pulse: &mut Pulse) {
        pulse.sent_at = pulse.sent_at.map(|sent| sent - PERIOD_IF_LATE);
    }

    #[test]
    fn it_lived_when_the_first_datagram_that_is_answered_was_sent() {
        let (mut pulse, to) = pulse();
        pulse.beat(5);
        pulse.beat(6);
        let [stranger] = farewells(&to)[..] else { panic!("it is not time for another") };
        assert_eq!((pulse.lived_ns(), pulse.is_answer(&[7; 12]), pulse.lived_ns()), (None, false, None));
        assert!(pulse.is_answer(&stranger) && pulse.lived_ns() == Some(5));
        for now_ns in 10..13 {
            wait(&mut pulse);
            pulse.beat(now_ns);
        }
        let [.., last] = farewells(&to)[..] else { panic!() };
        // What had been answered says nothing of those.
        assert!(pulse.is_answer(&stranger) && pulse.lived_ns() == Some(5));
        assert!(pulse.is_answer(&last) && pulse.lived_ns() == Some(10));
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
