"""Whatever flies on this machine, one flight after the other, as somebody watches it."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import ExitStack
from typing import TYPE_CHECKING

from spacecraft_gnc.analysis.live.history import History
from spacecraft_gnc.analysis.live.picture import Phase, Picture, Setup
from spacecraft_gnc.analysis.live.transport import Transport
from spacecraft_gnc.ros.graph import GraphView
from spacecraft_gnc.ros.live_source import LiveSource

if TYPE_CHECKING:
    from typing_extensions import Self

_LOOK = 0.5  # [s] wall between two looks for a graph


class LiveFlight:
    """Joins the graph that there is, and the next one after its end. Use as a context manager.

    Parameters
    ----------
    find_domain
        Returns the ROS_DOMAIN_ID to watch; None: no graph runs yet.
    namespace
        Of the spacecraft.
    """

    transport: Transport | None = None

    def __init__(self, find_domain: Callable[[], int | None], namespace: str = "") -> None:
        self._find_domain = find_domain
        self._namespace = namespace
        self._looked = 0.0
        self._nothing = (Setup(title="no graph yet", live=True), History())
        self._joined = ExitStack()
        self._view: GraphView | None = None
        self._source: LiveSource | None = None

    def __enter__(self) -> Self:
        """Look for a graph."""
        self._look()
        return self

    def __exit__(self, *_: object) -> None:
        """Leave it."""
        self._leave()

    @property
    def setup(self) -> Setup:
        """What flies."""
        return self._nothing[0] if self._source is None else self._source.setup

    @property
    def history(self) -> History:
        """Its past."""
        return self._nothing[1] if self._source is None else self._source.history

    def picture(self) -> Picture:
        """Return what there is to see now."""
        if self._source is None:
            note = "no graph runs on this machine: start one with gnc launch"
            return Picture(phase=Phase.WAITING, note=note)
        return self._source.picture()

    def wait(self, duration: float) -> None:
        """Listen for ``duration`` seconds of wall time."""
        deadline = time.monotonic() + duration
        if time.monotonic() - self._looked >= _LOOK:
            self._look()
        if self._view is None:
            time.sleep(max(0.0, deadline - time.monotonic()))
        else:
            self._view.spin_until(lambda: time.monotonic() >= deadline)

    def _look(self) -> None:
        """Join a graph if there is none yet, or the one joined is over and another one runs."""
        self._looked = time.monotonic()
        view, source = self._view, self._source
        if view is not None and source is not None and source.heard and not source.ended:
            return
        domain_id = self._find_domain()
        if domain_id is None or (view is not None and domain_id == view.domain_id):
            return
        self._leave()
        self._view = self._joined.enter_context(GraphView(domain_id, take_interrupts=False))
        self._source = LiveSource(self._view, self._namespace)

    def _leave(self) -> None:
        self._view = None
        self._joined.close()
