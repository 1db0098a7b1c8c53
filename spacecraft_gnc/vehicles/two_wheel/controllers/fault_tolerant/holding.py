"""Laws that hold with two wheels what `hold.holdable` found: a steady rotation, or rest elsewhere.

**Rotation** about the body axis e, to be kept along the inertial direction d. With g = R^T d,

    omega = k (e x g) + beta f,   n . J omega = n . R^T H - kappa,

where the second equation is what the wheels cannot change, and gives beta; any such omega they can
make. Without momentum f = J n, along e, so that

    d/dt (e . g) = omega . (e x g) = k |e x g|^2,

and the axis comes to its direction from everywhere but the opposite one. With momentum d is along
H, and the same holds of f = g, about which the rotation stays steady; far from d, where that
rotation would be fast, f = J n is taken if it comes nearer sooner within the limit of speed.

**Rest** where n . R^T H = kappa, with H != 0. Next to an attitude W of rest, R = W exp(hat(eta)),

    J eta' = p x eta - B (nu - nu_W),   p = W^T H,   nu' = u,

is controllable unless n is along p: H tilts with the body and turns it about the third axis. u is
the linear-quadratic regulator of the sampled system. Turns about H and about n keep a spacecraft
among its attitudes of rest; W goes ahead of it on such turns, to the one that is to be held.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm, solve_discrete_are

from spacecraft_gnc import lie
from spacecraft_gnc.types import Array, Matrix3, Vector3
from spacecraft_gnc.vehicles.two_wheel.controllers.report import Rest
from spacecraft_gnc.vehicles.two_wheel.dynamics import Gyrostat
from spacecraft_gnc.vehicles.two_wheel.hold import NEGLIGIBLE, Held, on_cone, plane_normal
from spacecraft_gnc.vehicles.two_wheel.state import WheelState

_GAIN: Final = 0.2
"""k in units of 1 over the control period."""
_AHEAD: Final = 0.2
"""Turn [rad] by which W is ahead of the attitude."""
_LARGE: Final = 0.1
"""Rotation [rad] that weighs as much as a wheel at a limit."""
_THIRD: Final = 10.0
"""Weight of the rotation about J n, which only the tilt of H can give, against the others."""
_FLATTEST: Final = 0.1
"""Cosine of J n and g below which the rotation about g would be too fast."""
_NEAR: Final = 0.5
"""Sine of the angle between axis and direction below which the rotation has to be steady."""


class TwoWheels:
    """Two wheels left of a gyrostat, and what they cannot change.

    Parameters
    ----------
    gyrostat : Gyrostat
        As believed, with its limits; its ``time_step`` is the control period.
    healthy : (m,) bool array
        The wheels left, whose axes span two dimensions.
    """

    def __init__(self, gyrostat: Gyrostat, healthy: NDArray[np.bool_]) -> None:
        self.gyrostat, self.healthy = gyrostat, healthy
        self.normal = plane_normal(gyrostat.wheel_axes[:, healthy])
        self.across = gyrostat.inertia @ self.normal
        self.own = gyrostat.wheels[:, healthy]
        self._inverse = np.linalg.pinv(self.own)

    def dead_momentum(self, wheel_speed: Array) -> Vector3:
        """Return h (3,), momentum of the other wheels, body frame [N m s]."""
        dead = ~self.healthy
        return np.asarray(self.gyrostat.wheels[:, dead] @ wheel_speed[dead])

    def speeds_for(self, rate: Vector3, total: Vector3, dead: Vector3) -> Array:
        """Return the speeds of the wheels left at a rate (3,) with momenta R^T H and h (3,)."""
        return np.asarray(self._inverse @ (total - dead - self.gyrostat.inertia @ rate))

    def rate_of(self, speeds: Array, total: Vector3, dead: Vector3) -> Vector3:
        """Return the rate (3,) of the bus with such speeds (2,) of the wheels left [rad/s]."""
        return np.asarray(np.linalg.solve(self.gyrostat.inertia, total - dead - self.own @ speeds))

    def accelerations(self, wheel_speed: Array, wanted: Array) -> Array:
        """Return accelerations (m,) from those wanted of the wheels left (2,) [rad/s^2].

        Scaled by one factor to the limit of acceleration, and cut to that of speed.
        """
        g, speed = self.gyrostat, wheel_speed[self.healthy]
        size, most = float(np.abs(wanted).max()), g.max_acceleration or math.inf
        scaled = wanted * (most / size) if size > most else wanted
        top = np.maximum(g.max_speed or math.inf, np.abs(speed))
        found = np.zeros(g.n_wheels)
        found[self.healthy] = np.clip(
            scaled, (-top - speed) / g.time_step, (top - speed) / g.time_step
        )
        return found


def keep_turning(wheels: TwoWheels, state: WheelState, held: Held, ahead: Array) -> Array:
    """Return accelerations (m,) that bring the axis of the rotation that remains to its direction.

    Parameters
    ----------
    wheels : TwoWheels
    state : WheelState
    held : Held
        With `Rest.NOWHERE`.
    ahead : (m,) array
        Wheel speeds expected at the end of the period; read of the wheels that do not answer.
    """
    period = wheels.gyrostat.time_step
    axis = held.rate / float(np.linalg.norm(held.rate))
    attitude = state.attitude @ lie.exp(period * state.angular_velocity)
    total, dead = attitude.T @ state.total_momentum, wheels.dead_momentum(ahead)
    g = attitude.T @ (held.attitude @ axis)
    aside = np.cross(axis, g)
    near = float(axis @ g) > 0.0 and float(np.linalg.norm(aside)) < _NEAR
    ways = [g] if near and total.any() else [wheels.across, g] if total.any() else [wheels.across]
    aims = [_aim(wheels, about, _GAIN / period * aside, total, dead) for about in ways]
    progress = [float(aside @ wheels.rate_of(aim, total, dead)) for aim in aims]
    aim = aims[int(np.argmax(progress))]
    return wheels.accelerations(
        state.wheel_speed, (aim - state.wheel_speed[wheels.healthy]) / period
    )


def _aim(wheels: TwoWheels, about: Vector3, turn: Vector3, total: Vector3, dead: Vector3) -> Array:
    """Return wheel speeds (2,) for a turn and the rotation about an axis that remains beside it.

    Of the turn (3,) [rad/s], as much as the limit of speed leaves.
    """
    along, fixed = float(wheels.across @ about), float(wheels.normal @ (total - dead))
    if abs(along) < _FLATTEST * float(np.linalg.norm(wheels.across) * np.linalg.norm(about)):
        about, along = wheels.across, float(wheels.across @ wheels.across)
    steady = wheels.speeds_for(fixed / along * about, total, dead)
    share = (fixed - float(wheels.across @ turn)) / along
    way = wheels.speeds_for(share * about + turn, total, dead) - steady
    return steady + _part(steady, way, wheels.gyrostat.max_speed) * way


def _part(start: Array, way: Array, top: float) -> float:
    """Return the largest share of a way, at most 1, that keeps speeds within their limit."""
    if not top:
        return 1.0
    room = np.where(way > 0.0, top - start, top + start)
    parts = np.divide(room, np.abs(way), out=np.ones_like(way), where=np.abs(way) > 0.0)
    return float(np.clip(parts.min(), 0.0, 1.0))


def go_to_rest(wheels: TwoWheels, state: WheelState, held: Held, ahead: Array) -> Array:
    """Return accelerations (m,) that bring the spacecraft to rest at an attitude on the cone.

    Parameters as of `keep_turning`; ``held`` with `Rest.ELSEWHERE`, or `Rest.AT_TARGET` where
    there is momentum.
    """
    momentum = state.total_momentum
    waypoint = _waypoint(wheels.normal, state.attitude, held.attitude, momentum)
    total, dead = waypoint.T @ momentum, wheels.dead_momentum(ahead)
    still = wheels.speeds_for(np.zeros(3), total, dead)
    off = np.append(lie.log(waypoint.T @ state.attitude), state.wheel_speed[wheels.healthy] - still)
    try:
        wanted = -_regulator(wheels, total) @ off
    except np.linalg.LinAlgError:  # n along p: there only the wheels can be brought to rest
        wanted = -off[3:] / wheels.gyrostat.time_step
    return wheels.accelerations(state.wheel_speed, wanted)


def _waypoint(n: Vector3, attitude: Matrix3, held: Matrix3, total_momentum: Vector3) -> Matrix3:
    """Return the attitude of rest to go to next, on the way of turns about H and about n."""
    up = total_momentum / float(np.linalg.norm(total_momentum))
    end = held @ n
    start, _ = on_cone(attitude, n, up, float(end @ up))
    normal = start @ n
    about = math.atan2(
        float(up @ np.cross(normal, end)),
        float(normal @ end) - float(normal @ up) * float(end @ up),
    )
    own = float(lie.log((lie.exp(about * up) @ start).T @ held) @ n)
    part = min(1.0, _AHEAD / max(abs(about) + abs(own), _AHEAD))
    return np.asarray(lie.exp(part * about * up) @ start @ lie.exp(part * own * n))


def _regulator(wheels: TwoWheels, total: Vector3) -> Array:
    """Return the gain (2, 5) of rotation and wheel speeds off an attitude of rest.

    Raises
    ------
    LinAlgError
        If the linear system is not stabilizable.
    """
    g = wheels.gyrostat
    motion = np.zeros((7, 7))
    motion[:3, :3] = np.linalg.solve(g.inertia, lie.hat(total))
    motion[:3, 3:5] = -np.linalg.solve(g.inertia, wheels.own)
    motion[3:5, 5:] = np.eye(2)
    sampled = expm(g.time_step * motion)[:5]
    free, driven = sampled[:, :5], sampled[:, 5:]
    fast = g.max_speed or _LARGE * float(np.linalg.norm(g.inertia) / np.linalg.norm(wheels.own))
    strong = g.max_acceleration or fast / g.time_step
    third = wheels.across / float(np.linalg.norm(wheels.across))
    weight = np.diag([1.0, 1.0, 1.0, *2 * [(_LARGE / fast) ** 2]])
    weight[:3, :3] += (_THIRD - 1.0) * np.outer(third, third)
    effort = (_LARGE / strong) ** 2 * np.eye(2)
    ahead = solve_discrete_are(free, driven, weight, effort)
    return np.asarray(np.linalg.solve(effort + driven.T @ ahead @ driven, driven.T @ ahead @ free))


def brake(
    gyrostat: Gyrostat, healthy: NDArray[np.bool_], state: WheelState, target: Matrix3
) -> tuple[Array, Held]:
    """Return accelerations (m,) that slow the bus as one wheel left can, or none, and what remains.

    The momentum B nu nearest to R^T H - h in the sense of the energy of the bus is taken in.
    """
    dead = gyrostat.wheels[:, ~healthy] @ state.wheel_speed[~healthy]
    excess = state.attitude.T @ state.total_momentum - dead
    own = gyrostat.wheels[:, healthy]
    weighed = np.linalg.solve(gyrostat.inertia, own)
    speeds = np.linalg.pinv(own.T @ weighed) @ (weighed.T @ excess)
    found = np.zeros(gyrostat.n_wheels)
    wanted = (speeds - state.wheel_speed[healthy]) / gyrostat.time_step
    most, top = gyrostat.max_acceleration or math.inf, gyrostat.max_speed or math.inf
    room = np.maximum(top, np.abs(state.wheel_speed[healthy]))
    low, high = (
        (bound - state.wheel_speed[healthy]) / gyrostat.time_step for bound in (-room, room)
    )
    found[healthy] = np.clip(np.clip(wanted, -most, most), low, high)
    rate = np.asarray(np.linalg.solve(gyrostat.inertia, excess - own @ speeds), dtype=np.float64)
    still = float(np.linalg.norm(rate)) <= NEGLIGIBLE
    loss = lie.angle_between(state.attitude, target)
    rest = Rest.ELSEWHERE if still else Rest.NOWHERE
    return found, Held(rest, state.attitude, np.zeros(3) if still else rate, loss)
