"""Repeat every decision of the governor: reference, alpha, margin and the rest."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypeAlias

import numpy as np

from spacecraft_gnc.audit.ledger import as_absolute
from spacecraft_gnc.errors import GncError
from spacecraft_gnc.loop.protocols import State
from spacecraft_gnc.recording.metadata import LOSSES_RECORD
from spacecraft_gnc.recording.steps import flight_topics
from spacecraft_gnc.signals import Signal
from spacecraft_gnc.signals.attitude import ACCEPTED_TARGET, GOVERNOR_STATUS, REFERENCE
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body.audit.told_plan import governor_of
from spacecraft_gnc.vehicles.rigid_body.planner.transfer import makes_plans
from spacecraft_gnc.vehicles.rigid_body.signals import STATE

if TYPE_CHECKING:
    from spacecraft_gnc.audit.evidence import Evidence, Progress
    from spacecraft_gnc.audit.ledger import Ledger
    from spacecraft_gnc.loop.protocols import Governor

    AnyGovernor: TypeAlias = Governor[Any, Any]

_DECISION: Final = "decision of the governor"
_CONSTRAINT: Final = "active_constraint"
_ANSWERED: Final = (STATE, REFERENCE, GOVERNOR_STATUS)
_NEEDED: Final = (*_ANSWERED, ACCEPTED_TARGET)
_MEASURES: Final = ("alpha", "margin", "admissible")
_COUNTS: Final = ("evaluations", "violation_step", "horizon", "waypoints")
_FIELDS: Final = {
    f"{REFERENCE}.attitude": slice(0, 9),
    f"{REFERENCE}.angular_velocity": slice(9, 12),
    f"{REFERENCE}.torque": slice(12, 15),
    **{
        f"{GOVERNOR_STATUS}.{name}": slice(15 + i, 16 + i)
        for i, name in enumerate((*_MEASURES, *_COUNTS))
    },
}
"""Columns of a decision written in one row."""
_COUNTED: Final = tuple(f"{GOVERNOR_STATUS}.{name}" for name in _COUNTS)


def audit_decisions(
    evidence: Evidence, ledger: Ledger, tolerance: float | None, progress: Progress | None
) -> None:
    """Put every recorded state, and every target that was taken, to the scenario's governor.

    A governor that was started anew in mid-flight is recognized by its decisions, and noted. With
    a tolerance (a share of the largest magnitude) counts, which rounding may tip, are left out.
    """
    why = _not_asked(evidence)
    if why:
        ledger.skip(_DECISION, why)
        return
    governor = governor_of(evidence)
    governor.warm_up()
    with np.errstate(all="ignore"):  # numbers of a recording may be of any size
        _Inquiry(evidence, governor, tolerance).enter(ledger, progress)


def _not_asked(evidence: Evidence) -> str:
    """Return why the governor cannot be asked again; empty: it can."""
    kind = evidence.scenario.governor.governor
    if evidence.scenario.vehicle.governor(kind) is None:
        return f"governor {kind} is a plug-in's, which may remember more than its states"
    if makes_plans(evidence.scenario.law) and evidence.scenario.plant.mode == "free_run":
        return "in free run plans are taken when they are found; their steps are made again"
    recorded = flight_topics(evidence.bag, _NEEDED, evidence.namespace)
    missing = set(_NEEDED) - set(recorded.values())
    missing |= {name for name in _ANSWERED if not evidence.columns[name].steps.size}
    return f"not recorded: {', '.join(sorted(map(str, missing)))}" if missing else ""


def _lost(evidence: Evidence) -> str:
    """Return what the recorder says that it lost: no excuse, for a bag may say so of anything."""
    losses = evidence.bag.metadata().get(LOSSES_RECORD, {})
    recorded = flight_topics(evidence.bag, _NEEDED, evidence.namespace)
    lost = [topic for topic in recorded if losses.get(topic, "0") != "0"]
    return f"the recorder says that it lost messages of {', '.join(sorted(lost))}" if lost else ""


def _field(where: str) -> tuple[Signal, str]:
    """Return signal and field of a name in `_FIELDS`."""
    topic, _, name = where.partition(".")
    return next(signal for signal in _ANSWERED if signal.name == topic), name


class _Decided(NamedTuple):
    """A decision, its numbers in the columns of `_FIELDS`."""

    row: Array
    constraint: str


class _Inquiry:
    """Asks a governor step by step, up to the first decision that nothing explains."""

    def __init__(self, evidence: Evidence, governor: AnyGovernor, tolerance: float | None) -> None:
        self._governor = governor
        self._steps = steps = evidence.common(*_ANSWERED)
        self._attitudes = evidence.rows(STATE, "attitude", steps).reshape(-1, 3, 3)
        self._momenta = evidence.rows(STATE, "angular_momentum", steps)
        status = evidence.columns[GOVERNOR_STATUS]
        self._constraints = status.fields[_CONSTRAINT][np.isin(status.steps, steps)]
        columns = [
            evidence.rows(topic, name, steps).reshape(len(steps), -1)
            for topic, name in (_field(where) for where in _FIELDS)
        ]
        self._recorded: Array = np.hstack(columns)
        self._limits: Array | None = None  # of each column; rounding may tip what is counted
        if tolerance is not None:
            self._limits = np.full(self._recorded.shape[1], np.inf)
            for (where, at), values in zip(_FIELDS.items(), columns, strict=True):
                if where not in _COUNTED:
                    self._limits[at] = as_absolute(tolerance, values)
        targets = evidence.columns[ACCEPTED_TARGET]
        attitudes = targets.fields.get("attitude", np.empty((0, 9))).reshape(-1, 3, 3)
        self._targets = dict(zip(targets.steps.tolist(), attitudes, strict=True))
        self._lost = _lost(evidence)
        self._anew: list[int] = []
        self._refused: int | None = None

    def enter(self, ledger: Ledger, progress: Progress | None) -> None:
        """Ask for every decision, and enter what differs."""
        made, constraints = np.empty_like(self._recorded), []
        for i, (row, constraint) in enumerate(self._decisions()):
            made[i] = row
            constraints.append(constraint)
            if progress is not None and i % 100 == 0:
                progress(i, len(self._steps))
        n = len(constraints)
        steps = self._steps[:n]
        for where, at in _FIELDS.items():
            recorded, again = {where: self._recorded[:n, at]}, {where: made[:n, at]}
            if self._limits is None:
                ledger.compare(_DECISION, steps, recorded, again)
            elif where not in _COUNTED:
                ledger.compare(_DECISION, steps, recorded, again, float(self._limits[at.start]))
        if self._limits is None:
            same = self._constraints[:n] == np.array(constraints, dtype=object)
            where = f"{GOVERNOR_STATUS}.{_CONSTRAINT}"
            ledger.require("constraint that limited alpha", "the same", steps, where, same)
        if self._refused is not None:
            where = f"{ACCEPTED_TARGET}.attitude"
            ledger.fail("targets are admissible", "taken again", self._refused, where)
        ledger.check(_DECISION, "", self._note())

    def _decisions(self) -> Iterator[_Decided]:
        self._governor.reset()
        for i, step in enumerate(self._steps.tolist()):
            state = State(step, self._attitudes[i], self._momenta[i])
            try:
                decided = self._decide(state)
                if i and not self._is_recorded(i, decided):
                    self._governor.reset()
                    again = self._decide(state)
                    if not self._is_recorded(i, again):
                        yield decided
                        return  # what follows rests on it
                    self._anew.append(step)
                    decided = again
            except GncError:
                self._refused = step
                return
            yield decided

    def _decide(self, state: State) -> _Decided:
        target = self._targets.get(state.step)
        if target is not None:
            self._governor.set_target(target)
        decision = self._governor.decide(state)
        numbers = [float(getattr(decision, name)) for name in (*_MEASURES, *_COUNTS)]
        row = np.concatenate([*(np.ravel(part) for part in decision.reference), numbers])
        return _Decided(row, decision.active_constraint)

    def _is_recorded(self, i: int, decided: _Decided) -> bool:
        recorded, made = self._recorded[i], decided.row
        if self._limits is None:
            same = recorded.tobytes() == made.tobytes()
            return same and bool(self._constraints[i] == decided.constraint)
        with np.errstate(invalid="ignore"):  # inf - inf, which is equal
            near = (recorded == made) | (np.abs(recorded - made) <= self._limits)
        return bool(near.all())

    def _note(self) -> str:
        notes = []
        if self._targets:
            notes.append(f"targets taken in flight: {len(self._targets)}")
        if self._anew:
            notes.append(f"the governor started anew at step {', '.join(map(str, self._anew))}")
        if self._lost:
            notes.append(self._lost)
        return "; ".join(notes)
