"""Live view of a flying graph: the latest messages of its topics as one picture."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Final

from spacecraft_gnc.analysis.live.history import History, sample
from spacecraft_gnc.analysis.live.picture import Phase, Picture, Setup, Timing
from spacecraft_gnc.analysis.live.transport import Transport
from spacecraft_gnc.analysis.vehicle import part_of
from spacecraft_gnc.launcher import domain
from spacecraft_gnc.parameters.sections import DEFAULT_VEHICLE
from spacecraft_gnc.recording.stamps import step_of
from spacecraft_gnc.ros.endpoints import full_topic_name, message_type
from spacecraft_gnc.ros.graph import GraphView, hear
from spacecraft_gnc.ros.graph_of import vehicle_signals
from spacecraft_gnc.ros.heard import Heard
from spacecraft_gnc.ros.inboxes import Rates
from spacecraft_gnc.ros.qos import ros_qos
from spacecraft_gnc.ros.setup_reader import SetupReader
from spacecraft_gnc.scenario.craft import craft_of
from spacecraft_gnc.signals import Refused, Signal
from spacecraft_gnc.signals.graph import WALL_TIMING
from spacecraft_gnc.vehicles.known_signals import vehicles_by_state
from spacecraft_gnc.vehicles.registry import vehicle_of
from spacecraft_gnc.vehicles.vehicle import Vehicle

_STALE: Final = 2.0  # [s] wall without a state, at least; a slow flight has its own pace
_STALE_PERIODS: Final = 3.0
_LOOK: Final = 0.5  # [s] wall between two looks at who publishes
_MOST_SAMPLES: Final = 60  # of one picture: a fast flight is drawn coarser


class LiveSource:
    """Listens to one flight of a graph; implements `analysis.live.feed.Watched`.

    Parameters
    ----------
    view
        The graph; its owner spins it.
    namespace
        Of the spacecraft; that of one of its craft means all of them.
    clock
        Wall time [s]; tests hand in their own.

    Raises
    ------
    TopicNameRefused
        If ``namespace`` cannot be one.
    """

    transport: Transport | None = None
    _step: int
    _sampled: int
    _arrived: float
    _interval: float

    def __init__(
        self, view: GraphView, namespace: str = "", clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._view = view
        self._clock = clock
        self._stand(namespace.strip("/"))
        self.history = History()
        self._subscriptions: list[Any] = []
        self._look_at, self._publishers = -math.inf, 0
        self._vehicles = vehicles_by_state()  # once: it reads what is installed
        self._join(vehicle_of(DEFAULT_VEHICLE))
        self._reader = SetupReader(view.node, self._space)

    def _stand(self, space: str) -> None:
        """Look for the spacecraft of a namespace."""
        self._space = space
        self._prefix = f"/{space}/" if space else "/"
        self._title = partial(_title, self._view.domain_id, space)

    def _join(self, vehicle: Vehicle, craft: Sequence[str] = ()) -> None:
        """Listen to the signals of a vehicle, and to no other's.

        Raises
        ------
        ParameterError
            If the vehicle cannot be watched.
        """
        room = part_of("live", vehicle)
        for subscription in self._subscriptions:
            self._view.node.destroy_subscription(subscription)
        self.setup = Setup.without_scenario(self._title(), vehicle, live=True)
        self._vehicle, self._heard = vehicle, Heard(vehicle, room, craft)
        self._rates = Rates(self._heard.inboxes)
        self._clear()
        self._state_name = full_topic_name(
            self._view.node, f"{self._prefix}{self._heard.seams.state}"
        )
        self._subscriptions = [
            self._listen(signal, prefix)
            for signal in self._heard.signals.values()
            for prefix in ({"/", self._prefix} if signal.shared else {self._prefix})
        ]

    def _listen(self, signal: Signal, prefix: str) -> Any:
        heard = self._heard
        is_state = signal is heard.seams.state

        def take(data: bytes) -> None:
            step = step_of(data)
            if step is None:
                return
            if is_state:
                self._note_step(step)
            heard.put(signal, step, data)

        kind, qos = message_type(signal.type), ros_qos(signal.qos)
        return hear(self._view.node, kind, f"{prefix}{signal}", take, qos)

    @property
    def heard(self) -> bool:
        """Whether a state was ever received."""
        return self._step >= 0

    @property
    def is_answered(self) -> bool:
        """Whether all that the vehicle's flight shows of a step has come once."""
        return self._heard.is_whole

    @property
    def _is_abandoned(self) -> bool:
        """Whether no plant was there when last looked, and nothing has come since."""
        return self._publishers == 0 and self._look_at > self._arrived

    @property
    def ended(self) -> bool:
        """Whether the flight is over."""
        return self._phase(self._clock()) is Phase.OVER

    def look(self) -> None:
        """Find out what flies: who publishes a state, and what the nodes say of the scenario.

        Raises
        ------
        ParameterError
            If it is a vehicle that cannot be watched.
        """
        now = self._clock()
        if now - self._look_at >= _LOOK:
            self._look_at = now
            self._publishers = len(self._view.publishers(self._state_name))
            if not self._publishers:
                self._find_vehicle()
        self._read_setup()

    def picture(self) -> Picture:
        """Return what there is to see now, and sample what came since the last call."""
        now = self._clock()
        self.look()
        self._sample()
        phase = self._phase(now)
        if not self.heard:
            return Picture(phase=phase, note=self._note(phase, now), values=self.setup.values({}))
        return self._at(self._step, phase, self._note(phase, now), now)

    def _find_vehicle(self) -> None:
        """Join the vehicle whose state somebody publishes; none yet: whichever is joined."""
        for state, vehicle in self._vehicles.items():
            if found := self._publishers_above(state, vehicle):
                self._publishers = found
                self._join(vehicle, self._craft_seen(vehicle))
                self._reader.restart()
                return

    def _publishers_above(self, state: Signal, vehicle: Vehicle) -> int:
        """Count who publishes a state here or, as this is one of its craft, in a namespace above.

        The vehicle is then watched from there.
        """
        if found := len(self._view.publishers(f"{self._prefix}{state}")):
            return found
        if not self._space or not any(
            self._view.publishers(f"{self._prefix}{signal}") for signal in _of_craft(vehicle)
        ):
            return 0
        above = self._space.rpartition("/")[0]
        found = len(self._view.publishers(f"/{above}/{state}".replace("//", "/")))
        if found:
            self._stand(above)
            self._reader = SetupReader(self._view.node, above)
        return found

    def _craft_seen(self, vehicle: Vehicle) -> list[str]:
        """Return the craft that have a topic of their own, until the scenario tells their order."""
        names = [f"/{signal}" for signal in _of_craft(vehicle)]
        topics = [name for name, _ in self._view.node.get_topic_names_and_types()]
        own = (name.removeprefix(self._prefix) for name in topics if name.startswith(self._prefix))
        return sorted({t.removesuffix(end) for t in own for end in names if t.endswith(end)})

    # What arrives.

    def _note_step(self, step: int) -> None:
        now = self._clock()
        if step < self._step:  # another flight begins
            self._forget()
        if step > self._step and self._step >= 0:
            self._interval = now - self._arrived
        if step != self._step:
            self._step, self._arrived = step, now

    def _forget(self) -> None:
        self._heard.clear()
        self._clear()
        self._reader.restart()

    def _clear(self) -> None:
        self.history.clear()
        self._step = self._sampled = -1
        self._arrived = self._interval = 0.0

    def _read_setup(self) -> None:
        found = self._reader.poll(self._clock())
        if found is not None:
            craft = craft_of(found)
            if (found.vehicle.name, craft) != (self._vehicle.name, self._heard.craft):
                self._join(found.vehicle, craft)
            self.setup = Setup.of(found, self._title(), live=True)

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
        inboxes = self._heard.inboxes
        states = inboxes[self._heard.seams.state.name].messages
        end = self._step + (1 if self._is_abandoned else 0)
        new = [k for k in states if self._sampled < k < end and self.history.wants(k)]
        if not new:
            return
        for step in new[:: max(1, len(new) // _MOST_SAMPLES)]:
            picture = self._at(step, Phase.FLYING, "", None)
            self.history.append(sample(picture, self.setup))
        self._sampled = new[-1]
        for inbox in inboxes.values():
            inbox.forget_before(self._step)

    def _at(self, step: int, phase: Phase, note: str, now: float | None) -> Picture:
        """Return the picture of a step; with ``now`` [s] also what is not of a step."""
        try:
            state = self._heard.state(step)
        except Refused as refusal:
            told = f"a state was refused: {refusal}"
            return Picture(phase=phase, note=told, step=step, values=self.setup.values({}))
        return Picture(
            phase=phase,
            note=note,
            step=step,
            time=state.stamp[0] + 1e-9 * state.stamp[1],
            values=self.setup.values(self._heard.row(step)),
            timing=None if now is None else self._timing(),
            rates={} if now is None else self._rates.at(now),
        )

    def _timing(self) -> Timing | None:
        m = self._heard.last(WALL_TIMING)
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


def _of_craft(vehicle: Vehicle) -> list[Signal]:
    """Return the signals that each craft of a vehicle has; none where it is one."""
    signals = vehicle_signals(vehicle) if vehicle.craft is not None else ()
    return [signal for signal in signals if signal.of_craft]


def _title(domain_id: int, space: str) -> str:
    """Name the graph by the scenario that its launcher wrote down, if there is one."""
    scenario = domain.about(domain_id).get("scenario", "")
    name = Path(scenario).stem if scenario else f"ROS_DOMAIN_ID={domain_id}"
    return f"{name} /{space}" if space else name
