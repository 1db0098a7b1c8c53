"""Topics and endpoints of a live graph: types, nodes, quality of service."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from rclpy.exceptions import InvalidTopicNameException
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    QoSCompatibility,
    QoSProfile,
    ReliabilityPolicy,
    qos_check_compatible,
)
from rclpy.validate_full_topic_name import validate_full_topic_name
from rclpy.validate_topic_name import validate_topic_name

from spacecraft_gnc.errors import GncError

if TYPE_CHECKING:
    from typing_extensions import Self

_DEPTH = 1000
_RCLError = rclpy_implementation.RCLError  # has no public name


class TopicNameRefused(GncError):
    """No topic can have a name."""


class TopicInfo(NamedTuple):
    """A topic as the graph shows it."""

    name: str
    types: tuple[str, ...]
    publishers: int
    subscribers: int


class Endpoint(NamedTuple):
    """A publisher or a subscription of a topic."""

    node: str
    """Full name."""
    type: str
    qos: QoSProfile

    @classmethod
    def of(cls, info: Any) -> Self:
        """Take over what rclpy tells."""
        node = f"{info.node_namespace.rstrip('/')}/{info.node_name}"
        return cls(node, info.topic_type, info.qos_profile)

    def __lt__(self, other: Any) -> bool:
        return (self.node, self.type) < (other.node, other.type)

    @property
    def qos_text(self) -> str:
        """The profile in words, what is not given by the wire left out."""
        qos = self.qos
        words = [
            ReliabilityPolicy(qos.reliability).name.lower(),
            DurabilityPolicy(qos.durability).name.lower(),
        ]
        if qos.history != HistoryPolicy.UNKNOWN:  # discovery does not carry it
            words.append(f"{HistoryPolicy(qos.history).name.lower()} {qos.depth}")
        for name in ("deadline", "lifespan", "liveliness_lease_duration"):
            seconds = getattr(qos, name).nanoseconds * 1e-9
            if 0.0 < seconds < _INFINITE:
                words.append(f"{name.split('_')[0]} {seconds:g} s")
        return ", ".join(words)


_INFINITE = 9.0e9  # [s] rmw's infinite duration and the DDS one both lie above


def full_topic_name(node: Node, name: str) -> str:
    """Return the full name of a topic that is named relative to a node, or in full.

    Raises
    ------
    TopicNameRefused
        No topic can have that name.
    """
    try:
        validate_topic_name(name)
        full_name = str(node.resolve_topic_name(name))
        validate_full_topic_name(full_name)
    except (InvalidTopicNameException, _RCLError) as error:
        reason = str(error).splitlines()[0].partition(", at ")[0].rstrip(":")
        reason = reason.removeprefix("failed to resolve name: ")
        raise TopicNameRefused(
            f"{name!r}: {reason}; required the name of a topic, such as /attitude_state; correct it"
        ) from error
    return full_name


def message_type(name: str) -> Any:
    """Return the class of ``pkg/msg/Type``, or of an action's ``pkg/action/Name_FeedbackMessage``.

    Raises
    ------
    ImportError
        It is not installed.
    """
    package, kind, leaf = name.split("/")
    module = importlib.import_module(f"{package}.{kind}")
    try:
        if kind == "action":
            action, _, part = leaf.rpartition("_")
            return getattr(getattr(module, action).Impl, part)
        return getattr(module, leaf)
    except AttributeError as error:
        remedy = f"required; build {package} again, in a checkout by `make setup`"
        raise ImportError(f"{package}.{kind} has no {leaf}, which is {remedy}") from error


def matching(profiles: Sequence[QoSProfile]) -> QoSProfile:
    """Return the most demanding profile that every publisher can serve."""
    qos = QoSProfile(depth=_DEPTH)
    if any(p.reliability != ReliabilityPolicy.RELIABLE for p in profiles):
        qos.reliability = ReliabilityPolicy.BEST_EFFORT
    if profiles and all(p.durability == DurabilityPolicy.TRANSIENT_LOCAL for p in profiles):
        qos.durability = DurabilityPolicy.TRANSIENT_LOCAL
    return qos


def misfits(publishers: Sequence[Endpoint], subscribers: Sequence[Endpoint]) -> list[str]:
    """Return a line for each pair of ends that do not hear each other."""
    lines = []
    for publisher in publishers:
        for subscriber in subscribers:
            if publisher.type != subscriber.type:
                types = f"{publisher.type} and {subscriber.type}"
                lines.append(f"{publisher.node} and {subscriber.node} have types {types}")
                continue
            verdict, reason = qos_check_compatible(publisher.qos, subscriber.qos)
            if verdict == QoSCompatibility.ERROR:
                why = " ".join(reason.split()).removeprefix("ERROR: ").rstrip("; ")
                lines.append(f"{subscriber.node} does not hear {publisher.node}: {why}")
    return lines
