"""Protocol of a vehicle's replay without a graph, and the checks that replays share."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.loop.flight import Flight
from spacecraft_gnc.loop.protocols import Controller

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class VehicleReplay(Protocol):
    """Recorded steps beside the answers of another controller."""

    @property
    def control(self) -> str:
        """What a controller commands, in a word."""

    def resolve(
        self,
        flight: Any,
        recorded: Any,
        revised: Any,
        *,
        steps: tuple[int, int] | None = None,
        cold: bool = False,
        progress: Callable[[int, int], None] | None = None,
    ) -> Any:
        """Solve recorded steps again; the result has ``steps`` and ``first_difference``."""

    def compare(self, resolved: Any, recorded: Any, revised: Any) -> dict[str, Any]:
        """Return the comparison in numbers, ready for JSON."""

    def sides(self, old: dict[str, Any], new: dict[str, Any]) -> list[tuple[str, str, str]]:
        """Return the rows of a table: what it is, as flown, as replayed."""

    def differences(self, numbers: dict[str, Any], period: float) -> list[tuple[str, str]]:
        """Return the rows that hold for both together."""

    def figure(self, resolved: Any, names: tuple[str, str], title: str = "") -> Figure:
        """Draw both, and their difference."""


def require_period(controller: Controller[Any, Any], flight: Flight) -> None:
    """Refuse a controller of another period than that of the flight, by a `ParameterError`."""
    if not math.isclose(controller.period, flight.period, rel_tol=1e-9):
        raise ParameterError(
            f"nmpc_controller.time_step: received {controller.period:g} s; required the period of "
            f"the flight, {flight.period:g} s, at which its states were recorded; leave it out"
        )


def complete_steps(
    flight: Flight, needed: Sequence[str], steps: tuple[int, int] | None, control: str
) -> NDArray[np.int64]:
    """Return the steps whose messages were all recorded.

    Parameters
    ----------
    flight
        What was flown.
    needed
        Columns that have to hold numbers.
    steps
        First step and the one after the last; None: all.
    control
        What a controller commands, in a word.

    Raises
    ------
    ParameterError
        If there are no such steps, or none of them is complete.
    """
    n = flight.n_steps
    first, end = steps or (0, n)
    if not 0 <= first < end <= n:
        raise ParameterError(
            f"--steps: received {first}:{end}; required A:B with 0 <= A < B <= {n}, the number of "
            f"steps of the flight; give for example 0:{n}"
        )
    rows = (getattr(flight, name)[first:end].reshape(end - first, -1) for name in needed)
    complete = first + np.flatnonzero(np.isfinite(np.hstack([*rows])).all(axis=1))
    if not complete.size:
        raise ParameterError(
            f"--steps: received {first}:{end}, in which every step lacks a state, a reference or a "
            f"{control}; required at least one complete step; choose others"
        )
    return complete
