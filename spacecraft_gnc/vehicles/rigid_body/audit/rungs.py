"""Audit commands not produced directly by a solve: those of a law and of the fallback ladder.

They are worked out again by the code that flew them, from the recorded states, references and
plans; what it remembers is the last plan, which is recorded, too.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc import lie
from spacecraft_gnc.audit.evidence import Evidence
from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.loop.protocols import Reference, Source, State
from spacecraft_gnc.ocp.solution import Solution
from spacecraft_gnc.ocp.terminal_problem import TerminalSetOcp
from spacecraft_gnc.signals.attitude import REFERENCE
from spacecraft_gnc.status import Status
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body.audit.plans import Certifier, Plans
from spacecraft_gnc.vehicles.rigid_body.controllers.ladder import FallbackLadder
from spacecraft_gnc.vehicles.rigid_body.signals import STATE, TORQUE

if TYPE_CHECKING:
    from spacecraft_gnc.loop.protocols import Controller

SENSITIVE: Final = 1e-9
"""Share of the largest torque that those may differ which rest on a linearized plan."""
TORQUE_FIELD: Final = "torque_command.torque"
_SOURCE: Final = "torque_command.source"
LAW: Final = "command of the law"
_LADDER = "command of the ladder"
_LINEAR = "neighboring extremal of an earlier plan"


class Sample(NamedTuple):
    """A step's state and reference, and the command that was published."""

    state: State
    reference: Reference
    torque: Array
    source: int


def sample(evidence: Evidence, step: int) -> Sample:
    """Return what is recorded of a step."""
    at = np.array([step])
    attitude = evidence.rows(STATE, "attitude", at).reshape(3, 3)
    momentum = evidence.rows(STATE, "angular_momentum", at)[0]
    target = evidence.rows(REFERENCE, "attitude", at).reshape(3, 3)
    rate, torque = (
        evidence.rows(REFERENCE, name, at)[0] for name in ("angular_velocity", "torque")
    )
    source = evidence.rows(TORQUE, "source", at)[0]
    return Sample(
        State(step, attitude, momentum),
        Reference(target, rate, torque),
        evidence.rows(TORQUE, "torque", at)[0],
        int(source) if math.isfinite(source) else -1,
    )


def audit_law(
    evidence: Evidence, controller: Controller[Any, Any], steps: NDArray[np.int64], ledger: Ledger
) -> None:
    """Ask the controller, which remembers nothing of the flight, for its commands once more."""
    torques, sources = np.empty((len(steps), 3)), np.empty(len(steps))
    recorded, published = torques.copy(), sources.copy()
    for i, step in enumerate(steps.tolist()):
        found = sample(evidence, step)
        command = controller.command(found.state, found.reference)
        torques[i], sources[i] = command.control, command.source
        recorded[i], published[i] = found.torque, found.source
    ledger.compare(LAW, steps, {TORQUE_FIELD: recorded}, {TORQUE_FIELD: torques})
    current = evidence.scenario.method.current_sources(published)
    ledger.compare(LAW, steps, {_SOURCE: current}, {_SOURCE: sources})


def restored(certifier: Certifier, plans: Plans, rows: dict[str, NDArray[Any]], i: int) -> Solution:
    """Return the solution of plan ``i``, with multipliers worked out from it."""
    costates, multiplier = certifier.multipliers(Plans(*(values[i : i + 1] for values in plans)))
    ocp, attitudes = certifier.ocp, plans.attitudes[i]
    if isinstance(ocp, TerminalSetOcp) and multiplier > 0.0:
        ocp = ocp.weighted(multiplier)
    return Solution(
        torques=plans.torques[i],
        attitudes=attitudes,
        momenta=plans.momenta[i],
        multipliers=np.vstack([costates, costates[-1:]]),
        cost=float(rows["cost"][i]),
        status=Status.CONVERGED,
        iterations=int(rows["iterations"][i]),
        residual=float(rows["residual"][i]),
        solve_time=math.nan,
        torque_margin=float(rows["torque_margin"][i]),
        reference=plans.references[i],
        ocp=ocp,
        formulation=str(rows["formulation"][i]),
        min_curvature=float(rows["min_curvature"][i]),
        zone_margins=rows["zone_margins"][i, : len(ocp.zones)],
        attitude_error=lie.angle_between(plans.references[i], attitudes[0]),
        travel=lie.angle_between(attitudes[0], attitudes[-1]),
        feedforward=plans.feedforward[i],
    )


class LadderAudit:
    """Follows the failure ladder along the flight: it remembers the last plan, across blocks."""

    def __init__(self, evidence: Evidence, certifier: Certifier, ledger: Ledger) -> None:
        self._evidence, self._certifier, self._ledger = evidence, certifier, ledger
        self._ladder = FallbackLadder(certifier.ocp)
        self._limit = certifier.ocp.max_torque
        self._last: tuple[int, Solution] | None = None
        self._fed = -1

    def audit(
        self,
        fallbacks: NDArray[np.int64],
        solved: NDArray[np.int64],
        plans: Plans,
        rows: dict[str, NDArray[Any]],
    ) -> None:
        """Audit the steps ``fallbacks`` of a block, whose plans are those of steps ``solved``."""
        for step in fallbacks.tolist():
            before = int(np.searchsorted(solved, step)) - 1
            if before >= 0:
                self._remember(int(solved[before]), plans, rows, before)
            self._feed()
            self._compare(step)
        if len(solved):
            self._remember(int(solved[-1]), plans, rows, len(solved) - 1)

    def _remember(self, step: int, plans: Plans, rows: dict[str, NDArray[Any]], i: int) -> None:
        if self._last is None or self._last[0] != step:
            self._last = step, restored(self._certifier, plans, rows, i)

    def _feed(self) -> None:
        if self._last is not None and self._last[0] != self._fed:
            self._fed, solution = self._last
            found = sample(self._evidence, self._fed)
            self._ladder.command(found.state, found.reference, solution)

    def _compare(self, step: int) -> None:
        found, at = sample(self._evidence, step), np.array([step])
        command = self._ladder.command(found.state, found.reference, None)
        sources = {_SOURCE: np.array([float(found.source)])}, {_SOURCE: np.array([command.source])}
        where = self._certifier.command
        torques = {where: found.torque[None]}, {where: command.control[None]}
        linear = command.source == Source.NEIGHBORING_EXTREMAL
        scale = self._limit or max(float(np.abs(found.torque).max()), 1e-300)
        limit, unit = (SENSITIVE * scale, "N m") if linear else (None, "")
        name = _LINEAR if linear else _LADDER
        self._ledger.compare(name, at, *torques, limit, unit)
        self._ledger.compare("rung of the ladder", at, *sources)
