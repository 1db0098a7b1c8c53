"""Single runs of a campaign, flown again and compared with their rows bit for bit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from spacecraft_gnc.campaign.flyer import Flown, Flyer, row_differences
from spacecraft_gnc.campaign.keeping import flown_and_failed
from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.loop.flight import Flight

if TYPE_CHECKING:
    from spacecraft_gnc.campaign.results import Campaign
    from spacecraft_gnc.scenario import Scenario

_WALL: Final = "wall_"


@dataclass(frozen=True, slots=True, eq=False)
class Rerun:
    """A run that was flown again alone.

    Attributes
    ----------
    run
        Its number.
    recorded
        Its row in the campaign.
    flown
        Row, flight and scenario of the new flight.
    differences
        The columns that differ by a bit, a text for each, in the order of the row.
    flyer
        What flew it.
    """

    run: int
    recorded: dict[str, Any]
    flown: Flown
    differences: tuple[str, ...]
    flyer: Flyer

    def require_flight(self) -> tuple[Flight, Scenario]:
        """Return flight and scenario of a run that flew to its end.

        Raises
        ------
        RecordingError
            If it did not.
        """
        if self.flown.flight is None or self.flown.scenario is None:
            raise RecordingError(
                f"run {self.run}: received a run without a flight ({self.flown.row['reason']}); "
                "required one that flew to its end; choose another one"
            )
        return self.flown.flight, self.flown.scenario

    def compare(self, flight: Flight) -> tuple[str, ...]:
        """Return in what a flight made elsewhere differs from the one flown again and its row.

        Every array is compared, then every column of the row; wall times are left out.

        Raises
        ------
        RecordingError
            If the run did not fly to its end.
        """
        ours, scenario = self.require_flight()
        row = self.flyer.row_of(self.run, flight, scenario)
        return (*_array_differences(ours, flight), *row_differences(self.recorded, row))


def fly_again(campaign: Campaign, run: int) -> Rerun:
    """Fly one run again, from what the folder of its campaign holds alone.

    Parameters
    ----------
    campaign
        An opened campaign.
    run
        Number of the run.

    Raises
    ------
    RecordingError
        If the campaign has no row of that run.
    """
    recorded = campaign.row(run)
    flyer = Flyer(campaign.spec)
    flown = flyer.fly(run)
    return Rerun(run, recorded, flown, tuple(row_differences(recorded, flown.row)), flyer)


def _array_differences(first: Flight, second: Flight) -> Iterator[str]:
    """Yield each array in which two flights differ by a bit, with the first step; no wall times."""
    compared = {
        name: not column.at_end
        for name, column in type(first).columns()
        if not column.member.rpartition(".")[2].startswith(_WALL)
    }
    for name, is_by_step in {"time": True, **compared}.items():
        ours, theirs = getattr(first, name), getattr(second, name)
        if ours.shape != theirs.shape or ours.dtype != theirs.dtype:
            yield f"array {name}: {ours.dtype} {ours.shape} / {theirs.dtype} {theirs.shape}"
        elif not np.array_equal(ours, theirs, equal_nan=True):
            apart = np.argwhere(~((ours == theirs) | (np.isnan(ours) & np.isnan(theirs))))
            yield f"array {name}{f', step {apart[0][0]}' if is_by_step else ''}"


def spot_runs(campaign: Campaign, count: int) -> tuple[int, ...]:
    """Return runs to check, ascending, drawn by the campaign's seed from those that flew.

    Parameters
    ----------
    campaign
        A complete campaign.
    count
        How many; fewer where fewer flew to their end.
    """
    flown, _ = flown_and_failed(campaign)
    random = np.random.Generator(np.random.Philox(key=[campaign.spec.seed, count]))
    return tuple(sorted(random.choice(flown, min(count, len(flown)), replace=False).tolist()))


def write_scenario(scenario: Scenario, path: Path) -> None:
    """Write the scenario of a run as a file that ``gnc simulate`` and ``gnc launch`` take.

    Raises
    ------
    RecordingError
        If it cannot be written.
    """
    try:
        path.write_text(scenario.to_yaml(), encoding="utf-8")
    except OSError as error:
        raise RecordingError(
            f"{path}: cannot be written ({error.strerror}); required a folder that can be written; "
            "choose another --out"
        ) from error
