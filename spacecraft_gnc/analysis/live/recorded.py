"""A recorded or simulated flight, played for somebody who watches."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING

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
from spacecraft_gnc.analysis.live.playback import Playback
from spacecraft_gnc.analysis.series import target
from spacecraft_gnc.errors import ParameterError

if TYPE_CHECKING:
    from collections.abc import Callable

    from typing_extensions import Self

    from spacecraft_gnc.recording.reader import Flight


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
    playback
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
        n_steps = len(self._flown.time)
        self.setup = (
            Setup(title=title, live=False, period=self._flown.period, n_steps=n_steps)
            if scenario is None
            else Setup.of(scenario, title, live=False)
        )
        self._target = target(self._flown, scenario)
        self._clock = clock
        self.playback = Playback(float(self._flown.time[0]), self._end(), rate)
        self.history = History()
        for step in chosen_steps(n_steps):
            row = sample(self._picture(step, Phase.PAUSED), self._target)
            self.history.append(row)
        self.playback.play(clock())

    def __enter__(self) -> Self:
        """Return the flight."""
        return self

    def __exit__(self, *_: object) -> None:
        """Nothing is held."""

    def wait(self, duration: float) -> None:
        """Let ``duration`` seconds of wall time pass."""
        time.sleep(duration)

    def picture(self) -> Picture:
        """Return the step that is played now."""
        wall = self._clock()
        now = self.playback.time(wall)
        step = int(np.searchsorted(self._flown.time, now, side="right")) - 1
        return self._picture(max(step, 0), self._phase(wall))

    def control(self, action: str, value: float | None) -> None:
        """Play, pause, seek to a time [s], or set the rate.

        Raises
        ------
        ParameterError
            The action or its value makes no sense.
        """
        wall, playback = self._clock(), self.playback
        if action == "play":
            playback.play(wall)
        elif action == "pause":
            playback.pause(wall)
        elif action == "seek" and value is not None:
            playback.seek(value, wall)
        elif action == "rate" and value is not None:
            playback.set_rate(value, wall)
        else:
            raise ParameterError(
                f"action: received {action!r} with value {value}; required play, pause, seek or "
                "rate, the last two with a number; correct it"
            )

    def _phase(self, wall: float) -> Phase:
        if self.playback.over(wall):
            return Phase.OVER
        return Phase.PAUSED if self.playback.paused else Phase.PLAYING

    def _end(self) -> float:
        return float(self._flown.time[-1])

    def _picture(self, step: int, phase: Phase) -> Picture:
        t = self._flown
        note = "the recording is over" if phase is Phase.OVER else ""
        return Picture(
            phase=phase,
            note=note,
            step=step,
            time=float(t.time[step]),
            attitude=_known(t.attitude[step]),
            reference=_known(t.reference[step]),
            target=self._target,
            momentum=_known(t.momentum[step]),
            torque=_known(t.torque[step]),
            source=int(t.source[step]),
            solve=Solve(
                status=status_name(int(t.status[step])),
                iterations=int(t.iterations[step]),
                residual=float(t.residual[step]),
                cost=float(t.cost[step]),
                solve_time=float(t.solve_time[step]),
            ),
            decision=self._decision(step),
        )

    def _decision(self, step: int) -> Decision | None:
        alpha = float(self._flown.alpha[step])
        margin = float(self._flown.governor_margin[step])
        return None if math.isnan(alpha) else Decision(alpha=alpha, margin=margin)


def _known(array: np.ndarray) -> np.ndarray | None:
    """Return an array, or None where the recording lost it."""
    return array if np.isfinite(array).all() else None
