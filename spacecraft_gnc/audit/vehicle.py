"""Protocol of a vehicle's own part of an audit."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.audit.counts import Counts
from spacecraft_gnc.audit.evidence import Evidence, Progress, Topics
from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.audit.limits import Exceedance

Watch: TypeAlias = Callable[[str], Progress | None]
"""Returns, for the name of a part of the work, what is called with its progress."""


class VehicleAudit(Protocol):
    """The audit of a vehicle's flights, but for what is the same for all."""

    @property
    def topics(self) -> Topics:
        """What it reads."""

    def require_flight(self, evidence: Evidence) -> None:
        """Refuse, by a `RecordingError`, what holds no whole control step."""

    def held_steps(self, evidence: Evidence) -> NDArray[np.int64]:
        """Return the steps for which the plant says that no command came in time."""

    def audit(
        self,
        evidence: Evidence,
        ledger: Ledger,
        counts: Counts,
        held: NDArray[np.int64],
        tolerance: float | None,
        watch: Watch,
    ) -> tuple[Exceedance, ...]:
        """Enter every check of the flight; return the limits that it exceeded."""
