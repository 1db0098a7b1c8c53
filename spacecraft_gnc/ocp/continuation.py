"""Continuations: ways to a problem that does not solve, or solves late, from one that is easier.

`PenaltyContinuation` and `StateContinuation` are the two scenarios of Gupta et al. 2015, Remark
III. `HorizonContinuation`, `EffortContinuation` and `OpenContinuation` lead from short horizons,
from small torques and from a sky without zones; they come from measurement (docs/solver.md).
`AutomaticContinuation` compares them.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Final, Protocol

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.arguments import require_kind
from spacecraft_gnc.ocp.problem import AttitudeOcp
from spacecraft_gnc.ocp.reference import Tracked, as_reference, is_moving
from spacecraft_gnc.ocp.shooting import ShootingOptions, ShootingSolver
from spacecraft_gnc.ocp.solution import Solution
from spacecraft_gnc.types import (
    Array,
    ArrayLike,
    Matrix3,
    Reference,
    Vector3,
    as_rotation,
    as_vector3,
)

SMALLEST_SHARE: Final = 1e-8  # of the penalties, with which a penalty continuation starts
FACTOR: Final = 100.0  # between two of its problems
SMALLEST_ADVANCE: Final = 1.0 / 1024.0  # share of the way below which a state continuation gives up
HARDENING: Final = (1e-4, 1e-2, 1.0)  # shares of the penalties of zones
LONG: Final = 60  # steps
NEAR_HALF_TURN: Final = math.radians(150.0)
EFFORTS: Final = tuple(10.0**i for i in range(4, -1, -1))  # times the weight of the torque
PATIENCE: Final = 4  # Newton steps after which a solution is compared with those of other starts


class Continuation(Protocol):
    """A detour to a solution."""

    patience: float
    """Newton steps of a direct solve after which this detour is tried although it converged."""

    def solve(
        self, attitude: ArrayLike, momentum: ArrayLike, reference: Tracked | None = None
    ) -> Solution:
        """Solve from a state."""


class _Series(ABC):
    """Problems that lead to one another; most flights need none, so they are made when used.

    Parameters
    ----------
    ocp : AttitudeOcp
        The last of them.
    options : ShootingOptions, optional
    """

    patience: float = math.inf

    def __init__(self, ocp: AttitudeOcp, options: ShootingOptions | None = None) -> None:
        self._ocp = require_kind("ocp", ocp, AttitudeOcp)
        chosen = ShootingOptions() if options is None else options
        self._options = require_kind("options", chosen, ShootingOptions)

    @cached_property
    def _solvers(self) -> Sequence[ShootingSolver]:
        easier = self._easier()
        return [ShootingSolver(ocp, options=self._options) for ocp in (*easier, self._ocp)]

    @abstractmethod
    def _easier(self) -> Iterable[AttitudeOcp]:
        """Return those before the last, the easiest first."""


class PenaltyContinuation(_Series):
    """Solve with soft penalties first, and harden them step by step.

    Parameters
    ----------
    ocp : AttitudeOcp
    options : ShootingOptions, optional
    """

    def _easier(self) -> Iterable[AttitudeOcp]:
        shares = [1.0]
        while _is_penalized(self._ocp) and shares[-1] > SMALLEST_SHARE * FACTOR:
            shares.append(shares[-1] / FACTOR)
        return [_softened(self._ocp, share) for share in reversed(shares[1:])]

    def solve(
        self, attitude: ArrayLike, momentum: ArrayLike, reference: Tracked | None = None
    ) -> Solution:
        """Return the solution at full penalties; its ``iterations`` count all problems' steps."""
        guess: Array | None = None
        iterations = 0
        for solver in self._solvers:
            solution = solver.solve(attitude, momentum, reference, guess)
            iterations += solution.iterations
            if np.isfinite(solution.costates).all():
                guess = solution.costates
        return solution.replace(iterations=iterations)


