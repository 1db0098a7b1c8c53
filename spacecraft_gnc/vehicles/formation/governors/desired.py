"""Desired formation, which every governor of the formation holds and no topic changes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.vehicles.formation.trajectory import NaturalTrajectory


class DesiredFormation:
    """The desired phases of the craft.

    Parameters
    ----------
    trajectory : NaturalTrajectory
    """

    def __init__(self, trajectory: NaturalTrajectory) -> None:
        self._trajectory = trajectory

    @property
    def target(self) -> NDArray[np.int64]:
        """Desired phases (n,) [control steps]."""
        return self._trajectory.phases

    def set_target(self, target: object) -> None:
        """Refuse: the desired phases are the scenario's.

        Raises
        ------
        ParameterError
            Always.
        """
        raise ParameterError(
            f"target: received {target!r}; required none, as the desired phases are those of the "
            "scenario; set reference_governor.phase"
        )
