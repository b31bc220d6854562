//! The announcements of participants, received independently of rustdds.
//!
//! rustdds fails in two cases, and then another participant must take over.
//! - It forgets a participant whose lease has ended. If the participant then announces itself with the same sequence
//!   number as before, rustdds takes that for a repetition, and never discovers it again. With Cyclone DDS, one lost
//!   announcement is enough.
//! - A participant restarts with the GUID of an earlier one, as firmware with a fixed prefix does. rustdds has already
//!   received its sequence numbers, and discards its messages until the numbers are greater.
//!
//! Source: OMG's DDSI-RTPS 2.5, 8.3.3.2 (header), 8.3.8.9 (`InfoTimestamp`), 9.4.5.4 (`Data`).

use std::collections::{BTreeMap, BTreeSet};
use std::net::{Ipv4Addr, SocketAddrV4, UdpSocket};
use std::time::{Duration, Instant};

use super::exchange::Prefix;
use super::options::{MULTICAST, Options};
use crate::clock::now;

/// How long rustdds may take to discover a participant that has announced itself.
const RETURNING: Duration = Duration::from_secs(2);

/// How much later a datagram may arrive than those that were sent after it.
const REORDERING: Duration = Duration::from_millis(100);

/// The most datagrams that are read in one call, and the most participants that are remembered.
const MOST: usize = 64;
const MOST_KNOWN: usize = 10_000;

/// Receives the announcements of participants.
pub(super) struct Announcements {
    socket: UdpSocket,
    /// The participants that have announced themselves although rustdds has given them up, and since when.
    returned: BTreeMap<Prefix, Instant>,
    known: BTreeMap<Prefix, Known>,
    /// The participants that have restarted since the last call.
    restarted: BTreeSet<Prefix>,
}

/// The last announcement of a participant.
#[derive(Clone, Copy, Debug)]
struct Known {
    announced: Announced,
    at: Instant,
    /// Whether it was repeated unchanged. Then its stamp is not that of the datagram.
    is_repeated: bool,
    has_left: bool,
}

/// What an announcement contains.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Announced {
    /// The participant is there. The announcement has a sequence number, and may have a stamp.
    Here { number: i64, stamp: Option<u64> },
    /// The participant leaves.
    Gone,
}

impl Announcements {
    /// Joins the multicast group of a domain's discovery. None if that is not possible here.
    pub(super) fn of(options: Options) -> Option<Self> {
        let socket = shared(SocketAddrV4::new(Ipv4Addr::UNSPECIFIED, u16::try_from(options.port()).ok()?))?;
        let interface = if options.is_local { Ipv4Addr::LOCALHOST } else { Ipv4Addr::UNSPECIFIED };
        socket.join_multicast_v4(&MULTICAST, &interface).ok()?;
        socket.set_nonblocking(true).ok()?;
        Some(Self { socket, returned: BTreeMap::new(), known: BTreeMap::new(), restarted: BTreeSet::new() })
    }

    /// Reads the announcements that have been received. `is_given_up` returns whether rustdds has given up a
    /// participant.
    pub(super) fn read(&mut self, is_given_up: impl Fn(&Prefix) -> bool) {
        let mut datagram = [0; 1 << 11];
        for _ in 0..MOST {
            // A longer datagram is truncated.
            let Ok(length) = self.socket.recv(&mut datagram) else { break };
            let datagram = &datagram[..length];
            if let (Some(b"RTPS"), Some(prefix)) = (datagram.get(..4), datagram.get(8..).and_then(<[u8]>::first_chunk))
            {
                if is_given_up(prefix) {
                    self.returned.entry(*prefix).or_insert_with(now);
                }
                if let Some(announced) = announced(datagram) {
                    self.add(*prefix, announced, now());
                }
            }
        }
        self.returned.retain(|prefix, _| is_given_up(prefix));
    }

    /// Whether rustdds has not discovered a participant again that it had given up and that has announced itself since.
    pub(super) fn has_returned(&self) -> bool {
        self.returned.values().any(|since| since.elapsed() > RETURNING)
    }

