"""The random problems as a nonlinear program in CasADi, one for each horizon.

Independent of the package: the state is (e, g), the unit quaternion of the attitude relative to the
reference and the Rodrigues vector of one step's relative rotation F. The integrator is explicit in
it: with b(g) = (J g + g x J g) / (1 + g.g) = h Pi / 2 and b'(g) = (J g - g x J g) / (1 + g.g) =
h F^T Pi / 2 it reads e+ = e o (1, g) / sqrt(1 + g.g) and b(g+) = b'(g) + h^2 B u / 2. The state
after the last step is (e, h Pi / 2). The cost is a sum of squares: with S = (tr(Q) I - Q) / 2,
|Q^(1/2) (R - I)|_F^2 / 2 = 4 v.S v, v the vector part of e, and |Q^(1/2) hat(x)|_F^2 / 2 = x.S x.
h = 1; controls are counted in units of the limit.
"""

# ruff: noqa: N803 - the symbols are the paper's

from __future__ import annotations

from functools import cache
from typing import Any

import casadi as ca
import numpy as np

ZONES = 4
STATE = 7  # numbers of (e, g)
ZONE = 9  # body axis, inertial axis, cosine, sign, penalty


class Program:
    """Cost, dynamics and their derivatives over N steps, and the same as a program for IPOPT."""

    def __init__(self, horizon: int, controls: int) -> None:
        self.horizon, self.controls = horizon, controls
        self.names, self.shapes, inner, self.last = stages(controls)
        self.inner = {name: part.map(horizon - 1) for name, part in inner.items() if horizon > 1}
        self._parts = [inner] * (horizon - 1) + [self.last]

    def pack(self, values: dict[str, Any]) -> np.ndarray:
        """Return the parameters as one vector."""
        flat = [
            np.asarray(values[name], float).reshape(self.shapes[name]).ravel(order="F")
            for name in self.names
        ]
        return np.concatenate(flat)

    def over_stages(self, name: str, *arguments: np.ndarray) -> np.ndarray:
        """Return a function of all stages, the last axis over the stages."""
        n, found = self.horizon, []
        if n > 1:
            first = [a[:, : n - 1] if a.ndim == 2 else a for a in arguments]
            found.append(self.inner[name](*first).full())
        end = [a[:, n - 1] if a.ndim == 2 else a for a in arguments]
        found.append(self.last[name](*end).full())
        rows = found[0].shape[0]
        return np.concatenate([part.reshape(rows, -1, order="F") for part in found], axis=1)

    def solver(self, options: dict[str, Any]) -> ca.Function:
        """Return IPOPT on x = (v_0, x_1, v_1, .., x_N) with p = (x_0, parameters)."""
        n, m = self.horizon, self.controls
        x = ca.SX.sym("x", n * (m + STATE))
        p = ca.SX.sym("p", STATE + sum(a * b for a, b in self.shapes.values()))
        gamma, multipliers = ca.SX.sym("gamma"), ca.SX.sym("multipliers", n * STATE)
        cost, defects, size = ca.SX(0), [], x.numel()
        slope = ca.SX.zeros(size)
        jacobian, hessian = ca.SX(n * STATE, size), ca.SX(size, size)
        for k, part in enumerate(self._parts):
            at = k * (m + STATE)
            places = list(range(at - STATE, at)) * (k > 0) + list(range(at, at + m + STATE))
            state = x[at - STATE : at] if k > 0 else p[:STATE]
            kept = list(range(STATE * (k == 0), 2 * STATE + m))
            w, q = ca.vertcat(state, x[at : at + m + STATE]), p[STATE:]
            rows = list(range(k * STATE, (k + 1) * STATE))
            cost += part["cost"](w, q)
            defects.append(part["defect"](w, q))
            slope[places] += part["slope"](w, q)[kept]
            jacobian[rows, places] = part["jacobian"](w, q)[:, kept]
            hessian[places, places] += part["hessian"](w, q, gamma, multipliers[rows])[kept, kept]
        defect = ca.vertcat(*defects)
        given = {
            "grad_f": ca.Function("grad_f", [x, p], [cost, slope]),
            "jac_g": ca.Function("jac_g", [x, p], [defect, jacobian]),
            "hess_lag": ca.Function("hess_lag", [x, p, gamma, multipliers], [ca.triu(hessian)]),
        }
        return ca.nlpsol(
            "ipopt", "ipopt", {"x": x, "p": p, "f": cost, "g": defect}, options | given
        )