class StateContinuation:
    """Start on the target, at rest or moving with it, and move the initial state away.

    The solution there is zero, or the torque fed forward. The state moves along the shortest
    rotation with a momentum that changes in proportion; the step is halved where a solve fails.

    Parameters
    ----------
    ocp : AttitudeOcp
    options : ShootingOptions, optional
    long_way : bool
        Move along the same axis the other way round, by a full turn less: another minimum.
    """

    patience: float = math.inf

    def __init__(
        self, ocp: AttitudeOcp, options: ShootingOptions | None = None, *, long_way: bool = False
    ) -> None:
        self._solver = ShootingSolver(ocp, options=options)
        self._long_way = long_way

    def solve(
        self, attitude: ArrayLike, momentum: ArrayLike, reference: Tracked | None = None
    ) -> Solution:
        """Return the solution at the state asked for; its ``iterations`` count all steps made.

        Where the way is blocked it is the failed solve nearest to it.
        """
        tracked = as_reference(reference)
        target, spin = tracked.attitude, None
        if is_moving(tracked):
            spin = np.asarray(self._solver.ocp.inertia) @ tracked.angular_velocity
        R, Pi = as_rotation("attitude", attitude), as_vector3("momentum", momentum)
        turn = lie.log(target.T @ R)
        angle = float(np.linalg.norm(turn))
        if self._long_way and angle > 0.0:
            turn = turn * (1.0 - 2.0 * math.pi / angle)
        share, advance, iterations = 0.0, 0.25, 0
        guess: Array | None = None
        while True:
            following = min(1.0, share + advance)
            start = R if following == 1.0 else target @ lie.exp(following * turn)
            moved = following * Pi
            if spin is not None:
                moved = moved + (1.0 - following) * spin
            solution = self._solver.solve(start, moved, reference, guess)
            iterations += solution.iterations
            if solution.converged:
                share, guess = following, solution.costates
                advance *= 2.0
            else:
                advance *= 0.5
            if share == 1.0 or advance < SMALLEST_ADVANCE:
                return solution.replace(iterations=iterations)


class HorizonContinuation(_Series):
    """Solve the first step alone, and double the horizon up to the whole.

    The steps that are added start from zero torque. A solve that fails so is tried cold.

    Parameters
    ----------
    ocp : AttitudeOcp
    options : ShootingOptions, optional
    """

    def _easier(self) -> Iterable[AttitudeOcp]:
        horizon = self._ocp.horizon
        horizons = (horizon >> i for i in range(horizon.bit_length() - 1, 0, -1))
        return [replace(self._ocp, horizon=n) for n in horizons]

    def solve(
        self, attitude: ArrayLike, momentum: ArrayLike, reference: Tracked | None = None
    ) -> Solution:
        """Return the solution over the whole horizon; its ``iterations`` count all steps made."""
        guess: Array | None = None
        iterations = 0
        for solver in self._solvers:
            if guess is not None:
                guess = np.vstack([guess, np.zeros((solver.ocp.horizon - len(guess), 6))])
            solution = solver.solve(attitude, momentum, reference, guess)
            iterations += solution.iterations
            if guess is not None and not solution.converged:
                solution = solver.solve(attitude, momentum, reference)
                iterations += solution.iterations
            guess = solution.costates if solution.converged else None
        return solution.replace(iterations=iterations)


class EffortContinuation(_Series):
    """Make torque dear first, so that little of it is used, and cheapen it step by step.

    The penalty of the torque limit grows with the weight, so that the multipliers of one problem,
    cheapened alike, make the same torques in the next.

    Parameters
    ----------
    ocp : AttitudeOcp
    options : ShootingOptions, optional
    """

    def _easier(self) -> Iterable[AttitudeOcp]:
        return [_dear(self._ocp, factor) for factor in EFFORTS[:-1]]

    def solve(
        self, attitude: ArrayLike, momentum: ArrayLike, reference: Tracked | None = None
    ) -> Solution:
        """Return the solution at the true weight; its ``iterations`` count all problems' steps."""
        guess: Array | None = None
        iterations, weight = 0, 1.0
        for factor, solver in zip(EFFORTS, self._solvers, strict=True):
            start = None if guess is None else guess * (factor / weight)
            solution = solver.solve(attitude, momentum, reference, start)
            iterations += solution.iterations
            if solution.converged:
                guess, weight = solution.costates, factor
        return solution.replace(iterations=iterations)


