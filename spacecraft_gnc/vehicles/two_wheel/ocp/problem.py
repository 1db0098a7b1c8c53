"""Optimal control problem of an attitude with two wheels: reach rest at a reference and stay there.

    minimize   sum over k < N of e_k' Q e_k + s |nu_k|^2 + r |u_k|^2
    subject to nu_k+1 = nu_k + T u_k,  R_k+1 by the prediction model,
               |u_k| <= U,  |nu_k| <= V,  nu_N = 0,  e_N = 0,

with e the angle from the reference in the coordinates of the model. Source: Kolmanovsky et al. 2016
(AFRL), (2)-(5). Erratum: (5) bounds u and nu from above only; the bounds have to be two-sided.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

import numpy as np

from spacecraft_gnc.arguments import as_count, as_limit, require_positive, require_word
from spacecraft_gnc.arrays import as_finite
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.types import Array, ArrayLike, Matrix3, as_inertia, read_only

MODELS: Final = ("simplified", "euler_321", "so3")
"""Prediction models, by the numbers of the kernels."""
LARGEST_TURN: Final = 0.3
"""[rad] by which one wheel may turn the bus in a step: the flow over it is a series in that turn,
and where wheels have no limit a solve would otherwise go astray among whole revolutions."""
_PARALLEL: Final = 1e-6  # sine of the angle between two rates that counts as two directions


@dataclass(frozen=True, slots=True, eq=False)
class WheelOcp:
    """Problem of one step: bus, the two wheels that are left, horizon, weights, limits.

    Attributes
    ----------
    inertia : (3, 3) array
        Bus and locked wheels, body frame [kg m^2].
    wheels : (3, 2) array
        Axes times axial inertias of the two wheels, one column each [kg m^2].
    time_step : float
        T [s].
    horizon : int
        N [steps].
    attitude_weights : (3,) array
        Q about e1, e2, e3 of the prediction frame `frame` [1/rad^2].
    speed_weight, acceleration_weight : float
        s [(s/rad)^2] and r [(s^2/rad)^2].
    max_speed, max_acceleration : float
        V [rad/s] and U [rad/s^2]; 0: none. V is then, and where more is given, the speed at which
        the faster-turning of the two wheels turns the bus by `LARGEST_TURN` in a step.
    model : {"so3", "euler_321", "simplified"}
        so3: exact kinematics, e twice the vector part of the error quaternion. euler_321: exact
        kinematics, e the 3-2-1 angles. simplified: the report's (2), for small angles.
    terminal_weight : float
        Of |e_N|^2 where the end is soft [1/rad^2].

    Raises
    ------
    ShapeError, ParameterError
        If an argument is refused, or the two wheels turn the bus about one axis only.
    """

    inertia: Matrix3
    wheels: Array
    time_step: float
    horizon: int = 30
    attitude_weights: Array = field(default_factory=lambda: np.array([1.0, 1.0, 10.0]))
    speed_weight: float = 1e-6
    acceleration_weight: float = 1e-3
    max_speed: float = 0.0
    max_acceleration: float = 0.0
    model: str = "so3"
    terminal_weight: float = 1e4
    frame: Matrix3 = field(init=False, repr=False)
    """(3, 3) axes of the prediction frame in the body frame, one column each: e1 along the rate
    that the first wheel gives, e3 about which none gives any."""
    rates: Array = field(init=False, repr=False)
    """(3, 2) rate of the bus in that frame per wheel speed, at zero total momentum."""

    def __post_init__(self) -> None:
        require_word("model", self.model, MODELS)
        inertia = as_inertia("inertia", self.inertia)
        wheels = as_finite("wheels", self.wheels, (3, 2), "a 3 x 2 matrix [kg m^2]")
        body: Array = np.asarray(np.linalg.solve(inertia, wheels), dtype=np.float64)
        frame = _frame(body)
        rates = -frame.T @ body
        rates[1, 0] = rates[2, 0] = rates[2, 1] = 0.0  # but for rounding
        period = require_positive("time_step", self.time_step)
        fastest = LARGEST_TURN / (period * float(np.linalg.norm(rates, axis=0).max()))
        checked = {
            "inertia": inertia,
            "wheels": wheels,
            "time_step": period,
            "horizon": as_count("horizon", self.horizon, remedy="give 30"),
            "attitude_weights": _as_weights(self.attitude_weights),
            "max_speed": min(as_limit("max_speed", self.max_speed) or fastest, fastest),
            "max_acceleration": as_limit("max_acceleration", self.max_acceleration),
            "frame": read_only(frame),
            "rates": read_only(rates),
        }
        for name in ("speed_weight", "acceleration_weight", "terminal_weight"):
            checked[name] = require_positive(name, getattr(self, name))
        for name, value in checked.items():
            object.__setattr__(self, name, value)


def _frame(body: Array) -> Array:
    """Return the prediction frame (3, 3) for rates (3, 2) per wheel speed, body frame."""
    first, second = body.T / np.linalg.norm(body, axis=0, keepdims=True).T
    normal = np.cross(first, second)
    size = float(np.linalg.norm(normal))
    if not size > _PARALLEL:
        raise ParameterError(
            f"wheels: received two wheels that turn the bus about axes {first} and {second}, "
            "which are parallel; required two directions; use two other wheels"
        )
    third = normal / size
    return np.column_stack([first, np.cross(third, first), third])


def _as_weights(value: ArrayLike) -> Array:
    weights = as_finite("attitude_weights", value, (3,), "three numbers [1/rad^2]")
    if weights.min() <= 0.0:
        raise ParameterError(
            f"attitude_weights: received {weights}; required three positive numbers [1/rad^2]; "
            "give (1, 1, 10)"
        )
    return weights
