//! How a response says to which request it belongs: it depends on the middleware of whoever is at the other end.
//!
//! Fast DDS numbers a request as it numbers any sample; a response refers to it in a parameter beside the message,
//! "related sample identity" in DDS-RPC 1.0, 7.8.2. With Cyclone DDS, a request and its response begin with the same
//! sixteen bytes: who asks, and a number.

/// The bytes that say how a message is encoded, and those of Cyclone's header.
const ENCODING: usize = 4;
const HEADER: usize = 16;

/// Cyclone DDS among the vendors of RTPS.
pub(super) const CYCLONE: [u8; 2] = [1, 0x10];

/// Where a request and its response say that they belong together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Correlation {
    Beside,
    Header,
}

impl Correlation {
    /// What a participant of this vendor understands.
    pub(super) fn of(vendor: Option<[u8; 2]>) -> Self {
        if vendor == Some(CYCLONE) { Self::Header } else { Self::Beside }
    }
}

/// The message with this header after its encoding.
pub(super) fn with_header(header: &[u8; HEADER], body: &[u8]) -> Vec<u8> {
    let (encoding, message) = body.split_at(body.len().min(ENCODING));
    [encoding, header, message].concat()
}

/// Takes the header out of a message: two numbers of eight bytes, the least significant one first. None if the message
/// is too short for that.
pub(super) fn take_header(body: &mut Vec<u8>) -> Option<[u8; HEADER]> {
    // The last bit of the encoding says whether its numbers are written so.
    let is_little = *body.get(1)? & 1 == 1;
    let mut header: [u8; HEADER] = body.get(ENCODING..ENCODING + HEADER)?.try_into().ok()?;
    body.drain(ENCODING..ENCODING + HEADER);
    if !is_little {
        header.chunks_exact_mut(HEADER / 2).for_each(<[u8]>::reverse);
    }
    Some(header)
}
