"""Playback of a recorded or simulated flight in the live view."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

import numpy as np

from spacecraft_gnc.analysis.live.history import History, chosen_steps, sample
from spacecraft_gnc.analysis.live.picture import Phase, Picture, Setup
from spacecraft_gnc.analysis.live.transport import Transport

if TYPE_CHECKING:
    from collections.abc import Callable

    from typing_extensions import Self

    from spacecraft_gnc.analysis.reader import RecordedRun


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
        flight: RecordedRun,
        title: str,
        rate: float = 1.0,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._flown = flight.trajectory
        scenario = flight.info.scenario
        n_steps = len(self._flown.time)
        self.setup = (
            Setup.without_scenario(title, live=False, period=self._flown.period, n_steps=n_steps)
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
        return Picture(
            phase=phase,
            note="the recording is over" if phase is Phase.OVER else "",
            step=step,
            time=float(self._flown.time[step]),
            values=self.setup.values(self._row(step)),
        )

    def _row(self, step: int) -> dict[str, Any]:
        """Return what the flight keeps of a step, by column."""
        kept = [name for name, column in self._flown.columns() if not column.at_end]
        return {name: _known(getattr(self._flown, name)[step]) for name in kept}


def _known(value: Any) -> Any:
    """Return a value of a recording; None for an array that it lost."""
    return value if np.ndim(value) == 0 or np.isfinite(value).all() else None
