"""What happened in a flight in formation: losses, deadlocks, passages, when it was formed."""

from __future__ import annotations

from collections.abc import Iterator
from enum import IntEnum
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.marks import Mark, Span
from spacecraft_gnc.drawing.sources import Stretch
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.formation.decision import Answer
from spacecraft_gnc.vehicles.formation.flight import FormationFlight
from spacecraft_gnc.vehicles.formation.flown import Flown, concluded_lost, craft_names
from spacecraft_gnc.vehicles.formation.metrics import equal_shifts, formed_at_step, position_errors


class Standing(IntEnum):
    """How far the craft are, as the governor finds it."""

    FORMING = 0
    DEADLOCK = 1
    """Parked in a formation that is not the desired one."""
    PASSAGE = 2
    """On the way from one parked formation to the next."""
    FORMED = 3


STANDING_COLORS: Final = {
    Standing.FORMING: style.RUN_COLORS[5],
    Standing.DEADLOCK: style.LIMIT_COLOR,
    Standing.PASSAGE: style.RUN_COLORS[4],
    Standing.FORMED: style.AXIS_COLORS[2],
}


_WITHOUT: Final = (Answer.HELD, Answer.LONGEST_KEPT, Answer.LEAST_VIOLATING)
"""Answers of steps at which no shifts were admissible."""


def standing(flight: FormationFlight) -> NDArray[np.int64]:
    """Return the `Standing` (n,) at each step; -1: not known."""
    return standing_of(flight.status, flight.formed, flight.deadlocked)


def standing_of(
    status: NDArray[np.int64], formed: NDArray[np.bool_], deadlocked: NDArray[np.bool_]
) -> NDArray[np.int64]:
    """Return the `Standing` of each of several steps, from what the governor tells of them."""
    found = np.select(
        [status < 0, formed, status == Answer.PASSAGE, deadlocked],
        [-1, Standing.FORMED, Standing.PASSAGE, Standing.DEADLOCK],
        Standing.FORMING,
    )
    return np.asarray(found, dtype=np.int64)


def standing_name(value: int) -> str:
    """Return a standing in a word; unknown where it is none."""
    return Standing(value).name.lower() if 0 <= value < len(Standing) else "unknown"


def stretches(values: NDArray[Any], times: Array) -> Iterator[Stretch]:
    """Yield the stretches of one value of the steps (n,); times (n + 1,) [s]."""
    begins = np.flatnonzero(np.append(True, values[1:] != values[:-1]))
    for begin, end in zip(begins, np.append(begins[1:], len(values)), strict=True):
        yield Stretch(int(values[begin]), float(times[begin]), float(times[end]), int(end - begin))


class Event(NamedTuple):
    """Something that happened."""

    time: float
    """[s]"""
    text: str
    is_bad: bool


def events(run: Flown) -> list[Event]:
    """Return losses of craft and their detection, missing shifts, and when it was formed."""
    found = [*_losses(run), *_answers(run.trajectory), *_formed(run)]
    return sorted(found, key=lambda event: event.time)


def _losses(run: Flown) -> Iterator[Event]:
    """Yield the loss of each craft, and when it was concluded lost; before: a false alarm."""
    flight, concluded = run.trajectory, concluded_lost(run.trajectory)
    for i, name in enumerate(craft_names(run)):
        gone, found = _first(~flight.healthy[:, i]), _first(concluded[:, i])
        if gone is not None:
            yield Event(float(flight.time[gone]), f"{name} lost", True)
        if found is not None and gone is not None and found >= gone:
            yield Event(float(flight.time[found]), f"{name} found lost", False)
        elif found is not None:
            yield Event(float(flight.time[found]), f"false alarm {name}", True)


def _first(flags: NDArray[np.bool_]) -> int | None:
    """Return the first step at which flags (n,) hold; None: never."""
    return int(np.argmax(flags)) if flags.any() else None


def _answers(flight: FormationFlight) -> Iterator[Event]:
    """Yield the first step of each stretch without admissible shifts."""
    without = np.isin(flight.status, _WITHOUT)
    for row in np.flatnonzero(without & ~np.append(False, without[:-1])):
        yield Event(float(flight.time[row]), "no admissible shifts", True)


def _formed(run: Flown) -> Iterator[Event]:
    if run.scenario is None:
        return
    flight = run.trajectory
    away = position_errors(flight.position, flight.reference_position, flight.healthy)
    equal = equal_shifts(flight.time_shift, flight.healthy)
    step = formed_at_step(away, equal, run.scenario.governor.formed_error)
    if step is not None:
        yield Event(float(flight.time[step]), f"formed, step {step}", False)


def marks(run: Flown) -> list[Mark]:
    """Return `events` as diagrams show them."""
    colors = {True: style.LIMIT_COLOR, False: style.INK}
    return [Mark(e.time, e.text, colors[e.is_bad], e.is_bad) for e in events(run)]


def spans(run: Flown) -> list[Span]:
    """Return deadlocks, and each passage of the way out, as diagrams show them."""
    flight = run.trajectory
    states, number = standing(flight), _passages_so_far(flight)
    numbered = np.where(states == Standing.PASSAGE, number, 0)
    found = []
    for s in stretches(states + len(Standing) * numbered, run.times):
        passage, state = divmod(s.source, len(Standing))
        if state in (Standing.DEADLOCK, Standing.PASSAGE) and s.source >= 0:
            text = standing_name(state) + (f" {passage}" if passage else "")
            color = STANDING_COLORS[Standing(state)]
            found.append(Span(s.begin, s.end, text, color, state == Standing.DEADLOCK))
    return found


def _passages_so_far(flight: FormationFlight) -> NDArray[np.int64]:
    """Return how many passages have begun (n,): one where the shifts change on the way out."""
    changed = np.append(False, (np.diff(flight.time_shift, axis=0) != 0).any(axis=1))
    return np.cumsum(changed & (flight.status == Answer.PASSAGE))
