"""Summary metrics of one flight."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from spacecraft_gnc.analysis.vehicle import part
from spacecraft_gnc.scenario.fingerprint import fingerprint

if TYPE_CHECKING:
    from spacecraft_gnc.loop.flight import Flight
    from spacecraft_gnc.scenario import Scenario


def summarize(flight: Flight, scenario: Scenario | None = None) -> dict[str, Any]:
    """Return the metrics of a flight, ready for JSON.

    Parameters
    ----------
    flight
        What was flown.
    scenario
        Gives limits, weights and the like; without it the metrics that need them are None.

    Returns
    -------
    dict
        ``scenario_hash`` (see `scenario.fingerprint`; None without a scenario), and what the
        vehicle counts (its module ``metrics``).
    """
    about = {"scenario_hash": None if scenario is None else fingerprint(scenario)}
    told: dict[str, Any] = part("metrics", scenario)(flight, scenario)
    return about | told