    /// The participants that have restarted since the last call.
    pub(super) fn take_restarted(&mut self) -> BTreeSet<Prefix> {
        std::mem::take(&mut self.restarted)
    }

    /// Compares an announcement with the last one of its participant.
    fn add(&mut self, prefix: Prefix, announced: Announced, at: Instant) {
        if self.known.len() >= MOST_KNOWN {
            self.known.clear();
        }
        let first = Known { announced, at, is_repeated: false, has_left: false };
        let known = self.known.entry(prefix).or_insert(first);
        let since = at.duration_since(known.at);
        match (announced, known.announced) {
            (Announced::Gone, _) => (known.has_left, known.at) = (true, at),
            (Announced::Here { .. }, _) if known.has_left => {
                if since > REORDERING {
                    self.restarted.insert(prefix);
                    *known = first;
                }
            }
            (Announced::Here { number, stamp }, Announced::Here { number: last, stamp: last_stamp }) => {
                // A repeated announcement keeps its stamp, unless its participant stamps each datagram.
                let is_other = number == last && stamp != last_stamp && known.is_repeated;
                if is_other || number < last && since > REORDERING {
                    self.restarted.insert(prefix);
                    *known = first;
                } else if number >= last {
                    let is_repeated = number == last && stamp == last_stamp;
                    *known = Known { is_repeated: is_repeated && (known.is_repeated || since > REORDERING), ..first };
                }
            }
            (Announced::Here { .. }, Announced::Gone) => *known = first,
        }
    }
}

/// The announcement in a datagram, if there is one.
fn announced(datagram: &[u8]) -> Option<Announced> {
    const INFO_TIMESTAMP: u8 = 0x09;
    const DATA: u8 = 0x15;
    const LITTLE_ENDIAN: u8 = 1;
    const INVALIDATE: u8 = 2;
    const WITH_DATA: u8 = 4;
    const ANNOUNCER: [u8; 4] = [0, 1, 0, 0xc2];
    let (mut rest, mut stamp) = (datagram.get(20..)?, None);
    loop {
        let ([kind, flags, length @ ..], body) = rest.split_first_chunk::<4>()?;
        let is_little = flags & LITTLE_ENDIAN != 0;
        let number = |bytes: [u8; 4]| if is_little { u32::from_le_bytes(bytes) } else { u32::from_be_bytes(bytes) };
        let length = if is_little { u16::from_le_bytes(*length) } else { u16::from_be_bytes(*length) };
        let at = |place: usize| body.get(place..)?.first_chunk().copied();
        match *kind {
            INFO_TIMESTAMP if flags & INVALIDATE != 0 => stamp = None,
            INFO_TIMESTAMP => stamp = Some(u64::from(number(at(0)?)) << 32 | u64::from(number(at(4)?))),
            DATA if at(8)? == ANNOUNCER => {
                let number = i64::from(number(at(12)?)) << 32 | i64::from(number(at(16)?));
                let is_here = flags & WITH_DATA != 0;
                return Some(if is_here { Announced::Here { number, stamp } } else { Announced::Gone });
            }
            _ => {}
        }
        // The last submessage may have the length 0: it extends to the end.
        rest = body.get(usize::from(length)..).filter(|_| length > 0)?;
    }
}

/// A socket at an address that other sockets may share.
#[cfg(unix)]
fn shared(address: SocketAddrV4) -> Option<UdpSocket> {
    use rustix::net::{AddressFamily, SocketType, bind, socket, sockopt};
    let made = socket(AddressFamily::INET, SocketType::DGRAM, None).ok()?;
    sockopt::set_socket_reuseaddr(&made, true).ok()?;
    bind(&made, &address).ok()?;
    Some(UdpSocket::from(made))
}

