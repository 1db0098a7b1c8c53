"""Interpolation of a table of attitudes and rates on SO(3).

Between two rows the attitude is R_i exp(hat(phi(t))), with phi the cubic that starts at 0 with the
rate omega_i and ends at log(R_i^T R_{i+1}) with the rate omega_{i+1}: the attitude and the rate of
each row are met exactly, and rate and acceleration are those of the attitude in between,

    omega = Jr(phi) phi',   Jr(phi) = I - a hat(phi) + b hat(phi)^2,
    a = (1 - cos |phi|) / |phi|^2,   b = (|phi| - sin |phi|) / |phi|^3.
"""

from __future__ import annotations

import math

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.arrays import as_finite, as_float, as_stack
from spacecraft_gnc.errors import ParameterError, ShapeError
from spacecraft_gnc.types import Array, ArrayLike, Matrix3, Vector3, as_rotation

SMALL_SQUARE = 1e-3  # |phi|^2 below which the coefficients are summed as series
LARGEST_TURN = math.radians(150.0)  # between two rows; at half a turn the way is not determined
MISFIT = 0.25  # share of a turn that the rates at its ends may miss it by, with the trapezoid rule
SMALL_MISS = 1e-3  # [rad], more than that share where a smooth motion starts from rest


class RotationSpline:
    """Attitude, rate, acceleration and torque of a table at any time from its first row on."""

    def __init__(
        self,
        times: ArrayLike,
        attitudes: ArrayLike,
        angular_velocities: ArrayLike,
        torques: ArrayLike | None = None,
    ) -> None:
        self._times = _increasing(times)
        n = len(self._times)
        rotations = as_stack("attitudes", attitudes)
        if rotations.shape != (n, 3, 3):
            raise ShapeError(
                f"attitudes: received an array of shape {rotations.shape}; required ({n}, 3, 3), a "
                "rotation for each time; check the rows"
            )
        self._attitudes = np.array(
            [as_rotation(f"attitudes[{i}]", R) for i, R in enumerate(rotations)]
        )
        self._rates = as_finite(
            "angular_velocities", angular_velocities, (n, 3), f"({n}, 3) numbers [rad/s]"
        )
        self._torques = None
        if torques is not None:
            self._torques = as_finite("torques", torques, (n, 3), f"({n}, 3) numbers [N m]")
        self._turns = np.array([self._turn(i) for i in range(n - 1)])

    def attitude(self, time: float) -> Matrix3:
        """Return the rotation (3, 3) at a time [s]."""
        i, s, _ = self._place(time)
        if i == len(self._turns):
            return np.asarray(self._attitudes[i] @ lie.exp(s * self._rates[i]))
        return np.asarray(self._attitudes[i] @ lie.exp(self._cubic(i, s)[0]))

    def motion(self, time: float) -> tuple[Vector3, Vector3]:
        """Return rate (3,) [rad/s] and acceleration (3,) [rad/s^2] at a time, own frame."""
        i, s, span = self._place(time)
        if i == len(self._turns):
            return self._rates[i].copy(), np.zeros(3)
        phi, first, second = self._cubic(i, s)
        return _body_motion(phi, first / span, second / span**2)

    def torque(self, time: float) -> Vector3 | None:
        """Return the table's torque (3,) [N m] at a time; None where it has none."""
        if self._torques is None:
            return None
        return np.array([np.interp(time, self._times, column) for column in self._torques.T])

    def _place(self, time: float) -> tuple[int, float, float]:
        """Return the row before a time, the share of the way to the next, and the time between.

        After the last row: that row, and the time since then.
        """
        i = max(0, int(np.searchsorted(self._times, time, side="right")) - 1)
        if i == len(self._turns):
            return i, time - float(self._times[i]), math.inf
        span = float(self._times[i + 1] - self._times[i])
        return i, (time - float(self._times[i])) / span, span

    def _cubic(self, i: int, s: float) -> tuple[Vector3, Vector3, Vector3]:
        """Return phi at a share s of the way from row i, and its derivatives to s."""
        span, end = self._times[i + 1] - self._times[i], self._turns[i]
        start_slope = span * self._rates[i]
        end_slope = span * np.linalg.solve(_jacobian(end), self._rates[i + 1])
        c2 = 3.0 * end - 2.0 * start_slope - end_slope
        c3 = start_slope + end_slope - 2.0 * end
        return (
            s * (start_slope + s * (c2 + s * c3)),
            start_slope + s * (2.0 * c2 + 3.0 * s * c3),
            2.0 * c2 + 6.0 * s * c3,
        )

    def _turn(self, i: int) -> Vector3:
        """Return the rotation vector (3,) from row i to the next, which its rates have to fit."""
        turn = lie.log(self._attitudes[i].T @ self._attitudes[i + 1])
        angle = float(np.linalg.norm(turn))
        if angle > LARGEST_TURN:
            raise ParameterError(
                f"attitudes: received rows {i} and {i + 1} that are {math.degrees(angle):.6g} deg "
                f"apart; required at most {math.degrees(LARGEST_TURN):g} deg, so that the way from "
                "one to the other is determined; add rows between them"
            )
        span = float(self._times[i + 1] - self._times[i])
        told = 0.5 * span * (self._rates[i] + self._rates[i + 1])
        miss, length = float(np.linalg.norm(told - turn)), float(np.linalg.norm(told))
        if miss > MISFIT * max(angle, length) + SMALL_MISS:
            raise ParameterError(
                f"angular_velocities: received rates of rows {i} and {i + 1} that make a turn of "
                f"{math.degrees(length):.6g} deg, {math.degrees(miss):.6g} deg off that of the "
                f"attitudes ({math.degrees(angle):.6g} deg); required rates in rad/s, in the "
                "reference's own frame, of rows close enough to each other; check unit and frame, "
                "or add rows"
            )
        return turn


