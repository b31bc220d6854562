//! The datagram with which a participant leaves its domain.
//!
//! When a participant leaves, rustdds sends only its serialized key. Fast DDS ignores such a message unless it contains
//! the hash of the key: it keeps the participant's readers until their lease ends.
//!
//! Source: OMG's DDSI-RTPS 2.5, 8.5.3 (participant discovery), 9.4.5.4 (`Data`), 9.6.4.8 and 9.6.4.9 (parameters).

use std::net::{Ipv4Addr, UdpSocket};

use super::options::{MULTICAST, Options};

/// The most participants on one machine that get a datagram each: its loopback may have no multicast.
const MOST_LOCAL: u16 = 32;

/// Announces to all participants of a domain that the one with this GUID leaves. A participant that does not receive it
/// keeps this one until its lease ends.
pub(super) fn send(options: Options, participant: &[u8; 16]) {
    let base = options.port();
    let Ok(socket) = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0)) else { return };
    let datagram = datagram(participant);
    let local = (0..u32::from(MOST_LOCAL)).map(|index| (Ipv4Addr::LOCALHOST, base + 10 + 2 * index));
    let multicast = (!options.is_local).then_some((MULTICAST, base));
    for (address, port) in multicast.into_iter().chain(local) {
        if let Ok(port) = u16::try_from(port) {
            // There may be no participant at the port.
            let _ = socket.send_to(&datagram, (address, port));
        }
    }
}

/// A `Data` submessage of the writer that announces participants: it disposes of the participant and unregisters it.
fn datagram(participant: &[u8; 16]) -> Vec<u8> {
    const HEADER: &[u8] = b"RTPS\x02\x03\x01\x12";
    // Little-endian, with inline QoS and without a payload; 52 bytes follow, with the QoS 16 bytes on from there.
    const DATA: &[u8] = &[0x15, 0b11, 52, 0, 0, 0, 16, 0];
    const TO_ALL_FROM_ANNOUNCER: &[u8] = &[0, 0, 0, 0, 0, 1, 0, 0xc2];
    // Greater than the numbers of all announcements.
    const NUMBER: &[u8] = &[0, 0, 0, 0, 0xff, 0xff, 0xff, 0xff];
    const KEY_HASH: &[u8] = &[0x70, 0, 16, 0];
    const STATUS: &[u8] = &[0x71, 0, 4, 0, 0, 0, 0, 0b11];
    const END: &[u8] = &[1, 0, 0, 0];
    [HEADER, &participant[..12], DATA, TO_ALL_FROM_ANNOUNCER, NUMBER, KEY_HASH, participant, STATUS, END].concat()
}
