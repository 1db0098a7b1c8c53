"""The Foxglove app gets the bytes of the bag, with their definitions, and can pause and seek."""

from __future__ import annotations

import json
import struct
import sys
import time
from contextlib import contextmanager

import pytest
import websocket
from live.watching import PATIENCE, Wall
from recording.bags import flight_messages, random_flight, record

from spacecraft_gnc.analysis.live import foxglove
from spacecraft_gnc.analysis.live.server import PortTaken
from spacecraft_gnc.analysis.live.transport import Transport
from spacecraft_gnc.extras import MissingDependency
from spacecraft_gnc.recording.bag import open_bag
from spacecraft_gnc.recording.playback import Playback

STEPS = 12
HEADER = struct.Struct("<BIQ")  # opcode, subscription, log time [ns]
MESSAGE, PLAYBACK_STATE = 1, 5  # opcodes of the server
PLAYBACK_CONTROL = 3  # opcode of the client
PLAYING, PAUSED, ENDED = 0, 1, 3


class App:
    """As much of a client of foxglove.sdk.v1 as the tests need."""

    def __init__(self, port):
        address = f"ws://127.0.0.1:{port}"
        self.socket = websocket.create_connection(
            address, subprotocols=["foxglove.sdk.v1"], timeout=PATIENCE
        )
        self.channels = {}
        self.about = {}

    def read(self):
        """Return (opcode, data) of the next binary message; texts are taken in on the way."""
        while True:
            kind, data = self.socket.recv_data()
            if kind == websocket.ABNF.OPCODE_BINARY:
                return data[0], data
            text = json.loads(data)
            if text["op"] == "serverInfo":
                self.about = text
            elif text["op"] == "advertise":
                self.channels |= {channel["topic"]: channel for channel in text["channels"]}
                return None, None

    def subscribe(self):
        ids = [channel["id"] for channel in self.channels.values()]
        self.socket.send(
            json.dumps(
                {"op": "subscribe", "subscriptions": [{"id": i, "channelId": i} for i in ids]}
            )
        )

    def control(self, command, speed, seek_ns=None):
        """Send a playback control request."""
        seek = struct.pack("<BQ", seek_ns is not None, seek_ns or 0)
        request = struct.pack("<BBf", PLAYBACK_CONTROL, command, speed) + seek
        self.socket.send_binary(request + struct.pack("<I", 1) + b"1")


class Stage:
    """A bag, a server, and a wall clock that moves when the player waits."""

    def __init__(self, folder, tick):
        self.bag, self.messages = folder, {}
        self.wall, self.tick = Wall(), tick

    @contextmanager
    def serve(self, rate=1.0):
        with open_bag(self.bag) as bag:
            for topic, data in bag.messages(bag.topics):
                self.messages.setdefault(topic, []).append(data)
            playback = Playback(bag)
            span = playback.start_ns / 1e9, playback.end_ns / 1e9
            self.transport = Transport(*span, rate, self.wall)
            with foxglove.FoxgloveServer(port=None, transport=self.transport) as server:
                foxglove.announce_all(bag, playback, server)
                self.play = lambda stop: foxglove.play(
                    playback, server, self.transport, stop, self.wait
                )
                self.server, app = server, App(server.port)
                yield app
                app.socket.close()

    def wait(self, duration):
        self.wall.now += self.tick


@pytest.fixture
def stage(tmp_path):
    flight = random_flight(STEPS, 1)
    return Stage(record(tmp_path / "bag", flight_messages(flight)), tick=0.1)


def ends(transport):
    """Return a stop that lets the player look once more after the end."""
    rest = iter([False, True])
    return lambda: transport.over and next(rest, True)


def test_the_app_gets_the_bytes_of_the_bag(stage) -> None:
    with stage.serve() as app:
        app.read()
        app.subscribe()
        wait_for_subscription(stage.server)
        stage.play(ends(stage.transport))
        names = {channel["id"]: topic for topic, channel in app.channels.items()}
        received, total = {}, sum(map(len, stage.messages.values()))
        while sum(map(len, received.values())) < total:
            opcode, data = app.read()
            if opcode == MESSAGE:
                _, channel, log_time = HEADER.unpack_from(data)
                received.setdefault(names[channel], []).append((log_time, data[HEADER.size :]))
    assert {t: [d for _, d in found] for t, found in received.items()} == stage.messages
    times = [log_time for log_time, _ in received["/attitude_state"]]
    assert times == [round(k * 0.4e9) for k in range(STEPS + 1)]


def wait_for_subscription(server):
    """Wait until the server has taken every subscription in."""
    deadline = time.monotonic() + PATIENCE
    while not all(channel.has_sinks() for channel in server._channels.values()):
        assert time.monotonic() < deadline, "the server never took the subscriptions in"


def test_channels_carry_the_definitions_of_the_bag(stage) -> None:
    with stage.serve() as app, open_bag(stage.bag) as bag:
        app.read()
        assert set(app.channels) == set(bag.topics)
        for topic, channel in app.channels.items():
            assert channel["encoding"] == "cdr"
            assert channel["schemaEncoding"] == "ros2msg"
            assert channel["schemaName"] == bag.topics[topic]
            assert channel["schema"] == bag.channel(topic).definition
        assert "playbackControl" in app.about["capabilities"]


def states(app, count):
    """Return the next playback states: (status, time [ns], speed, did seek)."""
    found = []
    while len(found) < count:
        opcode, data = app.read()
        if opcode == PLAYBACK_STATE:
            status, now, speed, sought = struct.unpack_from("<BQf?", data, 1)
            found.append((status, now, speed, sought))
    return found


def test_the_app_can_pause_seek_and_set_the_speed(stage) -> None:
    with stage.serve() as app:
        app.read()
        app.control(1, 2.0, seek_ns=2_000_000_000)
        ((status, now, speed, sought),) = states(app, 1)
        assert (status, now, speed, sought) == (PAUSED, 2_000_000_000, 2.0, True)
        assert stage.transport.paused
        app.control(0, 4.0)
        ((status, _, speed, sought),) = states(app, 1)
        assert (status, speed, sought) == (PLAYING, 4.0, False)
        assert not stage.transport.paused


def test_a_port_that_is_taken_is_refused(stage) -> None:
    with foxglove.FoxgloveServer(port=None) as first:
        with pytest.raises(PortTaken, match=f"received {first.port}, where another process"):
            foxglove.FoxgloveServer(port=first.port)
        with foxglove.FoxgloveServer(port=None) as second:
            assert second.port != first.port


def test_without_the_library_the_remedy_is_named(monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "foxglove", None)
    with pytest.raises(MissingDependency, match=r"pip install 'spacecraft_gnc\[view\]'"):
        foxglove.FoxgloveServer()


def test_a_bag_stands_at_its_start_until_an_app_subscribes(stage) -> None:
    with stage.serve() as app:
        app.read()
        looks = iter([False] * 20)
        stage.play(lambda: next(looks, True))
        assert stage.transport.paused
        assert stage.transport.time() == stage.transport.start
        app.subscribe()
        wait_for_subscription(stage.server)
        stage.play(ends(stage.transport))
        assert stage.transport.over
