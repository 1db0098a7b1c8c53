"""Who takes part in a graph: roles, once or once for each agent, and the ends that they have.

A node is named relative to the graph: ``plant``, ``sc1/nmpc_controller``. What stands before the
last slash is its agent; nodes without one serve all agents.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from typing import NamedTuple

from spacecraft_gnc.signals.graph import CONTROLLER, GOVERNOR, PLANT, RECORDER
from spacecraft_gnc.signals.signal import EVERY, Signal


def role_of(name: str) -> str:
    """Return the role of a node."""
    return name.rpartition("/")[2]


def agent_of(name: str) -> str:
    """Return the agent of a node; empty where it has none."""
    return name.rpartition("/")[0]


class Place(NamedTuple):
    """Where a node or a topic stands."""

    root: str
    """Namespace of the graph, without the last slash; empty: the root namespace."""
    agent: str = ""

    def of_agent(self, agent: str) -> Place:
        """Return the place of another agent."""
        return self._replace(agent=agent)

    def node(self, role: str) -> str:
        """Return the full name of the node of a role."""
        return f"{self.root}/{self.within_graph(role)}"

    def within_graph(self, what: object) -> str:
        """Return the name of a signal's topic, or a role, relative to the graph."""
        is_of_agent = self.agent and not (isinstance(what, Signal) and what.shared)
        return f"{self.agent}/{what}" if is_of_agent else str(what)

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
    """

    def __init__(self, names: Iterable[str], wanted: Collection[str] = ()) -> None:
        self.names = tuple(names)
        self._wanted = tuple(wanted)

    def place(self, namespace: str, role: str) -> Place:
        """Return the place of a node of a role in a namespace."""
        full = f"{namespace.rstrip('/')}/{role}"
        ends = [name for name in self.names if full.endswith(f"/{name}")]
        name = max(ends, key=len, default=role)
        return Place(full[: -len(name) - 1], agent_of(name))

    def subscribers(self, signal: Signal, agent: str) -> int:
        """Return how many subscriptions a topic of an agent has."""
        is_recorded = is_recorded_of(signal, agent, self._wanted)
        recorders = (RECORDER,) if is_recorded else ()
        return self._count((*signal.subscribers, *recorders), signal, agent)

    def publishers(self, signal: Signal, agent: str) -> int:
        """Return how many publishers a topic of an agent has."""
        return self._count(signal.publishers, signal, agent)

    def _count(self, roles: Sequence[str], signal: Signal, agent: str) -> int:
        among = [n for n in self.names if signal.shared or agent_of(n) in ("", agent)]
        return sum(roles.count(role_of(name)) for name in among)


def is_recorded_of(signal: Signal, agent: str, wanted: Collection[str]) -> bool:
    """Tell whether a recorder asked for topics ``wanted`` takes an agent's signal.

    A name without an agent means the topic of each.
    """
    prefix = f"{agent}/"
    return signal.is_recorded([name.strip("/").removeprefix(prefix) for name in wanted])


def foreign(signals: Iterable[tuple[str, Signal]], wanted: Collection[str]) -> tuple[str, ...]:
    """Return what a recorder is asked for and no signal of an agent (agent, signal) is."""
    known = {EVERY}
    for agent, signal in signals:
        if signal.recorded:
            known |= {signal.name.strip("/"), Place("", agent).within_graph(signal).strip("/")}
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
