"""Parameters of all nodes, requested from the live graph."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from typing import Any, Final

from rcl_interfaces.msg import ParameterType
from rcl_interfaces.srv import GetParameters, GetParameterTypes, ListParameters
from rclpy.client import Client
from rclpy.parameter import parameter_value_to_python
from rclpy.timer import Timer

from spacecraft_gnc.nodes._node import GncNode
from spacecraft_gnc.parameters.declare import unflatten
from spacecraft_gnc.scenario.scenario import sections_to_yaml

_TICK: Final = 0.02  # [s] wall between two looks for the services of a node
_AGAIN: Final = 1.0  # [s] wall: an answer can be lost while DDS still matches
_PATIENCE: Final = 5.0  # [s] wall until a node counts as one that does not answer


class ParameterDump:
    """Asks nodes for all their parameters.

    Parameters
    ----------
    node
        Who asks, and adds its own.
    others
        Names of the nodes to ask, in the namespace of ``node``.
    on_done
        Called when all have answered, or one has not in time.
    """

    def __init__(self, node: GncNode, others: Iterable[str], on_done: Callable[[], None]) -> None:
        self._node = node
        self._others = {name: _Inquiry(node, name, self._tick) for name in others}
        self._on_done = on_done
        self._timer: Timer | None = None
        self._deadline = 0.0
        self.done = False

    def ask(self) -> None:
        """Begin; asking again does nothing."""
        if self._timer is None:
            self._deadline = time.monotonic() + _PATIENCE
            self._timer = self._node.every(_TICK, self._tick)

    def missing(self) -> tuple[str, ...]:
        """Nodes that have not told their parameters."""
        return tuple(name for name, inquiry in self._others.items() if inquiry.values is None)

    def text(self) -> str:
        """Return a ROS 2 parameter file of the nodes that have answered, and of the launcher."""
        own = self._node.get_parameters_by_prefix("")
        sections = {self._node.ROLE: {name: item.value for name, item in own.items()}}
        for name, inquiry in self._others.items():
            if inquiry.values is not None:
                sections[name] = inquiry.values
        prefix = self._node.get_namespace().rstrip("/")
        named = {
            f"{prefix}/{name}" if prefix else name: unflatten(_without_none(values))
            for name, values in sections.items()
        }
        named["launcher"] = unflatten(self._node.scenario.values["launcher"])  # no node to ask
        silent = "".join(f"# {name}: did not answer\n" for name in self.missing())
        return silent + sections_to_yaml(named)

    def _tick(self) -> None:
        if self.done or self._timer is None:
            return
        now = time.monotonic()
        for inquiry in self._others.values():
            inquiry.go_on(now)
        if self.missing() and now < self._deadline:
            return
        self.done = True
        self._timer.cancel()
        if self.missing():
            self._node.get_logger().warning(f"no parameters from {', '.join(self.missing())}")
        self._on_done()


class _Inquiry:
    """One node that is asked: for the names, their types, then the values of those that have one.

    One parameter without a value, such as an empty list, would empty the whole answer.
    """

    def __init__(self, node: GncNode, name: str, on_answer: Callable[[], None]) -> None:
        self.values: dict[str, Any] | None = None
        self._on_answer = on_answer
        self._names: list[str] = []
        self._set: list[str] = []
        self._asked = -_AGAIN
        full_name = f"{node.get_namespace().rstrip('/')}/{name}"
        self._list = _client(node, ListParameters, f"{full_name}/list_parameters")
        self._types = _client(node, GetParameterTypes, f"{full_name}/get_parameter_types")
        self._get = _client(node, GetParameters, f"{full_name}/get_parameters")

    def go_on(self, now: float) -> None:
        """Send what is to be sent now."""
        if self.values is not None or now - self._asked < _AGAIN:
            return
        client, request, take = self._next()
        if client.service_is_ready():
            self._asked = now
            client.call_async(request).add_done_callback(lambda future: self._go_on(take, future))

    def _next(self) -> tuple[Client, Any, Callable[[Any], None]]:
        if self._set:
            return self._get, GetParameters.Request(names=self._set), self._take_values
        if self._names:
            return self._types, GetParameterTypes.Request(names=self._names), self._take_types
        return self._list, ListParameters.Request(), self._take_names

    def _go_on(self, take: Callable[[Any], None], future: Any) -> None:
        take(future.result())
        self._asked = -_AGAIN
        self._on_answer()

    def _take_names(self, response: Any) -> None:
        self._names = list(response.result.names)

    def _take_types(self, response: Any) -> None:
        kinds = zip(self._names, response.types, strict=False)
        self._set = [name for name, kind in kinds if kind != ParameterType.PARAMETER_NOT_SET]

    def _take_values(self, response: Any) -> None:
        if len(response.values) == len(self._set):  # else one was withdrawn meanwhile: ask again
            values = map(parameter_value_to_python, response.values)
            self.values = dict.fromkeys(self._names) | dict(zip(self._set, values, strict=True))


def _client(node: GncNode, kind: Any, name: str) -> Client:
    client = node.create_client(kind, name)
    node.on_close(node.destroy_client, client)
    return client


def _without_none(values: dict[str, Any]) -> dict[str, Any]:
    """Write an array without a value, which ROS 2 counts as not set, as an empty list."""
    return {name: [] if value is None else _listed(value) for name, value in sorted(values.items())}


def _listed(value: Any) -> Any:
    return list(value) if hasattr(value, "__iter__") and not isinstance(value, str) else value
