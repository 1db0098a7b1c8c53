"""Methods of the rigid body, and the section of the scenario file that they read."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from spacecraft_gnc.parameters.parameter import group
from spacecraft_gnc.vehicles.rigid_body.controllers import (
    feedback,
    fsolve,
    neighboring_extremal,
    planned,
    shooting,
    slsqp,
    terminal_set,
)
from spacecraft_gnc.vehicles.rigid_body.controllers.feedback import FeedbackParameters
from spacecraft_gnc.vehicles.rigid_body.controllers.neighboring_extremal import (
    NeighboringParameters,
)
from spacecraft_gnc.vehicles.rigid_body.controllers.planned import PlannedParameters
from spacecraft_gnc.vehicles.rigid_body.controllers.terminal_set import (
    TerminalSetParameters,
    TerminalSetWeights,
)
from spacecraft_gnc.vehicles.rigid_body.parameters.common import CommonParameters
from spacecraft_gnc.vehicles.rigid_body.parameters.ocp import PenalizedWeights
from spacecraft_gnc.vehicles.vehicle import Method

METHODS: Final[tuple[Method, ...]] = (
    shooting.METHOD,
    neighboring_extremal.METHOD,
    slsqp.METHOD,
    fsolve.METHOD,
    terminal_set.METHOD,
    feedback.METHOD,
    planned.METHOD,
)


@dataclass(frozen=True, kw_only=True, eq=False)
class WeightParameters(TerminalSetWeights, PenalizedWeights):
    """Weights of all costs."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ControllerParameters(
    FeedbackParameters,
    TerminalSetParameters,
    NeighboringParameters,
    PlannedParameters,
    CommonParameters,
):
    """Section ``nmpc_controller``: what every method reads, and what each one adds."""

    weights: WeightParameters = group(WeightParameters)
