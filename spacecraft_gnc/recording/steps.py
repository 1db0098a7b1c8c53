"""The topics of a flight whose messages carry a control step."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence

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
    named = {topic_name(bag, prefix, signal): signal for signal in wanted}
    topics = {name: signal for name, signal in named.items() if name in bag.topics}
    for topic, signal in topics.items():
        _check_type(bag, topic, signal)
    return topics


def namespace_topics(
    bag: Bag, namespace: str | None = None, leads: Iterable[Signal] = ()
) -> dict[str, str]:
    """Return the full name of each topic of one spacecraft by its name in the namespace.

    ``leads``: as of `flight_namespace`; those that were not recorded with their step do not count.

    Raises
    ------
    RecordingError
        If the bag holds no spacecraft, or several.
    """
    names = {topic.rpartition("/")[2] for topic in bag.topics if bag.is_stepped(topic)}
    prefix = f"{flight_namespace(bag, namespace, [s for s in leads if s.name in names])}/"
    return {name.removeprefix(prefix): name for name in bag.topics if name.startswith(prefix)}


def flight_namespace(bag: Bag, namespace: str | None, leads: Iterable[Signal] = ()) -> str:
    """Return the prefix, without the last slash, of the flight's topics.

    Parameters
    ----------
    bag
        An open bag.
    namespace
        Of the spacecraft, where the bag holds several; that of one of its craft means it, too.
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
        known = _topics_by_namespace(bag, leads)
        prefixes = [prefix for prefix in known if prefix.strip("/") == namespace.strip("/")]
        prefixes = prefixes or _host_of_craft(bag, namespace, found)
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


def flight_namespaces(bag: Bag, leads: Collection[Signal] = ()) -> list[str]:
    """Return the prefixes of the flights in a bag, sorted; ``leads`` as of `flight_namespace`."""
    found = _topics_by_namespace(bag, leads)
    return sorted(space for space in found if leads or not _is_craft(space, found))


def _topics_by_namespace(bag: Bag, leads: Collection[Signal]) -> dict[str, set[str]]:
    """Return the names of the topics that lead a flight, by their namespace."""
    names = {lead.name for lead in leads}
    topics = (
        topic
        for topic in bag.topics
        if (topic.rpartition("/")[2] in names if names else bag.is_gapless(topic))
        and (names or bag.is_stepped(topic))
    )
    found: dict[str, set[str]] = {}
    for topic in topics:
        space, _, name = topic.rpartition("/")
        found.setdefault(space, set()).add(name)
    return found


def craft_in(
    bag: Bag, signal: Signal, lead: Signal, namespace: str | None = None
) -> tuple[str, ...]:
    """Return the craft of a flight of which a bag has a signal that each of them has, sorted.

    The flight is found by its leading signal, as in `flight_topics`. Their names are relative to
    the flight's namespace, as `Signal.of` takes them. Where the scenario is known, it is the order
    of `scenario.craft.craft_of` that counts.

    Raises
    ------
    RecordingError
        If the bag holds no flight, or several.
    """
    prefix, name = f"{flight_namespace(bag, namespace, [lead])}/", f"/{signal.name}"
    own = (topic for topic in bag.topics if topic.startswith(prefix) and topic.endswith(name))
    return tuple(sorted(topic.removeprefix(prefix).removesuffix(name) for topic in own))


def _is_craft(space: str, found: Mapping[str, set[str]]) -> bool:
    """Tell whether a namespace is that of a craft: beneath a flight's, of other topics than its."""
    above = [names for other, names in found.items() if other != space and _is_within(space, other)]
    return any(names.isdisjoint(found[space]) for names in above)


def _host_of_craft(bag: Bag, namespace: str, found: Sequence[str]) -> list[str]:
    """Return the nearest flight above a namespace in which craft of it have told of their steps."""
    own = f"/{namespace.strip('/')}/"
    if not any(topic.startswith(own) and bag.is_stepped(topic) for topic in bag.topics):
        return []
    return sorted((p for p in found if _is_within(namespace, p)), key=len)[-1:]


def _is_within(namespace: str, prefix: str) -> bool:
    return f"{namespace.strip('/')}/".startswith(f"{prefix.strip('/')}/".lstrip("/"))


def topic_name(bag: Bag, prefix: str, signal: Signal) -> str:
    """Return the full name of a signal's topic, recorded or not.

    One of the graph may lie in a namespace above the agent's.
    """
    if signal.name.startswith("/"):
        return signal.name
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
