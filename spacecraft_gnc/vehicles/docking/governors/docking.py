"""Governor of the docking vehicle: admissible references, and the abort after a lost thruster."""

from __future__ import annotations

import time
from typing import Any, Final

import numpy as np

from spacecraft_gnc.arrays import listed
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.governors.periodic import AdmissibleSets, PeriodicGovernor, PeriodicLoop
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.docking.decision import Answer, DockingDecision, Phase
from spacecraft_gnc.vehicles.docking.governors.abort import Abort
from spacecraft_gnc.vehicles.docking.governors.diagnosis import ThrusterMonitor
from spacecraft_gnc.vehicles.docking.governors.status import active_of, answer_of, kkt_residual
from spacecraft_gnc.vehicles.docking.linear import coordinates
from spacecraft_gnc.vehicles.docking.state import RelativeReference, RelativeState

_KEPT: Final = 1e-9  # share of its room by which a row may be missed by rounding


class DockingGovernor:
    """The reference nearest to the target from which every constraint will be kept.

    Parameters
    ----------
    name : str
        Law, as in the scenario.
    loop : PeriodicLoop
        As believed.
    sets : AdmissibleSets
        Of that loop.
    weight : (6,) array
        Diagonal of the weight of the distance between references.
    target : (6,) array
        Port offset [m] and rotation vector [rad] finally wanted.
    start : (12,) array
        Linear state at the start, from which there has to be an admissible reference.
    monitor : ThrusterMonitor, optional
        Finds a lost thruster direction; None: nothing does.
    abort : Abort, optional
        What flies after one is lost; None: docking goes on.

    Raises
    ------
    ParameterError
        If the target is not admissible in steady state, or the start has no admissible reference.
    """

    slow = False

    def __init__(
        self,
        name: str,
        loop: PeriodicLoop,
        sets: AdmissibleSets,
        weight: Array,
        target: Array,
        start: Array,
        monitor: ThrusterMonitor | None = None,
        abort: Abort | None = None,
    ) -> None:
        self.name = name
        self.sets, self.weight = sets, weight
        self._steady = loop.steady_maps()
        self._first_target = self._admissible(RelativeReference.of(target))
        self._target = self._first_target
        self._governor = PeriodicGovernor(sets, weight)
        self._first = self._reference_at(start)
        self._monitor, self._abort = monitor, abort
        self.reset()

    @property
    def target(self) -> RelativeReference:
        """Reference that is finally wanted."""
        return self._target

    def set_target(self, target: RelativeReference) -> None:
        """Ask for another reference; after an abort nothing comes of it.

        Raises
        ------
        ParameterError
            If its steady state breaks a constraint, with the constraint and by how much.
        """
        self._target = self._admissible(target)

    def warm_up(self) -> None:
        """Nothing to load: the start was decided."""

    def reset(self) -> None:
        """Return to the scenario's target, and to the reference of the start."""
        self._target = self._first_target
        self._governor.reset(self._first)
        if self._monitor is not None:
            self._monitor.reset()
        if self._abort is not None:
            self._abort.reset()

    def memory(self) -> tuple[Any, ...]:
        """Return target and reference, and what monitor and abort keep."""
        monitor = None if self._monitor is None else self._monitor.memory()
        abort = None if self._abort is None else self._abort.memory()
        return self._target, self._governor.reference, monitor, abort

    def recall(self, memory: tuple[Any, ...]) -> None:
        """Go on as the governor did whose `memory` it is."""
        target, reference, monitor, abort = memory
        self._target = RelativeReference(*target)
        self._governor.reset(reference)
        if self._monitor is not None:
            self._monitor.recall(monitor)
        if self._abort is not None:
            self._abort.recall(abort)

    def decide(self, state: RelativeState) -> DockingDecision:
        """Return the reference of the control step that starts at ``state``, as measured."""
        begun = time.perf_counter()
        lost, error = -1, float("nan")
        if self._monitor is not None:
            lost, error = self._monitor.look(state)
        if lost >= 0 and self._abort is not None:
            decision = self._abort.decide(state, lost)._replace(law=self.name)
        else:
            decision = self._dock(state)
        return decision._replace(
            lost_thruster=lost, response_error=error, decision_time=time.perf_counter() - begun
        )

    def _reference_at(self, start: Array) -> Array:
        """Return the reference of the start; refuse one that has none."""
        try:
            return self._governor.decide(0, start, self._target.vector).reference
        except ParameterError as error:
            _, _, why = str(error).partition(" from which ")
            raise ParameterError(
                f"plant.initial_*: received a start from which {why} (port offset, velocity, "
                "rotation and rate together)"
            ) from error

    def _dock(self, state: RelativeState) -> DockingDecision:
        x, wish = coordinates(*state.measured), self._target.vector
        found = self._governor.decide(state.step, x, wish)
        answer = answer_of(found)
        rows, residual = self.sets.at(state.step), float("nan")
        if answer == Answer.OPTIMAL:
            residual = kkt_residual(rows, self.weight, x, wish, found)
        shares = rows.slacks(x, found.reference) / rows.bounds  # the room of a row when docked
        least = int(shares.argmin())
        return DockingDecision(
            RelativeReference.of(found.reference),
            self.name,
            answer,
            Phase.DOCKING,
            wish,
            slack=float(shares[least]),
            constraint=self.sets.names[rows.constraint[least]],
            constraint_ahead=int(rows.ahead[least]),
            active=active_of(found),
            iterations=found.iterations,
            residual=residual,
        )

    def _admissible(self, target: RelativeReference) -> RelativeReference:
        """Return a target as given; refuse one whose steady state is not admissible."""
        v = target.vector
        if v.shape != (6,) or not np.isfinite(v).all():
            raise ParameterError(
                f"target: received {listed(v)}; required 6 finite numbers, port offset [m] and "
                "rotation vector [rad]; correct it"
            )
        worst, name = np.inf, ""
        for k, steady in enumerate(self._steady):
            rows, inside = self.sets.at(k), self.sets.inside[k]
            rooms = rows.slacks(inside[:12], inside[12:])
            shares = rows.slacks(steady @ v, v) / rooms
            i = int(shares.argmin())
            if shares[i] < worst:
                worst, name = float(shares[i]), self.sets.names[rows.constraint[i]]
        if worst < -_KEPT:
            raise ParameterError(
                f"target: received {listed(v)}, whose steady state breaks the constraint {name!r} "
                f"by {-100.0 * worst:.3g} % of its room; required one that keeps every constraint; "
                "move it toward the docking axis, or nearer to alignment"
            )
        return target
