"""What a solve may be asked to track: an attitude at rest, or one that moves."""

from __future__ import annotations

from typing import Final, TypeAlias

import numpy as np

from spacecraft_gnc.arrays import listed
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.types import Array, ArrayLike, Reference, as_rotation, as_vector3, read_only

Tracked: TypeAlias = ArrayLike | Reference
"""A (3, 3) attitude at rest, or a `Reference` with the rate and torque with which it moves."""

RESTING: Final = read_only(np.zeros((2, 3)))
"""Angular velocity and torque fed forward for a reference at rest."""


AT_REST: Final = RESTING[0].tobytes()


def as_reference(reference: Tracked | None) -> Reference:
    """Return what is to be tracked from now on, checked; None is the identity at rest.

    Raises
    ------
    ShapeError, ParameterError
        If the attitude is no rotation, or the rate or the torque are not 3 finite numbers.
    """
    if not isinstance(reference, Reference):
        return Reference(as_rotation("reference", _or_identity(reference)), *RESTING)
    return Reference(as_rotation("reference.attitude", reference.attitude), *motion_of(reference))


def motion_of(reference: Reference) -> Array:
    """Return (2, 3) angular velocity and torque, checked."""
    rate = as_vector3("reference.angular_velocity", reference.angular_velocity)
    return np.array([rate, as_vector3("reference.torque", reference.torque)])


def is_moving(reference: Reference) -> bool:
    """Tell whether a reference has a rate or a torque to be fed forward."""
    _, rate, torque = reference
    try:  # ten times faster, and right but for -0
        if rate.tobytes() == AT_REST == torque.tobytes():
            return False
    except AttributeError:  # a list, say
        pass
    return bool(np.any(rate) or np.any(torque))


def is_fixed(reference: Reference) -> bool:
    """Tell whether the rate and the torque of a reference are arrays that nobody can write to."""
    return all(isinstance(each, np.ndarray) and not each.flags.writeable for each in reference[1:])


def unreachable(reference: Reference, time_step: float) -> ParameterError:
    """Return the error that says why a reference cannot move as it is asked to."""
    return ParameterError(
        f"reference: received angular velocity {listed(reference.angular_velocity)} rad/s and "
        f"torque {listed(reference.torque)} N m; required a motion of which every step of "
        f"{time_step:g} s over the horizon exists (Kalabic et al. 2014, (3)); turn more slowly, or "
        "use a shorter time step"
    )


def stacked(reference: Reference) -> Array:
    """Return the rows (5, 3) R_ref, omega_ref, tau_ref that the kernels take."""
    return np.vstack([np.asarray(value) for value in reference])


def _or_identity(attitude: ArrayLike | None) -> ArrayLike:
    return np.eye(3) if attitude is None else attitude
