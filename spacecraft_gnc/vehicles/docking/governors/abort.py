"""Abort after a lost thruster direction: retreat to the hold point with what is left.

At each step the forces of the next minutes are planned (`retreat`) for some attitudes to turn to,
and the best plan is flown: the reference is the one for which the law answers with its wrench.
docs/docking.md says why, and what it reaches.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.docking.decision import Answer, DockingDecision, Phase
from spacecraft_gnc.vehicles.docking.governors.diagnosis import AXES, center_of
from spacecraft_gnc.vehicles.docking.governors.retreat import Plan, Retreat
from spacecraft_gnc.vehicles.docking.governors.turn import Turn
from spacecraft_gnc.vehicles.docking.law import FeedbackLaw
from spacecraft_gnc.vehicles.docking.linear import coordinates
from spacecraft_gnc.vehicles.docking.state import DIRECTIONS, RelativeReference, RelativeState

_NEAR: Final = 0.5  # [m] from the hold point, within which it is held
_SLOW: Final = 0.01  # [m/s]
_LOYALTY: Final = 0.1  # share of its cost by which another plan has to cost less
_TRIED: Final = 8  # other attitudes tried in a step, one after the other in turn
_ANGLES: Final = (0.15, 0.25 * math.pi, 0.5 * math.pi, 3.0)  # [rad]; half a turn has no one axis


def _attitudes() -> Array:
    """Return the attitudes (c, 3, 3) to turn to: none, and angles about each axis, either way."""
    axes = np.vstack([np.eye(3), -np.eye(3)])
    turns = [lie.exp(angle * axis) for axis in axes for angle in _ANGLES]
    return np.array([np.eye(3), *turns])


class Abort:
    """Flies to the hold point without one thruster direction.

    Parameters
    ----------
    law : FeedbackLaw
        Of the controller.
    retreat : Retreat
        Plans of forces.
    turn : Turn
        How the deputy turns.
    hold : (3,) array
        Port offset of the hold point [m].
    """

    def __init__(self, law: FeedbackLaw, retreat: Retreat, turn: Turn, hold: Array) -> None:
        self._law, self._retreat, self._turn = law, retreat, turn
        self._wish = np.concatenate([hold, np.zeros(3)])
        self._attitudes = _attitudes()
        self.reset()

    def reset(self) -> None:
        """Forget the plan."""
        self._chosen: int | None = None

    def memory(self) -> tuple[int | None]:
        """Return the attitude chosen last."""
        return (self._chosen,)

    def recall(self, memory: tuple[int | None]) -> None:
        """Go on as the abort did whose `memory` it is."""
        (self._chosen,) = memory

    def decide(self, state: RelativeState, lost: int) -> DockingDecision:
        """Return the reference of the step that starts at ``state``, with a direction lost."""
        motion = state.measured
        plans = self._retreat.at(state.step, center_of(motion, self._turn.port))
        best: tuple[float, int, Plan] | None = None
        iterations = 0
        chosen = self._candidates(state.step)
        turns = self._turn.foretold(
            motion.attitude, motion.angular_velocity, self._attitudes[chosen]
        )
        for index, attitudes in zip(chosen, turns, strict=True):
            plan = plans.best(attitudes, AXES[lost], self._wish[:3])
            if plan is None:
                continue
            iterations += plan.iterations
            cost = plan.cost - _LOYALTY * abs(plan.cost) * (index == self._chosen)
            if best is None or cost < best[0]:
                best = cost, index, plan
        if best is None:  # rest and turn on
            best = 0.0, self._chosen or 0, Plan(np.zeros(3), 0.0, np.inf, np.inf, 0)
        _, self._chosen, plan = best
        moment = self._turn.moment(
            motion.attitude, motion.angular_velocity, self._attitudes[self._chosen]
        )
        wrench = np.concatenate([plan.force, moment])
        reference = self._law.reference(state.step, coordinates(*motion), wrench)
        return DockingDecision(
            RelativeReference.of(reference),
            "",
            Answer.OPTIMAL if plan.sight_miss + plan.depth_miss == 0.0 else Answer.LEAST_VIOLATION,
            self._phase(state),
            self._wish,
            slack=-max(plan.sight_miss, plan.depth_miss),
            constraint=f"no force {DIRECTIONS[lost]}",
            iterations=iterations,
        )

    def _candidates(self, step: int) -> list[int]:
        """Return the attitudes whose plans are compared: all at first, then some in turn."""
        count = len(self._attitudes)
        if self._chosen is None:
            return list(range(count))
        others = [(step * _TRIED + i) % count for i in range(_TRIED)]
        return list(dict.fromkeys([self._chosen, *others]))

    def _phase(self, state: RelativeState) -> Phase:
        far = np.linalg.norm(state.measured.port_offset - self._wish[:3])
        speed = np.linalg.norm(state.measured.port_velocity)
        return Phase.HOLDING if far < _NEAR and speed < _SLOW else Phase.ABORTING
