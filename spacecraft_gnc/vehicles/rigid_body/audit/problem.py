"""Numbers of the problem that a flight's plans are certified by."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.ocp import AttitudeOcp, PointingZone
from spacecraft_gnc.ocp.terminal_problem import TerminalSetOcp
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body.audit._audit_kernels import turns


@dataclass(frozen=True, slots=True)
class Problem:
    """Numbers of a problem, from its public attributes.

    Attributes
    ----------
    ocp
        The problem.
    limit
        On |u| [N m]; 0: none.
    penalty
        mu0 of the limit; infinite: a hard one.
    attitude, momentum, control
        Q1, S2 = (tr(Q2) I - Q2) / 2, and the weight of u . W u of a stage, each times h there.
    end_attitude, end_momentum
        P1 and S of P2 (Gupta (28)).
    rate, end
        lambda Q2 / h^2 and P of the cost of Kalabic et al. (2014), (24)-(26); ``end`` is None for
        the cost of Gupta et al. (27), (28).
    zones
        Rows v (3), d (3), cosine, sign (+1 exclusion), weight.
    """

    ocp: AttitudeOcp
    limit: float
    penalty: float
    attitude: Array
    momentum: Array
    control: Array
    end_attitude: Array
    end_momentum: Array
    rate: Array
    end: Array | None
    zones: Array

    @classmethod
    def of(cls, ocp: AttitudeOcp, limit: float | None = None) -> Problem:
        """Return the numbers of a problem; with ``limit`` its limits are constraints instead."""
        w, axes, h = ocp.weights, ocp.control_axes, ocp.time_step
        attitude, rate, end = np.asarray(w.stage_attitude), np.zeros((3, 3)), None
        hard = limit is not None
        if isinstance(ocp, TerminalSetOcp):
            attitude = ocp.stage_cost_scale / h * attitude
            rate = ocp.stage_cost_scale / h**2 * np.asarray(ocp.stage_rate)
            end, hard = ocp.terminal.riccati, True
        zones = [] if hard else [_zone_row(zone) for zone in ocp.zones]
        return cls(
            ocp=ocp,
            limit=ocp.max_torque if limit is None else limit,
            penalty=math.inf if hard else ocp.torque_penalty,
            attitude=attitude,
            momentum=_half_trace_minus(np.asarray(w.stage_momentum)),
            control=axes @ np.diag(ocp.control_weights) @ axes.T,
            end_attitude=np.asarray(w.terminal_attitude),
            end_momentum=_half_trace_minus(np.asarray(w.terminal_momentum)),
            rate=rate,
            end=end,
            zones=np.array(zones).reshape(-1, 9),
        )

    @property
    def back(self) -> Array:
        """(3, m) pseudo-inverse of B^T."""
        return np.asarray(np.linalg.pinv(self.ocp.torque_map.T))

    def turns(self, momenta: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Return F (..., 3, 3) of momenta (..., 3), and where it exists."""
        flat = np.ascontiguousarray(momenta.reshape(-1, 3))
        F, exists = np.empty((len(flat), 3, 3)), np.empty(len(flat), dtype=bool)
        body = self.ocp.body
        turns(body.packed, body.time_step, flat, F, exists)
        return F.reshape(*momenta.shape, 3), exists.reshape(momenta.shape[:-1])


def _zone_row(zone: PointingZone) -> list[float]:
    axes = [*np.ravel(zone.body_axis).tolist(), *np.ravel(zone.inertial_axis).tolist()]
    return [*axes, math.cos(zone.half_angle), zone.sign, zone.penalty]


def nonstandard(problem: Problem) -> Array:
    """Return Jd = tr(J) I / 2 - J."""
    J = np.asarray(problem.ocp.inertia)
    return np.asarray(0.5 * np.trace(J) * np.eye(3) - J)


def _half_trace_minus(matrix: Array) -> Array:
    return np.asarray(0.5 * (np.trace(matrix) * np.eye(3) - matrix))
