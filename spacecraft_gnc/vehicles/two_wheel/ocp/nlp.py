"""The problem of two wheels as a sparse nonlinear program of CasADi, with exact derivatives.

Unknowns, stage after stage: speeds nu_k+1 and attitude a_k+1, with the flow as equality conditions
(multiple shooting: the matrices are banded, and IPOPT takes half the time that it takes with the
speeds as the only unknowns). nu_N is fixed by its bounds. The formulas are written here once more,
not taken from the kernels of the own solver, whose reference this is.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.two_wheel.ocp.problem import WheelOcp

_TERMS = 10  # of the series of sine and cosine: exact to rounding up to a turn of pi in a step


class Program(NamedTuple):
    """Expressions of the program, and the bounds of its unknowns ``x`` and conditions ``g``."""

    x: Any
    p: Any
    f: Any
    g: Any
    low_x: Array
    high_x: Array
    low_g: Array
    high_g: Array
    costates: Any
    """Function (x, p, y) -> multipliers of the flows (na, N), y those of the terminal condition."""


def program(ocp: WheelOcp, soft: bool) -> Program:
    """Return the program; parameters are the first attitude, the first speeds and the drift.

    ``g`` holds N flows (na each), the terminal condition e_N = 0 (3; none where ``soft``), and the
    accelerations (2 N). All are in the prediction frame.
    """
    n, na, step = ocp.horizon, width(ocp), ocp.time_step
    first, nu_0, drift = ca.SX.sym("a", na), ca.SX.sym("nu", 2), ca.SX.sym("d", 3, n + 1)
    stages = ca.SX.sym("stage", 2 + na, n)
    nu, a = ca.horzcat(nu_0, stages[:2, :]), ca.horzcat(first, stages[2:, :])
    u = (nu[:, 1:] - nu[:, :-1]) / step
    w = ca.mtimes(ca.DM(ocp.rates), nu) + drift
    f, flows = ca.SX(0), []
    y = ca.SX.sym("y", 0 if soft else 3)
    for k in range(n):
        e = _coordinates(ocp.model, a[:, k])
        f += ca.dot(ca.DM(ocp.attitude_weights) * e, e)
        f += ocp.speed_weight * ca.dot(nu[:, k], nu[:, k])
        f += ocp.acceleration_weight * ca.dot(u[:, k], u[:, k])
        flows.append(a[:, k + 1] - _flow(ocp.model, step, a[:, k], w[:, k], w[:, k + 1]))
    last = _coordinates(ocp.model, a[:, n])
    terminal = ca.SX(0, 1) if soft else last
    if soft:
        f += ocp.terminal_weight * ca.dot(last, last)
    x, p = ca.vec(stages), ca.veccat(first, nu_0, drift)
    costates = _costates(f + ca.dot(y, terminal), flows, a)
    most = ocp.max_acceleration or math.inf
    high_x = np.full((n, 2 + na), math.inf)
    high_x[:, :2] = ocp.max_speed
    high_x[-1, :2] = 0.0
    closed = np.zeros(na * n + (0 if soft else 3))
    return Program(
        x=x,
        p=p,
        f=f,
        g=ca.vertcat(*flows, terminal, ca.vec(u)),
        low_x=-high_x.ravel(),
        high_x=high_x.ravel(),
        low_g=np.concatenate([closed, np.full(2 * n, -most)]),
        high_g=np.concatenate([closed, np.full(2 * n, most)]),
        costates=ca.Function("costates", [x, p, y], [costates]),
    )


def ipopt(program: Program, options: dict[str, Any]) -> Any:
    """Return IPOPT, with options of its own, for a program."""
    expressions = {"x": program.x, "p": program.p, "f": program.f, "g": program.g}
    settings: dict[str, Any] = {"print_time": False, "show_eval_warnings": False, "ipopt": options}
    return ca.nlpsol("two_wheels", "ipopt", expressions, settings)


def _costates(lagrangian: Any, flows: list[Any], a: Any) -> Any:
    """Return the multipliers of the flows that make the Lagrangian stationary in the attitudes."""
    later = -ca.gradient(lagrangian, a[:, -1])
    found = [later]
    for k in range(len(flows) - 1, 0, -1):
        pull = ca.jtimes(flows[k], a[:, k], later, True)
        later = -ca.gradient(lagrangian, a[:, k]) - pull
        found.insert(0, later)
    return ca.horzcat(*found)


def flows(ocp: WheelOcp) -> Any:
    """Return the function (a_0, w (3, N+1)) -> attitudes (na, N) of the nodes after the first."""
    a, w_0, w_1 = ca.SX.sym("a", width(ocp)), ca.SX.sym("w", 3), ca.SX.sym("w", 3)
    step = ca.Function("step", [a, w_0, w_1], [_flow(ocp.model, ocp.time_step, a, w_0, w_1)])
    return step.mapaccum(ocp.horizon)


def coordinates(ocp: WheelOcp) -> Any:
    """Return the function a -> e (3,)."""
    a = ca.SX.sym("a", width(ocp))
    return ca.Function("coordinates", [a], [_coordinates(ocp.model, a)])


def width(ocp: WheelOcp) -> int:
    """Return na: three angles of the simplified model, or the four components of a quaternion."""
    return 3 if ocp.model == "simplified" else 4


def _flow(model: str, h: float, a: Any, w_0: Any, w_1: Any) -> Any:
    if model == "simplified":
        # phi' = w_1, theta' = w_2, psi' = w_3 + w_2 phi with rates linear in time, in closed form.
        area = 3 * w_0[1] * w_0[0] + w_0[1] * w_1[0] + 5 * w_1[1] * w_0[0] + 3 * w_1[1] * w_1[0]
        yaw = h / 2 * (w_0[1] + w_1[1]) * a[0] + h**2 / 24 * area
        return a + h / 2 * (w_0 + w_1) + ca.vertcat(0, 0, yaw)
    turn = h / 2 * (w_0 + w_1) + h**2 / 12 * ca.cross(w_0, w_1)
    t = ca.dot(turn, turn) / 4
    cosine, sinc = _series(t, 0), _series(t, 1) / 2
    d, v = sinc * turn, a[1:4]
    return ca.vertcat(a[0] * cosine - ca.dot(v, d), a[0] * d + cosine * v + ca.cross(v, d))


def _series(t: Any, odd: int) -> Any:
    """Return sum of (-t)^k / (2k + odd)!: the cosine of sqrt(t), or its sine over itself."""
    total = ca.SX(0)
    for k in reversed(range(_TERMS + 1)):
        total = total * t + (-1) ** k / math.factorial(2 * k + odd)
    return total


def _coordinates(model: str, a: Any) -> Any:
    if model == "simplified":
        return a
    if model == "so3":
        return 2 * a[1:4]
    q, x, y, z = a[0], a[1], a[2], a[3]
    return ca.vertcat(
        ca.atan2(2 * (y * z + q * x), q * q - x * x - y * y + z * z),
        ca.asin(2 * (q * y - x * z)),
        ca.atan2(2 * (x * y + q * z), q * q + x * x - y * y - z * z),
    )
