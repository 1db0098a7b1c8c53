"""The terminal-set NMPC problem: a hard torque limit and a terminal set in the logarithm.

    minimize    sum_k lambda L(X_k, T_k) + F(X_N)
    L(X, T)   = tr(Q1 (I - C)) + tr(Q2 (I - F)) / h^2 + T . M T / 2,   C = R_ref^T R
    F(X)      = x . P x / 2,   x = (Z, Pi),   hat(Z) = log C
    subject to  |T_k| <= max_torque,   |x_N|_P^2 <= c

and to the integrator of `dynamics.rigid_body`. Source: Kalabic et al. 2014, (24)-(32), extended to
a reference attitude other than the identity. The angle of Z is kept continuous along the horizon,
from the principal one of the first attitude (at half a turn `lie.log`'s branch) on.
"""

from __future__ import annotations

import math

import numpy as np

from spacecraft_gnc.arguments import as_count, as_limit, as_real, require_word
from spacecraft_gnc.arrays import as_shaped
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.ocp import _data_kernels, _terminal_kernels
from spacecraft_gnc.ocp.problem import AttitudeOcp, Weights
from spacecraft_gnc.ocp.terminal_controller import TerminalController
from spacecraft_gnc.ocp.terminal_level import Level, decrease_level
from spacecraft_gnc.ocp.zones import PointingZone
from spacecraft_gnc.types import Array, ArrayLike, Matrix3, as_semidefinite, read_only

BELOW = 1.0 - 2.0**-51  # keeps rounding below the torque limit, which is hard
TERMINAL_SETS = ("true", "without_kappa", "false")


