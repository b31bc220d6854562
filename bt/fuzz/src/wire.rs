//! What ZeroMQ's protocol puts around messages.

/// A frame of a message.
pub(crate) fn frame(flags: u8, body: &[u8]) -> Vec<u8> {
    [&[flags | 2][..], &(body.len() as u64).to_be_bytes(), body].concat()
}

/// The parts of a message, after the empty one.
pub(crate) fn message(parts: &[&[u8]]) -> Vec<u8> {
    let mut bytes = frame(1, b"");
    for (index, part) in parts.iter().enumerate() {
        bytes.extend(frame(u8::from(index + 1 < parts.len()), part));
    }
    bytes
}

/// The beginning of a connection of a socket of this type.
pub(crate) fn handshake(socket: &[u8]) -> Vec<u8> {
    let mut greeting = [0; 64];
    (greeting[0], greeting[9], greeting[10]) = (0xff, 0x7f, 3);
    greeting[12..16].copy_from_slice(b"NULL");
    let name = b"\x0bSocket-Type";
    let ready = [&b"\x05READY"[..], name, &(socket.len() as u32).to_be_bytes(), socket].concat();
    [&greeting[..], &frame(4, &ready)].concat()
}
