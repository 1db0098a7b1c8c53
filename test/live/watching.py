"""A recorded flight with a wall clock of its own, and a small client of the page's server."""

from __future__ import annotations

import http.client
import json
from dataclasses import replace
from pathlib import Path

from analysis.flights import case1, scenario

from spacecraft_gnc.analysis.live.feed import PERIOD, Feed
from spacecraft_gnc.analysis.live.recorded import RecordedFlight
from spacecraft_gnc.analysis.reader import RecordedRun
from spacecraft_gnc.analysis.run_info import RunInfo

PATIENCE = 60.0  # [s] wall: after this a test has failed
ZONE = {
    "star": {
        "kind": "exclusion",
        "body_axis": [1.0, 0.0, 0.0],
        "inertial_axis": [0.0, 1.0, 0.0],
        "half_angle_deg": 20.0,
    }
}


class Wall:
    """Wall time [s] that only a test moves on."""

    def __init__(self):
        self.now = 100.0

    def __call__(self):
        return self.now


def recorded(wall, rate=1.0, trajectory=None, begun=True, **controller):
    """Return Case I, flown by CasADi and IPOPT, as a recording that begins to play at once."""
    flown = case1() if trajectory is None else trajectory
    info = RunInfo(path=Path("case1"), scenario=scenario(zones=ZONE, max_torque=0.01, **controller))
    flight = RecordedFlight(RecordedRun(flown, info), "case1", rate, wall)
    if begun:
        flight.transport.begin()
    return flight


def without_scenario(flight):
    """Return a flight whose scenario was not recorded."""
    return RecordedRun(flight.trajectory, replace(flight.info, scenario=None))


class Stage:
    """A feed of Case I whose ticks and whose wall clock a test drives."""

    def __init__(self, rate=1.0, trajectory=None):
        self.wall = Wall()
        self.flight = recorded(self.wall, rate, trajectory)
        self.feed = Feed(self.flight)

    def tick(self, count=1):
        for _ in range(count):
            self.feed.tick()
            self.wall.now += PERIOD


def request(server, path, method="GET", body=None, **headers):
    """Return (status, headers, body) of one request; header names with ``_`` for ``-``."""
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=PATIENCE)
    names = {name.replace("_", "-"): value for name, value in headers.items()}
    connection.request(method, path, body, names)
    response = connection.getresponse()
    answer = response.status, dict(response.headers), response.read().decode()
    connection.close()
    return answer


class EventReader:
    """Reads server-sent events one by one."""

    def __init__(self, port):
        self.connection = http.client.HTTPConnection("127.0.0.1", port, timeout=PATIENCE)
        self.connection.request("GET", "/events")
        self.response = self.connection.getresponse()
        assert self.response.headers["Content-Type"] == "text/event-stream"

    def __iter__(self):
        return self

    def __next__(self):
        name = self.response.readline().decode()
        if not name:
            raise StopIteration
        data = self.response.readline().decode()
        assert self.response.readline() == b"\n"
        return name.removeprefix("event: ").strip(), json.loads(data.removeprefix("data: "))

    def close(self):
        self.response.close()
        self.connection.close()
