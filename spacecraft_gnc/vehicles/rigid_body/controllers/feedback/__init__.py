"""``method: feedback``: T = -K Pi - e, Kalabic et al. 2014, (8)-(10)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from spacecraft_gnc.lazy import Lazy
from spacecraft_gnc.parameters.parameter import LARGEST, Kind, MatrixRule, parameter
from spacecraft_gnc.status import Source
from spacecraft_gnc.types import Matrix3
from spacecraft_gnc.vehicles.vehicle import Method


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class FeedbackParameters:
    """Parameters of ``method: feedback``."""

    feedback_attitude_gain: Matrix3 = parameter(
        Kind.DOUBLE_ARRAY,
        [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        "feedback: gain A on the attitude error",
        unit="N m",
        shape=(3, 3),
        matrix=MatrixRule.DEFINITE,
        maximum=LARGEST,
        may_be_empty=True,
        formula="omega^2 (0.501 tr(J) I - J)",
    )
    feedback_momentum_gain: Matrix3 = parameter(
        Kind.DOUBLE_ARRAY,
        [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        "feedback: gain K on the angular momentum",
        unit="1/s",
        shape=(3, 3),
        matrix=MatrixRule.DEFINITE,
        maximum=LARGEST,
        may_be_empty=True,
        formula="2 omega I",
    )


METHOD: Final = Method(
    name="feedback",
    build=Lazy(f"{__name__}.controller:FeedbackController.from_scenario"),
    parameters=FeedbackParameters,
    memoryless=True,
    former_source=Source.FEEDBACK,
)
