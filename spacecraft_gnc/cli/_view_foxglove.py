"""``gnc view --foxglove``: a bag or a graph for the Foxglove app."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

from spacecraft_gnc.analysis.live import foxglove
from spacecraft_gnc.analysis.live.hosts import url_host
from spacecraft_gnc.analysis.live.transport import Transport
from spacecraft_gnc.recording.bag import open_bag
from spacecraft_gnc.recording.playback import Playback
from spacecraft_gnc.vehicles.known_signals import every_signal

Announce = Callable[[str, int], None]
_NS_PER_S = 1_000_000_000


def serve_bag(
    path: Path,
    rate: float,
    unfinished: bool,
    host: str,
    port: int | None,
    announce: Announce,
    stop: Callable[[], bool],
) -> None:
    """Play a bag to the app until ``stop``; the app's own buttons pause and seek."""
    with open_bag(path, allow_unfinished=unfinished) as bag:
        playback = Playback(bag, signals=every_signal())
        start, end = (time_ns / _NS_PER_S for time_ns in (playback.start_ns, playback.end_ns))
        transport = Transport(start, end, rate, time.monotonic)
        with foxglove.FoxgloveServer(host, port, transport) as server:
            for remark in playback.remarks():
                print(f"warning: {remark}", file=sys.stderr)
            foxglove.announce_all(bag, playback, server)
            announce(_url(host, server.port), server.port)
            foxglove.play(playback, server, transport, stop)


def serve_graph(
    domain_id: int,
    host: str,
    port: int | None,
    announce: Announce,
    stop: Callable[[], bool],
) -> None:
    """Relay every topic of a graph to the app until ``stop``."""
    from spacecraft_gnc.ros.graph import GraphView
    from spacecraft_gnc.ros.relay import Relay

    with (
        foxglove.FoxgloveServer(host, port) as server,
        GraphView(domain_id, take_interrupts=False) as view,
    ):
        relay = Relay(view, server.announce, server.send)
        announce(_url(host, server.port), server.port)
        while not stop():
            relay.look()
            server.serve_latched()
            relay.wait()


def _url(host: str, port: int) -> str:
    return f"ws://{url_host(host)}:{port}"
