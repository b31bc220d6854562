#!/usr/bin/env python3
"""Reads a simulated run over Groot2's protocol, as Groot2 would: `groot_client.py STEWARD SCENARIO OUT` (pip
install pyzmq msgpack).
Requests and replies are made as the headers of BehaviorTree.CPP describe them (groot2_protocol.h)."""
import struct, subprocess, sys, time
import xml.etree.ElementTree as ET

import msgpack, zmq

PORT = 16680
context = zmq.Context()


class Client:
    def __init__(self):
        self.socket = context.socket(zmq.REQ)
        self.socket.setsockopt(zmq.RCVTIMEO, 10_000)
        self.socket.connect(f"tcp://127.0.0.1:{PORT}")
        self.asked, self.tree = 0, None

    def raw(self, *parts):
        self.socket.send_multipart(parts)
        return self.socket.recv_multipart()

    def ask(self, kind, *more):
        self.asked += 1
        header = struct.pack("<BcI", 2, kind, self.asked)
        reply = self.raw(header, *more)
        assert reply[0][:6] == header and len(reply[0]) == 22, reply
        self.tree = self.tree or reply[0][6:]
        assert reply[0][6:] == self.tree
        return reply[1] if len(reply) > 1 else None


def transitions(client):
    records = struct.iter_unpack("<IHHB", client.ask(b"t"))
    return [(low | high << 32, uid, status) for low, high, uid, status in records]


command = [sys.argv[1], "run", sys.argv[2], "--quiet", "--serve-groot", str(PORT), "--out", sys.argv[3]]
run = subprocess.Popen(command)
try:
    clients = [Client() for _ in range(5)]
    one, others = clients[0], clients[1:]
    tree = ET.fromstring(one.ask(b"T"))
    uids = sorted(int(node.get("_uid")) for node in tree.iter() if node.get("_uid"))
    assert uids == list(range(1, len(uids) + 1)) and tree.find("TreeNodesModel") is not None
    assert int(one.ask(b"r", b"start")) >= 0
    statuses, seen, last = {}, 0, -1
    deadline = time.monotonic() + 60
    while seen < 20 and time.monotonic() < deadline:
        time.sleep(0.05)
        for at, uid, status in transitions(one):
            assert at >= last and uid in uids and 0 <= status <= 4
            statuses[uid], seen, last = status, seen + 1, at
    assert seen >= 20
    # Whoever asks sees the same, whatever somebody else sends in between.
    for number, client in enumerate(others):
        status = client.ask(b"S")
        assert sorted(uid for uid, _ in struct.iter_unpack("<HB", status)) == uids
        assert {status for _, status in struct.iter_unpack("<HB", status)} <= {0, 1, 2, 3, 11, 12, 13}
        for kind in b"IRUDAX":
            assert client.raw(struct.pack("<BBI", 2, kind, 7), b"{}")[0] == b"error"
        for nonsense in [(b"",), (b"\x09S\0\0\0\0",), (b"x" * 60_000,), (struct.pack("<BcI", 2, b"B", 1),)]:
            assert client.raw(*nonsense)[0] == b"error", nonsense
        names = [board.get("_fullpath") or board.get("ID") for board in tree.iter("BehaviorTree")]
        boards = msgpack.unpackb(client.ask(b"B", ";".join([*names, "none"]).encode()))
        assert set(boards) == set(names), boards
        assert msgpack.unpackb(client.ask(b"B", b"none")) is None
    subscriber = context.socket(zmq.SUB)
    subscriber.subscribe(b"")
    subscriber.connect(f"tcp://127.0.0.1:{PORT + 1}")
    assert subscriber.poll(300) == 0
    assert one.ask(b"r", b"stop") is None and transitions(one) == []
    print(f"{len(uids)} nodes, {seen} transitions, blackboards: {boards}")
finally:
    run.terminate()
    run.wait()