#[cfg(not(unix))]
fn shared(_: SocketAddrV4) -> Option<UdpSocket> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn datagram(number: u32, stamp: Option<u32>, is_here: bool) -> Vec<u8> {
        let mut datagram = b"RTPS\x02\x03\x01\x0f\x07\x07\x07\x07\x07\x07\x07\x07\x07\x07\x07\x07".to_vec();
        // Another submessage comes first: the destination.
        datagram.extend([0x0e, 1, 12, 0].iter().chain(&[0; 12]));
        if let Some(stamp) = stamp {
            datagram.extend([0x09, 1, 8, 0].iter().chain(&stamp.to_le_bytes()).chain(&[0; 4]));
        }
        datagram.extend([0x15, if is_here { 5 } else { 9 }, 0, 0, 0, 0, 16, 0, 0, 0, 0, 0, 0, 1, 0, 0xc2, 0, 0, 0, 0]);
        datagram.extend(number.to_le_bytes());
        datagram
    }

    /// The announcements that show a restart. Each is given with the milliseconds since the one before, and with its
    /// number, its stamp, and whether the participant is there.
    fn restarts(announcements: &[(u64, u32, Option<u32>, bool)]) -> Vec<usize> {
        let mut all = Announcements {
            socket: UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port"),
            returned: BTreeMap::new(),
            known: BTreeMap::new(),
            restarted: BTreeSet::new(),
        };
        let (mut at, mut found) = (now(), Vec::new());
        for (index, (later_ms, number, stamp, is_here)) in announcements.iter().enumerate() {
            at += Duration::from_millis(*later_ms);
            all.add([7; 12], announced(&datagram(*number, *stamp, *is_here)).expect("an announcement"), at);
            found.extend((!all.take_restarted().is_empty()).then_some(index));
        }
        found
    }

    #[test]
    fn new_numbers_or_stamps_show_that_a_participant_has_restarted() {
        let (here, gone) = (true, false);
        // It counts them, with and without stamps.
        assert_eq!(
            restarts(&[(0, 1, None, here), (3000, 2, None, here), (3000, 3, None, here), (900, 1, None, here)]),
            [3]
        );
        assert_eq!(restarts(&[(0, 1, Some(5), here), (3000, 2, Some(8), here), (3000, 1, Some(11), here)]), [2]);
        // It repeats one, as Fast DDS and Cyclone DDS do.
        let repeated = [(0, 1, Some(5), here), (3000, 1, Some(5), here), (3000, 1, Some(5), here)];
        assert_eq!(restarts(&repeated), [0; 0]);
        assert_eq!(restarts(&[&repeated[..], &[(900, 1, Some(12), here), (3000, 1, Some(12), here)]].concat()), [3]);
        // It has announced its departure.
        assert_eq!(restarts(&[(0, 1, Some(5), here), (900, 2, Some(6), gone), (900, 1, Some(7), here)]), [2]);
        assert_eq!(
            restarts(&[(0, 1, None, here), (900, 2, None, gone), (900, 3, None, here), (900, 4, None, here)]),
            [2]
        );
    }

    #[test]
    fn repeated_and_updated_announcements_show_no_restart() {
        let here = true;
        // They arrive twice, arrive late, or get a new stamp whenever they are sent again.
        for same in [
            &[(0, 1, Some(5), here), (0, 1, Some(5), here), (3000, 2, Some(8), here), (1, 2, Some(8), here)][..],
            &[(0, 1, None, here), (3000, 3, None, here), (1, 2, None, here), (3000, 4, None, here)],
            &[(0, 1, Some(5), here), (0, 1, Some(5), here), (3000, 1, Some(8), here), (3000, 1, Some(11), here)],
            &[(0, 1, Some(5), here), (900, 2, Some(6), false), (1, 1, Some(5), here)],
        ] {
            assert_eq!(restarts(same), [0; 0], "{same:?}");
        }
    }

    #[test]
    fn truncated_datagrams_announce_nothing() {
        let whole = datagram(1, Some(5), true);
        for length in 0..whole.len() {
            assert_eq!(announced(&whole[..length]), None, "{length}");
        }
    }
}
