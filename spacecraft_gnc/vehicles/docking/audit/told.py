"""What the governor of a docking flight told, step by step."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.audit.evidence import Evidence
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.docking.audit.law import linear_states
from spacecraft_gnc.vehicles.docking.audit.motion import recorded_rows
from spacecraft_gnc.vehicles.docking.decision import Phase
from spacecraft_gnc.vehicles.docking.signals import ACCEPTED_TARGET, GOVERNOR_STATUS, REFERENCE


@dataclass(frozen=True)
class Told:
    """What the governor told at steps (m,)."""

    evidence: Evidence
    steps: NDArray[np.int64]

    def field(self, name: str) -> Array:
        """Return a field of the status (m, ...)."""
        return self.evidence.rows(GOVERNOR_STATUS, name, self.steps)

    def text(self, name: str) -> list[str]:
        """Return a field of text (m,)."""
        columns = self.evidence.columns[GOVERNOR_STATUS]
        return list(columns.fields[name][np.isin(columns.steps, self.steps)])

    def slack_of(self, at: NDArray[np.int64]) -> Array:
        """Return the slacks of rows of the steps."""
        return np.asarray(self.field("slack")[at])

    @cached_property
    def reference(self) -> Array:
        """(m, 6) as the controller was told."""
        rows = (self.evidence.rows(REFERENCE, name, self.steps)
                for name in ("port_offset", "rotation_vector"))  # fmt: skip
        return np.hstack(list(rows))

    @cached_property
    def wish(self) -> Array:
        """(m, 6) what the reference is to come near."""
        return self.field("wish")

    @cached_property
    def states(self) -> Array:
        """(m, 12) linear states as measured."""
        return linear_states(recorded_rows(self.evidence, self.steps, "measured_"))

    @cached_property
    def docking(self) -> NDArray[np.bool_]:
        """(m,) whether the way to the target goes on."""
        return np.asarray(self.field("phase") == Phase.DOCKING)

    @cached_property
    def targets(self) -> Array:
        """(m, 6) of the scenario, then those taken in flight."""
        g = self.evidence.scenario.governor
        found = np.tile(
            np.concatenate([g.target_port_offset, g.target_rotation_vector]), (len(self.steps), 1)
        )
        taken = self.evidence.columns[ACCEPTED_TARGET]
        for i, step in enumerate(taken.steps.tolist()):
            parts = [taken.fields[name][i] for name in ("port_offset", "rotation_vector")]
            found[self.steps >= step] = np.concatenate(parts)
        return found
