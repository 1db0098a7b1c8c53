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
from spacecraft_gnc.vehicles.two_wheel.ocp.certificate import reduced_curvature
from spacecraft_gnc.vehicles.two_wheel.ocp.problem import WheelOcp
from spacecraft_gnc.vehicles.two_wheel.ocp.search import IDENTITY, Found, solve
from spacecraft_gnc.vehicles.two_wheel.ocp.solution import WarmStart, WheelSolution
from spacecraft_gnc.vehicles.two_wheel.ocp.starts import within

_STATUS: Final = {
    "Solve_Succeeded": Status.CONVERGED,
    "Maximum_Iterations_Exceeded": Status.MAX_ITERATIONS,
    "Infeasible_Problem_Detected": Status.INFEASIBLE,
    "Invalid_Number_Detected": Status.NOT_FINITE,
}
_OPTIONS: Final[dict[str, Any]] = {
    "print_level": 0,
    "sb": "yes",
    "bound_relax_factor": 0.0,  # bounds are kept exactly
    "mumps_permuting_scaling": 0,  # 15 % faster on these matrices
    "mumps_scaling": 0,
}
_LEAST: Final = 1e-6
_WARM: Final[dict[str, Any]] = {
    "warm_start_init_point": "yes",
    "mu_init": _LEAST,
    **{
        f"warm_start_{kind}": _LEAST
        for kind in ("bound_push", "bound_frac", "slack_bound_push", "slack_bound_frac",
                     "mult_bound_push")
    },
}  # fmt: skip
"""For a plan and multipliers that are nearly optimal: 4 iterations where the defaults take 10."""


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
        search: bool = True,
    ) -> WheelSolution:
        """Find the plan from a state to rest at a reference, as `SqpSolver.solve`."""
        return solve(
            self.ocp, self._run, _curvature, self.restarts, self.seed,
            attitude, wheel_speed, reference, drift, warm_start, soft, search,
        )  # fmt: skip

    def _get(self, soft: bool) -> _Built:
        """Return what belongs to one kind of end, built at its first use."""
        if soft not in self.built:
            self.built[soft] = _build(self.ocp, soft, self.tolerance, self.max_iterations)
        return self.built[soft]

    def _run(
        self,
        first: Array,
        speeds: Array,
        rates: Array,
        soft: bool,
        warm: WarmStart | None,
        firm: bool,  # IPOPT has no price
    ) -> Found:
        """Return what one start leads to."""
        built, ocp = self._get(soft), self.ocp
        p, n, na = built.program, ocp.horizon, first.size
        x = np.column_stack([speeds[1:], _rolled_out(built, ocp, first, speeds, rates)]).ravel()
        given = np.concatenate([first, speeds[0], rates.ravel()])
        ipopt, multipliers = built.cold, {}
        rows = 0 if soft else 3
        if warm is not None and warm.terminal.size == rows + 2:
            ipopt, multipliers = built.warm, _multipliers(p, x, given, warm, na)
        out = ipopt(
            x0=x, p=given, **multipliers,
            lbx=p.low_x, ubx=p.high_x, lbg=p.low_g, ubg=p.high_g,
        )  # fmt: skip
        stats = ipopt.stats()
        stages = np.asarray(out["x"]).reshape(n, 2 + na)
        prices = np.asarray(out["lam_x"]).reshape(n, 2 + na)[:, :2]
        prices[-1] = 0.0  # nu_N is no bound
        lam = np.asarray(out["lam_g"]).ravel()
        status = _STATUS.get(stats["return_status"], Status.LINE_SEARCH_FAILED)
        if status != Status.CONVERGED:  # its flows and limits are violated: make it a plan
            near = within(ocp, np.vstack([speeds[0], stages[:, :2]]), speeds[0])
            stages = np.column_stack([near[1:], _rolled_out(built, ocp, first, near, rates)])
        e = np.asarray(built.coordinates(stages[-1, 2:])).ravel()
        report = np.array(
            [stats["iter_count"], _residual(stats), float(out["f"]), np.abs(e).sum(), 0.0]
        )
        terminal = lam[n * na : n * na + rows]
        return Found(
            status,
            np.vstack([speeds[0], stages[:, :2]]),
            np.vstack([first, stages[:, 2:]]),
            np.append(terminal, np.zeros(2)),
            np.column_stack([prices, lam[-2 * n :].reshape(n, 2)]),
            report,
            (ipopt, out["x"], given, out["lam_g"], rows),
        )


def _curvature(found: Found) -> float:
    """Return the least curvature of a plan by the accelerations, from CasADi's derivatives."""
    ipopt, x, given, lam, rows = found.matrices
    upper = ipopt.get_function("nlp_hess_l")(x, given, 1.0, lam).full()
    hessian = upper + np.triu(upper, 1).T
    jacobian = ipopt.get_function("nlp_jac_g")(x, given)[1].full()
    n, na = found.speeds.shape[0] - 1, found.attitudes.shape[1]
    accelerations = jacobian[-2 * n :].reshape(2 * n, n, 2 + na)[:, :, :2].reshape(2 * n, 2 * n)
    active = found.active
    motion = np.empty((n, 2 + na, 2 * n))
    motion[:, :2] = np.linalg.inv(accelerations).reshape(n, 2, 2 * n)
    flows = jacobian[: n * na].reshape(n * na, n, 2 + na)
    by_speed, by_attitude = flows[:, :, :2].reshape(n * na, -1), flows[:, :, 2:].reshape(n * na, -1)
    turned = np.linalg.solve(by_attitude, by_speed @ motion[:, :2].reshape(2 * n, 2 * n))
    motion[:, 2:] = -turned.reshape(n, na, 2 * n)
    flat = motion.reshape(-1, 2 * n)
    conditions = [
        jacobian[n * na : n * na + rows] @ flat,
        motion[-1, :2],
        motion[:-1, :2][active[:-1, :2]],
        np.eye(2 * n)[active[:, 2:].ravel()],
    ]
    return reduced_curvature(flat.T @ hessian @ flat, np.vstack(conditions))


def _rolled_out(built: _Built, ocp: WheelOcp, first: Array, speeds: Array, rates: Array) -> Array:
    """Return the attitudes (N, na) after the first that speeds (N+1, 2) lead to."""
    w = (speeds @ ocp.rates.T + rates).T
    return np.asarray(built.flows(first, w[:, :-1], w[:, 1:])).T


def _multipliers(p: Any, x: Array, given: Array, warm: WarmStart, na: int) -> dict[str, Array]:
    """Return the multipliers of a warm start, in the order of the program."""
    y = warm.terminal[:-2]
    flows = np.asarray(p.costates(x, given, y)).T
    stages = np.column_stack([warm.bounds[:, :2], np.zeros((len(flows), na))])
    return {
        "lam_x0": stages.ravel(),
        "lam_g0": np.concatenate([flows.ravel(), y, warm.bounds[:, 2:].ravel()]),
    }


def _build(ocp: WheelOcp, soft: bool, tolerance: float, most: int) -> _Built:
    with explained_imports():
        from spacecraft_gnc.vehicles.two_wheel.ocp import nlp

    program = nlp.program(ocp, soft)
    options = {**_OPTIONS, "tol": tolerance, "max_iter": most}
    cold, warm = (nlp.ipopt(program, more) for more in (options, options | _WARM))
    return _Built(program, cold, warm, nlp.flows(ocp), nlp.coordinates(ocp))


def _residual(stats: dict[str, Any]) -> float:
    history = stats.get("iterations", {})
    if not history:
        return math.inf
    return float(max(history["inf_pr"][-1], history["inf_du"][-1]))
