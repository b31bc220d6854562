//! The announcements of participants, seen beside rustdds.
//!
//! rustdds forgets a participant that has not announced itself for as long as its lease, and takes an announcement with
//! the same number as before for a repetition: it never hears such a participant again. With Cyclone DDS, one lost
//! announcement is enough.
//!
//! Source: OMG's DDSI-RTPS 2.5, 8.3.3.2 (header).

use std::collections::BTreeMap;
use std::net::{Ipv4Addr, SocketAddrV4, UdpSocket};
use std::time::{Duration, Instant};

use super::heard::Prefix;
use super::options::{EVERYBODY, Options};
use crate::clock::now;

/// How long rustdds may take to know a participant that has announced itself.
const RETURNING: Duration = Duration::from_secs(2);

/// The most datagrams that are looked at in one turn.
const MOST: usize = 64;

/// Who has announced itself although it had been given up, and since when.
pub(super) struct Announcements {
    socket: UdpSocket,
    heard: BTreeMap<Prefix, Instant>,
}

impl Announcements {
    /// Listens to what is announced to all in a domain; none if that cannot be heard here.
    pub(super) fn of(options: Options) -> Option<Self> {
        let socket = shared(SocketAddrV4::new(Ipv4Addr::UNSPECIFIED, u16::try_from(options.port()).ok()?))?;
        let interface = if options.is_local { Ipv4Addr::LOCALHOST } else { Ipv4Addr::UNSPECIFIED };
        socket.join_multicast_v4(&EVERYBODY, &interface).ok()?;
        socket.set_nonblocking(true).ok()?;
        Some(Self { socket, heard: BTreeMap::new() })
    }

    /// Whether somebody who has been given up goes on, and still is given up a while later.
    pub(super) fn has_returned(&mut self, is_given_up: impl Fn(&Prefix) -> bool) -> bool {
        let mut header = [0; 20];
        for _ in 0..MOST {
            // A datagram that is longer is cut off.
            let Ok(length) = self.socket.recv(&mut header) else { break };
            if let (b"RTPS", Some(prefix)) = (&header[..4], header[8..length.max(8)].first_chunk())
                && is_given_up(prefix)
            {
                self.heard.entry(*prefix).or_insert_with(now);
            }
        }
        self.heard.retain(|prefix, _| is_given_up(prefix));
        self.heard.values().any(|since| since.elapsed() > RETURNING)
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
