"""Telemetry of a flight in formation: what a bag tells beside the arrays of a flight."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, NamedTuple

from spacecraft_gnc.recording.columns import Columns, read_columns
from spacecraft_gnc.signals.graph import WALL_TIMING
from spacecraft_gnc.vehicles.formation.signals import GOVERNOR_STATUS

if TYPE_CHECKING:
    from spacecraft_gnc.recording.bag import Bag
    from spacecraft_gnc.vehicles.formation.flight import FormationFlight


class Telemetry(NamedTuple):
    """What a bag tells beside the arrays of a flight."""

    missed_deadlines: int | None = None
    """Steps of a free run whose command came too late; None: no free run."""
    constraint: tuple[str, ...] = ()
    """Of each step: the constraint with the least room along the prediction; empty: none."""
    refused: tuple[str, ...] = ()
    """Of each step: the one that the cheapest candidate would exceed the most; empty: that
    candidate is chosen."""


def telemetry(
    flight: FormationFlight, bag: Bag | None, namespace: str | None, *, is_free: bool
) -> Telemetry:
    """Return what the bag of a flight tells; ``is_free``: it was a free run."""
    if bag is None:
        return Telemetry()
    found = read_columns(bag, [WALL_TIMING, GOVERNOR_STATUS], namespace)
    missed = found[WALL_TIMING].fields.get("missed_deadlines")
    count = 0 if missed is None or not missed.size else int(missed.max())
    constraint, refused = (
        _words(found[GOVERNOR_STATUS], name, flight.n_steps) for name in ("constraint", "refused")
    )
    return Telemetry(count if is_free else None, constraint, refused)


def _words(status: Columns, name: str, n_steps: int) -> tuple[str, ...]:
    """Return a field of text of each step; empty where nothing is known."""
    told = [""] * n_steps
    for step, word in zip(status.steps.tolist(), status.fields.get(name, ()), strict=False):
        if step < n_steps:
            told[step] = str(word)
    return tuple(told)


def counts(constraints: tuple[str, ...]) -> dict[str, int]:
    """Return at how many steps each constraint stands, without its numbers; most frequent first."""
    return dict(Counter(text.partition(":")[0] for text in constraints if text).most_common())
