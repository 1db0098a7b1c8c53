"""Audit of recorded plans of torques on the bus, by its own integration, cost and derivatives.

The integrator of the plans is h hat(Pi) = F Jd - Jd F^T, R+ = R F, Pi+ = F^T Pi + h T (Kalabic et
al. 2014, (3)). With F = exp(hat(f)) the first equation is

    h Pi = sin|f| / |f| J f + (1 - cos|f|) / |f|^2 f x J f.

Only weights and limits are taken from the method (`torque_problem`). Derivatives come from
imaginary steps, exact to rounding.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.audit.evidence import Evidence
from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.recording.columns import Columns
from spacecraft_gnc.signals.attitude import REFERENCE
from spacecraft_gnc.status import Status
from spacecraft_gnc.types import Array, Matrix3
from spacecraft_gnc.vehicles.two_wheel.controllers.shooting.problem import torque_problem
from spacecraft_gnc.vehicles.two_wheel.dynamics import Gyrostat
from spacecraft_gnc.vehicles.two_wheel.signals import COMMAND, SOLVER_STATUS, STATE

if TYPE_CHECKING:
    from spacecraft_gnc.vehicles.two_wheel.scenario import Scenario

MODEL: Final = "rigid_body"
STEP: Final = 1e-20
"""Imaginary step."""
_SOLVES: Final = 10  # Newton steps for a turn; each squares the error, but for terms of third order
_LIMITS: Final = {
    "torque plan = own integration": ("flow", "predicted_attitudes", 1e-9),
    "cost of the torque plan": ("cost", "cost", 1e-9),
    "first-order conditions of the torque plan": ("residual", "predicted_torques", 1e-5),
}


class _Found(NamedTuple):
    """What is wrong with one plan."""

    flow: float
    """Largest difference of an attitude."""
    cost: float
    """Relative."""
    residual: float
    """Largest derivative of the cost, over that of the torques' own part."""


@dataclass(frozen=True, slots=True, eq=False)
class TorqueProblem:
    """Problem of the bus with some of its wheels."""

    inertia: Matrix3
    period: float
    attitude_weights: tuple[Array, Array]
    """(3, 3) of a stage and of the end."""
    momentum_weights: tuple[Array, Array]
    torque_weight: Array
    max_torque: float
    penalty: float

    @classmethod
    def of(cls, scenario: Scenario, healthy: NDArray[np.bool_]) -> TorqueProblem:
        """Return that of a scenario's section ``nmpc_controller``."""
        c, n = scenario.controller, scenario.controller.torque_horizon
        believed = Gyrostat(
            c.inertia, c.wheel_axes, c.wheel_inertias, scenario.period, c.max_wheel_speed,
            c.max_wheel_acceleration,
        )  # fmt: skip
        allocation = np.linalg.pinv((believed.wheel_axes * believed.wheel_inertias)[:, healthy])
        ocp = torque_problem(believed, np.asarray(allocation), c.feedback_bandwidth, n)
        w = {name: np.asarray(getattr(ocp.weights, name)) for name in ocp.weights.__slots__}
        return cls(
            believed.inertia,
            scenario.period,
            (w["stage_attitude"], w["terminal_attitude"]),
            (_of_vectors(w["stage_momentum"]), _of_vectors(w["terminal_momentum"])),
            _of_vectors(w["stage_torque"]),
            ocp.max_torque,
            ocp.torque_penalty,
        )

    def roll_out(self, error: Array, momentum: Array, torques: Any) -> tuple[Any, Any]:
        """Return errors (b, N+1, 3, 3) and momenta (b, N+1, 3) under torques (b, N, 3)."""
        b, n = torques.shape[:2]
        errors = np.empty((b, n + 1, 3, 3), dtype=torques.dtype)
        momenta = np.empty((b, n + 1, 3), dtype=torques.dtype)
        errors[:, 0], momenta[:, 0] = error, momentum
        for k in range(n):
            turn = self._turn(momenta[:, k])
            errors[:, k + 1] = errors[:, k] @ turn
            carried = np.einsum("bji,bj->bi", turn, momenta[:, k])
            momenta[:, k + 1] = carried + self.period * torques[:, k]
        return errors, momenta

    def _turn(self, momentum: Any) -> Any:
        """Return F (b, 3, 3) for momenta (b, 3)."""
        f = self.period * momentum @ np.linalg.inv(self.inertia)
        for _ in range(_SOLVES):
            a, c = _shares(f)
            own = f @ self.inertia
            off = a * own + c * np.cross(f, own) - self.period * momentum
            slope = a[..., None] * self.inertia + c[..., None] * (
                _hat(f) @ self.inertia - _hat(own)
            )
            f = f - np.linalg.solve(slope, off[..., None])[..., 0]
        a, c = _shares(f)
        hat = _hat(f)
        return np.eye(3) + a[..., None] * hat + c[..., None] * hat @ hat

    def cost(self, errors: Any, momenta: Any, torques: Any) -> Any:
        """Return the cost (b,) of plans."""
        off = errors - np.eye(3)
        h, total = self.period, 0.0
        for part, share in ((slice(0, -1), h), (slice(-1, None), 1.0)):
            which = int(share == 1.0 and part.start == -1)
            q, p = self.attitude_weights[which], self.momentum_weights[which]
            attitudes, speeds = off[:, part], momenta[:, part]
            total = total + 0.5 * share * np.einsum("bkij,il,bklj->b", attitudes, q, attitudes)
            total = total + 0.5 * share * np.einsum("bki,ij,bkj->b", speeds, p, speeds)
        return total + self.effort(torques)

    def effort(self, torques: Any) -> Any:
        """Return the part of the torques and of the penalty of their limit (b,)."""
        own = 0.5 * self.period * np.einsum("bki,ij,bkj->b", torques, self.torque_weight, torques)
        if not self.max_torque:
            return own
        beyond = np.sum(torques**2, axis=2) - self.max_torque**2
        squares = np.where(beyond.real > 0.0, beyond, 0.0) ** 2
        return own + self.period * self.penalty * np.sum(squares, axis=1)

    def examine(self, error: Array, momentum: Array, torques: Array) -> tuple[Array, float, float]:
        """Return the errors (N+1, 3, 3), the cost and the residual of a plan."""
        errors, momenta = self.roll_out(error, momentum, torques[None])
        cost = float(self.cost(errors, momenta, torques[None])[0])
        steps = torques + 1j * STEP * np.eye(torques.size).reshape(-1, *torques.shape)
        slopes = self.cost(*self.roll_out(error, momentum, steps), steps).imag / STEP
        own = self.effort(steps).imag / STEP
        floor = 1e-6 * float(np.abs(self.torque_weight).max()) * self.period * _unit(self)
        return errors[0], cost, float(np.abs(slopes).max() / (np.abs(own).max() + floor))


