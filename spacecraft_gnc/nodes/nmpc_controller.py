"""Node ``nmpc_controller``: solves one optimal control problem at each control step."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from functools import partial
from typing import Any, ClassVar, NamedTuple

from diagnostic_msgs.msg import DiagnosticStatus

from spacecraft_gnc.loop.memory_file import Inputs
from spacecraft_gnc.loop.past import Past
from spacecraft_gnc.loop.protocols import Command
from spacecraft_gnc.nodes._node import GncNode
from spacecraft_gnc.nodes._past import past_of
from spacecraft_gnc.nodes._runner import run
from spacecraft_gnc.nodes._worker import Worker, pace_core
from spacecraft_gnc.ros.graph_of import outputs_of, vehicle_signals
from spacecraft_gnc.scenario import Scenario
from spacecraft_gnc.signals import Signal
from spacecraft_gnc.signals.graph import CONTROLLER, WALL_STATUS, WALL_STATUS_PERIOD
from spacecraft_gnc.signals.members import Seams
from spacecraft_gnc.signals.message import Stamp

_NEVER = -1


class _Job(NamedTuple):
    """A control step to be answered."""

    stamp: Stamp
    step: int
    state: Any
    reference: Any
    arrival: float
    """Wall time at which the state came [s]."""
    begun: float
    """Wall time at which the answer was begun [s]."""
    told: Inputs
    """Messages of state and reference."""


class ControllerNode(GncNode):
    """Answers step k once state k and reference k are here.

    Whichever comes last triggers the solve, so arrival order does not matter. State k brings the
    simulated time t_k with it, so there is no timer to wait for. The last state has no step to
    make. A repeated state is answered by the same bytes.

    A slow controller computes in a thread of its own, and the node stays responsive meanwhile. Of
    the states that come during a solve the last is answered next; a step passed over is counted.
    """

    ROLE: ClassVar[str] = CONTROLLER
    _past: Past | None = None

    def build(self, scenario: Scenario) -> None:
        """Build the controller and load its kernels."""
        self._controller = self._own(scenario.build_controller())
        pace_core(self._controller, scenario)
        self._controller.warm_up()
        self._past = past_of(self, self._controller, self._answer_again, self._past)
        self._worker: Worker[_Job, Command] | None = None
        self._signals = vehicle_signals(scenario.vehicle)
        self._seams = Seams.among(self._signals)
        self._outputs = outputs_of(scenario)
        free_run = scenario.plant.mode == "free_run"
        factor = scenario.plant.real_time_factor
        self._wall_period = self._controller.period / factor if free_run else math.nan

    def open(self) -> None:
        """Create the endpoints."""
        self._outlets: dict[Signal, Callable[[bytes], None]] = {
            signal: self.advertise(signal).publish
            for signal in self._signals
            if CONTROLLER in signal.publishers
        }
        self._publish_wall_status = self.advertise(WALL_STATUS).publish
        self._states = self.listen(self._seams.state, self._on_state)
        self._references = self.listen(self._seams.reference, self._on_reference)
        self.every(WALL_STATUS_PERIOD, self._report)

    def start(self) -> None:
        """Forget the past."""
        if self._worker is not None:
            self._worker.require_end("solve")
        self._controller.reset()
        if self._past is not None:
            self._past.begin()
        self._state_bytes = self._reference_bytes = self._command_bytes = b""
        self._state: Any = None
        self._reference: Any = None
        self._step = self._reference_step = self._answered = _NEVER
        self._skipped = 0
        self._command: Command | None = None
        self._unheard = False
        for signal, value in self._outputs.setup():
            self._outlets[signal](signal.encode((0, 0), 0, value))
        # A fast solve costs less than handing it to another thread and back.
        self._worker = Worker(self, self._solve, self._on_solved) if self._controller.slow else None

    def stop(self) -> None:
        """Drop the solve that is under way."""
        if self._worker is not None:
            self._worker.close()
        if self._skipped:
            text = f"{self._skipped} steps passed over without an answer"
            self.diagnose(DiagnosticStatus.WARN, text, {"skipped_steps": self._skipped})

    def _own(self, controller: Any) -> Any:
        """Return the controller of this node's craft; of a vehicle that is one craft, itself."""
        place = self.place
        if not place.craft:
            return controller
        return controller.craft[self.fleet.craft_of(place.agent).index(place.craft)]

    # What arrives.

    def _on_state(self, data: bytes) -> None:
        if not self.active:
            return
        if data == self._state_bytes:
            self._repeat()
            return
        message = self._states.decode(data, self._step)
        value = self._seams.state.value(message)
        joining = self._state is None
        self._stamp, self._step, self._state = message.stamp, message.step, value
        self.keep_time(message.stamp, message.step)
        self._state_bytes = data
        self._arrival = time.perf_counter()
        self._unheard = joining and self.is_unheard(self._step)
        self._answer_if_due()

    def _on_reference(self, data: bytes) -> None:
        if not self.active:
            return
        message = self._references.decode(data, self._reference_step)
        self._reference = self._seams.reference.value(message)
        self._reference_step = message.step
        self._reference_bytes = data
        self._answer_if_due()

    # What goes out.

    def _answer_if_due(self) -> None:
        state, reference = self._state, self._reference
        if state is None or reference is None or self._busy or self._unheard:
            return
        step = self._step
        if self._reference_step == step > self._answered and step < self.window.n_steps:
            if self._answered != _NEVER:
                self._skipped += step - self._answered - 1
            self._answered = step
            begun = time.perf_counter()
            told = self._state_bytes, self._reference_bytes
            self._answer(_Job(self._stamp, step, state, reference, self._arrival, begun, told))

    @property
    def _busy(self) -> bool:
        return self._worker is not None and self._worker.busy

    def _answer(self, job: _Job) -> None:
        if self._worker is None:
            self._publish(job, self._solve(job))
        else:
            self._worker.give(job)

    def _solve(self, job: _Job) -> Command:
        compute = partial(self._controller.command, job.state, job.reference)
        return compute() if self._past is None else self._past.answer(job.step, job.told, compute)

    def _answer_again(self, told: Inputs) -> None:
        """Answer a step once more that another process answered."""
        state, reference = self._seams.state, self._seams.reference
        self._controller.command(
            state.value(state.decode(told[0], _NEVER)),
            reference.value(reference.decode(told[1], _NEVER)),
        )

    def _on_solved(self, job: _Job, command: Command) -> None:
        self._publish(job, command)
        self._answer_if_due()

    def _publish(self, job: _Job, command: Command) -> None:
        self._command = command
        now = time.perf_counter()
        wall = (now - job.begun, self._wall_period - (now - job.arrival))
        for signal, value in self._outputs.controller(job.state, job.reference, command, wall):
            data = signal.encode(job.stamp, job.step, value)
            if signal is self._seams.control:
                self._command_bytes = data
            self._outlets[signal](data)

    def _repeat(self) -> None:
        if self._state is None:
            return
        if self._unheard:
            self._unheard = self.is_unheard(self._step)
            self._answer_if_due()
        elif self._answered == self._step and not self._busy:
            self._outlets[self._seams.control](self._command_bytes)

    def _report(self) -> None:
        """Publish what a progress display shows."""
        if not self.active:
            return
        state, reference, command = self._state, self._reference, self._command
        if state is None or reference is None or command is None:
            return
        values = {
            "step": self._step,
            **self._outputs.progress(state, reference, command),
            "source": int(command.source),
            "skipped_steps": self._skipped,
            "rejected_messages": self.refused,
        }
        text = f"step {self._step}"
        self._publish_wall_status(self.diagnostic(DiagnosticStatus.OK, text, values))


def main() -> int:
    """Run the node until it is told to end."""
    return run(ControllerNode)


if __name__ == "__main__":
    raise SystemExit(main())
