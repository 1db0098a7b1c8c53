"""A flying graph as somebody watches it: the last messages of its topics, put into one picture."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

from rclpy.serialization import deserialize_message
from spacecraft_gnc_msgs.msg import GovernorStatus, SolverStatus, WallTiming

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
from spacecraft_gnc.recording.stamps import step_of
from spacecraft_gnc.ros import convert
from spacecraft_gnc.ros.endpoints import full_topic_name
from spacecraft_gnc.ros.graph import GraphView
from spacecraft_gnc.ros.inboxes import Inbox, Rates
from spacecraft_gnc.ros.setup_reader import SetupReader
from spacecraft_gnc.ros.topics import (
    ACCEPTED_TARGET,
    GOVERNOR_STATUS,
    REFERENCE,
    SOLVER_STATUS,
    STATE,
    TORQUE,
    WALL_TIMING,
)
from spacecraft_gnc.types import Matrix3

_STALE: Final = 2.0  # [s] wall without a state, at least; a slow flight has its own pace
_STALE_PERIODS: Final = 3.0
_LOOK: Final = 0.5  # [s] wall between two looks at who publishes
_MOST_SAMPLES: Final = 60  # of one picture: a fast flight is drawn coarser
_TOPICS: Final = (
    STATE, REFERENCE, TORQUE, SOLVER_STATUS, GOVERNOR_STATUS, WALL_TIMING, ACCEPTED_TARGET,
)  # fmt: skip


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
        self.setup = Setup(title=_title(view.domain_id), live=True)
        self.history = History()
        self._state_name = full_topic_name(view.node, f"{prefix}{STATE.name}")
        self._reader = SetupReader(view.node, prefix)
        self._inboxes = {topic.name: Inbox() for topic in _TOPICS}
        for topic in _TOPICS:
            self._listen(topic, prefix)
        self._rates = Rates(self._inboxes)
        self._look_at, self._publishers = -math.inf, 0
        self._step = self._sampled = -1
        self._arrived = self._interval = 0.0
        self._targets: dict[int, Matrix3] = {}

    def _listen(self, topic: Any, prefix: str) -> None:
        inbox = self._inboxes[topic.name]
        notes = {STATE.name: self._note_step, ACCEPTED_TARGET.name: self._note_target}
        note = notes.get(topic.name)

        def take(data: bytes) -> None:
            step = step_of(data)
            if step is None:
                return
            if note is not None:
                note(step, data)
            inbox.put(step, data)

        name = f"{prefix}{topic.name}"
        self._view.node.create_subscription(topic.type, name, take, topic.qos, raw=True)

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
            self._look_at, self._publishers = now, len(self._view.publishers(self._state_name))
        self._sample()
        phase = self._phase(now)
        if not self.heard:
            return Picture(phase=phase, note=self._note(phase, now), rates={})
        return self._at(self._step, phase, self._note(phase, now), now)

    # What arrives.

    def _note_step(self, step: int, _: bytes) -> None:
        now = self._clock()
        if step < self._step:  # another flight begins
            self._forget()
        if step > self._step and self._step >= 0:
            self._interval = now - self._arrived
        if step != self._step:
            self._step, self._arrived = step, now

    def _note_target(self, step: int, data: bytes) -> None:
        target = _attitude(data)
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
            self.setup = Setup.of(found, _title(self._view.domain_id), live=True)

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
            return f"nothing received yet from {self._state_name} on {where}: {who}"
        if phase is Phase.OVER:
            return f"the flight is over; its end is shown until another one begins on {where}"
        if phase is Phase.STALE:
            return f"no new state for {now - self._arrived:.0f} s, though {where} has a plant"
        return ""

    def _sample(self) -> None:
        """Sample the steps before the newest, whose reference and torque have come by now."""
        states = self._inboxes[STATE.name].messages
        end = self._step + (1 if self._is_abandoned else 0)
        new = [k for k in states if self._sampled < k < end and self.history.wants(k)]
        if not new:
            return
        for step in new[:: max(1, len(new) // _MOST_SAMPLES)]:
            picture = self._at(step, Phase.FLYING, "", None)
            self.history.append(sample(picture, self.setup.target))
        self._sampled = new[-1]
        for inbox in self._inboxes.values():
            inbox.forget_before(self._step)

    def _at(self, step: int, phase: Phase, note: str, now: float | None) -> Picture:
        """Return the picture of a step; with ``now`` [s] also what is not of a step."""
        try:
            stamp, state, _ = convert.decode_state(self._message(STATE.name, step), 0)
        except convert.Refused as refusal:
            return Picture(phase=phase, note=f"a state was refused: {refusal}", step=step)
        torque = self._torque(step)
        return Picture(
            phase=phase,
            note=note,
            step=step,
            time=stamp[0] + 1e-9 * stamp[1],
            attitude=state.attitude,
            reference=_attitude(self._message(REFERENCE.name, step)),
            target=self._target(step),
            momentum=state.momentum,
            torque=None if torque is None else torque.torque,
            source=-1 if torque is None else int(torque.source),
            solve=None if now is None else self._solve(),
            decision=self._decision(step),
            timing=None if now is None else self._timing(),
            rates={} if now is None else self._rates.at(now),
        )

    def _message(self, topic: str, step: int) -> bytes:
        """Return the message of a step, or else the last one."""
        inbox = self._inboxes[topic]
        return inbox.messages.get(step, inbox.last)

    def _torque(self, step: int) -> convert.Torque | None:
        data = self._message(TORQUE.name, step)
        try:
            return convert.decode_torque(data) if data else None
        except convert.Refused:
            return None

    def _solve(self) -> Solve | None:
        data = self._inboxes[SOLVER_STATUS.name].last
        if not data:
            return None
        m = deserialize_message(data, SolverStatus)
        return Solve(
            status=status_name(m.status),
            iterations=m.iterations,
            residual=m.residual,
            cost=m.cost,
            curvature=m.min_curvature,
            solve_time=m.wall_solve_time,
        )

    def _decision(self, step: int) -> Decision | None:
        data = self._message(GOVERNOR_STATUS.name, step)
        if not data:
            return None
        m = deserialize_message(data, GovernorStatus)
        return Decision(
            alpha=m.alpha,
            margin=m.margin,
            admissible=m.admissible,
            constraint=m.active_constraint,
        )

    def _timing(self) -> Timing | None:
        data = self._inboxes[WALL_TIMING.name].last
        if not data:
            return None
        m = deserialize_message(data, WallTiming)
        simulated = m.header.stamp.sec + 1e-9 * m.header.stamp.nanosec
        return Timing(
            speed=simulated / m.wall_elapsed if m.wall_elapsed > 0.0 else math.nan,
            latency=m.wall_latency,
            slack=m.wall_deadline_slack,
            missed=m.missed_deadlines,
            held=m.held_commands,
            rejected=m.rejected_messages,
        )


def _attitude(data: bytes) -> Matrix3 | None:
    """Return the attitude (3, 3) of an AttitudeReference; None: it is absent, or a bad one."""
    try:
        return convert.decode_reference(data)[1].attitude if data else None
    except convert.Refused:
        return None


def _title(domain_id: int) -> str:
    """Name the graph by the scenario that its launcher wrote down, if there is one."""
    for graph in domain.running_graphs():
        if graph.domain_id == domain_id and "scenario" in graph.about:
            return Path(graph.about["scenario"]).stem
    return f"ROS_DOMAIN_ID={domain_id}"
