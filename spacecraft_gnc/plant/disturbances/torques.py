"""The external torque of one control step, as a sum of parts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

import numpy as np

from spacecraft_gnc.arguments import shown
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.types import Matrix3, Vector3, read_only


class Motion(NamedTuple):
    """Motion of the body at one instant, as a disturbance sees it."""

    step: int
    """Control step that the instant belongs to."""
    time: float
    """[s] since the start of step 0."""
    attitude: Matrix3
    """(3, 3) rotation, body to inertial."""
    angular_velocity: Vector3
    """(3,) body rate, body frame [rad/s]."""


class Disturbance(Protocol):
    """One external torque: a pure function of the motion, so that a flight can be flown again."""

    def torque(self, motion: Motion) -> Vector3:
        """Return the torque (3,) at ``motion``, body frame [N m]."""


@dataclass(frozen=True, slots=True)
class Disturbances:
    """The disturbances of one body, by name; false where there are none."""

    parts: Mapping[str, Disturbance] = field(default_factory=dict)

    def __len__(self) -> int:
        """Return the number of parts."""
        return len(self.parts)

    def torque(self, *motions: Motion) -> Vector3:
        """Return the sum of the parts (3,), body frame [N m], its mean over several instants.

        Raises
        ------
        ParameterError
            If a part fails, or returns anything but three finite numbers.
        """
        total = np.zeros(3)
        for motion in motions:
            total += self._at(motion)
        return read_only(total / len(motions))

    def _at(self, motion: Motion) -> Vector3:
        total = np.zeros(3)
        for name, part in self.parts.items():
            total += _finite_torque(name, part, motion)
        return total


def _finite_torque(name: str, part: Disturbance, motion: Motion) -> Vector3:
    try:
        torque = np.asarray(part.torque(motion), dtype=np.float64)
    except Exception as error:  # a plug-in may raise anything
        raise _refusal(name, motion, shown(error)) from error
    if torque.shape != (3,) or not np.isfinite(torque).all():
        raise _refusal(name, motion, shown(torque.tolist()))
    return torque


def _refusal(name: str, motion: Motion, received: str) -> ParameterError:
    return ParameterError(
        f"disturbances: received {received} from {name!r} at step {motion.step}; required a "
        f"finite body torque (3,) [N m]; mend the package of {name!r}"
    )
