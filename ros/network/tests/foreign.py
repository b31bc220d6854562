#!/usr/bin/env python3
"""`steward watch` with bridges of others: `foreign.py STEWARD` (pip install foxglove-sdk foxglove-websocket).

The servers are that of the SDK, on which today's `foxglove_bridge` is built, and that of the older protocol, both with
the same robot. What they advertise is listed. Planted violations are found at the right message or, if no messages
follow, at the right time. Nothing is published. After a restart of the bridge, verdicts are unsure if lost messages
could change them. `steward verify` gives the same verdicts for the recording.
"""
import asyncio, atexit, json, socket, struct, subprocess, sys, tempfile, threading, time
from pathlib import Path

import foxglove
from foxglove_websocket.server import FoxgloveServer, FoxgloveServerListener

STEWARD = sys.argv[1]
with socket.socket() as free:
    free.bind(("127.0.0.1", 0))
    PORT = free.getsockname()[1]
ADDRESS = f"ws://127.0.0.1:{PORT}"
TYPES = {
    "/battery": ("robot_msgs/msg/Battery", "float32 percentage\n"),
    "/cmd_vel": ("geometry_msgs/msg/Twist", "Vector3 linear\nVector3 angular\n" + "=" * 80
                 + "\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n"),
    "/stop": ("std_msgs/msg/Bool", "bool data\n"),
}
MAPPING = """
tick_s = 0.1
reorder_s = 0
[[messages]]
topic = "/battery"
from = "battery"
to = "base"
fields = { level = "percentage" }
[[messages]]
topic = "/cmd_vel"
from = "controller"
to = "base"
fields = { speed = "linear.x" }
[[messages]]
topic = "/stop"
from = "operator"
to = "base"
fields = { is_on = "data" }
"""
PROPERTIES = """
property low_is_slow := always ((battery, base, m.level < 0.2) implies (controller, base, m.speed <= 0.2))
property stops := always ((operator, base, m.is_on = true) implies time_until (controller, base, m.speed = 0) <= 1 s)
property slow := always (controller, base, m.speed <= 1)
"""


def battery(level):
    return "/battery", b"\0\1\0\0" + struct.pack("<f", level)


def speed(mps):
    return "/cmd_vel", b"\0\1\0\0" + struct.pack("<6d", mps, 0, 0, 0, 0, 0)


def stop(is_on):
    return "/stop", b"\0\1\0\0" + bytes([is_on])


class Sdk(foxglove.ServerListener):
    """The server of Foxglove's SDK."""

    def __init__(self):
        self.heard, self.said = set(), []
        self.context = foxglove.Context()
        self.channels = {
            topic: foxglove.Channel(topic, message_encoding="cdr", context=self.context,
                                    schema=foxglove.Schema(name=kind, encoding="ros2msg", data=text.encode()))
            for topic, (kind, text) in TYPES.items()
        }
        capabilities = [foxglove.Capability.ClientPublish, foxglove.Capability.ConnectionGraph]
        self.server = foxglove.start_server(host="127.0.0.1", port=PORT, name="a robot", context=self.context,
                                            server_listener=self, capabilities=capabilities,
                                            supported_encodings=["cdr"])
        graph = foxglove.ConnectionGraph()
        graph.set_published_topic("/battery", ["/driver"])
        graph.set_advertised_service("/dock", ["/dock_server"])
        self.server.publish_connection_graph(graph)

    def on_subscribe(self, client, channel):
        self.heard.add(channel.topic)

    def on_unsubscribe(self, client, channel):
        self.heard.discard(channel.topic)

    def on_client_advertise(self, client, channel):
        self.said.append(channel)

    def on_message_data(self, client, client_channel_id, data):
        self.said.append(data)

    def send(self, topic, body):
        self.channels[topic].log(body)

    def close(self):
        self.server.stop()
        wait_for("the server has ended", is_free)


class Older(FoxgloveServerListener):
    """The server of the older protocol."""

    def __init__(self):
        self.heard, self.said, self.ids = set(), [], {}
        self.loop, self.ready, self.over = asyncio.new_event_loop(), threading.Event(), None
        self.thread = threading.Thread(target=lambda: self.loop.run_until_complete(self.serve()), daemon=True)
        self.thread.start()
        self.ready.wait()

    async def serve(self):
        self.over = asyncio.Event()
        async with FoxgloveServer("127.0.0.1", PORT, "a robot", capabilities=["clientPublish"],
                                  supported_encodings=["cdr"]) as self.server:
            self.server.set_listener(self)
            for topic, (kind, text) in TYPES.items():
                channel = {"topic": topic, "encoding": "cdr", "schemaName": kind, "schema": text,
                           "schemaEncoding": "ros2msg"}
                self.ids[await self.server.add_channel(channel)] = topic
            await self.server.wait_opened()
            self.ready.set()
            await self.over.wait()

    async def on_subscribe(self, server, channel_id):
        self.heard.add(self.ids[channel_id])

    async def on_unsubscribe(self, server, channel_id):
        self.heard.discard(self.ids[channel_id])

    async def on_client_advertise(self, server, channel):
        self.said.append(channel)

    async def on_client_message(self, server, channel_id, payload):
        self.said.append(payload)

    def send(self, topic, body):
        channel = next(id for id, name in self.ids.items() if name == topic)
        sent = asyncio.run_coroutine_threadsafe(self.server.send_message(channel, time.time_ns(), body), self.loop)
        sent.result()

    def close(self):
        self.loop.call_soon_threadsafe(self.over.set)
        self.thread.join()


