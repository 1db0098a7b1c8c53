"""Audit of references, commands and applied accelerations: governor and law are evaluated again."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.audit.applied import stand_ins
from spacecraft_gnc.audit.evidence import Evidence, Progress
from spacecraft_gnc.audit.ledger import Ledger, as_absolute
from spacecraft_gnc.loop.protocols import Command, Source
from spacecraft_gnc.signals.attitude import (
    ACCEPTED_TARGET,
    GOVERNOR_STATUS,
    REFERENCE,
    quaternion_of,
)
from spacecraft_gnc.types import Array, GovernorDecision, Reference, read_only
from spacecraft_gnc.vehicles.two_wheel.audit.states import recorded_states
from spacecraft_gnc.vehicles.two_wheel.signals import APPLIED, COMMAND, STATE

_DECISION: Final = "decision of the governor"
_LAW: Final = "command of the law"
_STATUS: Final = (
    "alpha",
    "admissible",
    "margin",
    "evaluations",
    "violation_step",
    "horizon",
    "waypoints",
)


def audit_references(evidence: Evidence, ledger: Ledger) -> None:
    """Ask the governor, which lets every target through, for each decision again."""
    steps, kind = evidence.columns[REFERENCE].steps, evidence.scenario.governor.governor
    if evidence.scenario.vehicle.governor(kind) is None:
        ledger.skip(_DECISION, f"governor {kind} is a plug-in's, which may remember its past")
        return
    if not steps.size:
        ledger.skip(_DECISION, f"{REFERENCE} was not recorded")
        return
    made = _asked_again(evidence, steps)
    references = [decision.reference for decision in made]
    for name, parts in (
        ("attitude", [reference.attitude.ravel() for reference in references]),
        ("orientation", [quaternion_of(reference.attitude) for reference in references]),
        ("angular_velocity", [reference.angular_velocity for reference in references]),
        ("torque", [reference.torque for reference in references]),
    ):
        where = f"{REFERENCE}.{name}"
        recorded = evidence.rows(REFERENCE, name, steps)
        ledger.compare(_DECISION, steps, {where: recorded}, {where: np.array(parts)})
    _audit_status(evidence, ledger, dict(zip(steps.tolist(), made, strict=True)))
    count = evidence.columns[ACCEPTED_TARGET].steps.size
    if count:
        ledger.check(_DECISION, "", f"targets taken in flight: {count}")


def _asked_again(evidence: Evidence, steps: NDArray[np.int64]) -> list[GovernorDecision]:
    """Return the decisions of steps, with each target taken from the step on that it counts."""
    governor = evidence.scenario.build_governor()
    taken = evidence.columns[ACCEPTED_TARGET]
    targets = dict(zip(taken.steps.tolist(), taken.fields.get("attitude", ()), strict=True))
    made = []
    for step in steps.tolist():
        if step in targets:
            governor.set_target(targets[step].reshape(3, 3))
        made.append(governor.decide(None))
    return made


def _audit_status(evidence: Evidence, ledger: Ledger, made: dict[int, GovernorDecision]) -> None:
    columns = evidence.columns[GOVERNOR_STATUS]
    steps = np.intersect1d(columns.steps, list(made))
    again = [made[step] for step in steps.tolist()]
    for name in _STATUS if steps.size else ():
        where = f"{GOVERNOR_STATUS}.{name}"
        recorded = evidence.rows(GOVERNOR_STATUS, name, steps)
        expected = np.array([float(getattr(decision, name)) for decision in again])
        ledger.compare(_DECISION, steps, {where: recorded}, {where: expected})
    if steps.size:
        told = columns.fields["active_constraint"][np.isin(columns.steps, steps)]
        same = told == np.array([decision.active_constraint for decision in again], dtype=object)
        where = f"{GOVERNOR_STATUS}.active_constraint"
        ledger.require("constraint that limited alpha", "the same", steps, where, same)


def audit_law(
    evidence: Evidence, ledger: Ledger, tolerance: float | None, progress: Progress | None
) -> None:
    """Ask the law for the command of each recorded state and reference."""
    scenario = evidence.scenario
    if not scenario.method.memoryless:
        method = scenario.controller.method
        ledger.skip(_LAW, f"method {method} may remember its past")
        return
    steps = evidence.common(COMMAND, STATE, REFERENCE)
    controller = scenario.build_controller()
    attitudes, rates, torques = (
        read_only(evidence.rows(REFERENCE, name, steps))
        for name in ("attitude", "angular_velocity", "torque")
    )
    again = []
    for i, state in enumerate(recorded_states(evidence, steps)):
        reference = Reference(attitudes[i].reshape(3, 3), rates[i], torques[i])
        again.append(controller.command(state, reference))
        if progress is not None and i % 1000 == 0:
            progress(i, len(steps))
    _compare(evidence, ledger, steps, again, tolerance)


def _compare(
    evidence: Evidence,
    ledger: Ledger,
    steps: NDArray[np.int64],
    again: list[Command],
    tolerance: float | None,
) -> None:
    m = evidence.scenario.plant.wheel_inertias.size
    accelerations = np.array([command.control for command in again]).reshape(-1, m)
    sources = np.array([float(command.source) for command in again])
    where, recorded = f"{COMMAND}.acceleration", evidence.rows(COMMAND, "acceleration", steps)
    limit = as_absolute(tolerance, recorded)
    ledger.compare(_LAW, steps, {where: recorded}, {where: accelerations}, limit)
    where, recorded = f"{COMMAND}.source", evidence.rows(COMMAND, "source", steps)
    ledger.compare(_LAW, steps, {where: recorded}, {where: sources})


def audit_applied(evidence: Evidence, held: NDArray[np.int64], ledger: Ledger) -> None:
    """Compare commands with what the plant applied; ``held`` are the steps without a command."""
    name, late = "applied = command", "applied where no command came in time"
    steps = evidence.columns[COMMAND].steps
    steps = np.intersect1d(steps, evidence.columns[STATE].steps - 1)
    steps = steps[~np.isin(steps, held)]
    commanded = evidence.rows(COMMAND, "acceleration", steps)
    _applied(evidence, ledger, name, steps, commanded, evidence.rows(COMMAND, "source", steps))
    if held.size:
        _applied(evidence, ledger, late, held, *stand_ins(evidence, held, APPLIED))
        ledger.check(late, "", f"{held.size} steps held or idle, as wall_timing counts them")
    else:
        ledger.skip(late, "every command came in time")
    start = np.zeros(1, dtype=np.int64)
    idle = np.zeros((1, evidence.scenario.plant.wheel_inertias.size))
    _applied(evidence, ledger, "nothing applied before step 0", start - 1, idle,
             np.array([float(Source.ZERO)]))  # fmt: skip


def _applied(
    evidence: Evidence,
    ledger: Ledger,
    name: str,
    steps: NDArray[np.int64],
    accelerations: Array,
    sources: Array,
) -> None:
    for field, expected in (("applied_acceleration", accelerations), ("applied_source", sources)):
        told, where = evidence.rows(STATE, field, steps + 1), f"{STATE}.{field}"
        ledger.compare(name, steps + 1, {where: told}, {where: expected})
