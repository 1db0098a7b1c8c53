"""Run of a report: its flight, scenario, metrics and audit."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from spacecraft_gnc.analysis.flown import Flown, flown
from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.analysis.plan_file import is_plan
from spacecraft_gnc.analysis.plans import planner_of, read_plan, report_part
from spacecraft_gnc.analysis.reader import load_run
from spacecraft_gnc.analysis.run_info import UNKNOWN_SCENARIO
from spacecraft_gnc.analysis.vehicle import part
from spacecraft_gnc.analysis.verdict import Verdict, audit_verdict

if TYPE_CHECKING:
    from spacecraft_gnc.audit.vehicle import Watch
    from spacecraft_gnc.scenario import Scenario


@dataclass(frozen=True, slots=True, kw_only=True)
class Run(Flown):
    """A flight with its metrics.

    Attributes
    ----------
    metrics
        As `metrics.summarize` gives them, and ``missed_deadlines`` (None: no free run).
    verdict
        Of the audit.
    """

    metrics: dict[str, Any]
    verdict: Verdict

    def warnings(self) -> list[str]:
        """Return what a reader should know before trusting the curves, one line each."""
        lines = [line.removeprefix(f"{self.info.path}: ") for line in self.info.warnings()]
        lines += report_part([self]).warnings(self)
        if self.verdict.passed is False:
            lines.append(f"the audit failed: {self.verdict.text}")
        if self.scenario is None and not self.info.is_plan:
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
    """Read a run, and audit it; of a plan, evaluate its conditions.

    Parameters
    ----------
    path
        Bag folder, .mcap file, or .npz file of ``gnc simulate --out`` or ``gnc plan --out``.
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
    if is_plan(path):
        return _read_plan(path, name)
    flight = load_run(path, namespace=namespace, allow_unfinished=allow_unfinished)
    known = flight.info.scenario or scenario
    part("report", known)  # refuses a vehicle without one
    run = flown(name, flight, known, allow_unfinished=allow_unfinished)
    missed = {"missed_deadlines": run.telemetry.missed_deadlines}
    verdict = audit_verdict(
        path, namespace=namespace, allow_unfinished=allow_unfinished, progress=progress
    )
    return Run(
        **_fields(run),
        metrics=summarize(run.trajectory, known) | missed,
        verdict=verdict,
    )


def _read_plan(path: Path, name: str) -> Run:
    run = read_plan(name, path)
    planner = planner_of(run.scenario)
    text = "the conditions of the optimum, evaluated from the numbers in the file"
    verdict = Verdict(True, text, planner.checks(run.trajectory))
    return Run(**_fields(run), metrics=planner.numbers(run.trajectory), verdict=verdict)


def _fields(run: Flown) -> dict[str, Any]:
    return {item.name: getattr(run, item.name) for item in fields(run)}
