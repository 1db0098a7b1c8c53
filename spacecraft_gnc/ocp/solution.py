"""What a solve returns."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, Final, NoReturn

import numpy as np
from typing_extensions import Self

from spacecraft_gnc.ocp._plan_kernels import NUMBERS, offsets
from spacecraft_gnc.ocp.reference import RESTING
from spacecraft_gnc.status import Status
from spacecraft_gnc.types import Array, Reference

if TYPE_CHECKING:
    from spacecraft_gnc.ocp.problem import AttitudeOcp

_STATUSES: Final = tuple(Status)


class PlanLayout:
    """Where the parts of a solver's flat plans stand, and what all its solutions share.

    Parameters
    ----------
    ocp : AttitudeOcp
        The problem solved.
    formulation : str
        How its conditions are solved.

    Attributes
    ----------
    size : int
        Length of a plan.
    """

    def __init__(self, ocp: AttitudeOcp, formulation: str) -> None:
        n, ends = ocp.horizon, offsets(ocp.horizon, len(ocp.zones))
        self.ocp, self.formulation, self.size = ocp, formulation, ends[-1]
        shapes = (
            (n + 1, 3, 3),
            (n + 1, 3),
            (n, 3),
            (n + 1, 6),
            (len(ocp.zones),),
            (NUMBERS,),
            (3, 3),
        )
        self._places = [
            (slice(*place), shape)
            for place, shape in zip(itertools.pairwise(ends), shapes, strict=True)
        ]
        self.numbers = ends[5]

    def part(self, plan: Array, i: int) -> Array:
        """Return part i of a plan."""
        place, shape = self._places[i]
        return plan[place].reshape(shape)

    def parts(self, plans: Array) -> Iterator[Array]:
        """Yield each part of n plans, stacked."""
        for place, shape in self._places:
            yield plans[:, place].reshape((len(plans), *shape))


_Maker = Callable[[Array, PlanLayout, int, float, Array], Any]
"""Makes a field of what a solve left: plan, its layout, status, time, feedforward."""


def _part(i: int) -> _Maker:
    return lambda plan, layout, *_: layout.part(plan, i)


def _number(i: int) -> _Maker:
    return lambda plan, layout, *_: plan.item(layout.numbers + i)


def _torque_margin(plan: Array, layout: PlanLayout, *_: Any) -> float:
    limit = layout.ocp.max_torque
    return limit - plan.item(layout.numbers + 5) ** 0.5 if limit > 0.0 else math.inf


_MAKERS: Final[dict[str, _Maker]] = {
    "torques": _part(2),
    "attitudes": _part(0),
    "momenta": _part(1),
    "multipliers": _part(3),
    "cost": _number(3),
    "status": lambda _plan, _layout, status, *_: _STATUSES[status],
    "iterations": lambda plan, layout, *_: int(plan.item(layout.numbers + 1)),
    "residual": _number(2),
    "solve_time": lambda _plan, _layout, _status, time, _motion: time,
    "torque_margin": _torque_margin,
    "reference": _part(6),
    "ocp": lambda _plan, layout, *_: layout.ocp,
    "formulation": lambda _plan, layout, *_: layout.formulation,
    "min_curvature": _number(4),
    "zone_margins": _part(4),
    "attitude_error": _number(6),
    "travel": _number(7),
    "terminal_level": lambda *_: math.nan,
    "terminal_multiplier": lambda *_: 0.0,
    "feedforward": lambda _plan, _layout, _status, _time, motion: motion,
}
"""Every field of a `Solution`, in order, and how it is made."""


class _Field:
    """Field of a solution, made when it is first asked for, and then kept in its dictionary.

    `functools.cached_property` takes a lock each time before Python 3.12.
    """

    def __init__(self, name: str, make: _Maker) -> None:
        self._name, self._make = name, make

    def __get__(self, solution: Any, _owner: object = None) -> Any:
        if solution is None:
            return self
        value = solution.__dict__[self._name] = self._make(*solution._made)  # noqa: SLF001 - its own
        return value


_put: Final = object.__setattr__


class Solution:
    """One solved horizon.

    Arrays belong to this solution alone and are not overwritten by later solves. Fields cannot be
    set; `replace` returns a solution with other ones.

    Attributes
    ----------
    torques : (N, 3) array
        Optimal body torques B u_0 .. B u_{N-1} [N m].
    attitudes : (N+1, 3, 3) array
        Predicted rotations, body to inertial.
    momenta : (N+1, 3) array
        Predicted angular momenta, body frame [N m s].
    multipliers : (N+1, 6) array
        `costates`, with the last row twice: what `warm_start` is cut from.
    cost : float
        (27) + (28) + penalties, constants included.
    status : Status
    iterations : int
        Newton steps taken.
    residual : float
        Euclidean norm of the first-order conditions over all stages, in the units of lambda2: of
        the costates run backward over the plan, minus the multipliers that its torques belong to.
    solve_time : float
        Wall time of the solve [s].
    torque_margin : float
        max_torque - max_k |u_k| [N m]; infinite without a limit.
    reference : (3, 3) array
        Attitude tracked at the start of the horizon, body to inertial.
    ocp : AttitudeOcp
        The problem solved.
    formulation : str
        How the conditions were solved, such as "backward_sweep".
    min_curvature : float
        Smallest pivot of the cost's second derivative to the torques, swept backward [(N m)^-2]. A
        stationary point is a strict local minimum exactly where it is positive. Of the last
        linearization, one Newton step from the solution; NaN where the solve did not converge.
    zone_margins : array
        Smallest angle [rad] to each zone over the predicted attitudes (negative: inside).
    attitude_error : float
        Angle [rad] from the reference at the start of the horizon.
    travel : float
        Angle [rad] between the first and the last predicted attitude.
    terminal_level : float
        |(Z_N, Pi_N)|_P^2 where the problem has a terminal set; NaN without one.
    terminal_multiplier : float
        Multiplier nu >= 0 of the terminal set; ``ocp`` then has (1 + nu) F as its terminal cost.
    feedforward : (2, 3) array
        Angular velocity [rad/s] and torque [N m] with which that attitude moves.
    """

    torques: Array
    attitudes: Array
    momenta: Array
    multipliers: Array
    cost: float
    status: Status
    iterations: int
    residual: float
    solve_time: float
    torque_margin: float
    reference: Array
    ocp: AttitudeOcp
    formulation: str
    min_curvature: float
    zone_margins: Array
    attitude_error: float
    travel: float
    terminal_level: float
    terminal_multiplier: float
    feedforward: Array

    def __init__(
        self,
        torques: Array,
        attitudes: Array,
        momenta: Array,
        multipliers: Array,
        cost: float,
        status: Status,
        iterations: int,
        residual: float,
        solve_time: float,
        torque_margin: float,
        reference: Array,
        ocp: AttitudeOcp,
        formulation: str,
        min_curvature: float,
        zone_margins: Array,
        attitude_error: float,
        travel: float,
        terminal_level: float = math.nan,
        terminal_multiplier: float = 0.0,
        feedforward: Array = RESTING,
    ) -> None:
        fields = (
            torques, attitudes, momenta, multipliers, cost, status, iterations, residual,
            solve_time, torque_margin, reference, ocp, formulation, min_curvature, zone_margins,
            attitude_error, travel, terminal_level, terminal_multiplier, feedforward,
        )  # fmt: skip
        for name, value in zip(_MAKERS, fields, strict=True):
            _put(self, name, value)

    @classmethod
    def of_plan(
        cls,
        plan: Array,
        layout: PlanLayout,
        status: int,
        solve_time: float,
        feedforward: Array = RESTING,
    ) -> Self:
        """Return the solution that a kernel left in a flat plan, which is its own from now on."""
        solution = object.__new__(cls)
        _put(solution, "_made", (plan, layout, status, solve_time, feedforward))
        return solution

    def __setattr__(self, name: str, value: object) -> NoReturn:
        """Refuse: a solution stays as it was found."""
        raise AttributeError(f"{name}: a solution cannot be changed; use replace({name}=...)")

    def __reduce__(self) -> tuple[type[Solution], tuple[Any, ...]]:
        """Copy and pickle the fields."""
        return type(self), self._fields()

    def _fields(self) -> tuple[Any, ...]:
        return tuple(getattr(self, name) for name in _MAKERS)

    def replace(self, **changes: Any) -> Self:
        """Return this solution with other values of some fields."""
        return type(self)(**(dict(zip(_MAKERS, self._fields(), strict=True)) | changes))

    def __repr__(self) -> str:
        """Return how the solve ended, in one line."""
        error = math.degrees(self.attitude_error)
        return (
            f"Solution({self.status.name} after {self.iterations} iterations, residual "
            f"{self.residual:.2g}, cost {self.cost:.6g}, {error:.4g} deg from the reference, "
            f"{len(self.torques)} steps, {1e6 * self.solve_time:.3g} us)"
        )

    def plain(self) -> tuple[Any, ...]:
        """Return its fields as numbers, texts and arrays alone; of the problem, nothing."""
        return self.replace(ocp=None, status=int(self.status))._fields()

    @classmethod
    def of_plain(cls, fields: tuple[Any, ...], ocp: AttitudeOcp) -> Self:
        """Return the solution of a problem whose `plain` fields these are."""
        found = cls(*fields)
        if found.terminal_multiplier > 0.0:
            ocp = ocp.weighted(found.terminal_multiplier)  # type: ignore[attr-defined]
        return found.replace(ocp=ocp, status=Status(found.status))

    @property
    def tracked(self) -> Reference:
        """The reference of the solve."""
        return Reference(self.reference, *self.feedforward)

    @property
    def converged(self) -> bool:
        """Whether the first-order conditions hold within the tolerance, at a minimum."""
        return self.status == Status.CONVERGED

    @property
    def costates(self) -> Array:
        """(N, 6) multipliers (lambda1_k, lambda2_k) in the paper's scaling, half the true ones."""
        return self.multipliers[:-1]

    @property
    def warm_start(self) -> Array | None:
        """Multipliers (N, 6) to start the next solve from, one step on; None if this one failed."""
        return self.multipliers[1:] if self.converged else None

    @property
    def controls(self) -> Array:
        """(N, m) optimal controls u_k, of which B makes the torques [N m]: the cheapest that do."""
        ocp = self.ocp
        B = ocp.torque_map
        if B.shape[1] != 3 or np.linalg.matrix_rank(B) == 3:  # of one weight, or the only ones
            return np.asarray(self.torques @ ocp.allocation.T)
        cheap = ocp.control_axes / np.sqrt(ocp.control_weights)
        return np.asarray((cheap @ (np.linalg.pinv(B @ cheap) @ self.torques.T)).T)


for _name, _make in _MAKERS.items():
    setattr(Solution, _name, _Field(_name, _make))
