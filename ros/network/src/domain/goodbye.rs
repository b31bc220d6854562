//! The datagram with which a participant leaves its domain.
//!
//! rustdds says goodbye with the serialized key alone. Fast DDS takes note of such a message only if it has the hash of
//! the key, and otherwise keeps readers that are gone for as long as their lease lasts.
//!
//! Source: OMG's DDSI-RTPS 2.5, 8.5.3 (participant discovery), 9.4.5.4 (`Data`), 9.6.4.8 and 9.6.4.9 (parameters).

use std::net::{Ipv4Addr, UdpSocket};

use super::options::{EVERYBODY, Options};

/// The most participants on one machine that are told one by one: its loopback may have no multicast.
const MOST_LOCAL: u16 = 32;

/// Tells everybody in a domain that the participant with this GUID leaves it. Those who do not hear it wait for the end
/// of its lease.
pub(super) fn say(options: Options, participant: &[u8; 16]) {
    let base = options.port();
    let Ok(socket) = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0)) else { return };
    let datagram = datagram(participant);
    let local = (0..u32::from(MOST_LOCAL)).map(|index| (Ipv4Addr::LOCALHOST, base + 10 + 2 * index));
    let everybody = (!options.is_local).then_some((EVERYBODY, base));
    for (address, port) in everybody.into_iter().chain(local) {
        if let Ok(port) = u16::try_from(port) {
            // Nobody may be there.
            let _ = socket.send_to(&datagram, (address, port));
        }
    }
}

/// A `Data` submessage of the writer that announces participants: this one is disposed of and unregistered.
fn datagram(participant: &[u8; 16]) -> Vec<u8> {
    const HEADER: &[u8] = b"RTPS\x02\x03\x01\x12";
    // Little-endian, with inline QoS and without a payload; 52 bytes follow, with the QoS 16 bytes on from there.
    const DATA: &[u8] = &[0x15, 0b11, 52, 0, 0, 0, 16, 0];
    const TO_ALL_FROM_ANNOUNCER: &[u8] = &[0, 0, 0, 0, 0, 1, 0, 0xc2];
    // Later than all others.
    const NUMBER: &[u8] = &[0, 0, 0, 0, 0xff, 0xff, 0xff, 0xff];
    const KEY_HASH: &[u8] = &[0x70, 0, 16, 0];
    const STATUS: &[u8] = &[0x71, 0, 4, 0, 0, 0, 0, 0b11];
    const END: &[u8] = &[1, 0, 0, 0];
    [HEADER, &participant[..12], DATA, TO_ALL_FROM_ANNOUNCER, NUMBER, KEY_HASH, participant, STATUS, END].concat()
}
