"""Closed-loop predictor of any controller, used by the reference governor.

A controller of the scenario's own kind is flown from the given state under the constant reference
until it settles (`settling`), violates a constraint, or the horizon ends. What a solver's short
horizon cannot see, a zone far ahead, a standstill, a momentum limit, this sees.

Zones count with their whole angle, without the softness of a solver's penalty, at the control
steps. A command that does not come from a good solve is a violation, and so is a flight that has
not settled when the horizon ends: an admissible reference is one that the loop reaches.
"""

from __future__ import annotations

import itertools
import math

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.arguments import as_count, as_limit, require_kind, require_members
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.governors._flight_kernels import (
    CONDITION,
    CONVERGENCE,
    ONWARD,
    SETTLED,
    SOLVER,
    TORQUE,
    examine,
    fly,
    violates,
)
from spacecraft_gnc.governors.prediction import Controller, Prediction
from spacecraft_gnc.governors.reference_set import ReferenceSet
from spacecraft_gnc.governors.settling import OneStep, settled_set
from spacecraft_gnc.ocp import ShootingSolver
from spacecraft_gnc.solvability import largest_step
from spacecraft_gnc.types import Matrix3, Reference, State, Vector3, as_rotation

# Room [rad, share of a limit] that a new reference needs where the controller flown remembers more
# than the one that predicts: its neighboring extremals and warm starts give other last digits.
MEMORY = 1e-3
CONSTRAINTS = (
    "torque limit",
    "momentum limit",
    "momentum condition (4)",
    "convergence",
    "solver",
)
SPARE = 1.25  # the horizon, as a multiple of the longest slew measured
LONGEST = 10  # slews that take more than so many times the linear decay are left out
# Turns of nearly half a turn [rad] about the body's axes and the diagonals between them.
AXES = tuple(
    math.radians(179.0) * np.array(axis) / np.linalg.norm(axis)
    for axis in itertools.product((-1.0, 0.0, 1.0), repeat=3)
    if any(axis)
)


