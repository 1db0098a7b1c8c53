"""Flights of the scenarios that come with the package, with the time of every command."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.loop import ClosedLoop, Flight
from spacecraft_gnc.loop.protocols import (
    Command,
    Controller,
    Governor,
    GovernorDecision,
    Reference,
    State,
)
from spacecraft_gnc.scenario import Scenario, load
from spacecraft_gnc.scenario.shipped import shipped
from spacecraft_gnc.types import Array, Matrix3
from spacecraft_gnc.vehicles.rigid_body import series

Progress = Callable[[str, int, int], None]
"""Called with what flies, its step, and its number of steps."""
REPEATS = 15
"""Timed flights of a fast method: the time of a step is the median over them."""


def quiet(_what: str, _step: int, _n_steps: int) -> None:
    """Report no progress."""


class Stopwatch:
    """A controller whose commands are timed: solve, failure ladder and certificate together.

    Parameters
    ----------
    controller : Controller

    Attributes
    ----------
    times : list of float
        Wall time of each command since the last reset [s].
    reports : list
        What the method reported beside each of them.
    """

    def __init__(self, controller: Controller[Any, Any]) -> None:
        self._controller = controller
        self.period, self.name, self.slow = controller.period, controller.name, controller.slow
        self.times: list[float] = []
        self.reports: list[Any] = []

    def warm_up(self) -> None:
        """Compile or load everything that `command` needs."""
        self._controller.warm_up()

    def reset(self) -> None:
        """Forget the past."""
        self._controller.reset()
        self.times, self.reports = [], []

    def command(self, state: State, reference: Reference) -> Command:
        """Return the controller's command."""
        begun = perf_counter()
        command = self._controller.command(state, reference)
        self.times.append(perf_counter() - begun)
        self.reports.append(command.report)
        return command


class GovernorStopwatch:
    """A governor whose decisions are timed.

    Parameters
    ----------
    governor : Governor

    Attributes
    ----------
    times : list of float
        Wall time of each decision since the last reset [s].
    """

    def __init__(self, governor: Governor[Any, Any]) -> None:
        self._governor = governor
        self.name, self.slow = governor.name, governor.slow
        self.times: list[float] = []

    @property
    def target(self) -> Matrix3:
        """Attitude (3, 3) that is finally wanted, body to inertial."""
        target: Matrix3 = self._governor.target
        return target

    def set_target(self, attitude: Matrix3) -> None:
        """Ask for a new target attitude (3, 3), body to inertial."""
        self._governor.set_target(attitude)

    def warm_up(self) -> None:
        """Compile or load everything that `decide` needs."""
        self._governor.warm_up()

    def reset(self) -> None:
        """Forget the past."""
        self._governor.reset()
        self.times = []

    def decide(self, state: State) -> GovernorDecision:
        """Return the governor's decision."""
        begun = perf_counter()
        decision: GovernorDecision = self._governor.decide(state)
        self.times.append(perf_counter() - begun)
        return decision


class Flown(NamedTuple):
    """A flight, and what its commands and decisions took."""

    scenario: Scenario
    trajectory: Flight
    step_times: Array
    """(n,) median over the repeats of each command's time [s]."""
    decision_times: Array
    """The same for the governor's decisions."""
    reports: Sequence[Any] = ()
    """(n,) what the method reported beside each command of the last flight."""

    @property
    def total(self) -> float:
        """Time of all commands together [s]."""
        return float(self.step_times.sum())


def fly(
    name: str,
    overrides: Sequence[str] = (),
    *,
    repeats: int = REPEATS,
    progress: Progress = quiet,
) -> Flown:
    """Fly a scenario that comes with the package.

    Parameters
    ----------
    name : str
        Such as ``gupta2015_case1``.
    overrides : sequence of str, optional
        ``node.parameter=value``, as for ``--set``.
    repeats : int, optional
        Timed flights, after one that is not; 1: that flight is the only one.
    progress : callable, optional

    Returns
    -------
    Flown
    """
    scenario = load(shipped(name), overrides)
    loop = scenario.build()
    watch, decisions = Stopwatch(loop.controller), GovernorStopwatch(loop.governor)
    timed = ClosedLoop(loop.plant, watch, decisions)
    if repeats > 1:
        timed.run()  # caches, and the nominal run of a neighboring extremal
    rows = []
    for i in range(repeats):
        done = i * scenario.n_steps
        trajectory = timed.run(
            lambda k, n, done=done: progress(name, done + k, repeats * n)  # type: ignore[misc]
        )
        rows.append((watch.times, decisions.times))
    command_times, decision_times = np.median(np.array(rows), axis=0)
    return Flown(scenario, trajectory, command_times, decision_times, watch.reports)


def set_vector(parameter: str, vector: Array) -> str:
    """Return the override that sets a parameter to a vector."""
    return f"{parameter}=[{', '.join(repr(float(x)) for x in vector)}]"


def separation_deg(first: Array, second: Array) -> Array:
    """Return the (n,) angles between two (n, 3, 3) series of attitudes [deg]."""
    return np.degrees(lie.angles_between(first, second))


def apart_deg(first: Flight, second: Flight) -> Array:
    """Return (n + 1,) angles between the attitudes of two flights [deg], as far as both go."""
    n = min(first.n_steps, second.n_steps)
    return separation_deg(series.attitudes(first)[: n + 1], series.attitudes(second)[: n + 1])
