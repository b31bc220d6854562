//! The announcements of participants, seen beside rustdds.
//!
//! rustdds forgets a participant that has not announced itself for as long as its lease, and takes an announcement with
//! the same number as before for a repetition: it never hears such a participant again. With Cyclone DDS, one lost
//! announcement is enough. And what a participant says that has begun anew with the GUID of an earlier one, as firmware
//! with a fixed prefix does, has numbers that rustdds has heard: it leaves all of it out, until there are more.
//!
//! Source: OMG's DDSI-RTPS 2.5, 8.3.3.2 (header), 8.3.8.9 (`InfoTimestamp`), 9.4.5.4 (`Data`).

use std::collections::{BTreeMap, BTreeSet};
use std::net::{Ipv4Addr, SocketAddrV4, UdpSocket};
use std::time::{Duration, Instant};

use super::heard::Prefix;
use super::options::{EVERYBODY, Options};
use crate::clock::now;

/// How long rustdds may take to know a participant that has announced itself.
const RETURNING: Duration = Duration::from_secs(2);

/// How long a datagram may take on another way than those after it.
const ASTRAY: Duration = Duration::from_millis(100);

/// The most datagrams that are looked at in one turn, and the most participants that are remembered.
const MOST: usize = 64;
const MOST_KNOWN: usize = 10_000;

/// What participants announce to all.
pub(super) struct Announcements {
    socket: UdpSocket,
    /// Who has announced itself although it had been given up, and since when.
    heard: BTreeMap<Prefix, Instant>,
    known: BTreeMap<Prefix, Known>,
    /// Those that have begun anew since the last look.
    anew: BTreeSet<Prefix>,
}

/// The last announcement of a participant.
#[derive(Clone, Copy, Debug)]
struct Known {
    announced: Announced,
    at: Instant,
    /// Whether it was repeated as it is: then its stamp is not that of the datagram.
    is_repeated: bool,
    has_left: bool,
}

/// An announcement: its number and its stamp. Without them, it is a farewell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Announced {
    Here { number: i64, stamp: Option<u64> },
    Gone,
}

impl Announcements {
    /// Listens to what is announced to all in a domain; none if that cannot be heard here.
    pub(super) fn of(options: Options) -> Option<Self> {
        let socket = shared(SocketAddrV4::new(Ipv4Addr::UNSPECIFIED, u16::try_from(options.port()).ok()?))?;
        let interface = if options.is_local { Ipv4Addr::LOCALHOST } else { Ipv4Addr::UNSPECIFIED };
        socket.join_multicast_v4(&EVERYBODY, &interface).ok()?;
        socket.set_nonblocking(true).ok()?;
        Some(Self { socket, heard: BTreeMap::new(), known: BTreeMap::new(), anew: BTreeSet::new() })
    }

    /// Hears what has been announced.
    pub(super) fn look(&mut self, is_given_up: impl Fn(&Prefix) -> bool) {
        let mut datagram = [0; 1 << 11];
        for _ in 0..MOST {
            // A datagram that is longer is cut off.
            let Ok(length) = self.socket.recv(&mut datagram) else { break };
            let datagram = &datagram[..length];
            if let (Some(b"RTPS"), Some(prefix)) = (datagram.get(..4), datagram.get(8..).and_then(<[u8]>::first_chunk))
            {
                if is_given_up(prefix) {
                    self.heard.entry(*prefix).or_insert_with(now);
                }
                if let Some(announced) = announced(datagram) {
                    self.take(*prefix, announced, now());
                }
            }
        }
        self.heard.retain(|prefix, _| is_given_up(prefix));
    }

    /// Whether a participant that has been given up goes on, and still is given up a while later.
    pub(super) fn has_returned(&self) -> bool {
        self.heard.values().any(|since| since.elapsed() > RETURNING)
    }

    /// Who has begun anew since the last call with the GUID of an earlier participant.
    pub(super) fn take_anew(&mut self) -> BTreeSet<Prefix> {
        std::mem::take(&mut self.anew)
    }

