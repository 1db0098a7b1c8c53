"""One run of a report: its flight and everything that is told of it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.analysis.telemetry import Telemetry, read_telemetry
from spacecraft_gnc.analysis.verdict import Verdict, audit_verdict
from spacecraft_gnc.recording.reader import load_run
from spacecraft_gnc.recording.steps import WALL_TIMING

if TYPE_CHECKING:
    from spacecraft_gnc.loop.trajectory import Trajectory
    from spacecraft_gnc.recording.run_info import RunInfo
    from spacecraft_gnc.scenario import Scenario

_BAG_FOLDER = "bag"  # what `gnc launch` calls it: its parent is the name of the run
_LOSSES = "losses"  # metadata record: steps that the recorder missed, by topic


@dataclass(frozen=True, slots=True)
class Run:
    """A flight with its metrics.

    Attributes
    ----------
    name
        How the report calls it; unique in the report.
    trajectory, info, telemetry
        What was recorded.
    scenario
        What flew, from the recording or from the user; None: not known.
    metrics
        As `metrics.summarize` gives them.
    verdict
        Of the audit.
    """

    name: str
    trajectory: Trajectory
    info: RunInfo
    telemetry: Telemetry
    scenario: Scenario | None
    metrics: dict[str, Any]
    verdict: Verdict

    def warnings(self) -> list[str]:
        """Return what a reader should know before trusting the curves, one line each."""
        lines = self.info.warnings()
        for topic, count in self.info.metadata.get(_LOSSES, {}).items():
            # The plant sends the wall timing a few times a second only: its gaps are no losses.
            if count not in ("0", "") and not topic.endswith(WALL_TIMING):
                lines.append(f"the recorder counted {count} lost steps on {topic}")
        if self.metrics["missing_steps"]:
            lines.append(
                f"{self.metrics['missing_steps']} steps are incomplete: gaps in the curves"
            )
        if self.metrics["unconverged_steps"]:
            lines.append(f"{self.metrics['unconverged_steps']} solves did not converge")
        if self.metrics["fallback_steps"]:
            lines.append(f"{self.metrics['fallback_steps']} steps flew on a fallback torque")
        if self.scenario is None:
            lines.append("the scenario is not known: no torque limit, no zones, no cost")
        return lines


def read_run(
    path: Path,
    name: str,
    scenario: Scenario | None = None,
    *,
    allow_unfinished: bool = False,
) -> Run:
    """Read a run, and audit it.

    Parameters
    ----------
    path
        Bag folder, .mcap file, or .npz file of ``gnc simulate --out``.
    name
        How the report calls it.
    scenario
        Used where the recording does not hold its own.
    allow_unfinished
        Read what is whole of a bag that was cut off, instead of refusing it.

    Raises
    ------
    RecordingError
        If it cannot be read.
    """
    flight = load_run(path, allow_unfinished=allow_unfinished)
    known = flight.info.scenario or scenario
    return Run(
        name=name,
        trajectory=flight.trajectory,
        info=flight.info,
        telemetry=read_telemetry(flight, known, allow_unfinished=allow_unfinished),
        scenario=known,
        metrics=summarize(flight.trajectory, known),
        verdict=audit_verdict(flight),
    )


def run_name(path: Path) -> str:
    """Return a short name of the run in a bag or file."""
    resolved = path.resolve()
    if resolved.is_dir() and resolved.name == _BAG_FOLDER and resolved.parent.name:
        return resolved.parent.name
    return resolved.name if resolved.is_dir() else resolved.stem


def run_names(paths: Iterable[Path]) -> list[str]:
    """Return a name for each run; where short ones would be the same, the paths as given."""
    paths = list(paths)
    short = [run_name(path) for path in paths]
    if len(set(short)) == len(short):
        return short
    full = [str(path) for path in paths]
    return [f"{path} ({i})" if full.count(path) > 1 else path for i, path in enumerate(full, 1)]