def is_free():
    try:
        socket.create_server(("127.0.0.1", PORT)).close()
        return True
    except OSError:
        return False


def wait_for(what, is_so):
    until = time.time() + 30
    while not is_so():
        assert time.time() < until, what
        time.sleep(0.01)


class Watch:
    """A running `steward watch`, and the lines that it has printed."""

    def __init__(self, folder, *more):
        self.asked = ["--map-channels", f"{folder}/robot.toml", "--property", f"{folder}/safety.scope", "--json"]
        self.child = subprocess.Popen([STEWARD, "watch", "--foxglove", ADDRESS, *self.asked, *more], text=True,
                                      stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        atexit.register(self.child.kill)
        self.lines = []
        self.reader = threading.Thread(target=self.read, daemon=True)
        self.reader.start()

    def read(self):
        for line in self.child.stdout:
            self.lines.append(json.loads(line))

    def said(self, name, verdict):
        return [line for line in self.lines if line.get("property") == name and line["verdict"] == verdict]

    def end(self):
        """The last line, the exit status and the notes."""
        self.child.send_signal(2)
        self.reader.join()
        return self.lines[-1], self.child.wait(), self.child.stderr.read()


def verified(watch, recording):
    out = subprocess.run([STEWARD, "verify", recording, *watch.asked], capture_output=True, text=True)
    return json.loads(out.stdout)["monitors"]


def check(server_kind, folder):
    server = server_kind()
    listed = subprocess.run([STEWARD, "watch", "--foxglove", ADDRESS, "--list"], capture_output=True, text=True)
    for topic, (kind, _) in TYPES.items():
        assert any(topic in line and kind in line for line in listed.stdout.splitlines()), listed
        assert f'topic = "{topic}"\ntype = "{kind}"' in listed.stdout, "a topic that says nothing may not be waited for"
    if server_kind is Sdk:
        assert "# node     /driver" in listed.stdout and "# service  /dock" in listed.stdout, listed.stdout
    wait_for("nobody listens", lambda: not server.heard)

    recording = f"{folder}/run.mcap"
    watch = Watch(folder, "--record", recording, "--on-violation", f"cat >> {folder}/hook")
    wait_for("all topics are listened to", lambda: server.heard == set(TYPES))
    for at in range(40):
        server.send(*speed(0.4))
        server.send(*battery(0.15 if at == 30 else 0.5))
    wait_for("the violation", lambda: watch.said("low_is_slow", "violated"))
    [violated] = watch.said("low_is_slow", "violated")
    # The battery's 31st message, after as many of the other topic.
    assert violated["witness"]["step"] == 62, violated
    hooked = Path(f"{folder}/hook")
    wait_for("the command", lambda: hooked.exists() and hooked.read_text().endswith("\n"))
    assert json.loads(hooked.read_text()) == violated
    # No messages follow: only the time shows that the robot does not stop.
    server.send(*stop(True))
    wait_for("the deadline", lambda: watch.said("stops", "violated"))
    last, status, notes = watch.end()
    assert (status, last["loss"]) == (1, "unknown") and "as the bridge forwarded it" in notes, (status, notes)
    assert [monitor["verdict"] for monitor in last["monitors"]] == ["violated", "violated", "satisfied"], last
    assert last["monitors"] == verified(watch, recording), "of the recording"

    wait_for("nobody listens", lambda: not server.heard)
    watch = Watch(folder, "--record", recording)
    wait_for("all topics are listened to", lambda: server.heard == set(TYPES))
    server.send(*speed(0.4))
    server.send(*battery(0.1))
    wait_for("the violation", lambda: watch.said("low_is_slow", "violated"))
    said = server.said
    server.close()
    wait_for("the gap", lambda: watch.said("slow", "unsure"))
    server = server_kind()
    wait_for("all topics are listened to again", lambda: server.heard == set(TYPES))
    server.send(*speed(2.0))
    wait_for("a violation that no lost message could change", lambda: watch.said("slow", "violated"))
    last, status, notes = watch.end()
    assert [monitor["verdict"] for monitor in last["monitors"]] == ["violated", "unsure", "violated"], last
    assert f"the connection to {ADDRESS}/ broke at" in last["monitors"][1]["unsure"], last
    assert last["monitors"] == verified(watch, recording), "of the recording with its gap"
    assert not said + server.said, "it only listens"
    server.close()


with tempfile.TemporaryDirectory() as folder:
    Path(folder, "robot.toml").write_text(MAPPING)
    Path(folder, "safety.scope").write_text(PROPERTIES)
    for kind in (Sdk, Older):
        Path(folder, "hook").unlink(missing_ok=True)
        check(kind, folder)
        print(f"{kind.__doc__} ok")
    refused = subprocess.run([STEWARD, "watch", "--foxglove", ADDRESS, "--list"], capture_output=True, text=True)
    assert refused.returncode == 2 and "the connection is refused" in refused.stderr, refused
