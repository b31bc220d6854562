"""The messages of a recording."""
import struct


def records(path):
    """The messages of an MCAP file without chunks, in order: topic, data, and when each was recorded, in nanoseconds."""
    bytes, at, topics, found = path.read_bytes(), 8, {}, []
    while at < len(bytes) - 8:
        opcode, size = struct.unpack_from("<BQ", bytes, at)
        record, at = bytes[at + 9 : at + 9 + size], at + 9 + size
        if opcode == 4:
            (channel, _, length) = struct.unpack_from("<HHI", record)
            topics[channel] = record[8 : 8 + length].decode()
        if opcode == 5:
            (channel, _, at_ns) = struct.unpack_from("<HIQ", record)
            found.append((topics[channel], record[22:], at_ns))
    return found