def _increasing(times: ArrayLike) -> Array:
    array = as_float("times", times, "two or more numbers [s]")
    if array.ndim != 1 or len(array) < 2:
        raise ShapeError(
            f"times: received an array of shape {array.shape}; required (n,) with n >= 2; give one "
            "time for each row of the table"
        )
    rising = np.isfinite(array).all() and array[0] == 0.0 and (np.diff(array) > 0.0).all()
    if not rising:
        wrong = int(np.argmin(np.diff(array, prepend=-1.0) > 0.0)) if array[0] == 0.0 else 0
        raise ParameterError(
            f"times: received {array[wrong]:g} s in row {wrong}; required finite times that start "
            "at 0 and increase; sort the rows, and count from the start of the flight"
        )
    return array


def _coefficients(square: float) -> tuple[float, float, float, float]:
    """Return a, b of Jr, and their derivatives to |phi| over |phi|, at |phi|^2."""
    t = square
    if t < SMALL_SQUARE:
        return (
            0.5 - t * (1.0 / 24.0 - t * (1.0 / 720.0 - t / 40320.0)),
            1.0 / 6.0 - t * (1.0 / 120.0 - t * (1.0 / 5040.0 - t / 362880.0)),
            -1.0 / 12.0 + t * (1.0 / 180.0 - t / 6720.0),
            -1.0 / 60.0 + t * (1.0 / 1260.0 - t / 60480.0),
        )
    angle = math.sqrt(t)
    sine, versine = math.sin(angle), 2.0 * math.sin(0.5 * angle) ** 2
    return (
        versine / t,
        (angle - sine) / (t * angle),
        (angle * sine - 2.0 * versine) / t**2,
        (angle * versine - 3.0 * (angle - sine)) / (t**2 * angle),
    )


def _jacobian(phi: Vector3) -> Matrix3:
    """Return Jr(phi) (3, 3): the body rate of exp(hat(phi)) is Jr phi'."""
    a, b, _, _ = _coefficients(float(phi @ phi))
    Phi = lie.hat(phi)
    return np.asarray(np.eye(3) - a * Phi + b * (Phi @ Phi))


def _body_motion(phi: Vector3, first: Vector3, second: Vector3) -> tuple[Vector3, Vector3]:
    """Return the rate of exp(hat(phi)) and its derivative, from those of phi."""
    a, b, slope_a, slope_b = _coefficients(float(phi @ phi))
    growth = float(phi @ first)
    Phi, Phi_dot = lie.hat(phi), lie.hat(first)
    square = Phi @ Phi
    Jr = np.eye(3) - a * Phi + b * square
    Jr_dot = growth * (slope_b * square - slope_a * Phi) + b * (Phi_dot @ Phi + Phi @ Phi_dot)
    # a hat(phi') phi' vanishes
    return np.asarray(Jr @ first), np.asarray(Jr @ second + Jr_dot @ first)