class TerminalSetOcp(AttitudeOcp):
    """The problem of Kalabic et al. 2014, section IV.

    Parameters
    ----------
    inertia : (3, 3) array
        Inertia matrix of the model, body frame [kg m^2].
    time_step : float
        Prediction step = control period h [s].
    horizon : int
        Number of steps N >= 1.
    stage_attitude, stage_rate, stage_torque : array_like
        Q1, Q2, M of (25), each a scalar (times I) or a (3, 3) array; Q1 and M positive definite.
    stage_cost_scale : float
        lambda of (24), in (0, 1).
    max_torque : float
        Hard limit on |T| [N m]; 0 means none.
    terminal_set : {"true", "without_kappa", "false"}
        true: |x_N|_P^2 <= c, with c so small that kappa keeps the torque limit in the whole set.
        without_kappa: c by (31) alone. false: no terminal constraint.
    zones : tuple of PointingZone, optional
        Their margins are reported; they are no part of the problem.

    Attributes
    ----------
    terminal : TerminalController
        P and K.
    level : Level or None
        c of the terminal set, and what certifies it; None without a terminal set.

    Raises
    ------
    ShapeError, ParameterError
        If an argument is refused; the message names it and says what is required.
    """

    stage_rate: Matrix3
    stage_cost_scale: float
    terminal_set: str
    terminal: TerminalController
    level: Level | None

    def __init__(
        self,
        inertia: ArrayLike,
        time_step: float,
        horizon: int,
        stage_attitude: ArrayLike = 1.0,
        stage_rate: ArrayLike = 1.0,
        stage_torque: ArrayLike = 1000.0,
        stage_cost_scale: float = 0.1,
        max_torque: float = 0.0,
        terminal_set: str = "true",
        zones: tuple[PointingZone, ...] = (),
    ) -> None:
        weights = Weights(stage_attitude, 0.0, stage_torque, 0.0, 0.0)
        super().__init__(inertia, time_step, horizon, weights, max_torque, zones=zones)
        stage_cost_scale = as_real(
            "stage_cost_scale", stage_cost_scale, lambda x: 0.0 < x < 1.0,
            "a number in (0, 1), for (30) to hold near the target", "give 0.1",
        )  # fmt: skip
        require_word("terminal_set", terminal_set, TERMINAL_SETS)
        attitude, torque = np.asarray(weights.stage_attitude), np.asarray(weights.stage_torque)
        if float(np.linalg.eigvalsh(attitude)[0]) <= 0.0:
            raise ParameterError(
                "weights.stage_attitude: received a singular matrix; required a positive definite "
                "weight, else the terminal cost bounds no error; use 1.0"
            )
        rate = as_semidefinite("weights.stage_rate", stage_rate)
        moments = np.asarray(self.inertia)
        design = TerminalController.design(moments, self.time_step, attitude, rate, torque)
        self._set(stage_rate=rate, stage_cost_scale=stage_cost_scale, terminal=design)
        self._set(terminal_set=terminal_set)
        self._pack(attitude, rate, torque)
        self._set(level=self._find_level())

    def weighted(self, multiplier: float) -> TerminalSetOcp:
        """Return this problem with (1 + multiplier) F as its terminal cost.

        At the multiplier of an active terminal set, its solution is that of the problem itself.
        """
        multiplier = as_limit("multiplier", multiplier)
        data = self.data.copy()
        at = _data_kernels.P_LOG
        data[at : at + 36] = (1.0 + multiplier) * self.terminal.riccati.ravel()
        return self._with(data=read_only(data))

    def with_horizon(self, horizon: int) -> TerminalSetOcp:
        """Return this problem over another number of steps; its terminal set is the same."""
        return self._with(horizon=as_count("horizon", horizon))

    def terminal_state(self, attitudes: Array, momenta: Array, reference: Matrix3) -> Array:
        """Return (6,) (Z, Pi) [rad, N m s] at the end of attitudes (N+1, 3, 3), momenta."""
        target = tuple(as_shaped("reference", reference, (3, 3)).ravel().tolist())
        Z = _terminal_kernels.continuous_log(target, np.ascontiguousarray(attitudes))
        return np.concatenate([Z, momenta[-1]])

    def largest_stage_cost(self, momentum: Array) -> float:
        """Return a bound on the sum of lambda L over the horizon from a momentum (3,).

        By |Pi_k| <= |Pi_0| + N h max_torque, and sin(angle of F) <= h |Pi| / (least moment);
        infinite without a torque limit.
        """
        if self.max_torque == 0.0:
            return math.inf
        h, n = self.time_step, self.horizon
        rate, scale = np.asarray(self.stage_rate), self.stage_cost_scale
        turn, push = _largest_pair(np.asarray(self.weights.stage_attitude)), _largest_pair(rate)
        fastest = (
            float(np.linalg.norm(as_shaped("momentum", momentum, (3,)))) + n * h * self.max_torque
        )
        spin = fastest / float(np.linalg.eigvalsh(np.asarray(self.inertia))[0])
        spinning = push * (spin**2 if h * spin < 1.0 else 2.0 / h**2)
        effort = 0.5 * self.max_torque**2 * np.linalg.norm(np.asarray(self.weights.stage_torque), 2)
        return float(n * scale * (2.0 * turn + spinning + effort))

    def level_of(self, state: Array) -> float:
        """Return |x|_P^2 of x (6,)."""
        x = as_shaped("state", state, (6,))
        return float(x @ self.terminal.riccati @ x)

    def _with(self, **values: object) -> TerminalSetOcp:
        other = object.__new__(TerminalSetOcp)
        other.__setstate__(self.__getstate__() | values)
        return other

    def __getstate__(self) -> dict[str, object]:
        """Return everything; that of the base class, for a copy, knows its own fields only."""
        return {name: getattr(self, name) for name in AttitudeOcp.__slots__} | vars(self)

    def __setstate__(self, state: dict[str, object]) -> None:
        self._set(**state)

    def _set(self, **values: object) -> None:
        for name, value in values.items():
            object.__setattr__(self, name, value)  # the base class is frozen

    def _pack(self, attitude: Matrix3, rate: Matrix3, torque: Matrix3) -> None:
        """Pack the problem in the log form; the kernels multiply stages by h."""
        scale, limit = self.stage_cost_scale, self.max_torque * BELOW
        weights, axes = np.linalg.eigh(0.5 * scale / self.time_step * torque)
        tail = [weights, axes.T.ravel(), axes.T.ravel()]
        head = np.concatenate(
            [
                [self.time_step, limit * limit, math.inf],
                (scale / self.time_step * attitude).ravel(),
                np.zeros(27),
                [1.0],
                (scale / self.time_step**2 * rate).ravel(),
                self.terminal.riccati.ravel(),
                self._scales(weights),
                [self.time_step, 3.0],
                *tail,
            ]
        )
        rows = self.zone_rows.copy()
        rows[:, 8] = 0.0  # no penalty
        self._set(
            data=read_only(head),
            control_axes=read_only(axes),
            control_weights=read_only(weights),
            zone_rows=read_only(rows),
        )

    def _scales(self, weights: Array) -> Array:
        """Return what `_data_kernels` calls U_UNIT, MADE_OF and MADE_OF_PI."""
        P, n = self.terminal.riccati, self.horizon
        stage = self.stage_cost_scale * _largest_pair(np.asarray(self.weights.stage_attitude))
        attitude = math.pi * np.linalg.norm(P[:3, :3], 2) + n * stage
        slowness = n * self.time_step / float(np.linalg.eigvalsh(np.asarray(self.inertia))[0])
        mixed = float(np.linalg.norm(P[:3, 3:], 2))
        momentum = slowness * mixed + float(np.linalg.norm(P[3:, 3:], 2))
        made_of = slowness * attitude + math.pi * mixed
        return np.array([(1.0 / weights).sum() / 3.0, made_of, momentum])

    def _find_level(self) -> Level | None:
        if self.terminal_set == "false":
            return None
        design = self.terminal
        bound = design.torque_level(self.max_torque) if self.terminal_set == "true" else math.inf
        return decrease_level(self.body.packed, self.data, design, bound)


def _largest_pair(weight: Matrix3) -> float:
    """Return the sum of the two largest eigenvalues: tr(Q (I - C)) is at most twice that."""
    values = np.linalg.eigvalsh(weight)
    return float(values[1] + values[2])
