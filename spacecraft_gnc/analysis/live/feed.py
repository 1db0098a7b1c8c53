"""Frames of a watched flight, made by one thread for any number of viewers."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from typing import Any, Final, NamedTuple, Protocol

from spacecraft_gnc.analysis.live.history import History, columns
from spacecraft_gnc.analysis.live.picture import Picture, Setup
from spacecraft_gnc.analysis.live.transport import Transport
from spacecraft_gnc.errors import ParameterError

PERIOD: Final = 0.1
"""Wall time between two frames [s]."""


class Watched(Protocol):
    """A flight that can be watched: live, or recorded."""

    @property
    def setup(self) -> Setup:
        """What the flight is; replaced, never changed, when more is known."""

    @property
    def history(self) -> History:
        """Its past; replaced when another flight begins."""

    @property
    def transport(self) -> Transport | None:
        """Where a recording is; None: live."""

    def picture(self) -> Picture:
        """Return what there is to see now; append what is new to `history`."""


class Event(NamedTuple):
    """A server-sent event."""

    name: str
    data: dict[str, Any]

    def encode(self) -> bytes:
        """Return its lines."""
        data = json.dumps(self.data, allow_nan=False, separators=(",", ":"))
        return f"event: {self.name}\ndata: {data}\n\n".encode()


class Feed:
    """What the watchers of one flight see.

    Parameters
    ----------
    flight
        What is watched. It is only touched by `tick` and `control`, under the feed's lock.
    """

    def __init__(self, flight: Watched) -> None:
        self._flight = flight
        self._changed = threading.Condition()
        self._frame: dict[str, Any] = {}
        self._number = 0
        self._closed = False

    def tick(self) -> None:
        """Make the next frame; call it every `PERIOD`."""
        with self._changed:
            flight = self._flight
            picture = flight.picture()
            self._number += 1
            self._frame = {
                "number": self._number,
                **picture.as_json(),
                "readouts": picture.readouts(flight.setup),
                "transport": self._transport(),
            }
            self._changed.notify_all()

    def control(self, action: str, value: float | None) -> None:
        """Play, pause, seek or set the rate.

        Raises
        ------
        ParameterError
            It makes no sense, or the flight is live.
        """
        with self._changed:
            if self._flight.transport is None:
                raise ParameterError("action: the flight is live; required a recording; watch it")
            self._flight.transport.control(action, value)

    def close(self) -> None:
        """Let the watchers go."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    def events(self) -> Iterator[Event]:
        """Yield the events of one watcher, until the feed is closed.

        A recording begins to play when its first watcher comes. First ``setup`` and ``history``,
        whenever they change; then a ``frame`` each tick. A watcher that is too slow misses frames,
        but no sample of the history.
        """
        setup: Setup | None = None
        generation, count, number = -1, 0, 0
        if self._flight.transport is not None:
            self._flight.transport.begin()
        while True:
            with self._changed:
                while not self._closed and self._number == number:
                    self._changed.wait()
                if self._closed:
                    return
                number = self._number
                flight = self._flight
                events = []
                if flight.setup is not setup:
                    setup = flight.setup
                    events.append(Event("setup", {**setup.as_json(), **setup.page_json()}))
                if flight.history.generation != generation:
                    generation, count = flight.history.generation, 0
                    events.append(Event("history", {"columns": columns(flight.setup)}))
                samples = list(flight.history.since(count))
                count += len(samples)
                events.append(Event("frame", {**self._frame, "samples": samples}))
            yield from events  # outside the lock, so that a slow viewer delays no other

    def _transport(self) -> dict[str, Any] | None:
        transport = self._flight.transport
        if transport is None:
            return None
        return {
            "start": transport.start,
            "end": transport.end,
            "rate": transport.rate,
            "paused": transport.paused,
        }
