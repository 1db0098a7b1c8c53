"""Live view of whatever flies on this machine, one flight after the other."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import ExitStack
from typing import TYPE_CHECKING

from spacecraft_gnc.analysis.live.history import History
from spacecraft_gnc.analysis.live.picture import Phase, Picture, Setup
from spacecraft_gnc.analysis.live.transport import Transport
from spacecraft_gnc.launcher import domain
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
        Of the spacecraft; empty: the first of several, else the only one.
    tell_choice
        Told of the graph and its agents where one of several was chosen.
    """

    transport: Transport | None = None

    def __init__(
        self,
        find_domain: Callable[[], int | None],
        namespace: str = "",
        tell_choice: Callable[[str, list[str]], None] = lambda *_: None,
    ) -> None:
        self._find_domain = find_domain
        self._namespace = namespace
        self._tell_choice = tell_choice
        self._watched = ""
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
        if domain_id is None:
            return
        wanted = self._wanted(domain_id)
        if view is not None and domain_id == view.domain_id and wanted in (None, self._watched):
            return
        self._leave()
        self._watched = wanted or ""
        self._view = self._joined.enter_context(GraphView(domain_id, take_interrupts=False))
        self._source = LiveSource(self._view, self._watched)

    def _wanted(self, domain_id: int) -> str | None:
        """Return the agent to watch; None: no launcher has written down yet who flies."""
        about = domain.about(domain_id)
        if self._namespace or not about:
            return self._namespace or None
        agents = about.get("agents", "").split()
        if agents and agents[0] != self._watched:
            self._tell_choice(about["scenario"], agents)
        return agents[0] if agents else ""

    def _leave(self) -> None:
        self._view = None
        self._joined.close()
