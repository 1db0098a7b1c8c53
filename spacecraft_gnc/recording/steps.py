"""The topics of a flight whose messages carry a control step."""

from __future__ import annotations

from collections.abc import Iterable

from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.recording.bag import Bag
from spacecraft_gnc.signals.signal import Signal


def flight_topics(
    bag: Bag, signals: Iterable[Signal], namespace: str | None = None
) -> dict[str, Signal]:
    """Return each signal of one flight by the full name of its topic, those recorded.

    The leading signal, of which the namespace is told, is the first that is unique in a step, or
    else the first of all.

    Raises
    ------
    RecordingError
        If the bag is of another package, holds several spacecraft, or a topic has another type or
        another version of its type.
    """
    wanted = list(signals)
    lead = next((signal for signal in wanted if signal.unique), wanted[0])
    prefix = flight_namespace(bag, namespace, [lead])
    named = {_full_name(bag, prefix, signal): signal for signal in wanted}
    topics = {name: signal for name, signal in named.items() if name in bag.topics}
    for topic, signal in topics.items():
        _check_type(bag, topic, signal)
    return topics


def namespace_topics(bag: Bag, namespace: str | None = None) -> dict[str, str]:
    """Return the full name of each topic of one spacecraft by its name in the namespace.

    Raises
    ------
    RecordingError
        If the bag holds no spacecraft, or several.
    """
    prefix = f"{flight_namespace(bag, namespace)}/"
    return {name.removeprefix(prefix): name for name in bag.topics if name.startswith(prefix)}


def flight_namespace(bag: Bag, namespace: str | None, leads: Iterable[Signal] = ()) -> str:
    """Return the prefix, without the last slash, of the flight's topics.

    Parameters
    ----------
    bag
        An open bag.
    namespace
        Of the spacecraft, where the bag holds several.
    leads
        Signals of which each spacecraft has one; none: whatever has a message of each step.

    Raises
    ------
    RecordingError
        If the bag holds no spacecraft, or several.
    """
    leads = list(leads)
    found = flight_namespaces(bag, leads)
    prefixes = found
    if namespace is not None:
        prefixes = [prefix for prefix in found if prefix.strip("/") == namespace.strip("/")]
        if not prefixes and all(lead.shared for lead in leads):  # it belongs to the graph
            prefixes = [prefix for prefix in found if _is_within(namespace, prefix)]
    if not prefixes:
        recorded = ", ".join(sorted(bag.topics)) or "none"
        where = f" in namespace {namespace}" if namespace is not None else ""
        raise RecordingError(
            f"{bag.path}: no topic {' or '.join(map(str, leads)) or 'of a control step'}{where}; "
            f"required a flight recorded by spacecraft_gnc; topics in the bag: {recorded}"
        )
    if len(prefixes) > 1:
        raise RecordingError(
            f"{bag.path}: several spacecraft ({', '.join(prefixes)}); required one; name "
            "it with --namespace"
        )
    return prefixes[0]


def flight_namespaces(bag: Bag, leads: Iterable[Signal] = ()) -> list[str]:
    """Return the prefixes of the flights in a bag, sorted; ``leads`` as of `flight_namespace`."""
    names = {lead.name for lead in leads}
    topics = (
        topic
        for topic in bag.topics
        if (topic.rpartition("/")[2] in names if names else bag.is_gapless(topic))
        and (names or bag.is_stepped(topic))
    )
    return sorted({topic.rpartition("/")[0] for topic in topics})


def _is_within(namespace: str, prefix: str) -> bool:
    return f"{namespace.strip('/')}/".startswith(f"{prefix.strip('/')}/".lstrip("/"))


def _full_name(bag: Bag, prefix: str, signal: Signal) -> str:
    """Return the name of a topic; one of the graph may lie in a namespace above the agent's."""
    name = f"{prefix}/{signal}"
    while signal.shared and name not in bag.topics and prefix:
        prefix = prefix.rpartition("/")[0]
        name = f"{prefix}/{signal}"
    return name


def _check_type(bag: Bag, topic: str, signal: Signal) -> None:
    if bag.topics[topic] != signal.type:
        raise RecordingError(
            f"{bag.path}: {topic} has type {bag.topics[topic]}; required {signal.type}; the bag "
            "was recorded from another package"
        )
    if not signal.fields:  # of a vehicle that is not installed: as its definition says
        return
    received = bag.type_hash(topic)
    if received != signal.type_hash:
        raise RecordingError(
            f"{bag.path}: {topic}: received {signal.type} with type hash {received}; required "
            f"{signal.type_hash}, this version's; read it with the version that flew, or "
            "record again"
        )
