"""Audit of the commands of each craft, and of the changes of velocity that were asked for."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.audit.evidence import Evidence
from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.signals import Signal
from spacecraft_gnc.signals.graph import WALL_TIMING
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.formation.audit.equations import gain, hill_map, mean_motion
from spacecraft_gnc.vehicles.formation.audit.told import of_craft, states_of
from spacecraft_gnc.vehicles.formation.craft import craft
from spacecraft_gnc.vehicles.formation.signals import COMMAND, REFERENCE, STATE

_LAW: Final = "command = the audit's own law"
_APPLIED: Final = "applied = command"
_LATE: Final = "applied where no command came in time"
_BEFORE: Final = "nothing applied before step 0"
_ROUNDING: Final = 1e-10
"""Share of what adds up to a command, of gains times errors: measured 1e-14."""


def commands(evidence: Evidence) -> tuple[Signal, ...]:
    """Return the command signal of each craft, in their order."""
    return tuple(COMMAND.of(name) for name in craft(evidence.scenario))


def audit_law(evidence: Evidence, ledger: Ledger) -> None:
    """Make the command of each recorded state and reference again."""
    scenario = evidence.scenario
    if scenario.controller.method != "lqr":
        ledger.skip(_LAW, f"method {scenario.controller.method} is a plug-in's")
        return
    K = gain(hill_map(mean_motion(scenario.plant), scenario.period), scenario.controller.weights)
    for i, signal in enumerate(commands(evidence)):
        steps = evidence.common(signal, STATE, REFERENCE)
        parts = (evidence.rows(REFERENCE, name, steps) for name in ("position", "velocity"))
        wanted = np.concatenate(
            [of_craft(rows, rows.shape[1] // 3)[:, i] for rows in parts], axis=1
        )
        x = states_of(evidence, steps)[:, i]
        limit = _ROUNDING * ((np.abs(x) + np.abs(wanted)) @ np.abs(K).T)
        where, told = f"{signal}.delta_v", evidence.rows(signal, "delta_v", steps)
        ledger.bound(_LAW, steps, where, told - (x - wanted) @ K.T, limit, "m/s")
        where, source = f"{signal}.source", np.full(len(steps), float(Source.METHOD))
        told = evidence.rows(signal, "source", steps)
        ledger.compare(f"{_LAW}: source", steps, {where: told}, {where: source})


def held_steps(evidence: Evidence) -> NDArray[np.int64]:
    """Return the steps for which the plant says that the command of a craft did not come in time.

    In free run its count grows by one at each. In lockstep, where it is told now and then only,
    the steps with an idle craft of the plant's own must be as many as it counts in all.
    """
    timing = evidence.columns[WALL_TIMING]
    if not timing.steps.size:
        return np.empty(0, dtype=np.int64)
    steps = np.arange(evidence.n)
    if evidence.scenario.plant.mode == "free_run":
        told = evidence.rows(WALL_TIMING, "held_commands", steps + 1)
        return np.flatnonzero(np.diff(np.concatenate([[0], told])) == 1)
    asked, source = _asked(evidence, steps)
    _, told = _commanded(evidence, steps)
    idle = (source == Source.ZERO) & (asked == 0.0).all(axis=-1) & (told != Source.ZERO)
    found = np.flatnonzero(idle.any(axis=1))
    counted = found.size == timing.fields["held_commands"].max()
    return found if counted else np.empty(0, dtype=np.int64)


def audit_applied(evidence: Evidence, held: NDArray[np.int64], ledger: Ledger) -> None:
    """Compare commands with what was asked of each craft; ``held`` are the steps that lack one."""
    steps = np.setdiff1d(evidence.columns[STATE].steps - 1, held)
    steps = steps[(steps >= 0) & (steps < evidence.n)]
    asked = _asked(evidence, steps)
    known = [
        np.where(np.isnan(told), acted, told)  # not recorded: the order of steps says so
        for told, acted in zip(_commanded(evidence, steps), asked, strict=True)
    ]
    _enter(ledger, _APPLIED, steps, asked, known)
    if held.size:
        _audit_held(evidence, held, ledger)
    else:
        ledger.skip(_LATE, "every command came in time")
    first = np.array([-1])
    n = len(evidence.scenario.plant.spacecraft)
    idle = np.zeros((1, n, 3)), np.full((1, n), float(Source.ZERO))
    _enter(ledger, _BEFORE, first, _asked(evidence, first), idle)


def _audit_held(evidence: Evidence, held: NDArray[np.int64], ledger: Ledger) -> None:
    """Check that each craft got its command, or else what takes its place."""
    asked, source = _asked(evidence, held)
    commanded, told = _commanded(evidence, held)
    came = (asked == commanded).all(axis=-1) & (source == told)
    control, stood = np.where(came[..., None], commanded, 0.0), np.where(came, told, Source.ZERO)
    for i in range(came.shape[1]):
        late = ~came[:, i]
        control[late, i], stood[late, i] = _stand_ins(evidence, held[late], i)
    _enter(ledger, _LATE, held, (asked, source), (control, stood))
    ledger.check(_LATE, "", f"{held.size} steps, as wall_timing counts them")


def _stand_ins(evidence: Evidence, held: NDArray[np.int64], i: int) -> tuple[Array, Array]:
    """Return controls and sources that act on a craft without a command: the last ones, or none.

    In free run the last command is held for ``plant.max_held_steps``, in lockstep not at all.
    """
    plant = evidence.scenario.plant
    most = plant.max_held_steps if plant.mode == "free_run" else 0
    runs = np.ones(held.size, dtype=np.int64)
    for at in np.flatnonzero(np.diff(held) == 1):
        runs[at + 1] = runs[at] + 1
    asked, source = _asked(evidence, held - 1)
    control, stood = np.nan_to_num(asked[:, i]), source[:, i]
    control[runs > most] = 0.0
    stood[(runs > most) | (held == 0)] = Source.ZERO
    return control, stood


def _asked(evidence: Evidence, steps: NDArray[np.int64]) -> tuple[Array, Array]:
    """Return what the plant says was asked of the craft in steps: (m, n, 3) and sources (m, n)."""
    n = len(evidence.scenario.plant.spacecraft)
    asked = evidence.rows(STATE, "applied_delta_v", steps + 1)
    return of_craft(asked, n), evidence.rows(STATE, "applied_source", steps + 1)


def _commanded(evidence: Evidence, steps: NDArray[np.int64]) -> tuple[Array, Array]:
    """Return what was commanded, likewise; NaN where a command was not recorded."""
    signals = commands(evidence)
    rows = [[evidence.rows(s, name, steps) for s in signals] for name in ("delta_v", "source")]
    return np.stack(rows[0], axis=1), np.stack(rows[1], axis=1)


def _enter(
    ledger: Ledger,
    name: str,
    steps: NDArray[np.int64],
    found: Sequence[Array],
    expected: Sequence[Array],
) -> None:
    """Compare delta-v and sources of the craft, bit for bit."""
    for field, told, made in zip(
        ("applied_delta_v", "applied_source"), found, expected, strict=True
    ):
        where = f"{STATE}.{field}"
        ledger.compare(name, steps + 1, {where: told}, {where: made})
