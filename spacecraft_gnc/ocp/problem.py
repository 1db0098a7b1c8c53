"""The finite-horizon optimal control problem: what is minimized, under which dynamics and limits.

    minimize    |P1^(1/2) (R_N - R_ref,N)|_F^2 / 2 + |P2^(1/2) hat(Pi_N - Pi_ref)|_F^2 / 2
              + sum_k h/2 (|Q1^(1/2) (R_k - R_ref,k)|_F^2 + |Q2^(1/2) hat(Pi_k - Pi_ref)|_F^2)
              + sum_k h/2 |Q3^(1/2) hat(u_k - u_ref)|_F^2
              + sum_k h mu0 max(0, |u_k|^2 - max_torque^2)^2 + sum_k sum_i h mu_i max(0, H_i(R_k))^2

subject to the integrator of `dynamics.rigid_body`, driven by the torque B u. Source: Gupta et al.
2015, (27)-(30), extended from regulation (R_ref = I) to a constant reference attitude (its Remark
II), to one that turns at a constant rate (docs/solver.md, "A moving reference": R_ref,k, Pi_ref and
u_ref follow from a `Reference`) and to an actuator matrix B (Bagherzadeh et al. 2023, (9)).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from spacecraft_gnc.arguments import as_count, as_limit, require_kind, require_positive
from spacecraft_gnc.arrays import as_finite, as_shaped
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.ocp import _data_kernels, _stage_kernels
from spacecraft_gnc.ocp.reference import Tracked
from spacecraft_gnc.ocp.rollout import Horizon
from spacecraft_gnc.ocp.zones import PointingZone, as_zones
from spacecraft_gnc.types import (
    Array,
    ArrayLike,
    Matrix3,
    Vector3,
    as_actuators,
    as_matrix3,
    as_semidefinite,
    read_only,
)


@dataclass(frozen=True, slots=True)
class Weights:
    """Weights of the cost; each a scalar (times I), 9 numbers row-major, or a (3, 3) array.

    All are symmetric positive semi-definite; ``stage_torque`` is positive definite. Names in the
    paper: Q1, Q2, Q3, P1, P2.
    """

    stage_attitude: ArrayLike = 0.01
    stage_momentum: ArrayLike = 0.01
    stage_torque: ArrayLike = 1.0
    terminal_attitude: ArrayLike = 0.01
    terminal_momentum: ArrayLike = 0.01

    def __post_init__(self) -> None:
        for name in self.__slots__:
            checked = as_semidefinite(f"weights.{name}", getattr(self, name))
            object.__setattr__(self, name, checked)
        smallest = float(np.linalg.eigvalsh(self.stage_torque)[0])
        if smallest <= 0.0:
            raise ParameterError(
                f"weights.stage_torque: received a matrix with eigenvalue {smallest:g}; required "
                "a positive definite weight, else the control is not determined; use 1.0"
            )


@dataclass(frozen=True, slots=True)
class AttitudeOcp:
    """The constrained attitude control problem over one prediction horizon.

    Attributes
    ----------
    inertia : (3, 3) array
        Inertia matrix of the model, body frame [kg m^2].
    time_step : float
        Prediction step = control period h [s].
    horizon : int
        Number of steps N >= 1.
    weights : Weights
    max_torque : float
        Limit on |u| [N m], the norm of the m controls, by penalty; 0 means none.
    torque_penalty : float
        Weight mu0 of h max(0, |u|^2 - max_torque^2)^2.
    zones : tuple of PointingZone
        Seen by R_1 .. R_{N-1}, of which u moves R_2 .. R_{N-1}; R_N carries no zone penalty.
    actuators : (3, m) array, optional
        Matrix B: torque = B u, body frame. The identity if absent. For m other than 3 the weight
        ``stage_torque`` must be a number q, which stands for q |u|^2.
    plant_step : float, optional
        Step [s] of the integrator whose momentum is measured, 0 for a continuous body; the time
        step if absent. Only the momentum of a moving reference depends on it.

    Raises
    ------
    ShapeError, ParameterError
        If an argument is refused; the message names it and says what is required.
    """

    inertia: ArrayLike
    time_step: float
    horizon: int
    weights: Weights = field(default_factory=Weights)
    max_torque: float = 0.0
    torque_penalty: float = 1.0e10
    zones: tuple[PointingZone, ...] = ()
    actuators: ArrayLike | None = None
    plant_step: float | None = None
    body: RigidBody = field(init=False, repr=False, compare=False)
    data: Array = field(init=False, repr=False, compare=False)
    zone_rows: Array = field(init=False, repr=False, compare=False)
    torque_map: Array = field(init=False, repr=False, compare=False)
    """(3, m) matrix B, whether it was given or not."""
    control_axes: Array = field(init=False, repr=False, compare=False)
    """(m, m) eigenvectors V of the control weight; the kernels count controls as V^T u."""
    control_weights: Array = field(init=False, repr=False, compare=False)
    """(m,) eigenvalues of that weight."""
    allocation: Array = field(init=False, repr=False, compare=False)
    """(m, 3) pseudo-inverse of B: the least controls that make a torque."""

    def __post_init__(self) -> None:
        self._check()
        object.__setattr__(self, "torque_map", as_actuators(self.actuators))
        allocation = np.asarray(np.linalg.pinv(self.torque_map), dtype=np.float64)
        object.__setattr__(self, "allocation", read_only(allocation))
        weights, axes = _control_weight(self)
        object.__setattr__(self, "control_axes", read_only(axes))
        object.__setattr__(self, "control_weights", read_only(weights))
        object.__setattr__(self, "data", _pack(self))
        object.__setattr__(self, "zone_rows", _zone_rows(self.zones))

    def _check(self) -> None:
        """Check the numbers given, and keep them as plain ones."""
        body = RigidBody(np.asarray(as_matrix3("inertia", self.inertia)), self.time_step)
        limit = as_limit("max_torque", self.max_torque)
        weighed = require_positive if limit > 0.0 else as_limit  # without a limit nobody reads it
        checked: dict[str, object] = {
            "body": body,
            "inertia": body.inertia,
            "time_step": body.time_step,
            "horizon": as_count("horizon", self.horizon, remedy="give 5", most=10_000),
            "weights": require_kind("weights", self.weights, Weights),
            "max_torque": limit,
            "torque_penalty": weighed("torque_penalty", self.torque_penalty),
            "zones": as_zones(self.zones),
            "plant_step": as_limit(
                "plant_step", body.time_step if self.plant_step is None else self.plant_step
            ),
        }
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    def __repr__(self) -> str:
        """Return the problem in one line."""
        limit = f"|u| <= {self.max_torque:g} N m" if self.max_torque > 0.0 else "no torque limit"
        return (
            f"{type(self).__name__}({self.horizon} steps of {self.time_step:g} s, "
            f"{self.n_controls} controls, {limit}, {len(self.zones)} zones)"
        )

    @property
    def n_controls(self) -> int:
        """Number m of controls."""
        return len(self.control_axes)

    def rollout(
        self, controls: ArrayLike, attitude: ArrayLike, momentum: ArrayLike
    ) -> tuple[Array, Array]:
        """Return attitudes (N+1, 3, 3) and momenta (N+1, 3) under controls (N, m) [N m]."""
        torques = self.checked_controls(controls) @ self.torque_map.T
        return self.body.simulate(attitude, momentum, np.ascontiguousarray(torques))

    def cost(
        self,
        controls: ArrayLike,
        attitude: ArrayLike,
        momentum: ArrayLike,
        reference: Tracked | None = None,
    ) -> float:
        """Return the cost of controls (N, m) [N m], constants and penalties included."""
        horizon = Horizon(self, controls, attitude, momentum, reference)
        return float(
            _stage_kernels.horizon_cost(
                self.data,
                self.zone_rows,
                horizon.track,
                horizon.attitudes,
                horizon.momenta,
                horizon.work,
            )
        )

    def gradient(
        self,
        controls: ArrayLike,
        attitude: ArrayLike,
        momentum: ArrayLike,
        reference: Tracked | None = None,
    ) -> Array:
        """Return the gradient (N, m) of `cost` to the controls, by the adjoint (34)-(38).

        dJ/du_k = 2 h ((S3 + 2 mu0 max(0, H0)) u_k - B^T lambda2_k): the printed multipliers are
        half the true ones, consistently.
        """
        return Horizon(self, controls, attitude, momentum, reference).gradient()

    def hessian(
        self,
        controls: ArrayLike,
        attitude: ArrayLike,
        momentum: ArrayLike,
        reference: Tracked | None = None,
    ) -> Array:
        """Return the second derivative (mN, mN) of `cost` to the controls."""
        return Horizon(self, controls, attitude, momentum, reference).hessian()

    def realizable(self, torque: Vector3) -> Vector3:
        """Return the torque (3,) [N m] nearest to ``torque`` that the actuators can give.

        What B cannot make is left out; where the controls would exceed the limit, all is scaled.
        """
        controls = self.allocation @ as_shaped("torque", torque, (3,))
        size = float(np.linalg.norm(controls))
        if 0.0 < self.max_torque < size:
            controls = controls * (self.max_torque / size)
        return np.asarray(self.torque_map @ controls)

    def checked_controls(self, controls: ArrayLike) -> Array:
        """Return ``controls`` as a contiguous (N, m) array; raise a GncError if it is none."""
        shape = (self.horizon, self.n_controls)
        return as_finite("controls", controls, shape, f"{shape} numbers [N m], a row for each step")

    def checked_warm_start(self, guess: ArrayLike) -> Array:
        """Return multipliers as an (N, 6) array; raise a GncError if they are none."""
        remedy = "pass the warm_start of a solution of the same problem"
        return as_shaped("warm_start", guess, (self.horizon, 6), remedy)


def _half_trace_minus(weight: ArrayLike) -> Matrix3:
    matrix = np.asarray(weight)
    return np.asarray(0.5 * (np.trace(matrix) * np.eye(3) - matrix))


def _control_weight(ocp: AttitudeOcp) -> tuple[Array, Array]:
    """Return eigenvalues (m,) and eigenvectors (m, m) of the weight of the controls."""
    weight = np.asarray(ocp.weights.stage_torque)
    m = ocp.torque_map.shape[1]
    if m == 3:
        values, vectors = np.linalg.eigh(_half_trace_minus(weight))
        return values, vectors
    if np.abs(weight - weight[0, 0] * np.eye(3)).max() > 0.0:
        raise ParameterError(
            f"weights.stage_torque: received a full matrix for {m} actuators; required one number, "
            "the weight of |u|^2; give it as a scalar"
        )
    return np.full(m, weight[0, 0]), np.eye(m)


def _pack(ocp: AttitudeOcp) -> Array:
    w = ocp.weights
    numbers: list[Array] = [
        np.array([ocp.time_step, ocp.max_torque * ocp.max_torque, ocp.torque_penalty]),
        np.ravel(np.asarray(w.stage_attitude)),
        np.ravel(np.asarray(w.terminal_attitude)),
        _half_trace_minus(w.stage_momentum).ravel(),
        _half_trace_minus(w.terminal_momentum).ravel(),
        np.zeros(_data_kernels.U_UNIT - _data_kernels.LOG_FORM),  # read in the log form only
        _scales(ocp),
        np.array([float(ocp.plant_step or 0.0), float(ocp.n_controls)]),
        ocp.control_weights,
        (ocp.torque_map @ ocp.control_axes).T.ravel(),
        (ocp.control_axes.T @ ocp.allocation).ravel(),
    ]
    return read_only(np.concatenate(numbers))


def _scales(ocp: AttitudeOcp) -> Array:
    """Return what `_data_kernels` calls U_UNIT, MADE_OF and MADE_OF_PI."""
    w, span = ocp.weights, ocp.horizon * ocp.time_step
    attitude = _size(w.terminal_attitude) + span * _size(w.stage_attitude)
    momentum = _size(w.terminal_momentum) + span * _size(w.stage_momentum)
    slowness = span / float(np.linalg.eigvalsh(ocp.body.inertia)[0])
    gains = ocp.torque_map @ ocp.control_axes
    return np.array([(gains**2 / ocp.control_weights).sum() / 3.0, slowness * attitude, momentum])


def _size(weight: ArrayLike) -> float:
    return float(np.trace(np.asarray(weight)))


def _zone_rows(zones: tuple[PointingZone, ...]) -> Array:
    rows = np.zeros((len(zones), _stage_kernels.ZONE_SIZE))
    for row, zone in zip(rows, zones, strict=True):
        axes: tuple[Vector3, Vector3] = (np.asarray(zone.body_axis), np.asarray(zone.inertial_axis))
        row[0:3], row[3:6] = axes
        row[6:9] = math.cos(zone.half_angle), zone.sign, zone.penalty
    return read_only(rows)
