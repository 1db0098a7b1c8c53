"""Governor ``none``: every craft tracks its desired place, without shifts."""

from __future__ import annotations

import numpy as np

from spacecraft_gnc.vehicles.formation.decision import Answer, FormationDecision
from spacecraft_gnc.vehicles.formation.governors.desired import DesiredFormation
from spacecraft_gnc.vehicles.formation.state import FormationState
from spacecraft_gnc.vehicles.formation.trajectory import NaturalTrajectory


class PassThroughGovernor(DesiredFormation):
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
        super().__init__(trajectory)
        self._formed_error = formed_error
        self._shift = np.zeros(len(trajectory.phases), dtype=np.int64)
        self._lost = np.zeros(len(trajectory.phases), dtype=bool)

    def warm_up(self) -> None:
        """Nothing to load."""

    def reset(self) -> None:
        """Nothing to forget."""

    def memory(self) -> tuple[()]:
        """Return nothing."""
        return ()

    def recall(self, memory: tuple[()]) -> None:
        """Nothing to remember."""

    def decide(self, state: FormationState) -> FormationDecision:
        """Return the desired states of the step."""
        reference = self._trajectory.reference(state.step, self._shift)
        error = float(np.linalg.norm(state.position - reference.position, axis=1).max())
        formed = error < self._formed_error
        return FormationDecision(
            reference, self.name, Answer.PASSED, error=error, lost=self._lost, formed=formed
        )
