#!/usr/bin/env python3
"""Captures the replies of a program with BehaviorTree.CPP over Groot2's protocol: `capture.py FILE WRITER TREE NAME TICKS`
(pip install pyzmq), with the compiled writer of the captured logs and its arguments. The first line contains the bytes
with which the program begins the connection, in hexadecimal. Each other line contains a request without its number, and
the bytes of the reply.
"""
import socket, struct, subprocess, sys, threading, time

import zmq

PORT = 16670
program = subprocess.Popen([*sys.argv[2:], "show", str(PORT)], stdin=subprocess.PIPE)
received = bytearray()


def relay(source, sink, copy):
    while block := source.recv(1 << 16):
        copy += block
        sink.sendall(block)


def through(here):
    asked, _ = here.accept()
    while True:
        try:
            answered = socket.create_connection(("127.0.0.1", PORT))
            break
        except ConnectionRefusedError:
            time.sleep(0.01)
    for way in [(asked, answered, bytearray()), (answered, asked, received)]:
        threading.Thread(target=relay, args=way, daemon=True).start()


here = socket.create_server(("127.0.0.1", 0))
threading.Thread(target=through, args=(here,), daemon=True).start()
client = zmq.Context().socket(zmq.REQ)
client.connect(f"tcp://127.0.0.1:{here.getsockname()[1]}")
client.setsockopt(zmq.RCVTIMEO, 3000)
while not received.endswith(b"\3REP"):
    time.sleep(0.01)
with open(sys.argv[1], "w") as file:
    file.write(received.hex() + "\n")

    def ask(kind, *more):
        received.clear()
        client.send_multipart([struct.pack("<BcI", 2, kind, 0), *more])
        client.recv_multipart()
        file.write(b" ".join([kind, *more]).decode() + " " + received.hex() + "\n")

    for request in [(b"T",), (b"B", b"nobody"), (b"?",), (b"r", b"start"), (b"S",), (b"t",)]:
        ask(*request)
    program.stdin.write(b"\n")
    program.stdin.flush()
    try:
        for asked in range(int(sys.argv[5])):
            time.sleep(0.02)
            ask(b"t")
            if asked % 10 == 0:
                ask(b"S")
                ask(b"B", b"Main;there")
        while True:
            time.sleep(0.02)
            ask(b"t")
    except zmq.Again:
        pass
