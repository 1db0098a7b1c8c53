"""Node ``reference_governor``: answers each state with the reference to track."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any, ClassVar, NamedTuple

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus

from spacecraft_gnc.errors import GncError, LaunchError
from spacecraft_gnc.loop.protocols import GovernorDecision, Reference, State
from spacecraft_gnc.nodes._governor_watch import GovernorWatch
from spacecraft_gnc.nodes._node import GncNode
from spacecraft_gnc.nodes._runner import run
from spacecraft_gnc.nodes._slew_server import Answer, SlewServer
from spacecraft_gnc.nodes._status import GovernorStatusEncoder
from spacecraft_gnc.nodes._worker import Worker
from spacecraft_gnc.ros import convert
from spacecraft_gnc.ros.topics import (
    ACCEPTED_TARGET,
    GOVERNOR,
    GOVERNOR_STATUS,
    REFERENCE,
    STATE,
    TARGET,
)
from spacecraft_gnc.scenario import Scenario
from spacecraft_gnc.types import Matrix3, Vector3, read_only

_NEVER = -1
_STILL = read_only(np.zeros(3))
_ACTIVATE = "required an active one; try again later"


class _Received(NamedTuple):
    """A state to be answered."""

    stamp: convert.Stamp
    state: State
    rate: Vector3
    """Body rate (3,) [rad/s]."""


class _Job(NamedTuple):
    """Something the governor is asked for, and who takes its answer."""

    compute: Callable[[], Any]
    deliver: Callable[[Any], None]


class _Decided(NamedTuple):
    """What the governor answers to a state."""

    decision: GovernorDecision
    target: Matrix3
    """Its target."""
    taken: Matrix3 | None
    """Target to announce: one that it took since the step before; None: none."""


class GovernorNode(GncNode):
    """Publishes reference k on state k; takes targets by topic and by the SlewTo action.

    A slow governor decides in a thread of its own, and the node stays responsive meanwhile. States
    and targets are put to it in the order in which they came: a target that comes during a decision
    counts from the next one. Of the states that come during a decision the last is answered next; a
    step passed over is counted. With the first decision that a target counts for it is published,
    so that whoever has the states and these targets can repeat the decisions.
    """

    ROLE: ClassVar[str] = GOVERNOR

    def build(self, scenario: Scenario) -> None:
        """Build the governor and load its kernels."""
        self._governor = scenario.build_governor()
        self._governor.warm_up()
        self._worker: Worker[_Job, Any] | None = None
        self._has_announced = False
        self._status = GovernorStatusEncoder()
        parameters = scenario.governor
        self._tolerances = (
            math.radians(parameters.slew_tolerance_deg),
            parameters.slew_rate_tolerance,
        )
        self._watch = GovernorWatch(*self._tolerances)
        self._step = self._received_step = _NEVER

    def open(self) -> None:
        """Create the endpoints."""
        self._publish_reference = self.advertise(REFERENCE).publish
        self._publish_status = self.advertise(GOVERNOR_STATUS).publish
        self._publish_target = self.advertise(ACCEPTED_TARGET).publish
        self.listen(STATE, self._on_state)
        self.listen(TARGET, self._on_target)
        self._slews = SlewServer(self, self._set_target, *self._tolerances)
        self.on_close(self._slews.destroy)

    def start(self) -> None:
        """Return to the scenario's target."""
        if self._worker is not None:
            self._worker.require_end("decision")
        self._governor.reset()
        self._watch.reset()
        self._step = self._received_step = _NEVER
        self._waiting: _Received | None = None
        self._taken: Matrix3 | None = None
        self._is_first = True
        self._deciding = self._unheard = False
        self._skipped = 0
        self._state_bytes = self._reference_bytes = b""
        # A fast decision costs less than handing it to another thread and back.
        self._worker = Worker(self, _compute, _deliver) if self._governor.slow else None

    def stop(self) -> None:
        """Drop the decision that is under way, and the slew being flown."""
        if self._worker is not None:
            self._worker.close()
        self._slews.stop()
        if self._skipped:
            text = f"{self._skipped} steps passed over without an answer"
            self.diagnose(DiagnosticStatus.WARN, text, {"skipped_steps": self._skipped})

    def progress(self) -> int:
        """Step received last."""
        return self._received_step

    # What arrives.

    def _on_state(self, data: bytes) -> None:
        if not self.active:
            return
        if data == self._state_bytes:
            self._repeat()
            return
        joining = self._received_step == _NEVER
        try:
            received = _Received(*convert.decode_state(data, self._received_step))
        except convert.Refused as error:
            self.refuse(STATE, str(error))
            return
        self._received_step = received.state.step
        self._state_bytes, self._reference_bytes = data, b""
        self._waiting = received
        self._unheard = joining and self.is_unheard(self._received_step)
        self._decide_next()

    def _repeat(self) -> None:
        if self._unheard:
            self._unheard = self.is_unheard(self._received_step)
        if self._reference_bytes:
            self._publish_reference(self._reference_bytes)
        self._decide_next()

    def _on_target(self, data: bytes) -> None:
        if not self.active:
            return
        try:
            _, target = convert.decode_reference(data)
        except convert.Refused as error:
            self.refuse(TARGET, str(error))
            return
        self._set_target(target.attitude, self._on_target_answered)

    def _on_target_answered(self, refusal: GncError | None) -> None:
        if refusal is not None:
            self.refuse(TARGET, str(refusal))
        else:
            self._slews.preempt(f"replaced by a target on the topic {TARGET.name}")

    # What the governor is asked for.

    def _set_target(self, target: Matrix3, answer: Answer) -> None:
        if not self.active:
            answer(LaunchError(f"target: received by an inactive {self.ROLE}; {_ACTIVATE}"))
            return
        self._ask(_Job(partial(self._refusal, target), answer))

    def _refusal(self, target: Matrix3) -> GncError | None:
        """Give the governor a target; return why it does not take it."""
        try:
            self._governor.set_target(target)
        except GncError as error:
            return error
        self._taken = target
        return None

    def _decide_next(self) -> None:
        received = self._waiting
        if received is None or self._deciding or self._unheard:
            return
        if self._step != _NEVER:
            self._skipped += received.state.step - self._step - 1
        self._step = received.state.step
        self._waiting, self._deciding = None, True
        self._ask(_Job(partial(self._decide, received.state), partial(self._publish, received)))

    def _decide(self, state: State) -> _Decided:
        taken, self._taken = self._taken, None
        if taken is None and self._is_first and (state.step > 0 or self._has_announced):
            taken = self._governor.target  # started anew: what was announced counts no more
        self._is_first = False
        self._has_announced |= taken is not None
        return _Decided(self._governor.decide(state), self._governor.target, taken)

    def _ask(self, job: _Job) -> None:
        if self._worker is None:
            job.deliver(job.compute())
        else:
            self._worker.give(job)

    # What goes out.

    def _publish(self, received: _Received, decided: _Decided) -> None:
        self._deciding = False
        stamp, state, rate = received
        decision, target, taken = decided
        if taken is not None:
            accepted = Reference(taken, _STILL, _STILL)
            self._publish_target(convert.encode_reference(stamp, state.step, accepted))
        data = convert.encode_reference(stamp, state.step, decision.reference)
        if self._waiting is None:  # else it is not the answer to the last state
            self._reference_bytes = data
        self._publish_reference(data)
        self._publish_status(self._status.encode(stamp, state.step, decision))
        self._slews.update(state, rate, decision.alpha)
        trouble = self._watch.look(state, rate, decision, target)
        if trouble is not None:
            self.get_logger().warning(trouble.text)
            self.diagnose(DiagnosticStatus.WARN, trouble.text, trouble.values, stamp)
        self._decide_next()


def _compute(job: _Job) -> Any:
    return job.compute()


def _deliver(job: _Job, answer: Any) -> None:
    job.deliver(answer)


def main() -> int:
    """Run the node until it is told to end."""
    return run(GovernorNode)


if __name__ == "__main__":
    raise SystemExit(main())
