"""What the governor of a formation told, step by step, beside the states that it read."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.audit.evidence import Evidence
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.formation.signals import GOVERNOR_STATUS, REFERENCE, STATE


def of_craft(rows: Array, n: int) -> Array:
    """Return numbers (m, 3 n) by craft (m, n, 3)."""
    return rows.reshape(len(rows), n, 3)


def states_of(evidence: Evidence, steps: NDArray[np.int64]) -> Array:
    """Return the recorded states (m, n, 6) of steps; NaN where there is none."""
    n = len(evidence.scenario.plant.spacecraft)
    parts = [of_craft(evidence.rows(STATE, name, steps), n) for name in ("position", "velocity")]
    return np.concatenate(parts, axis=-1)


@dataclass(frozen=True)
class Told:
    """What the governor told at steps (m,)."""

    evidence: Evidence
    steps: NDArray[np.int64]

    @property
    def n_craft(self) -> int:
        """Number of craft."""
        return len(self.evidence.scenario.plant.spacecraft)

    def field(self, name: str) -> Array:
        """Return a field of the status (m, ...)."""
        return self.evidence.rows(GOVERNOR_STATUS, name, self.steps)

    def text(self, name: str) -> list[str]:
        """Return a field of text (m,)."""
        columns = self.evidence.columns[GOVERNOR_STATUS]
        return list(columns.fields[name][np.isin(columns.steps, self.steps)])

    def by_craft(self, name: str) -> Array:
        """Return a field (m, n) that has a number for each craft, or for none: then NaN."""
        found = self.field(name).reshape(len(self.steps), -1)
        return found if found.size else np.full((len(self.steps), self.n_craft), np.nan)

    @cached_property
    def shifts(self) -> NDArray[np.int64]:
        """(m, n) as the reference says."""
        return self.evidence.rows(REFERENCE, "shift", self.steps).astype(np.int64)

    @cached_property
    def reference(self) -> Array:
        """(m, n, 6) commanded states."""
        rows = [
            of_craft(self.evidence.rows(REFERENCE, name, self.steps), self.n_craft)
            for name in ("position", "velocity")
        ]
        return np.concatenate(rows, axis=-1)

    @cached_property
    def states(self) -> Array:
        """(m, n, 6) of the craft."""
        return states_of(self.evidence, self.steps)

    @cached_property
    def lost(self) -> NDArray[np.bool_]:
        """(m, n) craft that the governor holds for lost."""
        return np.asarray(self.by_craft("lost") == 1.0)

    @cached_property
    def follows(self) -> NDArray[np.bool_]:
        """(m,) which steps come right after the one before them."""
        return np.append(False, np.diff(self.steps) == 1)

    @cached_property
    def equal(self) -> NDArray[np.bool_]:
        """(m,) at which steps the shifts of all craft that are not lost are equal."""
        able, shifts = ~self.lost, self.shifts
        most = np.where(able, shifts, -1).max(axis=1, keepdims=True)
        return np.asarray((~able | (shifts == most)).all(axis=1))
