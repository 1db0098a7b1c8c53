"""Governors of the docking vehicle from a scenario."""

from __future__ import annotations

import logging
import time
from typing import Final

import numpy as np

from spacecraft_gnc.governors.periodic import AdmissibleSets, PeriodicLoop, SetOptions, cached_sets
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.docking.build import (
    believed_motion,
    initial_motion,
    mean_law,
    navigation_noise,
    periodic_law,
    periodic_model,
)
from spacecraft_gnc.vehicles.docking.governors.abort import Abort
from spacecraft_gnc.vehicles.docking.governors.diagnosis import Noise, ThrusterMonitor
from spacecraft_gnc.vehicles.docking.governors.docking import DockingGovernor
from spacecraft_gnc.vehicles.docking.governors.none import PassThroughGovernor
from spacecraft_gnc.vehicles.docking.governors.retreat import STEPS, Retreat
from spacecraft_gnc.vehicles.docking.governors.rows import Bounds, constraints
from spacecraft_gnc.vehicles.docking.governors.turn import Turn
from spacecraft_gnc.vehicles.docking.law import FeedbackLaw
from spacecraft_gnc.vehicles.docking.linear import LinearMotion, coordinates
from spacecraft_gnc.vehicles.docking.scenario import Scenario

_PATIENCE: Final = 2.0  # wall time [s] before anything is told of the sets
_TOLD_EVERY: Final = 10.0  # wall time [s]
_LOG: Final = logging.getLogger(__name__)


def pass_through(scenario: Scenario) -> PassThroughGovernor:
    """Return the governor ``none`` of a scenario."""
    return PassThroughGovernor(_target(scenario))


def periodic(scenario: Scenario) -> DockingGovernor:
    """Return the governor ``periodic`` of a scenario."""
    return _governor("periodic", scenario, periodic_law(scenario))


def time_invariant(scenario: Scenario) -> DockingGovernor:
    """Return the governor ``time_invariant``: that of the mean model of a period."""
    return _governor("time_invariant", scenario, mean_law(scenario))


def tightened_bounds(scenario: Scenario) -> Bounds:
    """Return the bounds that the sets keep: those of the plant less the margins."""
    p, g, motion = scenario.plant, scenario.governor, believed_motion(scenario)
    slope, slack = motion.line_of_sight
    return Bounds(
        force=p.max_force - g.force_margin,
        moment=p.max_moment - g.moment_margin,
        slope=slope,
        slack=slack - g.distance_margin,
        depth=p.clearance_tolerance - g.distance_margin,
        arms=motion.deputy.vertices - motion.deputy.port,
    )


def sets_of(scenario: Scenario, law: FeedbackLaw, loop: PeriodicLoop) -> AdmissibleSets:
    """Return the admissible sets of a law, from the cache if they are there.

    Raises
    ------
    GncError
        If they are empty.
    """
    options = SetOptions(steady_share=scenario.governor.steady_share)
    rows = constraints(law, tightened_bounds(scenario))
    return cached_sets(loop, rows, options, _Told(loop.period), notice=_LOG.warning)


def _governor(name: str, scenario: Scenario, law: FeedbackLaw) -> DockingGovernor:
    g, loop = scenario.governor, law.loop()
    motion = periodic_model(scenario)  # whatever the law: what is foretold has to come true
    return DockingGovernor(
        name,
        loop,
        sets_of(scenario, law, loop),
        np.array([1.0, 1.0, 1.0, *[g.rotation_weight] * 3]),
        _target(scenario),
        coordinates(*initial_motion(scenario)),
        _monitor(scenario, motion),
        _abort(scenario, motion) if g.aborts else None,
    )


def _monitor(scenario: Scenario, model: LinearMotion) -> ThrusterMonitor:
    p, noise = scenario.plant, navigation_noise(scenario)
    known = Noise() if noise is None else Noise(
        noise.position, noise.velocity, noise.attitude, noise.rate
    )  # fmt: skip
    limit = p.max_force if p.saturates else float("inf")
    return ThrusterMonitor(model, p.deputy_port, limit, scenario.period, known)


def _abort(scenario: Scenario, model: LinearMotion) -> Abort:
    p, motion = scenario.plant, believed_motion(scenario)
    mean = scenario.controller.method == "time_invariant_lqr"
    law = mean_law(scenario) if mean else periodic_law(scenario)  # of the controller
    retreat = Retreat(model, motion.deputy, tightened_bounds(scenario))
    turn = Turn(motion.inertia, motion.deputy.port, p.max_moment, scenario.period, STEPS)
    return Abort(law, retreat, turn, scenario.governor.hold_port_offset)


def _target(scenario: Scenario) -> Array:
    g = scenario.governor
    return np.concatenate([g.target_port_offset, g.target_rotation_vector])


class _Told:
    """Progress of the sets, told as it lasts; they repeat after one or two periods."""

    def __init__(self, period: int) -> None:
        self._period = period
        self._due = time.perf_counter() + _PATIENCE

    def __call__(self, done: int, most: int, rows: int) -> None:
        """Tell of a backward step."""
        del most
        now = time.perf_counter()
        if now >= self._due:
            self._due = now + _TOLD_EVERY
            _LOG.warning(
                "admissible sets, once: step %d of %d to %d, %d rows",
                done, self._period + 1, 2 * self._period, rows,
            )  # fmt: skip
