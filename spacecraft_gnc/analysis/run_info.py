"""Origin, scenario and completeness of a recorded run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from spacecraft_gnc.recording.metadata import LOSSES_RECORD, RECOVERED_RECORD
from spacecraft_gnc.scenario import Scenario

UNKNOWN_SCENARIO: Final = (
    "the scenario is not known: no torque limit, no zones, no cost; name it with --scenario"
)
"""What a reader of a run without one is told."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RunInfo:
    """Where a trajectory comes from, and how complete it is.

    Attributes
    ----------
    path
        Bag or file.
    scenario
        What flew; None where it was not recorded or this version refuses it.
    scenario_text
        The same as recorded.
    scenario_problem
        Why this version refuses the recorded scenario; empty if it does not.
    is_plan
        Whether it is a plan of ``gnc plan``, not a flight.
    namespace
        Of the spacecraft, as the reader was told; None: the only one in the bag.
    unfinished
        Whether the bag was cut off.
    missing
        Steps without a message, by topic. Their rows are NaN (integers: -1).
    overridden
        Steps whose applied torque differs from the command (late, refused or never came).
    metadata
        Records of the bag, for instance versions.
    remarks
        What of the bag is not read, one line each.
    """

    path: Path
    scenario: Scenario | None = None
    scenario_text: str = ""
    scenario_problem: str = ""
    is_plan: bool = False
    namespace: str | None = None
    unfinished: bool = False
    missing: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    overridden: tuple[int, ...] = ()
    metadata: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()

    def warnings(self) -> list[str]:
        """Return what a reader of the run should be told, one line each."""
        lines = [*self.remarks]
        if self.unfinished:
            lines.append(f"{self.path}: the bag was cut off; what was saved is shown")
        for topic, steps in self.missing.items():
            lines.append(f"{self.path}: {topic} lacks {_listed(steps)}")
        if self.overridden:
            lines.append(
                f"{self.path}: the plant applied another torque than commanded in "
                f"{_listed(self.overridden)}"
            )
        if self.scenario_problem:
            lines.append(f"{self.path}: recorded scenario not used: {self.scenario_problem}")
        if RECOVERED_RECORD in self.metadata:
            source = self.metadata[RECOVERED_RECORD].get("source", "another")
            lines.append(f"{self.path}: recovered from {source}, which was cut off")
        for topic, lost in self.metadata.get(LOSSES_RECORD, {}).items():
            if lost != "0" and topic.rpartition("/")[2] not in self.missing:
                lines.append(f"{self.path}: {topic} lost {lost} on the way to the recorder")
        return lines


def _listed(steps: tuple[int, ...]) -> str:
    """Return ``step 7``, or ``12 steps (first 7, last 90)``."""
    if len(steps) == 1:
        return f"step {steps[0]}"
    return f"{len(steps)} steps (first {steps[0]}, last {steps[-1]})"
