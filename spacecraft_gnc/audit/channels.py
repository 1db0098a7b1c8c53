"""Check that a bag has the topics that the scenario's graph had."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Final

from spacecraft_gnc.audit.evidence import Evidence
from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.recording.steps import flight_namespace, topic_name
from spacecraft_gnc.signals import graph
from spacecraft_gnc.signals.signal import EVERY, Signal

_TOPICS: Final = "topics of the graph"
_EACH: Final = "each in the bag"


def audit_channels(evidence: Evidence, ledger: Ledger, signals: Iterable[Signal]) -> None:
    """Require a channel of every topic that the recorder of the scenario takes.

    A recorder announces them all before step 0, so that one without messages is there, too.

    Parameters
    ----------
    evidence, ledger
        Of the audit.
    signals
        Those of the vehicle.
    """
    line = ledger.check(_TOPICS, _EACH)
    line.is_condition = True
    of_all = (one for signal in signals for one in evidence.topics.each(signal))
    for signal in (*of_all, *graph.SIGNALS):
        if not is_wanted(evidence, signal) or not _existed(evidence, signal):
            continue
        line.count(_TOPICS, 1)
        if channel_of(evidence, signal) is None:
            ledger.fail(_TOPICS, _EACH, 0, f"{signal} (no channel)")


def channel_of(evidence: Evidence, signal: Signal) -> str | None:
    """Return the full name of a signal's topic; None where the bag does not have it."""
    bag = evidence.bag
    name = topic_name(bag, _prefix(evidence), signal)
    return name if bag.topics.get(name) == signal.type else None


def is_wanted(evidence: Evidence, signal: Signal) -> bool:
    """Tell whether the scenario's recorder takes a topic of the agent."""
    wanted = {name.strip("/") for name in evidence.scenario.recorder.topics}
    if not signal.recorded or not wanted or EVERY in wanted:
        return signal.recorded
    craft, _, name = signal.name.strip("/").rpartition("/")
    return not wanted.isdisjoint([*_names(evidence, craft, name), *_names(evidence, "", name)])


def is_expected(evidence: Evidence, signal: Signal) -> bool:
    """Tell whether the scenario has messages of a topic recorded: one of its publishers flew."""
    launched, craft = set(evidence.scenario.launcher.nodes), signal.name.rpartition("/")[0]
    names = (n for r in signal.publishers for c in {craft, ""} for n in _names(evidence, c, r))
    return not launched.isdisjoint(names) and is_wanted(evidence, signal)


def _existed(evidence: Evidence, signal: Signal) -> bool:
    """Tell whether the version that flew must have had a topic."""
    needs = evidence.topics.later.get(signal)
    return needs is None or needs(evidence.scenario)


def _prefix(evidence: Evidence) -> str:
    states = [signal for signal in evidence.topics.every_step if signal.unique]
    return flight_namespace(evidence.bag, evidence.namespace, states[:1])


def _names(evidence: Evidence, craft: str, name: str) -> Iterator[str]:
    """Yield what a topic or a node may be called, with its namespace or a part of it or without."""
    own = f"{craft}/{name}" if craft else name
    parts = _prefix(evidence).strip("/").split("/")
    for i in range(len(parts) + 1):
        yield "/".join([*parts[i:], own])
