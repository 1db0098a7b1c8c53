"""Body torque for a limited time: a thruster that fires once, or a collision."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from spacecraft_gnc.arguments import as_limit, require_positive
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.parameters.parameter import LONGEST, WITHIN, Kind, NodeParameters, parameter
from spacecraft_gnc.types import ArrayLike, Matrix3, Vector3, as_vector3, read_only

if TYPE_CHECKING:
    from spacecraft_gnc.plant.disturbances.torques import Motion

_NOTHING: Final = read_only(np.zeros(3))
_ROUNDING: Final = 1e-9  # relative, of a time in steps


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class PushParameters(NodeParameters):
    """What ``push`` reads of the section of the plant."""

    push_torque: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "push: torque while it lasts, body frame",
        unit="N m",
        shape=(3,),
        may_be_empty=True,
        **WITHIN,
        is_neutral=True,
    )
    push_time: float = parameter(
        Kind.DOUBLE,
        0.0,
        "push: time at which it begins",
        unit="s",
        minimum=0.0,
        maximum=LONGEST,
        is_neutral=True,
    )
    push_duration: float = parameter(
        Kind.DOUBLE,
        0.0,
        "push: how long it lasts",
        unit="s",
        minimum=0.0,
        maximum=LONGEST,
        is_neutral=True,
    )


class Push:
    """A torque that is constant in the body frame, for a limited time.

    Parameters
    ----------
    value : (3,) array
        Torque, body frame [N m].
    time, duration : float
        When it begins, and how long it lasts [s].

    Raises
    ------
    ShapeError, ParameterError
        If an argument is refused.

    Notes
    -----
    The impulses of the integrator come at the ends of its steps: a push from t on is first felt in
    the step that begins at t.
    """

    def __init__(self, value: ArrayLike, time: float, duration: float) -> None:
        self.value = as_vector3("push_torque", value)
        self.time = as_limit("push_time", time)
        self.duration = require_positive("push_duration", duration)

    @classmethod
    def from_parameters(cls, parameters: PushParameters, _: Matrix3) -> Push:
        """Build it from ``push_torque``, ``push_time`` and ``push_duration``."""
        if np.isnan(parameters.push_torque).all():
            raise ParameterError(
                "push_torque: received nothing; required 3 numbers [N m] for the disturbance "
                "'push'; add it, such as [1.0e-2, 0.0, 0.0]"
            )
        if parameters.push_duration == 0.0:
            raise ParameterError(
                "push_duration: received 0.0 s; required a positive time for the disturbance "
                "'push'; add it, such as 1.0"
            )
        return cls(parameters.push_torque, parameters.push_time, parameters.push_duration)

    def torque(self, motion: Motion) -> Vector3:
        """Return the torque (3,), body frame [N m]."""
        since, room = motion.time - self.time, _ROUNDING * motion.time
        return self.value if room < since <= self.duration + room else _NOTHING
