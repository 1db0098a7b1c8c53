"""One run of a report: its flight and everything that is told of it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from spacecraft_gnc.analysis import series
from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.analysis.reader import load_run
from spacecraft_gnc.analysis.run_info import UNKNOWN_SCENARIO
from spacecraft_gnc.analysis.telemetry import Telemetry, read_telemetry
from spacecraft_gnc.analysis.verdict import Verdict, Watch, audit_verdict
from spacecraft_gnc.types import Array

if TYPE_CHECKING:
    from spacecraft_gnc.analysis.run_info import RunInfo
    from spacecraft_gnc.loop.trajectory import Trajectory
    from spacecraft_gnc.scenario import Scenario


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
        As `metrics.summarize` gives them, and ``missed_deadlines`` (None: no free run).
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

    @property
    def times(self) -> Array:
        """(n + 1,) of the states [s]."""
        return series.state_times(self.trajectory)

    def warnings(self) -> list[str]:
        """Return what a reader should know before trusting the curves, one line each."""
        lines = [line.removeprefix(f"{self.info.path}: ") for line in self.info.warnings()]
        counted = {
            "missing_steps": "steps without a state or a torque (gaps in the curves)",
            "unconverged_steps": "solves that did not converge",
            "fallback_steps": "steps flown on a fallback torque",
            "inadmissible_steps": "steps without an admissible reference",
        }
        for key, what in counted.items():
            if self.metrics[key]:
                lines.append(f"{what}: {self.metrics[key]}")
        if self.telemetry.missed_deadlines:
            missed = self.telemetry.missed_deadlines
            lines.append(f"torques that came after their deadline: {missed}")
        late = int(np.count_nonzero(self.telemetry.deadline_slack < 0.0))
        if late:
            lines.append(f"solves that ended after their deadline: {late}")
        margins = self.metrics["zone_margin_deg"].items()
        lines += [
            f"pointing zone {name} was violated by {-margin:.3g} deg"
            for name, margin in margins
            if margin is not None and margin < 0.0
        ]
        if self.verdict.passed is False:
            lines.append(f"the audit failed: {self.verdict.text}")
        if self.scenario is None:
            lines.append(UNKNOWN_SCENARIO)
        return lines


def read_run(
    path: Path,
    name: str,
    scenario: Scenario | None = None,
    *,
    namespace: str | None = None,
    allow_unfinished: bool = False,
    progress: Watch | None = None,
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
    namespace
        Of the spacecraft, where the bag holds several.
    allow_unfinished
        Read what is whole of a bag that was cut off, instead of refusing it.
    progress
        Returns, for the name of a part of the work, what is called with its progress.

    Raises
    ------
    RecordingError
        If it cannot be read.
    """
    flight = load_run(path, namespace=namespace, allow_unfinished=allow_unfinished)
    known = flight.info.scenario or scenario
    telemetry = read_telemetry(flight, known, allow_unfinished=allow_unfinished)
    missed = {"missed_deadlines": telemetry.missed_deadlines}
    return Run(
        name=name,
        trajectory=flight.trajectory,
        info=flight.info,
        telemetry=telemetry,
        scenario=known,
        metrics=summarize(flight.trajectory, known) | missed,
        verdict=audit_verdict(
            path, namespace=namespace, allow_unfinished=allow_unfinished, progress=progress
        ),
    )
