"""A recorded or simulated flight, played for somebody who watches."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, Any

import numpy as np

from spacecraft_gnc.analysis.live.history import History, chosen_steps, sample
from spacecraft_gnc.analysis.live.picture import (
    Decision,
    Phase,
    Picture,
    Setup,
    Solve,
    status_name,
)
from spacecraft_gnc.analysis.live.transport import Transport
from spacecraft_gnc.analysis.vehicle import part

if TYPE_CHECKING:
    from collections.abc import Callable

    from typing_extensions import Self

    from spacecraft_gnc.analysis.reader import Flight


class RecordedFlight:
    """A flight of a bag, or of a file of ``gnc simulate``.

    Parameters
    ----------
    flight
        What is played.
    title
        Its name.
    rate
        Simulated seconds per wall second.
    clock
        Wall time [s]; tests hand in their own.

    Attributes
    ----------
    setup
        What the flight is.
    history
        The whole flight, thinned.
    transport
        Where it is.
    """

    def __init__(
        self,
        flight: Flight,
        title: str,
        rate: float = 1.0,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._flown = flight.trajectory
        scenario = flight.info.scenario
        self._view = part("live", scenario)
        n_steps = len(self._flown.time)
        self.setup = (
            Setup(title=title, live=False, period=self._flown.period, n_steps=n_steps)
            if scenario is None
            else Setup.of(scenario, title, live=False)
        )
        first, last = float(self._flown.time[0]), float(self._flown.time[-1])
        self.transport = Transport(first, last, rate, clock)
        self.history = History()
        for step in chosen_steps(n_steps):
            self.history.append(sample(self._picture(step, Phase.PAUSED), self.setup))

    def __enter__(self) -> Self:
        """Return the flight."""
        return self

    def __exit__(self, *_: object) -> None:
        """Nothing is held."""

    def wait(self, duration: float) -> None:
        """Let ``duration`` seconds of wall time pass; none if it is negative."""
        time.sleep(max(0.0, duration))

    def picture(self) -> Picture:
        """Return the step that is played now."""
        now = self.transport.time()
        step = int(np.searchsorted(self._flown.time, now, side="right")) - 1
        return self._picture(max(step, 0), self._phase())

    def _phase(self) -> Phase:
        if self.transport.over:
            return Phase.OVER
        return Phase.PAUSED if self.transport.paused else Phase.PLAYING

    def _picture(self, step: int, phase: Phase) -> Picture:
        t = self._flown
        note = "the recording is over" if phase is Phase.OVER else ""
        drawn: dict[str, Any] = {k: _known(v) for k, v in self._view.row(t, step).items()}
        return Picture(
            phase=phase,
            note=note,
            step=step,
            time=float(t.time[step]),
            attitude=_known(t.attitude[step]),
            reference=_known(t.reference[step]),
            target=_known(t.target[step]),
            **drawn,
            source=int(t.source[step]),
            solve=Solve(
                status=status_name(int(t.status[step])),
                iterations=int(t.iterations[step]),
                residual=float(t.residual[step]),
                cost=float(t.cost[step]) if hasattr(t, "cost") else math.nan,
                solve_time=float(t.solve_time[step]),
            ),
            decision=self._decision(step),
        )

    def _decision(self, step: int) -> Decision | None:
        if not hasattr(self._flown, "alpha"):
            return None
        alpha = float(self._flown.alpha[step])
        margin = float(self._flown.governor_margin[step])
        return None if math.isnan(alpha) else Decision(alpha=alpha, margin=margin)


def _known(array: np.ndarray) -> np.ndarray | None:
    """Return an array, or None where the recording lost it."""
    return array if np.isfinite(array).all() else None