def audit_torque_plans(
    evidence: Evidence, ledger: Ledger, block: Columns, problems: dict[bytes, TorqueProblem]
) -> None:
    """Enter the checks of the torque plans in a block; ``problems`` keeps what they solve."""
    solved = (block.fields["status"] == Status.CONVERGED) & (
        block.fields["model"].astype(str) == MODEL
    )
    solved &= np.isin(block.steps, evidence.common(COMMAND, STATE, REFERENCE))
    steps, found = block.steps[solved], []
    attitudes = evidence.rows(STATE, "attitude", steps).reshape(-1, 3, 3)
    rates = evidence.rows(STATE, "angular_velocity", steps)
    ends = evidence.rows(REFERENCE, "attitude", steps).reshape(-1, 3, 3)
    for i, k in enumerate(np.flatnonzero(solved).tolist()):
        healthy = block.fields["planned"][k] == 1.0
        if healthy.tobytes() not in problems:
            problems[healthy.tobytes()] = TorqueProblem.of(evidence.scenario, healthy)
        problem, told = problems[healthy.tobytes()], block.fields
        torques = _known(told["predicted_torques"][k], (-1, 3))
        momentum = problem.inertia @ rates[i]
        errors, cost, residual = problem.examine(ends[i].T @ attitudes[i], momentum, torques)
        planned = _known(told["predicted_attitudes"][k], (-1, 3, 3))
        flow = float(np.abs(ends[i] @ errors - planned).max())
        found.append(_Found(flow, abs(cost - told["cost"][k]) / max(cost, 1e-9), residual))
    for name, (part, field, limit) in _LIMITS.items() if found else ():
        values = np.array([getattr(one, part) for one in found])
        ledger.bound(name, steps, f"{SOLVER_STATUS}.{field}", values, limit)


def _known(values: Array, shape: tuple[int, ...]) -> Array:
    return np.asarray(values, dtype=np.float64)[np.isfinite(values)].reshape(shape)


def _of_vectors(weight: Array) -> Array:
    """Return tr(Q) I - Q, for which |Q^(1/2) hat(x)|_F^2 is a quadratic form in x."""
    return np.asarray(np.trace(weight) * np.eye(3) - weight)


def _unit(problem: TorqueProblem) -> float:
    """Return the torque that counts as one [N m]."""
    return problem.max_torque or 1.0 / float(np.sqrt(np.abs(problem.torque_weight).max()))


def _shares(f: Any) -> tuple[Any, Any]:
    """Return sin|f| / |f| and (1 - cos|f|) / |f|^2 (b, 1)."""
    t = np.sum(f * f, axis=-1, keepdims=True)
    small = np.abs(t) < 1e-2
    angle = np.sqrt(np.where(small, 1.0, t))
    first, second = np.ones_like(t), 0.5 * np.ones_like(t)
    term, other = np.ones_like(t), 0.5 * np.ones_like(t)
    for i in range(1, 7):
        term = -term * t / ((2 * i) * (2 * i + 1))
        other = -other * t / ((2 * i + 1) * (2 * i + 2))
        first, second = first + term, second + other
    return (
        np.where(small, first, np.sin(angle) / angle),
        np.where(small, second, (1.0 - np.cos(angle)) / angle**2),
    )


def _hat(x: Any) -> Any:
    """Return the matrices (b, 3, 3) of the cross product from the left."""
    zero = np.zeros_like(x[..., 0])
    a, b, c = np.moveaxis(x, -1, 0)
    rows = [zero, -c, b, c, zero, -a, -b, a, zero]
    return np.stack(rows, axis=-1).reshape(*x.shape[:-1], 3, 3)