@cache
def stages(
    controls: int,
) -> tuple[
    tuple[str, ...], dict[str, tuple[int, int]], dict[str, ca.Function], dict[str, ca.Function]
]:
    """Return names and shapes of the parameters, and the functions of a stage and of the last."""
    parts = _parameters(controls)
    p = ca.vertcat(*(ca.vec(part) for part in parts.values()))
    inner, last = (_stage(parts, p, controls, end) for end in (False, True))
    return tuple(parts), {name: part.shape for name, part in parts.items()}, inner, last


def _parameters(controls: int) -> dict[str, ca.SX]:
    square = {name: ca.SX.sym(name, 3, 3) for name in ("J", "S1", "S2", "T1", "T2")}
    return square | {
        "D": ca.SX.sym("D", controls, controls),
        "B": ca.SX.sym("B", 3, controls),
        "limit": ca.SX.sym("limit"),
        "scale": ca.SX.sym("scale"),
        "penalty": ca.SX.sym("penalty"),
        "cost_scale": ca.SX.sym("cost_scale"),
        "zones": ca.SX.sym("zones", ZONE, ZONES),
    }


def product(e: ca.SX, g: ca.SX) -> ca.SX:
    """Return the quaternion e o (1, g) / sqrt(1 + g.g), scalar part first."""
    s, v = e[0], e[1:]
    turned = ca.vertcat(s - ca.dot(v, g), v + s * g + ca.cross(v, g))
    return turned / ca.sqrt(1 + ca.dot(g, g))


def pushed(J: ca.SX, g: ca.SX, sign: float) -> ca.SX:
    """Return b(g) for sign 1, b'(g) for sign -1."""
    Jg = J @ g
    return (Jg + sign * ca.cross(g, Jg)) / (1 + ca.dot(g, g))


def _state_cost(e: ca.SX, b: ca.SX, S1: ca.SX, S2: ca.SX) -> ca.SX:
    return 4 * ca.bilin(S1, e[1:], e[1:]) + 4 * ca.bilin(S2, b, b)


def _zone_cost(zones: ca.SX, e: ca.SX) -> ca.SX:
    s, v = e[0], e[1:]
    total = 0
    for i in range(ZONES):
        zone = zones[:, i]
        body, inertial = zone[:3], zone[3:6]
        # R^T d by the conjugate quaternion.
        t = 2 * ca.cross(v, inertial)
        seen = inertial - s * t + ca.cross(v, t)
        excess = ca.fmax(0, zone[7] * (ca.dot(body, seen) - zone[6]))
        total += zone[8] * excess**2
    return total


def _effort(parts: dict[str, ca.SX], v: ca.SX) -> ca.SX:
    scale, limit = parts["scale"], parts["limit"]
    excess = ca.fmax(0, ca.dot(v, v) - (limit / scale) ** 2)
    # Without a limit the penalty is given as zero.
    return scale**2 * ca.bilin(parts["D"], v, v) + parts["penalty"] * (scale**2 * excess) ** 2


def _stage(parts: dict[str, ca.SX], p: ca.SX, controls: int, last: bool) -> dict[str, ca.Function]:
    """Return cost, defect and derivatives of one stage to w = (x, v, x+); the cost is scaled."""
    x, v, following = ca.SX.sym("x", STATE), ca.SX.sym("v", controls), ca.SX.sym("y", STATE)
    e, g = x[:4], x[4:]
    J = parts["J"]
    b = pushed(J, g, 1.0)
    states = _state_cost(e, b, parts["S1"], parts["S2"]) + _zone_cost(parts["zones"], e)
    end = _state_cost(following[:4], following[4:], parts["T1"], parts["T2"]) if last else 0
    cost = parts["cost_scale"] * (states + _effort(parts, v) + end)
    torque = parts["scale"] * (parts["B"] @ v)
    reached = following[4:] if last else pushed(J, following[4:], 1.0)
    defect = ca.vertcat(following[:4] - product(e, g), reached - pushed(J, g, -1.0) - 0.5 * torque)
    w, multipliers = ca.vertcat(x, v, following), ca.SX.sym("l", STATE)
    factor = ca.SX.sym("f")
    hessian, _ = ca.hessian(factor * cost + ca.dot(multipliers, defect), w)
    return {
        "cost": ca.Function("cost", [w, p], [cost]),
        "defect": ca.Function("defect", [w, p], [defect]),
        "slope": ca.Function("slope", [w, p], [ca.gradient(cost, w)]),
        "jacobian": ca.Function("jacobian", [w, p], [ca.jacobian(defect, w)]),
        "hessian": ca.Function("hessian", [w, p, factor, multipliers], [hessian]),
    }
