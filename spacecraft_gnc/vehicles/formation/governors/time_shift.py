"""Governor ``time_shift``: shifts along the natural trajectory that keep every constraint."""

from __future__ import annotations

import time
from typing import Any, Final

import numpy as np

from spacecraft_gnc.governors.time_shift import Margin, TimeShiftDecision, TimeShiftGovernor
from spacecraft_gnc.vehicles.formation.decision import Answer, FormationDecision
from spacecraft_gnc.vehicles.formation.governors.desired import DesiredFormation
from spacecraft_gnc.vehicles.formation.state import FormationState
from spacecraft_gnc.vehicles.formation.trajectory import NaturalTrajectory

_NO_MARGIN: Final = ("", np.inf, -1.0)


class FormationGovernor(DesiredFormation):
    """Choose the shifts of every step.

    Parameters
    ----------
    trajectory : NaturalTrajectory
    governor : TimeShiftGovernor
        Of the same trajectory.
    names : tuple of str
        Of the craft, as messages name them.
    """

    name = "time_shift"
    slow = False

    def __init__(
        self, trajectory: NaturalTrajectory, governor: TimeShiftGovernor, names: tuple[str, ...]
    ) -> None:
        super().__init__(trajectory)
        self._governor = governor
        self._names = names

    def warm_up(self) -> None:
        """Load the kernels, and search the passages out of deadlocks."""
        self._governor.warm_up()

    def reset(self) -> None:
        """Forget the last shifts and what was observed."""
        self._governor.reset()

    def memory(self) -> tuple[Any, ...] | None:
        """Return the governor's."""
        return self._governor.memory()

    def recall(self, memory: tuple[Any, ...]) -> None:
        """Go on as the governor did whose `memory` it is."""
        self._governor.recall(memory)

    def decide(self, state: FormationState) -> FormationDecision:
        """Return what the craft are to track from a step on."""
        begun = time.perf_counter()
        applied = state.applied if state.step else None
        found = self._governor.decide(state.step, state.vectors, applied)
        return self._told(found, begun)

    def _told(self, found: TimeShiftDecision, begun: float) -> FormationDecision:
        constraint, margin, ahead = self._in_words(found.margin)
        refused, refused_margin, _ = self._in_words(found.refused)
        reference = self._trajectory.reference(found.step, found.shifts)
        return FormationDecision(
            reference,
            self.name,
            Answer(found.answer),
            found.cost,
            found.shift_cost,
            found.state_cost,
            found.n_admissible,
            found.n_candidates,
            constraint,
            margin,
            ahead,
            refused,
            refused_margin,
            found.error,
            found.deadlocked,
            found.waypoint,
            found.waypoints_left,
            found.lost,
            np.array(found.response),
            found.formed,
            time.perf_counter() - begun,
        )

    def _in_words(self, margin: Margin | None) -> tuple[str, float, float]:
        if margin is None:
            return _NO_MARGIN
        return margin.text(self._names), margin.share, margin.ahead
