"""Somebody who sends what no participant would: `hostile.py SECONDS` changes the datagrams that it sees on the loopback of
its network, and sends them again. It says how many those were.
"""
import random, socket, struct, sys, time

random.seed(1)
seen = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.ntohs(3))
seen.bind(("lo", 0))
seen.settimeout(0.001)
out = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
NUMBERS = [b"\xff\xff\xff\xff", b"\0\0\0\0", b"\x7f\xff\xff\xff", b"\x80\0\0\0", b"\xff\xff", b"\0\0", b"\1\0"]
IP, UDP, MULTICAST_PORT = b"\x08\0", 17, 7400
MOST = 3000


def changed(datagram):
    datagram = bytearray(datagram)
    for _ in range(random.choice([1, 1, 2, 4, 16])):
        at, how = random.randrange(len(datagram) + 1), random.random()
        if how < 0.4:
            datagram[at : at + 1] = bytes([random.randrange(256)])
        elif how < 0.6:
            number = random.choice(NUMBERS)
            datagram[at : at + len(number)] = number
        elif how < 0.75:
            del datagram[at : at + random.choice([1, 2, 4, 8, 64])]
        elif how < 0.9:
            datagram[at:at] = random.randbytes(random.choice([1, 4, 32]))
        else:
            other = random.randrange(len(datagram) + 1)
            datagram[at:at] = datagram[other : other + random.choice([4, 16, 100])]
    return bytes(datagram[:65000])


known, sent, end = [], 0, time.monotonic() + float(sys.argv[1])
while time.monotonic() < end:
    try:
        frame = seen.recv(65535)
        header = 14 + 4 * (frame[14] & 15)
        port, datagram = struct.unpack_from(">H", frame, header + 2)[0], frame[header + 8 :]
        if frame[12:14] == IP and frame[23] == UDP and datagram[:4] == b"RTPS":
            if len(known) < MOST:
                known.append((port, datagram))
            elif random.random() < 0.01:
                known[random.randrange(MOST)] = (port, datagram)
    except TimeoutError:
        pass
    for port, datagram in random.choices(known, k=20) if len(known) >= 50 else []:
        try:
            out.sendto(changed(datagram), ("239.255.0.1" if port == MULTICAST_PORT else "127.0.0.1", port))
            sent += 1
        except OSError:
            # There is no room for more.
            pass
print(sent)
