"""A recorded flight with its telemetry, as figures and reports take it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from spacecraft_gnc.analysis.reader import RecordedRun, is_npz
from spacecraft_gnc.analysis.vehicle import has_part, part
from spacecraft_gnc.recording.bag import open_bag
from spacecraft_gnc.types import Array

if TYPE_CHECKING:
    from spacecraft_gnc.analysis.run_info import RunInfo
    from spacecraft_gnc.drawing.vehicle import VehicleReport
    from spacecraft_gnc.loop.flight import Flight
    from spacecraft_gnc.scenario import Scenario


@dataclass(frozen=True, slots=True, kw_only=True)
class Flown:
    """A flight.

    Attributes
    ----------
    name
        How it is called; unique among the flights of a figure or page.
    trajectory, info
        What was recorded.
    telemetry
        What the vehicle reads beside them; None where its report reads nothing.
    scenario
        What flew, from the recording or from the user; None: not known.
    """

    name: str
    trajectory: Flight
    info: RunInfo
    telemetry: Any
    scenario: Scenario | None

    @property
    def times(self) -> Array:
        """(n + 1,) of the states [s]."""
        time = self.trajectory.time
        return np.append(time, time[-1] + self.trajectory.period)


def flown(
    name: str, flight: RecordedRun, scenario: Scenario | None, *, allow_unfinished: bool = False
) -> Flown:
    """Return a flight with what its bag tells beside its arrays.

    Raises
    ------
    RecordingError
        If the bag cannot be read any more.
    """
    return Flown(
        name=name,
        trajectory=flight.trajectory,
        info=flight.info,
        telemetry=_telemetry(flight, scenario, allow_unfinished=allow_unfinished),
        scenario=scenario,
    )


def _telemetry(flight: RecordedRun, scenario: Scenario | None, *, allow_unfinished: bool) -> Any:
    """Return what a flight tells beside its arrays, from its bag where it has one."""
    if not has_part("report", scenario):
        return None
    vehicle: VehicleReport = part("report", scenario)
    path = flight.info.path
    if is_npz(path):
        return vehicle.telemetry(flight.trajectory, scenario, None)
    with open_bag(path, allow_unfinished=allow_unfinished) as bag:
        return vehicle.telemetry(flight.trajectory, scenario, bag, flight.info.namespace)
