"""Constant body torque: a leak, or a misaligned thruster that burns all the time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.parameters.parameter import WITHIN, Kind, NodeParameters, parameter
from spacecraft_gnc.types import ArrayLike, Matrix3, Vector3, as_vector3

if TYPE_CHECKING:
    from spacecraft_gnc.plant.disturbances.torques import Motion


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class ConstantParameters(NodeParameters):
    """What ``constant`` reads of the section of the plant."""

    constant_torque: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "constant: torque, body frame",
        unit="N m",
        shape=(3,),
        may_be_empty=True,
        **WITHIN,
        is_neutral=True,
    )


class ConstantTorque:
    """A torque that is constant in the body frame.

    Parameters
    ----------
    value : (3,) array
        Torque, body frame [N m].

    Raises
    ------
    ShapeError, ParameterError
        If it is not three finite numbers.
    """

    def __init__(self, value: ArrayLike) -> None:
        self.value = as_vector3("constant_torque", value)

    @classmethod
    def from_parameters(cls, parameters: ConstantParameters, _: Matrix3) -> ConstantTorque:
        """Build it from ``constant_torque``."""
        if np.isnan(parameters.constant_torque).all():
            raise ParameterError(
                "constant_torque: received nothing; required 3 numbers [N m] for the disturbance "
                "'constant'; add it, such as [1.0e-4, 0.0, 0.0]"
            )
        return cls(parameters.constant_torque)

    def torque(self, motion: Motion) -> Vector3:
        """Return the torque (3,), body frame [N m]."""
        return self.value
