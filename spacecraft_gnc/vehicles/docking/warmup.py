"""Short flights that compile every kernel of the docking vehicle."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final

from spacecraft_gnc.vehicles.docking.controllers.methods import METHODS
from spacecraft_gnc.vehicles.docking.scenario import Scenario


def flights() -> Iterator[dict[str, Any]]:
    """Yield scenarios, by section: every method, both gravities, a chief that does not rotate.

    No governor with sets among them: those take minutes, and no kernel of their own.
    """
    for method in METHODS:
        for exact in (False, True):
            yield {
                "plant": {
                    "vehicle": "docking",
                    "chief_spin_rate": 0.0,
                    "two_body": exact,
                    "gravity_gradient": exact,
                    "duration": 10.0,
                },
                "nmpc_controller": {"method": method.name},
                "reference_governor": {"governor": "none"},
            }


def compile_further(scenario: Scenario) -> None:
    """Compile what no flight needs: nothing."""
    del scenario


WARMUP: Final = (flights, compile_further)
