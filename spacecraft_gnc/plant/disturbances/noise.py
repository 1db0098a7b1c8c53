"""White-noise torque, drawn anew for each control step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from spacecraft_gnc.arguments import as_count
from spacecraft_gnc.arrays import listed
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.parameters.parameter import LARGEST, Kind, parameter
from spacecraft_gnc.plant.random_numbers import LARGEST_SEED, SeedParameters, standard_normals
from spacecraft_gnc.types import ArrayLike, Matrix3, Vector3, as_vector3

STREAM = "disturbances.noise"

if TYPE_CHECKING:
    from spacecraft_gnc.plant.disturbances.torques import Motion


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class NoiseParameters(SeedParameters):
    """What ``noise`` reads of the section of the plant."""

    noise_torque: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "noise: standard deviation about each body axis of the torque held over a control step",
        unit="N m",
        shape=(3,),
        may_be_empty=True,
        minimum=0.0,
        maximum=LARGEST,
        is_neutral=True,
    )


class NoiseTorque:
    """A Gaussian torque, independent between axes and control steps, held over each step.

    A step of length T adds momentum of deviation T sigma, so that a spectral density S
    [N^2 m^2 s] takes sigma = sqrt(S / T).

    Parameters
    ----------
    deviation : (3,) array
        Standard deviation sigma about each body axis [N m].
    seed, run : int
        Master seed, and the run of a campaign.

    Raises
    ------
    ShapeError, ParameterError
        If an argument is refused.
    """

    def __init__(self, deviation: ArrayLike, seed: int = 0, run: int = 0) -> None:
        self.deviation = as_vector3("noise_torque", deviation)
        if (self.deviation < 0.0).any():
            raise ParameterError(
                f"noise_torque: received {listed(self.deviation)}; required standard deviations "
                ">= 0; change the sign"
            )
        self.seed = as_count("seed", seed, least=0, most=LARGEST_SEED)
        self.run = as_count("run", run, least=0, most=LARGEST_SEED)

    @classmethod
    def from_parameters(cls, parameters: NoiseParameters, _: Matrix3) -> NoiseTorque:
        """Build it from ``noise_torque``, ``seed`` and ``run``."""
        if np.isnan(parameters.noise_torque).all():
            raise ParameterError(
                "noise_torque: received nothing; required 3 standard deviations [N m] for the "
                "disturbance 'noise'; add it, such as [1.0e-5, 1.0e-5, 1.0e-5]"
            )
        return cls(parameters.noise_torque, parameters.seed, parameters.run)

    def torque(self, motion: Motion) -> Vector3:
        """Return the torque (3,) of the step, body frame [N m]."""
        normals = standard_normals(self.seed, self.run, STREAM, motion.step, 3)
        return np.asarray(self.deviation * normals)