    fn take(&mut self, prefix: Prefix, announced: Announced, at: Instant) {
        if self.known.len() >= MOST_KNOWN {
            self.known.clear();
        }
        let first = Known { announced, at, is_repeated: false, has_left: false };
        let known = self.known.entry(prefix).or_insert(first);
        let since = at.duration_since(known.at);
        match (announced, known.announced) {
            (Announced::Gone, _) => (known.has_left, known.at) = (true, at),
            (Announced::Here { .. }, _) if known.has_left => {
                if since > ASTRAY {
                    self.anew.insert(prefix);
                    *known = first;
                }
            }
            (Announced::Here { number, stamp }, Announced::Here { number: last, stamp: last_stamp }) => {
                // A repeated announcement keeps its stamp. A participant that stamps each datagram never repeats one.
                let is_other = number == last && stamp != last_stamp && known.is_repeated;
                if is_other || number < last && since > ASTRAY {
                    self.anew.insert(prefix);
                    *known = first;
                } else if number >= last {
                    let is_repeated = number == last && stamp == last_stamp;
                    *known = Known { is_repeated: is_repeated && (known.is_repeated || since > ASTRAY), ..first };
                }
            }
            (Announced::Here { .. }, Announced::Gone) => *known = first,
        }
    }
}

/// What a datagram announces of the participant that it comes from, if it does.
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
        // The last one may reach to the end.
        rest = body.get(usize::from(length)..).filter(|_| length > 0)?;
    }
}

/// A socket at an address that others have, too.
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

    /// After which announcements, made so many milliseconds after the one before, a participant is found to be another.
    fn anew(announcements: &[(u64, u32, Option<u32>, bool)]) -> Vec<usize> {
        let mut all = Announcements {
            socket: UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port"),
            heard: BTreeMap::new(),
            known: BTreeMap::new(),
            anew: BTreeSet::new(),
        };
        let (mut at, mut found) = (now(), Vec::new());
        for (index, (later_ms, number, stamp, is_here)) in announcements.iter().enumerate() {
            at += Duration::from_millis(*later_ms);
            all.take([7; 12], announced(&datagram(*number, *stamp, *is_here)).expect("an announcement"), at);
            found.extend((!all.take_anew().is_empty()).then_some(index));
        }
        found
    }

    #[test]
    fn a_participant_that_begins_anew_numbers_or_stamps_its_announcements_anew() {
        let (here, gone) = (true, false);
        // It counts them, with and without stamps.
        assert_eq!(
            anew(&[(0, 1, None, here), (3000, 2, None, here), (3000, 3, None, here), (900, 1, None, here)]),
            [3]
        );
        assert_eq!(anew(&[(0, 1, Some(5), here), (3000, 2, Some(8), here), (3000, 1, Some(11), here)]), [2]);
        // It repeats one, as Fast DDS and Cyclone DDS do.
        let repeated = [(0, 1, Some(5), here), (3000, 1, Some(5), here), (3000, 1, Some(5), here)];
        assert_eq!(anew(&repeated), [0; 0]);
        assert_eq!(anew(&[&repeated[..], &[(900, 1, Some(12), here), (3000, 1, Some(12), here)]].concat()), [3]);
        // It says goodbye.
        assert_eq!(anew(&[(0, 1, Some(5), here), (900, 2, Some(6), gone), (900, 1, Some(7), here)]), [2]);
        assert_eq!(anew(&[(0, 1, None, here), (900, 2, None, gone), (900, 3, None, here), (900, 4, None, here)]), [2]);
    }

    #[test]
    fn what_repeats_or_changes_its_announcements_is_the_same() {
        let here = true;
        // One on two ways, one that comes late, and one that is sent again and stamped again each time.
        for same in [
            &[(0, 1, Some(5), here), (0, 1, Some(5), here), (3000, 2, Some(8), here), (1, 2, Some(8), here)][..],
            &[(0, 1, None, here), (3000, 3, None, here), (1, 2, None, here), (3000, 4, None, here)],
            &[(0, 1, Some(5), here), (0, 1, Some(5), here), (3000, 1, Some(8), here), (3000, 1, Some(11), here)],
            &[(0, 1, Some(5), here), (900, 2, Some(6), false), (1, 1, Some(5), here)],
        ] {
            assert_eq!(anew(same), [0; 0], "{same:?}");
        }
    }

    #[test]
    fn what_is_cut_off_announces_nothing() {
        let whole = datagram(1, Some(5), true);
        for length in 0..whole.len() {
            assert_eq!(announced(&whole[..length]), None, "{length}");
        }
    }
}
