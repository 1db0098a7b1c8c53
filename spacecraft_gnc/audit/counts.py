"""Counts of repeated solves, justified fallbacks and standstills."""

from __future__ import annotations

from dataclasses import asdict, dataclass


@dataclass(slots=True)
class Counts:
    """Counts of control steps, part of the verdict.

    Attributes
    ----------
    solves_repeated
        Whose claimed failure was solved again.
    failures_confirmed
        Of these, where the solve failed again in the same way.
    fallbacks
        Whose torque came from a rung of the ladder below an optimal plan, after a claimed failure.
    fallbacks_justified
        Of these, where the failure was confirmed.
    standstills_looked_for
        At which the controller looks for a standstill, and the audit did.
    standstills_found
        Of these, where it found one.
    standstills_reported
        At which the controller said that there is one.
    """

    solves_repeated: int = 0
    failures_confirmed: int = 0
    fallbacks: int = 0
    fallbacks_justified: int = 0
    standstills_looked_for: int = 0
    standstills_found: int = 0
    standstills_reported: int = 0

    def as_dict(self) -> dict[str, int]:
        """Return the counts by name."""
        return asdict(self)

    @property
    def text(self) -> str:
        """The counts in one line."""
        return (
            f"claimed failures solved again {self.solves_repeated}, failed again "
            f"{self.failures_confirmed}; fallbacks justified {self.fallbacks_justified} of "
            f"{self.fallbacks}; standstills looked for at {self.standstills_looked_for} steps, "
            f"found {self.standstills_found}, reported {self.standstills_reported}"
        )
