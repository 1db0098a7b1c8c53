"""Short flights that compile every kernel of the formation."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final

from spacecraft_gnc.vehicles.formation.parameters.plant import TRUTHS
from spacecraft_gnc.vehicles.formation.scenario import Scenario

_STEPS: Final = 2.5
_PERIOD: Final = 109.8  # about that of the default orbit [s]


def flights() -> Iterator[dict[str, Any]]:
    """Yield scenarios, by section: every motion, and the governor at a start that it admits."""
    for truth in TRUTHS:
        yield {
            "plant": {
                "vehicle": "formation",
                "motion": truth,
                "initial_along_track_offset": [6103.0, 8325.0, 5036.0],
                "initial_amplitude": [1.53, 1.705, 0.877],
                "duration": _STEPS * _PERIOD,
            },
            "reference_governor": {"governor": "time_shift" if truth == "hill" else "none"},
        }


def compile_further(scenario: Scenario) -> None:
    """Compile what no flight needs: nothing."""
    del scenario


WARMUP: Final = (flights, compile_further)
