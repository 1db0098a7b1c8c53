"""Topics of the vehicle that somebody watches, whichever vehicle flies."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from spacecraft_gnc.parameters.sections import DEFAULT_VEHICLE
from spacecraft_gnc.recording.stamps import step_of
from spacecraft_gnc.ros.endpoints import full_topic_name, message_type
from spacecraft_gnc.ros.graph import GraphView
from spacecraft_gnc.ros.graph_of import vehicle_signals
from spacecraft_gnc.ros.inboxes import Inbox
from spacecraft_gnc.ros.qos import ros_qos
from spacecraft_gnc.signals import Message, Refused, Signal
from spacecraft_gnc.signals.graph import WALL_TIMING
from spacecraft_gnc.signals.members import Seams
from spacecraft_gnc.vehicles.live import VehicleLive
from spacecraft_gnc.vehicles.registry import VEHICLES, own_names, vehicle_of
from spacecraft_gnc.vehicles.vehicle import Vehicle

Note = Callable[[Signal, int, bytes], None]


class WatchedTopics:
    """Keeps what comes of a vehicle's signals.

    Parameters
    ----------
    view
        The graph.
    prefix
        Namespace with its slashes.
    note
        Told of each message: signal, step and bytes.

    Attributes
    ----------
    seams, drawn
        Of the vehicle that is watched.
    inboxes
        By name of the topic.
    """

    seams: Seams
    drawn: VehicleLive

    def __init__(self, view: GraphView, prefix: str, note: Note) -> None:
        self._view, self._prefix, self._note = view, prefix, note
        self._vehicles = list(_watchable())
        self._signals: dict[str, Signal] = {}
        self.inboxes: dict[str, Inbox] = {}
        first = next(v for v in self._vehicles if v.name == DEFAULT_VEHICLE)
        self._watch(first)

    @property
    def state_name(self) -> str:
        """Full name of the topic of the state."""
        return self._full_name(self.seams.state)

    def publishers(self) -> int:
        """Return how many plants are there; watch another vehicle's where only that one is."""
        for vehicle in sorted(self._vehicles, key=lambda v: v is not self._vehicle):
            state = Seams.among(vehicle_signals(vehicle)).state
            count = len(self._view.publishers(self._full_name(state)))
            if count:
                if vehicle is not self._vehicle:
                    self._watch(vehicle)
                return count
        return 0

    def message(self, signal: Signal, step: int) -> bytes:
        """Return the message of a step, or else the last one."""
        inbox = self.inboxes[signal.name]
        return inbox.messages.get(step, inbox.last)

    def last(self, name: str) -> Message | None:
        """Return the last message of a signal; None: it is absent, or none."""
        if name not in self._signals:
            return None
        data = self.inboxes[name].last
        try:
            return self._signals[name].read(data) if data else None
        except Refused:
            return None

    def _watch(self, vehicle: Vehicle) -> None:
        assert vehicle.live is not None  # noqa: S101 - else it is not among those to watch
        self._vehicle, self.drawn = vehicle, vehicle.live.load()
        signals = vehicle_signals(vehicle)
        self.seams = Seams.among(signals)
        for signal in (*signals, WALL_TIMING):
            if signal.is_stepped and signal.name not in self._signals:
                self._signals[signal.name] = signal
                self.inboxes[signal.name] = Inbox()
                self._listen(signal)

    def _listen(self, signal: Signal) -> None:
        inbox = self.inboxes[signal.name]

        def take(data: bytes) -> None:
            step = step_of(data)
            if step is not None:
                self._note(signal, step, data)
                inbox.put(step, data)

        kind, qos = message_type(signal.type), ros_qos(signal.qos)
        # What is shared stands in the graph's namespace: the root's, where there are agents.
        for place in {self._prefix, "/"} if signal.shared else {self._prefix}:
            self._view.node.create_subscription(kind, f"{place}{signal}", take, qos, raw=True)

    def _full_name(self, signal: Signal) -> str:
        return full_topic_name(self._view.node, f"{self._prefix}{signal}")


def _watchable() -> Iterator[Vehicle]:
    """Yield the vehicles of this package that can be watched."""
    for name in own_names(VEHICLES):
        vehicle = vehicle_of(name)
        if vehicle.live is not None and vehicle.signals is not None:
            yield vehicle