class OpenContinuation(_Series):
    """Leave the zones out and move the initial state away from the target; then harden the zones.

    With zones, and near half a turn, the state also moves the other way round: the cheaper solution
    is returned.

    Parameters
    ----------
    ocp : AttitudeOcp
    options : ShootingOptions, optional
    """

    def _easier(self) -> Iterable[AttitudeOcp]:
        shares = HARDENING[:-1] if self._ocp.zones else ()
        return [_softer_zones(self._ocp, share) for share in shares]

    @cached_property
    def _ways(self) -> tuple[StateContinuation, StateContinuation]:
        """The short and the long way, without zones."""
        open_sky, options = replace(self._ocp, zones=()), self._options
        long = StateContinuation(open_sky, options, long_way=True)
        return StateContinuation(open_sky, options), long

    def solve(
        self, attitude: ArrayLike, momentum: ArrayLike, reference: Tracked | None = None
    ) -> Solution:
        """Return the solution with all zones; its ``iterations`` count all steps made."""
        target = as_reference(reference)
        problem = (as_rotation("attitude", attitude), as_vector3("momentum", momentum), target)
        angle = lie.angle_between(target.attitude, problem[0])
        ways = self._ways if self._ocp.zones or angle > NEAR_HALF_TURN else self._ways[:1]
        return cheapest(self._hardened(way.solve(*problem), problem) for way in ways)

    def _hardened(self, found: Solution, problem: tuple[Matrix3, Vector3, Reference]) -> Solution:
        iterations, guess = found.iterations, None
        for solver in self._solvers:
            guess = found.costates if found.converged else guess
            found = solver.solve(*problem, guess)
            iterations += found.iterations
        return found.replace(iterations=iterations)


class AutomaticContinuation:
    """Go by short horizons, by small torques and without zones, and take the cheapest solution.

    The last is left out over more than 60 steps, where it takes seconds. Where all fail, the
    penalties are softened, if there are any, and then the state is moved.

    Parameters
    ----------
    ocp : AttitudeOcp
    options : ShootingOptions, optional
    """

    patience: float = PATIENCE

    def __init__(self, ocp: AttitudeOcp, options: ShootingOptions | None = None) -> None:
        self._starts: tuple[Continuation, ...] = (
            HorizonContinuation(ocp, options),
            EffortContinuation(ocp, options),
        )
        if ocp.horizon <= LONG:
            self._starts += (OpenContinuation(ocp, options),)
        self._softer = (PenaltyContinuation(ocp, options),) if _is_penalized(ocp) else ()
        self._nearer = StateContinuation(ocp, options)

    def solve(
        self, attitude: ArrayLike, momentum: ArrayLike, reference: Tracked | None = None
    ) -> Solution:
        """Return the cheapest solution found; its ``iterations`` count all steps made."""
        problem = (attitude, momentum, reference)
        found = cheapest(way.solve(*problem) for way in self._starts)
        for way in (*self._softer, self._nearer):
            if not found.converged:
                found = cheapest((found, way.solve(*problem)))
        return found


def cheapest(solutions: Iterable[Solution]) -> Solution:
    """Return the converged solution of least cost, the first one where none converged.

    Its ``iterations`` are those of all. Of two whose costs differ by rounding only, the first wins.
    """
    given: Sequence[Solution] = tuple(solutions)
    best = given[0]
    for other in given[1:]:
        cheaper = other.converged and other.cost < best.cost - 1e-12 * abs(best.cost)
        if other.converged and (cheaper or not best.converged):
            best = other
    return best.replace(iterations=sum(solution.iterations for solution in given))


def _is_penalized(ocp: AttitudeOcp) -> bool:
    return ocp.max_torque > 0.0 or len(ocp.zones) > 0


def _softened(ocp: AttitudeOcp, share: float) -> AttitudeOcp:
    """Return the same problem with its penalties scaled down."""
    return replace(_softer_zones(ocp, share), torque_penalty=share * ocp.torque_penalty)


def _softer_zones(ocp: AttitudeOcp, share: float) -> AttitudeOcp:
    """Return the same problem with the penalties of its zones scaled down."""
    zones = tuple(replace(zone, penalty=share * zone.penalty) for zone in ocp.zones)
    return replace(ocp, zones=zones)


def _dear(ocp: AttitudeOcp, factor: float) -> AttitudeOcp:
    """Return the same problem with its torque dearer."""
    weights = replace(ocp.weights, stage_torque=factor * np.asarray(ocp.weights.stage_torque))
    return replace(ocp, weights=weights, torque_penalty=factor * ocp.torque_penalty)
