"""Who takes part in a graph: roles, once or once for each agent, and the ends that they have.

A node is named relative to the graph: ``plant``, ``sc1/nmpc_controller``. What stands before the
last slash is its agent, or one of the craft of an agent; nodes without one serve all agents.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

from spacecraft_gnc.signals.graph import CONTROLLER, GOVERNOR, PLANT, RECORDER
from spacecraft_gnc.signals.signal import EVERY, Signal


def role_of(name: str) -> str:
    """Return the role of a node."""
    return name.rpartition("/")[2]


def space_of(name: str) -> str:
    """Return the namespace of a node, an agent's or a craft's; empty where it has none."""
    return name.rpartition("/")[0]


class Place(NamedTuple):
    """Where a node or a topic stands."""

    root: str
    """Namespace of the graph, without the last slash; empty: the root namespace."""
    agent: str = ""
    """Namespace of the agent, relative to the graph."""
    craft: str = ""
    """Namespace of one of its craft, likewise; empty: the agent's own."""

    def of_space(self, space: str) -> Place:
        """Return the place of another agent, or of one of the craft where a signal is of each."""
        return Place(self.root, space)

    def space(self, what: object) -> str:
        """Return the namespace of a signal's topic, or of a role, relative to the graph."""
        if isinstance(what, Signal):
            if what.shared:
                return ""
            if not what.of_craft:
                return self.agent
        return self.craft or self.agent

    def node(self, role: str) -> str:
        """Return the full name of the node of a role."""
        return f"{self.root}/{self.within_graph(role)}"

    def within_graph(self, what: object) -> str:
        """Return the name of a signal's topic, or a role, relative to the graph."""
        space = self.space(what)
        return f"{space}/{what}" if space else str(what)

    def topic(self, signal: Signal) -> str:
        """Return the full name of a signal's topic."""
        if signal.name.startswith("/"):
            return signal.name
        return f"{self.root}/{self.within_graph(signal)}"


class Members:
    """The nodes of a graph.

    Parameters
    ----------
    names
        Relative to the graph.
    wanted
        Topics that the recorder among them takes; empty: all.
    craft
        Agent of each craft, by its namespace; an agent of one craft is not among them.
    """

    def __init__(
        self,
        names: Iterable[str],
        wanted: Collection[str] = (),
        craft: Mapping[str, str] = MappingProxyType({}),
    ) -> None:
        self.names = tuple(names)
        self._wanted = tuple(wanted)
        self._craft = craft

    def place(self, namespace: str, role: str) -> Place:
        """Return the place of a node of a role in a namespace."""
        full = f"{namespace.rstrip('/')}/{role}"
        known = (*self.names, *(f"{craft}/{CONTROLLER}" for craft in self._craft))
        ends = [name for name in known if full.endswith(f"/{name}")]
        name = max(ends, key=len, default=role)
        root, space = full[: -len(name) - 1], space_of(name)
        if space in self._craft:
            return Place(root, self._craft[space], space)
        return Place(root, space)

    def subscribers(self, signal: Signal, space: str) -> int:
        """Return how many subscriptions a topic of an agent or a craft has."""
        is_recorded = is_recorded_of(signal, space, self._wanted)
        recorders = (RECORDER,) if is_recorded else ()
        return self._count((*signal.subscribers, *recorders), signal, space)

    def publishers(self, signal: Signal, space: str) -> int:
        """Return how many publishers a topic of an agent or a craft has."""
        return self._count(signal.publishers, signal, space)

    def speakers(self, signal: Signal, space: str) -> tuple[str, ...]:
        """Return the nodes that publish on a topic of an agent or a craft."""
        serving = (name for name in self.names if self._serves(name, signal, space))
        return tuple(name for name in serving if role_of(name) in signal.publishers)

    def _count(self, roles: Sequence[str], signal: Signal, space: str) -> int:
        return sum(roles.count(role_of(n)) for n in self.names if self._serves(n, signal, space))

    def _serves(self, name: str, signal: Signal, space: str) -> bool:
        """Tell whether a node takes part in the topic that a signal has in a namespace."""
        own = space_of(name)
        if signal.of_craft:  # of the other craft's nodes none
            return own in ("", space, self._craft.get(space, space))
        return signal.shared or self._craft.get(own, own) in ("", space)


def is_recorded_of(signal: Signal, space: str, wanted: Collection[str]) -> bool:
    """Tell whether a recorder asked for topics ``wanted`` takes a signal of an agent or a craft.

    A name without a namespace means the topic of each.
    """
    prefix = f"{space}/"
    return signal.is_recorded([name.strip("/").removeprefix(prefix) for name in wanted])


def foreign(signals: Iterable[tuple[str, Signal]], wanted: Collection[str]) -> tuple[str, ...]:
    """Return what a recorder is asked for and no signal of a namespace (space, signal) is."""
    known = {EVERY}
    for space, signal in signals:
        if signal.recorded:
            known |= {signal.name.strip("/"), Place("", space).within_graph(signal).strip("/")}
    return tuple(name for name in wanted if name.strip("/") not in known)


class Seams(NamedTuple):
    """The signals that plant, controller and governor hand to each other."""

    state: Signal
    control: Signal
    reference: Signal
    target: Signal | None
    """What a user asks the governor for; None: the vehicle takes no targets."""
    accepted: Signal | None
    """A target that the governor took, of the target's type; None likewise."""

    @classmethod
    def among(cls, signals: Iterable[Signal]) -> Seams:
        """Find them among a vehicle's signals, by who publishes them to whom.

        Raises
        ------
        LookupError
            If one is missing.
        """
        known = list(signals)

        def find(publishers: tuple[str, ...], subscriber: str) -> list[Signal]:
            return [s for s in known if s.publishers == publishers and subscriber in s.subscribers]

        required = ((PLANT, CONTROLLER), (CONTROLLER, PLANT), (GOVERNOR, CONTROLLER))
        found = [find((publisher,), subscriber)[:1] for publisher, subscriber in required]
        for (publisher, subscriber), among in zip(required, found, strict=True):
            if not among:
                raise LookupError(
                    f"signals: received none from {publisher} to {subscriber}; required one; "
                    "declare it among the vehicle's signals"
                )
        target = next(iter(find((), GOVERNOR)), None)
        accepted = None
        if target is not None:
            told = [s for s in known if s.publishers == (GOVERNOR,) and s.type == target.type]
            accepted = next((s for s in told if not s.subscribers), None)
        state, control, reference = (among[0] for among in found)
        return cls(state, control, reference, target, accepted)
