"""A bad network: `relay.py A B` hands on what comes in at either of two interfaces. Of a hundred datagrams of UDP
from A to B, it loses one, sends two twice, and lets two wait until some others have gone by. At the end of its input,
it says how many those were.
"""
import random, select, socket, sys

from lines import say

random.seed(1)
IP, UDP = b"\x08\0", 17


def socket_of(interface):
    opened = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.ntohs(3))
    opened.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 26)
    opened.bind((interface, 0))
    return opened


def received(at):
    """A frame that came in, and whether it is a datagram."""
    frame, (_, _, kind, *_) = at.recvfrom(65535)
    frame, start = bytearray(frame), 14 + 4 * (frame[14] & 15)
    is_datagram = frame[12:14] == IP and frame[23] == UDP
    if is_datagram and not (frame[20] & 31 or frame[21]):
        # The kernel has left the checksum to the network's hardware; without one, it need not be right.
        frame[start + 6 : start + 8] = b"\0\0"
    return None if kind == socket.PACKET_OUTGOING else frame, is_datagram


a, b = map(socket_of, sys.argv[1:])
counts, waiting = {"lost": 0, "twice": 0, "late": 0}, []
say({"up": True})
while True:
    ready, _, _ = select.select([a, b, sys.stdin], [], [], 0.01)
    if sys.stdin in ready:
        break
    if b in ready:
        frame, _ = received(b)
        frame and a.send(frame)
    if a in ready:
        frame, is_datagram = received(a)
        fate = random.choices([None, "lost", "twice", "late"], [95, 1, 2, 2])[0] if frame and is_datagram else None
        if fate:
            counts[fate] += 1
        if fate == "late":
            waiting.append([random.randrange(1, 9), frame])
        elif frame and fate != "lost":
            [b.send(frame) for _ in range(2 if fate == "twice" else 1)]
    # If nothing else goes by, they do not wait any longer.
    for late in waiting:
        late[0] -= 1
    [b.send(frame) for left, frame in waiting if left < 0]
    waiting = [late for late in waiting if late[0] >= 0]
say(counts)
