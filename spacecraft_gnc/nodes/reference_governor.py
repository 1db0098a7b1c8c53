"""Node ``reference_governor``: answers each state with the reference to track."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any, ClassVar, NamedTuple

from diagnostic_msgs.msg import DiagnosticStatus

from spacecraft_gnc.errors import GncError, LaunchError
from spacecraft_gnc.loop.memory_file import Inputs
from spacecraft_gnc.loop.past import Past
from spacecraft_gnc.loop.protocols import GovernorDecision
from spacecraft_gnc.nodes._door import UsersDoor
from spacecraft_gnc.nodes._governor_watch import GovernorWatch
from spacecraft_gnc.nodes._node import GncNode
from spacecraft_gnc.nodes._past import past_of
from spacecraft_gnc.nodes._runner import run
from spacecraft_gnc.nodes._slew_server import Answer, SlewServer
from spacecraft_gnc.nodes._worker import Worker, pace_core
from spacecraft_gnc.ros.graph_of import outputs_of, vehicle_signals
from spacecraft_gnc.scenario import Scenario
from spacecraft_gnc.signals import Message, Signal
from spacecraft_gnc.signals.attitude import REFERENCE
from spacecraft_gnc.signals.graph import GOVERNOR
from spacecraft_gnc.signals.members import Seams

_NEVER = -1
_INACTIVE = "is not active, as the graph starts or ends; required an active one; try again later"


class _Received(NamedTuple):
    """A state to be answered."""

    message: Message
    state: Any
    told: Inputs
    """Message of the state."""


class _Job(NamedTuple):
    """Something the governor is asked for, and who takes its answer."""

    compute: Callable[[], Any]
    deliver: Callable[[Any], None]


class _Decided(NamedTuple):
    """What the governor answers to a state."""

    decision: GovernorDecision
    target: Any
    """Its target."""
    taken: Any
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
    _past: Past | None = None

    def build(self, scenario: Scenario) -> None:
        """Build the governor and load its kernels."""
        self._governor = scenario.build_governor()
        pace_core(self._governor, scenario)
        self._governor.warm_up()
        self._past = past_of(self, self._governor, self._decide_again, self._past)
        self._worker: Worker[_Job, Any] | None = None
        self._has_announced = False
        self._signals = vehicle_signals(scenario.vehicle)
        self._seams = Seams.among(self._signals)
        self._outputs = outputs_of(scenario)
        self._steers_attitude = self._seams.reference.type == REFERENCE.type
        if self._steers_attitude:
            parameters = scenario.governor
            self._tolerances = (
                math.radians(parameters.slew_tolerance_deg),
                parameters.slew_rate_tolerance,
            )
            self._watch = GovernorWatch(*self._tolerances)
        self._step = self._received_step = _NEVER

    def open(self) -> None:
        """Create the endpoints."""
        self._outlets: dict[Signal, Callable[[bytes], None]] = {
            signal: self.advertise(signal).publish
            for signal in self._signals
            if GOVERNOR in signal.publishers
        }
        self._door = UsersDoor(self)
        self._states = self.listen(self._seams.state, self._on_state)
        if self._seams.target is not None:
            self._targets = self.listen(self._seams.target, self._on_target)
        self._slews = None
        if self._steers_attitude:
            self._slews = SlewServer(self, self._door, self._set_target, *self._tolerances)
            self.on_close(self._slews.destroy)

    def start(self) -> None:
        """Return to the scenario's target."""
        if self._worker is not None:
            self._worker.require_end("decision")
        self._governor.reset()
        if self._past is not None:
            self._past.begin()
        if self._steers_attitude:
            self._watch.reset()
        self._step = self._received_step = _NEVER
        self._waiting: _Received | None = None
        self._taken: Any = None
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
        if self._slews is not None:
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
        message = self._states.decode(data, self._received_step)
        received = _Received(message, self._seams.state.value(message), (data, b""))
        self._received_step = message.step
        self.keep_time(message.stamp, message.step)
        self._state_bytes, self._reference_bytes = data, b""
        self._waiting = received
        self._unheard = joining and self.is_unheard(self._received_step)
        self._decide_next()

    def _repeat(self) -> None:
        if self._unheard:
            self._unheard = self.is_unheard(self._received_step)
        if self._reference_bytes:
            self._outlets[self._seams.reference](self._reference_bytes)
        self._decide_next()

    def _on_target(self, data: bytes) -> None:
        wanted = self._targets.signal.value(self._targets.decode(data))
        if not self._door.admits(self._targets.signal):
            return
        if self._steers_attitude:
            wanted = wanted.attitude
        self._set_target(wanted, self._on_target_answered)

    def _on_target_answered(self, refusal: GncError | None) -> None:
        target = self._seams.target
        if refusal is not None:
            self.refuse(target, str(refusal))
        elif self._slews is not None:
            self._slews.preempt(f"replaced by a target on the topic {target}")

    # What the governor is asked for.

    def _set_target(self, target: Any, answer: Answer) -> None:
        if not self.active:
            answer(LaunchError(f"target: received while the {self.ROLE} {_INACTIVE}"))
            return
        self._ask(_Job(partial(self._refusal, target), answer))

    def _refusal(self, target: Any) -> GncError | None:
        """Give the governor a target; return why it does not take it."""
        try:
            self._governor.set_target(target)
        except GncError as error:
            return error
        self._taken = target
        if self._past is not None:
            self._past.take_target(target)
        return None

    def _decide_next(self) -> None:
        received = self._waiting
        if received is None or self._deciding or self._unheard:
            return
        if self._step != _NEVER:
            self._skipped += received.message.step - self._step - 1
        self._step = received.message.step
        self._waiting, self._deciding = None, True
        decide = partial(self._decide, self._step, received)
        self._ask(_Job(decide, partial(self._publish, received)))

    def _decide(self, step: int, received: _Received) -> _Decided:
        if self._past is not None:
            self._take_up(step, self._past)
        taken, self._taken = self._taken, None
        is_anew = self._is_first and (step > 0 or self._has_announced)
        if taken is None and is_anew and not getattr(self._governor, "moves", False):
            taken = self._governor.target  # what was announced counts no more
        self._is_first = False
        self._has_announced |= taken is not None
        decide = partial(self._governor.decide, received.state)
        past = self._past
        decision = decide() if past is None else past.answer(step, received.told, decide)
        return _Decided(decision, self._governor.target, taken)

    def _take_up(self, step: int, past: Past) -> None:
        """Before the first decision: go on where another process ended."""
        past.take_up(step)
        if self._is_first and past.is_taken_up:
            self._is_first = False  # what was announced still counts
            if past.has_news:
                self._taken = self._governor.target

    def _decide_again(self, told: Inputs) -> None:
        """Answer a step once more that another process answered."""
        state = self._seams.state
        self._governor.decide(state.value(state.decode(told[0], _NEVER)))

    def _ask(self, job: _Job) -> None:
        if self._worker is None:
            job.deliver(job.compute())
        else:
            self._worker.give(job)

    # What goes out.

    def _publish(self, received: _Received, decided: _Decided) -> None:
        self._deciding = False
        stamp, step = received.message.stamp, received.message.step
        if decided.taken is not None:
            for signal, value in self._outputs.accepted(decided.taken):
                self._outlets[signal](signal.encode(stamp, step, value))
        for signal, value in self._outputs.governor(decided.decision):
            data = signal.encode(stamp, step, value)
            # Else it is not the answer to the last state.
            if signal is self._seams.reference and self._waiting is None:
                self._reference_bytes = data
            self._outlets[signal](data)
        if self._slews is not None:
            self._judge(received, decided, self._slews)
        self._decide_next()

    def _judge(self, received: _Received, decided: _Decided, slews: SlewServer) -> None:
        """Tell how a slew goes, and what the governor cannot do."""
        state, rate = received.state, received.message.array("angular_velocity")
        slews.update(state, rate, decided.decision.alpha)
        trouble = self._watch.look(state, rate, decided.decision, decided.target)
        if trouble is not None:
            self.get_logger().warning(trouble.text)
            stamp = received.message.stamp
            self.diagnose(DiagnosticStatus.WARN, trouble.text, trouble.values, stamp)


def _compute(job: _Job) -> Any:
    return job.compute()


def _deliver(job: _Job, answer: Any) -> None:
    job.deliver(answer)


def main() -> int:
    """Run the node until it is told to end."""
    return run(GovernorNode)


if __name__ == "__main__":
    raise SystemExit(main())
