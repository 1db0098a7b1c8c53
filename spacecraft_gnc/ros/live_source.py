"""A flying graph as somebody watches it: the last messages of its topics, put into one picture."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, Final

from spacecraft_gnc.analysis.live.history import History, sample
from spacecraft_gnc.analysis.live.picture import (
    Decision,
    Phase,
    Picture,
    Setup,
    Solve,
    Timing,
    status_name,
)
from spacecraft_gnc.analysis.live.transport import Transport
from spacecraft_gnc.launcher import domain
from spacecraft_gnc.ros.graph import GraphView
from spacecraft_gnc.ros.inboxes import Rates
from spacecraft_gnc.ros.setup_reader import SetupReader
from spacecraft_gnc.ros.watched import WatchedTopics
from spacecraft_gnc.signals import Refused, Signal
from spacecraft_gnc.signals.attitude import ACCEPTED_TARGET, GOVERNOR_STATUS, REFERENCE
from spacecraft_gnc.signals.graph import WALL_TIMING
from spacecraft_gnc.types import Matrix3, Vector3

_STALE: Final = 2.0  # [s] wall without a state, at least; a slow flight has its own pace
_STALE_PERIODS: Final = 3.0
_LOOK: Final = 0.5  # [s] wall between two looks at who publishes
_MOST_SAMPLES: Final = 60  # of one picture: a fast flight is drawn coarser
_INVARIANTS: Final = "plant_invariants"
_SOLVER_STATUS: Final = "solver_status"


class LiveSource:
    """Listens to one flight of a graph; implements `analysis.live.feed.Watched`.

    Parameters
    ----------
    view
        The graph; its owner spins it.
    namespace
        Of the spacecraft.
    clock
        Wall time [s]; tests hand in their own.

    Raises
    ------
    TopicNameRefused
        If ``namespace`` cannot be one.
    """

    transport: Transport | None = None

    def __init__(
        self, view: GraphView, namespace: str = "", clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._view = view
        self._clock = clock
        space = namespace.strip("/")
        prefix = f"/{space}/" if space else "/"
        self._title = partial(_title, view.domain_id, space)
        self.setup = Setup(title=self._title(), live=True)
        self.history = History()
        self._reader = SetupReader(view.node, space)
        self._topics = WatchedTopics(view, prefix, self._note_message)
        self._inboxes = self._topics.inboxes
        self._rates = Rates(self._inboxes)
        self._look_at, self._publishers = -math.inf, 0
        self._step = self._sampled = -1
        self._arrived = self._interval = 0.0
        self._targets: dict[int, Matrix3] = {}

    @property
    def heard(self) -> bool:
        """Whether a state was ever received."""
        return self._step >= 0

    @property
    def _is_abandoned(self) -> bool:
        """Whether no plant was there when last looked, and nothing has come since."""
        return self._publishers == 0 and self._look_at > self._arrived

    @property
    def ended(self) -> bool:
        """Whether the flight is over."""
        return self._phase(self._clock()) is Phase.OVER

    def picture(self) -> Picture:
        """Return what there is to see now, and sample what came since the last call."""
        now = self._clock()
        self._read_setup()
        if now - self._look_at >= _LOOK:
            self._look_at, self._publishers = now, self._topics.publishers()
        self._sample()
        phase = self._phase(now)
        if not self.heard:
            return Picture(phase=phase, note=self._note(phase, now), rates={})
        return self._at(self._step, phase, self._note(phase, now), now)

    # What arrives.

    def _note_message(self, signal: Signal, step: int, data: bytes) -> None:
        if signal is ACCEPTED_TARGET:
            self._note_target(step, data)
        elif signal is self._topics.seams.state:
            self._note_step(step)

    def _note_step(self, step: int) -> None:
        now = self._clock()
        if step < self._step:  # another flight begins
            self._forget()
        if step > self._step and self._step >= 0:
            self._interval = now - self._arrived
        if step != self._step:
            self._step, self._arrived = step, now

    def _note_target(self, step: int, data: bytes) -> None:
        target = _attitude(ACCEPTED_TARGET, data)
        if target is not None:
            self._targets[step] = target

    def _target(self, step: int) -> Matrix3 | None:
        """Return the target taken in flight that counts at a step; None: the scenario's does."""
        taken = max((known for known in self._targets if known <= step), default=None)
        return None if taken is None else self._targets[taken]

    def _forget(self) -> None:
        for inbox in self._inboxes.values():
            inbox.messages.clear()
        self.history.clear()
        self._step = self._sampled = -1
        self._arrived = self._interval = 0.0
        self._targets.clear()
        self._reader.restart()

    def _read_setup(self) -> None:
        found = self._reader.poll(self._clock())
        if found is not None:
            strip = self.setup.strip
            self.setup = Setup.of(found, self._title(), live=True)
            if self.setup.strip != strip:  # samples have other columns from here on
                self.history.clear()

    # What it looks like.

    def _phase(self, now: float) -> Phase:
        if not self.heard:
            return Phase.WAITING
        if 0 < self.setup.n_steps <= self._step or self._is_abandoned:
            return Phase.OVER
        patience = max(_STALE, _STALE_PERIODS * self._interval)
        return Phase.STALE if now - self._arrived > patience else Phase.FLYING

    def _note(self, phase: Phase, now: float) -> str:
        where = f"ROS_DOMAIN_ID={self._view.domain_id}"
        if phase is Phase.WAITING:
            who = "a plant is there, but has not begun" if self._publishers else "no plant is there"
            return f"nothing received yet from {self._topics.state_name} on {where}: {who}"
        if phase is Phase.OVER:
            return f"the flight is over; its end is shown until another one begins on {where}"
        if phase is Phase.STALE:
            return f"no new state for {now - self._arrived:.0f} s, though {where} has a plant"
        return ""

    def _sample(self) -> None:
        """Sample the steps before the newest, whose reference and torque have come by now."""
        states = self._inboxes[self._topics.seams.state.name].messages
        end = self._step + (1 if self._is_abandoned else 0)
        new = [k for k in states if self._sampled < k < end and self.history.wants(k)]
        if not new:
            return
        for step in new[:: max(1, len(new) // _MOST_SAMPLES)]:
            picture = self._at(step, Phase.FLYING, "", None)
            self.history.append(sample(picture, self.setup))
        self._sampled = new[-1]
        for inbox in self._inboxes.values():
            inbox.forget_before(self._step)

    def _at(self, step: int, phase: Phase, note: str, now: float | None) -> Picture:
        """Return the picture of a step; with ``now`` [s] also what is not of a step."""
        signal = self._topics.seams.state
        try:
            message = signal.decode(self._topics.message(signal, step))
        except Refused as refusal:
            return Picture(phase=phase, note=f"a state was refused: {refusal}", step=step)
        state = signal.value(message)
        control, source = self._control(step)
        return Picture(
            phase=phase,
            note=note,
            step=step,
            time=message.stamp[0] + 1e-9 * message.stamp[1],
            attitude=state.attitude,
            reference=_attitude(REFERENCE, self._topics.message(REFERENCE, step)),
            target=self._target(step),
            **self._topics.drawn.step(state, control),
            external_torque=self._external_torque(),
            source=int(source),
            solve=None if now is None else self._solve(),
            decision=self._decision(step),
            timing=None if now is None else self._timing(),
            rates={} if now is None else self._rates.at(now),
        )

    def _control(self, step: int) -> tuple[Any, int]:
        """Return the control of a step and its source; None and -1 where none is known."""
        signal = self._topics.seams.control
        data = self._topics.message(signal, step)
        try:
            return signal.value(signal.decode(data)) if data else (None, -1)
        except Refused:
            return None, -1

    def _external_torque(self) -> Vector3 | None:
        """Return what disturbed the vehicle in the last step; None where it does not tell."""
        m = self._topics.last(_INVARIANTS)
        return None if m is None else m.array("external_torque")

    def _solve(self) -> Solve | None:
        m = self._topics.last(_SOLVER_STATUS)
        if m is None:
            return None
        return Solve(
            status=status_name(m["status"]),
            iterations=m["iterations"],
            residual=m["residual"],
            cost=m["cost"],
            curvature=m["min_curvature"],
            solve_time=m["wall_solve_time"],
        )

    def _decision(self, step: int) -> Decision | None:
        data = self._topics.message(GOVERNOR_STATUS, step)
        try:
            m = GOVERNOR_STATUS.read(data) if data else None
        except Refused:
            m = None
        if m is None:
            return None
        return Decision(
            alpha=m["alpha"],
            margin=m["margin"],
            admissible=m["admissible"],
            constraint=m["active_constraint"],
        )

    def _timing(self) -> Timing | None:
        m = self._topics.last(WALL_TIMING.name)
        if m is None:
            return None
        simulated, elapsed = m.stamp[0] + 1e-9 * m.stamp[1], m["wall_elapsed"]
        return Timing(
            speed=simulated / elapsed if elapsed > 0.0 else math.nan,
            latency=m["wall_latency"],
            slack=m["wall_deadline_slack"],
            missed=m["missed_deadlines"],
            held=m["held_commands"],
            rejected=m["rejected_messages"],
        )


def _attitude(signal: Signal, data: bytes) -> Matrix3 | None:
    """Return the attitude (3, 3) of a reference; None: it is absent, or a bad one."""
    try:
        return signal.value(signal.decode(data)).attitude if data else None
    except Refused:
        return None


def _title(domain_id: int, space: str) -> str:
    """Name the graph by the scenario that its launcher wrote down, if there is one."""
    scenario = domain.about(domain_id).get("scenario", "")
    name = Path(scenario).stem if scenario else f"ROS_DOMAIN_ID={domain_id}"
    return f"{name} /{space}" if space else name
