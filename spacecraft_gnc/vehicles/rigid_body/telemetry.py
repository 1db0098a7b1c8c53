"""Telemetry of a flight: curvature, closed-loop radius, deadlines, invariants, plans."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from spacecraft_gnc.recording.columns import Columns, read_columns
from spacecraft_gnc.signals.graph import WALL_TIMING
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body import series
from spacecraft_gnc.vehicles.rigid_body.planner.recorded import RecordedPlan, plans_of
from spacecraft_gnc.vehicles.rigid_body.signals import ATTITUDE_PLAN, INVARIANTS, SOLVER_STATUS

if TYPE_CHECKING:
    from spacecraft_gnc.loop.flight import Flight
    from spacecraft_gnc.recording.bag import Bag
    from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario

_PLANS: Final = ("predicted_attitudes", "predicted_momenta", "predicted_torques", "first_costate")


@dataclass(frozen=True, slots=True)
class Telemetry:
    """Arrays beside a `Flight` of n steps; NaN where a value is not known.

    Attributes
    ----------
    min_curvature : (n,) array
        Smallest eigenvalue of the reduced Hessian [cost per (N m)^2].
    closed_loop_radius : (n,) array
        Spectral radius of the closed loop, linearized at a standstill.
    deadline_slack : (n,) array
        Wall time left before the deadline when the solve ended [s]; NaN without a deadline.
    kinetic_energy : (n + 1,) array
        Rotational [J].
    inertial_momentum : (n + 1, 3) array
        Angular momentum, inertial frame [N m s].
    orthogonality_error : (n + 1,) array
        Frobenius norm of R^T R - I.
    invariants_recorded : bool
        Whether the plant published the last three; else they are computed from the states.
    missed_deadlines : int or None
        Steps of a free run whose torque came too late, as the plant counted; None: no free run.
    plans : tuple of RecordedPlan
        Plans that were taken; none where nothing recorded them.
    """

    min_curvature: Array
    closed_loop_radius: Array
    deadline_slack: Array
    kinetic_energy: Array
    inertial_momentum: Array
    orthogonality_error: Array
    invariants_recorded: bool
    missed_deadlines: int | None = None
    plans: tuple[RecordedPlan, ...] = ()


def read_telemetry(
    bag: Bag, namespace: str | None, trajectory: Flight, scenario: Scenario | None = None
) -> Telemetry:
    """Read what the bag of a flight holds beside its trajectory.

    Raises
    ------
    RecordingError
        If the bag cannot be read any more.
    """
    signals = (SOLVER_STATUS, INVARIANTS, ATTITUDE_PLAN, WALL_TIMING)
    topics = read_columns(bag, signals, namespace, leave_out=_PLANS)
    n, solves, plant = trajectory.n_steps, topics[SOLVER_STATUS], topics[INVARIANTS]
    from_states = computed(trajectory, scenario)
    recorded = bool(plant.steps.size)
    return Telemetry(
        min_curvature=_by_step(solves, "min_curvature", n),
        closed_loop_radius=_by_step(solves, "closed_loop_radius", n),
        deadline_slack=_by_step(solves, "wall_deadline_slack", n),
        kinetic_energy=_by_step(plant, "kinetic_energy", n + 1)
        if recorded
        else from_states.kinetic_energy,
        inertial_momentum=_by_step(plant, "inertial_momentum", n + 1, (3,))
        if recorded
        else from_states.inertial_momentum,
        orthogonality_error=_by_step(plant, "orthogonality_error", n + 1)
        if recorded
        else from_states.orthogonality_error,
        invariants_recorded=recorded,
        missed_deadlines=_missed_deadlines(topics[WALL_TIMING], scenario),
        plans=plans_of(topics[ATTITUDE_PLAN]),
    )


def computed(trajectory: Flight, scenario: Scenario | None = None) -> Telemetry:
    """Return the telemetry that a trajectory alone gives: the invariants of its states."""
    unknown = np.full(trajectory.n_steps, math.nan)
    attitudes, momenta = series.attitudes(trajectory), series.momenta(trajectory)
    energy = np.full(len(momenta), math.nan)
    if scenario is not None and np.isfinite(scenario.plant.inertia).all():
        rates = np.linalg.solve(scenario.plant.inertia, momenta.T).T
        energy = 0.5 * np.einsum("ni,ni->n", momenta, rates)
    defect = np.einsum("nji,njk->nik", attitudes, attitudes) - np.eye(3)
    return Telemetry(
        min_curvature=unknown,
        closed_loop_radius=unknown,
        deadline_slack=unknown,
        kinetic_energy=energy,
        inertial_momentum=np.asarray(np.einsum("nij,nj->ni", attitudes, momenta)),
        orthogonality_error=np.asarray(np.linalg.norm(defect, axis=(1, 2))),
        invariants_recorded=False,
    )


def _missed_deadlines(timing: Columns, scenario: Scenario | None) -> int | None:
    """Return the last count of the plant; it grows only."""
    free = scenario is not None and scenario.plant.mode == "free_run"
    return int(timing.fields["missed_deadlines"].max()) if free and timing.steps.size else None


def _by_step(columns: Columns, name: str, n: int, shape: tuple[int, ...] = ()) -> Array:
    """Return the values of steps 0..n-1; NaN where a step has none."""
    result = np.full((n, *shape), math.nan)
    if name in columns.fields:
        inside = (columns.steps >= 0) & (columns.steps < n)
        result[columns.steps[inside]] = columns.fields[name][inside]
    return result
