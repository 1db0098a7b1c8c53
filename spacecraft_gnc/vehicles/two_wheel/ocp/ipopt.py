"""IPOPT as the reference of the own solver: the same problem, in CasADi, with exact derivatives."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Final, NamedTuple

import numpy as np

from spacecraft_gnc.arguments import as_count, require_kind, require_positive
from spacecraft_gnc.extras import explained_imports
from spacecraft_gnc.status import Status
from spacecraft_gnc.types import Array, ArrayLike
from spacecraft_gnc.vehicles.two_wheel.ocp.problem import WheelOcp
from spacecraft_gnc.vehicles.two_wheel.ocp.search import solve
from spacecraft_gnc.vehicles.two_wheel.ocp.solution import WarmStart, WheelSolution
from spacecraft_gnc.vehicles.two_wheel.ocp.sqp import IDENTITY, Found

_STATUS: Final = {
    "Solve_Succeeded": Status.CONVERGED,
    "Maximum_Iterations_Exceeded": Status.MAX_ITERATIONS,
    "Infeasible_Problem_Detected": Status.INFEASIBLE,
    "Invalid_Number_Detected": Status.NOT_FINITE,
}
_OPTIONS: Final = {
    "print_level": 0,
    "sb": "yes",
    "bound_relax_factor": 0.0,  # bounds are kept exactly
    "mumps_permuting_scaling": 0,  # 15 % faster on these matrices
    "mumps_scaling": 0,
}
_WARM: Final = {
    "mu_init": 1e-3,
    "bound_push": 1e-3,
    "bound_frac": 1e-3,
    "slack_bound_push": 1e-3,
    "slack_bound_frac": 1e-3,
}
"""For a plan that is nearly optimal: 40 % fewer iterations than with the defaults."""


class _Built(NamedTuple):
    """What is built once per problem and kind of end."""

    program: Any
    cold: Any
    warm: Any
    flows: Any
    coordinates: Any


@dataclass(frozen=True, slots=True, eq=False)
class IpoptSolver:
    """Solve a `WheelOcp` with CasADi and IPOPT, which takes longer than `SqpSolver`.

    Attributes and exceptions are those of `SqpSolver`; besides:

    Raises
    ------
    MissingDependency
        If CasADi is not installed.

    Notes
    -----
    Multiple shooting in the speeds and attitudes of all nodes, exact Hessian, MUMPS. Of several
    formulations the fastest was taken (docs/underactuated.md). The multipliers of a warm start are
    not used: they took IPOPT no fewer iterations.
    """

    ocp: WheelOcp
    tolerance: float = 1e-8
    max_iterations: int = 200
    restarts: int = 3
    seed: int = 0
    built: dict[bool, _Built] = field(init=False, repr=False, default_factory=dict)

    def __post_init__(self) -> None:
        require_kind("ocp", self.ocp, WheelOcp)
        require_positive("tolerance", self.tolerance)
        as_count("max_iterations", self.max_iterations)
        as_count("restarts", self.restarts, least=0)
        self._get(False)

    def solve(
        self,
        attitude: ArrayLike,
        wheel_speed: ArrayLike,
        reference: ArrayLike = IDENTITY,
        *,
        drift: ArrayLike | None = None,
        warm_start: WarmStart | None = None,
        soft: bool = False,
    ) -> WheelSolution:
        """Find the plan from a state to rest at a reference, as `SqpSolver.solve`."""
        return solve(
            self.ocp, self._run, self.restarts, self.seed,
            attitude, wheel_speed, reference, drift, warm_start, soft,
        )  # fmt: skip

    def _get(self, soft: bool) -> _Built:
        """Return what belongs to one kind of end, built at its first use."""
        if soft not in self.built:
            self.built[soft] = _build(self.ocp, soft, self.tolerance, self.max_iterations)
        return self.built[soft]

    def _run(
        self, first: Array, speeds: Array, rates: Array, soft: bool, warm: WarmStart | None
    ) -> Found:
        """Return what one start leads to."""
        built, ocp = self._get(soft), self.ocp
        p, n, na = built.program, ocp.horizon, first.size
        w = (speeds @ ocp.rates.T + rates).T
        a = np.asarray(built.flows(first, w[:, :-1], w[:, 1:])).T
        ipopt = built.cold if warm is None else built.warm
        out = ipopt(
            x0=np.column_stack([speeds[1:], a]).ravel(),
            p=np.concatenate([first, speeds[0], rates.ravel()]),
            lbx=p.low_x, ubx=p.high_x, lbg=p.low_g, ubg=p.high_g,
        )  # fmt: skip
        stats = ipopt.stats()
        stages = np.asarray(out["x"]).reshape(n, 2 + na)
        prices = np.asarray(out["lam_x"]).reshape(n, 2 + na)[:, :2]
        prices[-1] = 0.0  # nu_N is no bound
        lam = np.asarray(out["lam_g"]).ravel()
        e = np.asarray(built.coordinates(stages[-1, 2:])).ravel()
        report = np.array(
            [stats["iter_count"], _residual(stats), float(out["f"]), np.abs(e).sum(), 0.0]
        )
        status = _STATUS.get(stats["return_status"], Status.LINE_SEARCH_FAILED)
        terminal = lam[n * na : n * na + (0 if soft else 3)]
        return Found(
            status,
            np.vstack([speeds[0], stages[:, :2]]),
            np.vstack([first, stages[:, 2:]]),
            np.append(terminal, np.zeros(2)),
            np.column_stack([prices, lam[-2 * n :].reshape(n, 2)]),
            report,
        )


def _build(ocp: WheelOcp, soft: bool, tolerance: float, most: int) -> _Built:
    with explained_imports():
        import casadi as ca
    from spacecraft_gnc.vehicles.two_wheel.ocp import nlp

    program = nlp.program(ocp, soft)
    options = {**_OPTIONS, "tol": tolerance, "max_iter": most}
    expressions = {"x": program.x, "p": program.p, "f": program.f, "g": program.g}

    def ipopt(**more: float) -> Any:
        settings = {"print_time": False, "ipopt": {**options, **more}}
        return ca.nlpsol("two_wheels", "ipopt", expressions, settings)

    return _Built(program, ipopt(), ipopt(**_WARM), nlp.flows(ocp), nlp.coordinates(ocp))


def _residual(stats: dict[str, Any]) -> float:
    history = stats.get("iterations", {})
    if not history:
        return math.inf
    return float(max(history["inf_pr"][-1], history["inf_du"][-1]))
