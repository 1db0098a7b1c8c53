"""What can be held with the wheels that are left: rest at the target, rest elsewhere, or rotation.

With the wheels that answer (momentum per speed B = A Js), the momentum h of the others in the body
frame and the total momentum H, conserved in the inertial frame, the bus turns at

    J omega = R^T H - h - B nu.

Where the axes left lie in one plane with normal n, B nu has no part along n, and what no command
can change is

    n . J omega = n . R^T H - kappa,    kappa = n . h.

Rest is then possible exactly where n . R^T H = kappa: everywhere if H = 0 and kappa = 0; where the
normal R n lies on a cone about H if |kappa| <= |H|; nowhere else. Where it is nowhere, the slowest
steady rotation is held: its axis is fixed in the body and in space (docs/wheel_loss.md).
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc import lie
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.types import Array, Matrix3, Vector3
from spacecraft_gnc.vehicles.two_wheel.controllers.report import Rest
from spacecraft_gnc.vehicles.two_wheel.wheels import span_of

NEGLIGIBLE: Final = 1e-9
"""Rate [rad/s] that counts as rest: a degree in half a year."""


class Held(NamedTuple):
    """Best that can be held."""

    rest: Rest
    attitude: Matrix3
    """(3, 3) attitude at rest, body to inertial; where it keeps turning: at its best phase."""
    rate: Vector3
    """(3,) rotation that remains, body frame [rad/s]."""
    pointing_loss: float
    """Angle by which the held pointing is off the target [rad]: of the attitude at rest, or of the
    axis of the rotation, which then is all that can be pointed."""


def plane_normal(axes: Array) -> Vector3:
    """Return the unit normal (3,) of the plane that unit axes (3, m) span."""
    return np.asarray(np.linalg.svd(axes, full_matrices=True)[0][:, 2])


def holdable(
    inertia: Matrix3,
    axes: Array,
    axial: Array,
    healthy: NDArray[np.bool_],
    wheel_speed: Array,
    total_momentum: Vector3,
    target: Matrix3,
) -> Held:
    """Return what can be held nearest to a target.

    Parameters
    ----------
    inertia : (3, 3) array
        Bus and locked wheels, body frame [kg m^2].
    axes, axial : (3, m), (m,) arrays
        Unit spin axes in the body frame, and inertias about them [kg m^2].
    healthy : (m,) bool array
        Wheels that take commands.
    wheel_speed : (m,) array
        Relative to the bus [rad/s]; of the others: the speed that they keep.
    total_momentum : (3,) array
        Of bus and wheels, inertial frame [N m s].
    target : (3, 3) array
        Body to inertial.

    Returns
    -------
    Held

    Raises
    ------
    ParameterError
        If the axes left span fewer than two dimensions: no attitude can then be commanded.

    Assumptions
    -----------
    No limit of speed acts. Momenta that turn the bus by less than `NEGLIGIBLE` count as zero.
    """
    rank = span_of(axes[:, healthy])
    if rank == 3:
        return Held(Rest.AT_TARGET, target, np.zeros(3), 0.0)
    if rank < 2:
        raise ParameterError(
            f"healthy: received {int(np.count_nonzero(healthy))} wheel(s) whose axes span {rank} "
            "dimension(s); required 2 or more, else no attitude can be held; brake the rotation"
        )
    n = plane_normal(axes[:, healthy])
    kappa = float(n @ (axes[:, ~healthy] @ (axial * wheel_speed)[~healthy]))
    across = inertia @ n
    size = float(np.linalg.norm(total_momentum))
    still = abs(kappa) <= NEGLIGIBLE * float(np.linalg.norm(across))
    if is_negligible(inertia, total_momentum):
        if still:
            return Held(Rest.AT_TARGET, target, np.zeros(3), 0.0)
        return Held(Rest.NOWHERE, target, -kappa * across / (across @ across), 0.0)
    direction = total_momentum / size
    if abs(kappa) <= size:
        attitude, loss = on_cone(target, n, direction, kappa / size)
        near = loss * size <= NEGLIGIBLE * float(np.linalg.norm(across))
        rest = Rest.AT_TARGET if near else Rest.ELSEWHERE
        return Held(rest, target if near else attitude, np.zeros(3), loss)
    axis, rate = _slowest(inertia, n, size, kappa)
    turn, loss = _carrying(target @ axis, direction)
    return Held(Rest.NOWHERE, turn @ target, rate * axis, loss)


def is_negligible(inertia: Matrix3, momentum: Vector3) -> bool:
    """Tell whether a momentum (3,) [N m s] turns the bus too slowly to count."""
    least = float(np.linalg.eigvalsh(inertia)[0])
    return float(np.linalg.norm(momentum)) <= NEGLIGIBLE * least


def on_cone(
    attitude: Matrix3, n: Vector3, direction: Vector3, cosine: float
) -> tuple[Array, float]:
    """Return the attitude nearest to one whose axis ``n`` has a cosine to an inertial direction.

    Returns
    -------
    attitude : (3, 3) array
    angle : float
        Between the two [rad]: no rotation by less carries the axis that far.
    """
    normal = attitude @ n
    wanted = math.acos(min(max(cosine, -1.0), 1.0))
    angle = float(lie.vector_angle(normal, direction))
    axis = np.cross(direction, normal)
    length = float(np.linalg.norm(axis))
    axis = axis / length if length > 1e-12 else _normal_to(direction)
    return lie.exp((wanted - angle) * axis) @ attitude, abs(wanted - angle)


def _slowest(inertia: Matrix3, n: Vector3, size: float, kappa: float) -> tuple[Vector3, float]:
    """Return the body axis along the total momentum, and the rate about it, that turn slowest.

    The rate is (size n . p - kappa) / (n . J p) about the axis p. For a given n . p it is least in
    the plane of n and J n, where at an angle a from n, with J n at b, its derivative is zero at
    sin(a - b) = -(size / kappa) sin b.
    """
    across = inertia @ n
    length = float(np.linalg.norm(across))
    side = across - (n @ across) * n
    width = float(np.linalg.norm(side))
    side = side / width if width > 1e-12 * length else _normal_to(n)
    lean = math.atan2(width, float(n @ across))
    off = math.asin(-size / kappa * math.sin(lean))
    found = []
    for angle in (lean + off, lean + math.pi - off):
        axis = math.cos(angle) * n + math.sin(angle) * side
        found.append((axis, (size * float(n @ axis) - kappa) / float(across @ axis)))
    return min(found, key=lambda pair: abs(pair[1]))


def _carrying(start: Vector3, end: Vector3) -> tuple[Matrix3, float]:
    """Return the least rotation (3, 3) that carries one unit vector to another, and its angle."""
    angle = float(lie.vector_angle(start, end))
    axis = np.cross(start, end)
    length = float(np.linalg.norm(axis))
    axis = axis / length if length > 1e-12 else _normal_to(start)
    return lie.exp(angle * axis), angle


def _normal_to(direction: Vector3) -> Vector3:
    """Return a unit vector normal to one, the same for the same."""
    axis = np.cross(direction, np.eye(3)[int(np.argmin(np.abs(direction)))])
    return np.asarray(axis / np.linalg.norm(axis))
