"""Audit of commands and of the wrenches that acted: the law is made again."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.audit.applied import stand_ins
from spacecraft_gnc.audit.evidence import Evidence
from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.docking.audit.law import Model, linear_states, loop_of, model_error
from spacecraft_gnc.vehicles.docking.audit.motion import recorded_rows
from spacecraft_gnc.vehicles.docking.signals import APPLIED, COMMAND, REFERENCE, STATE

_LAW: Final = "command = the audit's own law"
_ROUNDING: Final = 1e-9
"""Share of what adds up to a command: of gains times states."""


def audit_law(evidence: Evidence, ledger: Ledger, model: Model) -> None:
    """Make the command of each measured state and reference again."""
    scenario = evidence.scenario
    method = scenario.controller.method
    steps = evidence.common(COMMAND, STATE, REFERENCE)
    if method not in ("periodic_lqr", "time_invariant_lqr"):
        ledger.skip(_LAW, f"method {method} is a plug-in's")
        return
    loop = loop_of(scenario, model if method == "periodic_lqr" else model.mean)
    x = linear_states(recorded_rows(evidence, steps, "measured_"))
    parts = (evidence.rows(REFERENCE, name, steps) for name in ("port_offset", "rotation_vector"))
    v = np.hstack(list(parts))
    made = loop.wrenches(steps, x, v)
    k = steps % loop.period
    share = _ROUNDING + model_error(scenario)
    size = np.abs(loop.U0[k]) + np.einsum("nij,nj->ni", np.abs(loop.K[k]), np.abs(x))
    size += np.einsum("nij,nj->ni", np.abs(loop.through[k]), np.abs(v))
    where, told = f"{COMMAND}.wrench", evidence.rows(COMMAND, "wrench", steps)
    for name, half, unit in (("force", slice(3), "N"), ("moment", slice(3, None), "N m")):
        limit = share * (1.0 + size[:, half])
        ledger.bound(f"{_LAW}: {name}", steps, where, (told - made)[:, half], limit, unit)
    where = f"{COMMAND}.source"
    source = np.full(len(steps), float(Source.METHOD))
    ledger.compare(_LAW, steps, {where: evidence.rows(COMMAND, "source", steps)}, {where: source})


def audit_applied(evidence: Evidence, held: NDArray[np.int64], ledger: Ledger) -> None:
    """Compare commands with what acted; ``held`` are the steps without a command."""
    name, late = "applied = command", "applied where no command came in time"
    steps = np.intersect1d(evidence.columns[COMMAND].steps, evidence.columns[STATE].steps - 1)
    steps = steps[~np.isin(steps, held)]
    commanded = evidence.rows(COMMAND, "wrench", steps)
    _applied(evidence, ledger, name, steps, commanded, evidence.rows(COMMAND, "source", steps))
    if held.size:
        _applied(evidence, ledger, late, held, *stand_ins(evidence, held, APPLIED))
        ledger.check(late, "", f"{held.size} steps held or idle, as wall_timing counts them")
    else:
        ledger.skip(late, "every command came in time")
    _applied(evidence, ledger, "nothing applied before step 0", np.array([-1]), np.zeros((1, 6)),
             np.array([float(Source.ZERO)]))  # fmt: skip


def _applied(
    evidence: Evidence,
    ledger: Ledger,
    name: str,
    steps: NDArray[np.int64],
    wrench: Array,
    sources: Array,
) -> None:
    for field, expected in (("applied_wrench", wrench), ("applied_source", sources)):
        told, where = evidence.rows(STATE, field, steps + 1), f"{STATE}.{field}"
        ledger.compare(name, steps + 1, {where: told}, {where: expected})
