//! How a response refers to its request. This depends on the middleware of the other end.
//!
//! With Fast DDS, a response refers to the sequence number of the request in a parameter beside the message, the
//! "related sample identity" of DDS-RPC 1.0, 7.8.2. With Cyclone DDS, a request and its response begin with the same
//! sixteen bytes: the client and a number.

/// The length of a message's encapsulation header, and of Cyclone's header after it.
const ENCODING: usize = 4;
const HEADER: usize = 16;

/// The vendor id of Cyclone DDS in RTPS.
pub(super) const CYCLONE: [u8; 2] = [1, 0x10];

/// Where a response refers to its request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Correlation {
    /// In a parameter beside the message.
    Beside,
    /// In a header at the beginning of the message.
    Header,
}

impl Correlation {
    /// The form that participants of this vendor use.
    pub(super) fn of(vendor: Option<[u8; 2]>) -> Self {
        if vendor == Some(CYCLONE) { Self::Header } else { Self::Beside }
    }
}

/// The message with this header inserted after its encapsulation header.
pub(super) fn with_header(header: &[u8; HEADER], body: &[u8]) -> Vec<u8> {
    let (encoding, message) = body.split_at(body.len().min(ENCODING));
    [encoding, header, message].concat()
}

/// Removes the header from a message: two numbers of eight bytes, returned in little-endian order. None if the message
/// is too short.
pub(super) fn take_header(body: &mut Vec<u8>) -> Option<[u8; HEADER]> {
    // The last bit of the encapsulation is set if the message is little-endian.
    let is_little = *body.get(1)? & 1 == 1;
    let mut header: [u8; HEADER] = body.get(ENCODING..ENCODING + HEADER)?.try_into().ok()?;
    body.drain(ENCODING..ENCODING + HEADER);
    if !is_little {
        header.chunks_exact_mut(HEADER / 2).for_each(<[u8]>::reverse);
    }
    Some(header)
}
