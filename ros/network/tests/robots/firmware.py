"""Firmware without a library of DDS: a participant of RTPS whose GUID is fixed, with a writer with best effort on /count.
`firmware.py HOW STAMPED` numbers its announcements (HOW is `counts`) or repeats the first one, as Fast DDS and Cyclone DDS
do (`repeats`); if STAMPED is `1`, messages have stamps. `sends FIRST COUNT` sends numbers, at 100 Hz. `restarts HOW` begins
anew, with everything numbered from 1 again: after a `goodbye`, or as if its power had been cut (`cut`).
"""
import socket, struct, sys, threading, time

from lines import answer

GUID_PREFIX = bytes.fromhex("010f") + b"firmware--"
PARTICIPANT, ANNOUNCER, PUBLISHER = b"\0\0\1\xc1", b"\0\1\0\xc2", b"\0\0\3\xc2"
WRITER, EVERYBODY = b"\0\0\1\x03", ("239.255.0.1", 7400)
HERE, GONE = 0b101, 0b1001
MOST_LISTENERS = 8
repeats, is_stamped = sys.argv[1] == "repeats", sys.argv[2] == "1"
out = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
inside = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2)]
for one in inside:
    one.bind(("127.0.0.1", 0))


def parameter(kind, value):
    value += b"\0" * (-len(value) % 4)
    return struct.pack("<HH", kind, len(value)) + value


def text(value):
    return struct.pack("<I", len(value) + 1) + value.encode() + b"\0"


def locator(port):
    return struct.pack("<iI", 1, port) + b"\0" * 12 + socket.inet_aton("127.0.0.1")


def parameters(*all):
    return b"\0\3\0\0" + b"".join(parameter(kind, value) for kind, value in all) + struct.pack("<HH", 1, 0)


def stamp(time_s):
    return struct.pack("<BBHII", 0x09, 1, 8, int(time_s), int(time_s % 1 * 2**32))


def data(writer, number, payload, flags=HERE):
    body = struct.pack("<HH4s4sII", 0, 16, b"\0" * 4, writer, 0, number) + payload
    return struct.pack("<BBH", 0x15, flags, len(body)) + body


def send(submessages, *addresses):
    for address in addresses:
        out.sendto(b"RTPS\2\3\1\x0f" + GUID_PREFIX + submessages, address)


ANNOUNCED = parameters((0x15, b"\2\3\0\0"), (0x16, b"\1\x0f\0\0"), (0x50, GUID_PREFIX + PARTICIPANT),
                       (0x58, struct.pack("<I", 0x3F)), (0x32, locator(inside[0].getsockname()[1])),
                       (0x31, locator(inside[1].getsockname()[1])), (0x02, struct.pack("<iI", 20, 0)))
OFFERED = parameters((0x5A, GUID_PREFIX + WRITER), (0x50, GUID_PREFIX + PARTICIPANT), (0x05, text("rt/count")),
                     (0x07, text("std_msgs::msg::dds_::Int32_")), (0x1A, struct.pack("<IiI", 1, 0, 100_000_000)))
meta, users = ([("127.0.0.1", 7410 + 2 * index + kind) for index in range(MOST_LISTENERS)] for kind in (0, 1))
is_on, announced, sent, begun = threading.Event(), 0, 0, time.time()


def announce():
    global announced
    while True:
        is_on.wait()
        announced += 1
        number, since = (1, begun) if repeats else (announced, time.time())
        send(stamp(since) + data(ANNOUNCER, number, ANNOUNCED), EVERYBODY)
        time.sleep(0.1)
        send(stamp(begun) + data(PUBLISHER, 1, OFFERED), *meta)
        time.sleep(0.9)


def sends(first, count):
    global sent
    for value in range(int(first), int(first) + int(count)):
        sent += 1
        stamped = stamp(time.time()) if is_stamped else b""
        send(stamped + data(WRITER, sent, b"\0\1\0\0" + struct.pack("<i", value)), *users)
        time.sleep(0.01)
    return {"sent": sent}


def restarts(how):
    global announced, sent, begun
    is_on.clear()
    if how == "goodbye":
        send(data(ANNOUNCER, announced + 1, parameters((0x50, GUID_PREFIX + PARTICIPANT)), GONE), EVERYBODY)
    time.sleep(1)
    announced, sent, begun = 0, 0, time.time()
    is_on.set()
    return {"restarted": how}


is_on.set()
threading.Thread(target=announce, daemon=True).start()
answer(sends, restarts)