class ControllerLoopPredictor:
    """Predicts the closed loop of a controller and a rigid body.

    Parameters
    ----------
    controller : Controller
        One of its own, that flies nothing else: it is reset for every prediction.
    body : RigidBody
        The plant's inertia and integrator step.
    substeps : int
        Integrator steps in one control period.
    reference_set : ReferenceSet
        The zones, with their names.
    target : (3, 3) array
        Attitude, body to inertial, at which the loop's settling is measured.
    max_torque, max_momentum : float
        Limits on the norms of torque [N m] and angular momentum [N m s]; 0: none.
    horizon : int
        Most steps of a prediction; 0: from the decay of the loop (`SettledSet.horizon`).

    Raises
    ------
    ParameterError
        If the loop does not settle at rest at the target, or a limit or the horizon is negative.

    Attributes
    ----------
    settled : SettledSet
        Where a prediction ends well.
    """

    slow = True

    def __init__(
        self,
        controller: Controller,
        body: RigidBody,
        substeps: int,
        reference_set: ReferenceSet,
        target: Matrix3,
        *,
        max_torque: float = 0.0,
        max_momentum: float = 0.0,
        horizon: int = 0,
    ) -> None:
        max_torque = as_limit("max_torque", max_torque)
        max_momentum = as_limit("max_momentum", max_momentum)
        horizon = as_count("horizon", horizon, least=0)
        target = as_rotation("target", target)
        members = ("period", "warm_up", "reset", "command")
        self._controller = require_members("controller", controller, members, "Controller")
        self._body = require_kind("body", body, RigidBody)
        self._substeps = as_count("substeps", substeps)
        self._set = require_kind("reference_set", reference_set, ReferenceSet)
        self._least_reserve = min(MEMORY, 0.5 * reference_set.steady_margin)
        self._names = (*reference_set.names, *CONSTRAINTS)
        step = OneStep(controller, body, substeps, np.asarray(target))
        self.settled = settled_set(step, max_torque, max_momentum)
        self._zones = reference_set.rows
        self._limits = np.array([max_torque, max_momentum, self.settled.level])
        self._rows = np.empty((7, 3))
        self._worst = np.empty(3)
        self.horizon = horizon or self._measured_horizon(np.asarray(target))

    def warm_up(self) -> None:
        """Load everything that a prediction needs."""
        self._controller.warm_up()
        self.predict(State(0, np.eye(3), np.zeros(3)), lie.exp(np.array([0.1, 0.0, 0.0])))

    def reset(self) -> None:
        """Do nothing: predictions have no memory."""

    def memory(self) -> tuple[()] | None:
        """Return nothing; None where the controller tells none, as it may keep something."""
        tell = getattr(self._controller, "memory", None)
        return None if tell is None or self._keeps_chord or tell() is None else ()

    def recall(self, memory: tuple[()]) -> None:
        """Nothing is remembered."""

    @property
    def _keeps_chord(self) -> bool:
        """Whether the solver takes its Jacobian from one prediction to the next."""
        solver = getattr(self._controller, "solver", None)
        options = getattr(getattr(solver, "solver", solver), "options", None)
        return getattr(options, "step_rule", "") == "chord"

    def predict(self, state: State, reference: Matrix3, reserve: float = 0.0) -> Prediction:
        """Fly the loop from ``state`` under ``reference`` (3, 3); see `prediction.Predictor`."""
        if reserve > 0.0:
            reserve = max(reserve, self._least_reserve)
        rows, worst = self._rows, self._worst
        rows[:3], rows[3], rows[4:] = state.attitude, state.momentum, reference
        worst[:] = math.inf, math.inf, -1.0
        margin, _ = self._set.margin(reference)
        self._limits[2] = self.settled.level_at(margin - reserve)
        found, step = self._fly(state.step, reserve)
        if found == SETTLED:
            name = self._names[int(worst[2])] if worst[2] >= 0.0 else ""
            return Prediction(True, float(worst[1]), name, -1)
        if found == ONWARD:
            found = len(self._set.names) + CONVERGENCE
        return Prediction(False, self._shortfall(found), self._names[found], step)

    def _measured_horizon(self, target: Matrix3) -> int:
        """Return the steps in which the slowest of the turns `AXES` settles, with some to spare.

        Of half or a quarter of these turns where none of them settles. At least what the decay of
        the loop says; only that where flights would take long.
        """
        least = self.settled.horizon
        if self._controller.slow:
            return least
        zones, limits = self._zones, self._limits
        self._zones, self._limits = zones[:0], np.array([0.0, 0.0, limits[2]])
        self.horizon = LONGEST * least
        longest = 0
        for share in (1.0, 0.5, 0.25):
            longest = max(self._slew(target, share * axis) for axis in AXES)
            if longest > 0:
                break
        self._zones, self._limits = zones, limits
        return max(least, math.ceil(SPARE * longest))

    def _slew(self, target: Matrix3, turn: Vector3) -> int:
        """Return the steps that a turn (3,) [rad] from rest takes to settle; 0: it does not."""
        self._rows[:3], self._rows[3], self._rows[4:] = target @ lie.exp(turn), 0.0, target
        found, steps = self._fly(0, 0.0)
        return steps if found == SETTLED else 0

    def _fly(self, first: int, reserve: float) -> tuple[int, int]:
        """Fly from ``rows``; return what `examine` says at the end, and the step."""
        self._controller.reset()
        rows, n = self._rows, len(self._set.names)
        zero = np.zeros(3)
        reference = Reference(rows[4:].copy(), zero, zero)
        for k in range(self.horizon + 1):
            found = self._examine(reserve)
            if found != ONWARD or k == self.horizon:
                break
            state = State(first + k, rows[:3].copy(), rows[3].copy())
            command = self._controller.command(state, reference)
            if command.is_fallback:
                return n + SOLVER, k
            limit, size = float(self._limits[0]), float(np.linalg.norm(command.control))
            if limit > 0.0 and violates(self._worst, limit - size, limit, reserve, n + TORQUE):
                return n + TORQUE, k
            try:
                rows[:3], rows[3] = self._body.step(
                    state.attitude, state.momentum, command.control, self._substeps
                )
            except ParameterError:  # no further step exists
                return n + CONDITION, k + 1
        return found, k

    def _examine(self, reserve: float) -> int:
        body = (self._body.packed, self._body.time_step)
        limits, metric = self._limits, self.settled.metric
        found = examine(self._rows, *body, self._zones, limits, metric, reserve, self._worst)
        return int(found)

    def _shortfall(self, found: int) -> float:
        """Margin of the constraint violated, in its own unit."""
        kind = found - len(self._set.names)
        if kind == CONDITION:  # at its bound, where the state passes it within a control period
            momentum, h = self._rows[3], self._body.time_step
            share = (
                largest_step(self._body.inertia, momentum) / h
            )  # of this momentum that (4) allows
            return min(0.0, (share - 1.0) * float(np.linalg.norm(momentum)))
        if kind in (CONVERGENCE, SOLVER):  # [rad] still to go
            return -lie.angle_between(self._rows[:3], self._rows[4:])
        return float(self._worst[1])


class ShootingLoopPredictor(ControllerLoopPredictor):
    """The same for ``method: shooting``, flown in one call of compiled code.

    Where a solve fails there, the controller itself flies, with all that it tries. The compiled
    loop does not count on the escape from an unstable standstill (`loop.standstill`): a reference
    that needs one is refused.
    """

    def __init__(
        self,
        controller: Controller,
        body: RigidBody,
        substeps: int,
        reference_set: ReferenceSet,
        target: Matrix3,
        *,
        max_torque: float = 0.0,
        max_momentum: float = 0.0,
        horizon: int = 0,
    ) -> None:
        solver = getattr(controller, "solver", None)
        if not isinstance(solver, ShootingSolver):
            raise ParameterError(
                f"controller: received one without a ShootingSolver ({controller.name!r}); "
                "required method shooting; use ControllerLoopPredictor"
            )
        n = solver.ocp.horizon
        self._solver = solver
        self._warm, self._plan = np.zeros((2, n, 6)), np.empty(solver.layout.size)
        self._room = np.empty((5, 3))
        super().__init__(
            controller, body, substeps, reference_set, target,
            max_torque=max_torque, max_momentum=max_momentum, horizon=horizon,
        )  # fmt: skip
        self._least_reserve = 0.0  # exact solves leave nothing to memory

    def _fly(self, first: int, reserve: float) -> tuple[int, int]:
        start = self._rows.copy()
        found, step = fly(
            self._rows, self._warm, self._plan, *self._solver.work, self._body.packed,
            self._body.time_step, self._substeps, self._zones, self._limits, self.settled.metric,
            reserve, self.horizon, self._room, self._worst,
        )  # fmt: skip
        if found == len(self._set.names) + SOLVER:
            self._rows[:] = start
            return super()._fly(first, reserve)
        return int(found), int(step)
