"""Governor ``none``: every craft tracks its desired place, without shifts."""

from __future__ import annotations

import numpy as np

from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.formation.decision import Answer, FormationDecision
from spacecraft_gnc.vehicles.formation.state import FormationState
from spacecraft_gnc.vehicles.formation.trajectory import NaturalTrajectory


class PassThroughGovernor:
    """Shift nothing.

    Parameters
    ----------
    trajectory : NaturalTrajectory
    formed_error : float
        Position error below which the craft count as formed [m].
    """

    name = "none"
    slow = False

    def __init__(self, trajectory: NaturalTrajectory, formed_error: float) -> None:
        self._trajectory = trajectory
        self._formed_error = formed_error
        self._shift = np.zeros(len(trajectory.phases), dtype=np.int64)

    @property
    def target(self) -> Array:
        """Desired phases (n,) [control steps]."""
        return self._trajectory.phases

    def set_target(self, target: Array) -> None:
        """Refuse: the desired phases are the scenario's, and no topic asks for others.

        Raises
        ------
        ParameterError
            Always.
        """
        raise ParameterError(
            f"target: received {target!r}; required none, as the desired phases are those of the "
            "scenario; set reference_governor.phase"
        )

    def warm_up(self) -> None:
        """Nothing to load."""

    def reset(self) -> None:
        """Nothing to forget."""

    def decide(self, state: FormationState) -> FormationDecision:
        """Return the desired states of the step."""
        reference = self._trajectory.reference(state.step, self._shift)
        errors = np.linalg.norm(state.position - reference.position, axis=1)
        formed = bool((errors < self._formed_error).all())
        return FormationDecision(reference, self.name, Answer.PASSED, formed=formed)
