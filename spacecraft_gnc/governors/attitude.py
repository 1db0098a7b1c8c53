"""Reference governor on SO(3): moves the reference to the target as fast as the loop allows.

Each step moves the reference along the shortest geodesic to the target,
V_k = exp(alpha log(R V_{k-1}^T)) V_{k-1}, by the largest alpha in [0, 1] found by bisection for
which the loop, predicted under V_k held for ever, keeps every constraint.

Source: Kalabic et al. 2014, (11), (14), (15) and Algorithm 1.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.arguments import require_members
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.governors.prediction import UNITS, Planner, Prediction, Predictor
from spacecraft_gnc.governors.reference_set import ReferenceSet
from spacecraft_gnc.governors.search import GeodesicSearch, Step
from spacecraft_gnc.types import (
    ArrayLike,
    GovernorDecision,
    Matrix3,
    Reference,
    State,
    as_rotation,
    read_only,
)

# A loop that is that near to its reference [rad] for so many steps, and gains nothing, is stuck.
_AT_REST = 1e-3
_PATIENCE = 10
_ZERO = read_only(np.zeros(3))


class AttitudeGovernor:
    """Keep the loop behind it within its constraints by shaping its reference.

    Parameters
    ----------
    predictor : Predictor
        Flies the loop ahead.
    reference_set : ReferenceSet
        V of (12).
    target : (3, 3) array
        Attitude R that is finally wanted, body to inertial.
    planner : Planner, optional
        Finds intermediate references where a zone lies across the geodesic.
    initial_reference : (3, 3) array, optional
        V_{-1}; the attitude at the first step if absent.
    alpha_tolerance : float
        Interval of alpha at which the bisection ends.
    cut_point_shift : float
        epsilon of (15).

    Raises
    ------
    ParameterError
        If the target or the initial reference is outside the reference set, or a number outside
        its range.

    Notes
    -----
    Recursively feasible: the loop that is flown is the loop that was predicted, so the last
    reference stays admissible. Where something else moved the body, it may not be: the last
    reference is then held, and the decision says that it is not admissible.
    """

    name = "attitude"

    def __init__(
        self,
        predictor: Predictor,
        reference_set: ReferenceSet,
        target: ArrayLike,
        *,
        planner: Planner | None = None,
        initial_reference: ArrayLike | None = None,
        alpha_tolerance: float = 1e-6,
        cut_point_shift: float = 0.01,
    ) -> None:
        self._search = GeodesicSearch(predictor, reference_set, alpha_tolerance, cut_point_shift)
        self.predictor = predictor
        self.reference_set = reference_set
        self.slow = predictor.slow
        if planner is not None:
            require_members("planner", planner, ("warm_up", "is_clear", "plan"), "Planner")
        self._planner = planner
        self._initial_target = as_rotation("target", target)
        reference_set.require("target", self._initial_target)
        self._first: Matrix3 | None = None
        if initial_reference is not None:
            self._first = as_rotation("initial_reference", initial_reference)
            reference_set.require("initial_reference", self._first)
        self.reset()

    @property
    def target(self) -> Matrix3:
        """Target attitude (3, 3), body to inertial."""
        return self._target

    def set_target(self, attitude: Matrix3) -> None:
        """Take a new target attitude (3, 3), body to inertial.

        Raises
        ------
        GncError
            If it is no rotation, or outside the reference set, with the margin there; the last
            target then stays.
        """
        target = as_rotation("target", attitude)
        self.reference_set.require("target", target)
        self._target = target
        self._forget_route()

    def require_start(self, state: State) -> None:
        """Refuse a start from which the initial reference cannot even be held.

        Raises
        ------
        ParameterError
            With the constraint, the predicted step and the margin.
        """
        reference = state.attitude if self._first is None else self._first
        self.reference_set.require("initial reference", reference)
        found = self.predictor.predict(state, reference)
        if not found.admissible:
            unit = UNITS.get(found.constraint, "rad")
            raise ParameterError(
                f"start: received a state from which holding the initial reference violates "
                f"{found.constraint!r} at predicted step {found.violation_step}, with margin "
                f"{found.margin:.6g} {unit}; required a start from which every constraint is kept; "
                "start slower or nearer to the reference (initial_reference_rotation_vector), or "
                "widen the limit"
            )

    def warm_up(self) -> None:
        """Compile or load everything that `decide` needs."""
        self.predictor.warm_up()
        if self._planner is not None:
            self._planner.warm_up()
        self._search.warm_up()

    def reset(self) -> None:
        """Return to the target and the reference of the start."""
        self._target = self._initial_target
        self._reference = self._first
        self.predictor.reset()
        self._forget_route()

    def decide(self, state: State) -> GovernorDecision:
        """Return the reference for the control step that starts at ``state``."""
        if self._reference is None:
            finite = np.isfinite(state.attitude).all()
            start = lie.orthonormalize(state.attitude) if finite else self._target
            if not finite:
                return self._decision(start, 0.0, Prediction(False, math.nan, "", 0), None, 0)
            self._reference = read_only(start)
        held = self._reference
        aim = self._aim(held)
        if self._obstacle is not None:
            return self._hold(state, held, 0, self._obstacle)
        if np.array_equal(aim, held):
            found = self.predictor.predict(state, held)
            return self._decision(held, 1.0, found, None, 1)
        step = self._search.step(state, held, aim)
        self._note_progress(state, step, held)
        if step.kept is None:
            return self._hold(state, held, step.evaluations, step.refused)
        self._reference = step.reference
        if step.reference is aim and self._route:
            self._route.pop(0)
        return self._decision(step.reference, step.alpha, step.kept, step.refused, step.evaluations)

    def _hold(
        self, state: State, held: Matrix3, evaluations: int, refused: Prediction | None
    ) -> GovernorDecision:
        found = self.predictor.predict(state, held)
        return self._decision(held, 0.0, found, refused, evaluations + 1)

    def _decision(
        self,
        reference: Matrix3,
        alpha: float,
        found: Prediction,
        refused: Prediction | None,
        evaluations: int,
    ) -> GovernorDecision:
        named = refused if found.admissible else found
        return GovernorDecision(
            Reference(reference, _ZERO, _ZERO),
            alpha,
            found.admissible,
            found.margin,
            "" if named is None else named.constraint,
            evaluations,
            -1 if named is None else named.violation_step,
            self.predictor.horizon,
            len(self._route),
        )

    # --- the way round -------------------------------------------------------------------------

    def _forget_route(self) -> None:
        self._route: list[Matrix3] = []
        self._obstacle: Prediction | None = None  # what bars the way where there is no way round
        self._planned_from: Matrix3 | None = None
        self._idle = 0

    def _aim(self, held: Matrix3) -> Matrix3:
        """Return the attitude to head for: the next intermediate reference, or the target."""
        if self._planner is not None and self._planned_from is None:
            self._planned_from = held
            if not self._planner.is_clear(held, self._target):
                self._plan(held)
        while self._route and np.array_equal(self._route[0], held):
            self._route.pop(0)
        return self._route[0] if self._route else self._target

    def _plan(self, held: Matrix3) -> None:
        """Ask for a way round from ``held``; once for each reference at which nothing moves."""
        if self._planner is None:
            return
        self._planned_from = held
        way = self._planner.plan(held, self._target)
        self._route = [] if way is None else [read_only(np.array(turn)) for turn in way]
        self._obstacle = self._search.obstacle(held, self._target) if way is None else None

    def _note_progress(self, state: State, step: Step, held: Matrix3) -> None:
        """Count the steps at which nothing moves; plan once where they add up."""
        resting = lie.angle_between(state.attitude, held) < _AT_REST
        self._idle = self._idle + 1 if step.kept is None and resting else 0
        if self._idle >= _PATIENCE and self._planned_from is not held:
            self._plan(held)

    # --- what outlives the process ----------------------------------------------------------------

    def memory(self) -> tuple[Any, ...] | None:
        """Return target, reference and the way round; None where the predictor does not tell its.

        The reference from which the way was planned counts as the last one, or as another.
        """
        tell = getattr(self.predictor, "memory", None)
        kept = None if tell is None else tell()
        if kept is None:
            return None
        is_here = self._planned_from is self._reference
        way = (tuple(self._route), self._obstacle, self._planned_from, is_here, self._idle)
        return self._target, self._reference, way, kept

    def recall(self, memory: tuple[Any, ...]) -> None:
        """Go on as the governor did whose `memory` it is."""
        self._target, self._reference, way, kept = memory
        route, obstacle, planned_from, is_here, self._idle = way
        self._route = list(route)
        self._obstacle = None if obstacle is None else Prediction(*obstacle)
        self._planned_from = self._reference if is_here else planned_from
        self.predictor.recall(kept)  # type: ignore[attr-defined]
