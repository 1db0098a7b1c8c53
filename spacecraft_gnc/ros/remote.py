"""Parameters and life cycle of another node, by its services."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, ClassVar, NamedTuple

from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetAvailableTransitions, GetState
from rcl_interfaces.msg import ParameterDescriptor, ParameterType
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient

from spacecraft_gnc.errors import GncError
from spacecraft_gnc.ros.graph import GraphError, GraphView

NOT_SET = ParameterType.PARAMETER_NOT_SET
_PATIENCE = 5.0  # [s] wall for a node to answer
_TRANSITION_PATIENCE = 60.0  # [s] wall for a transition; kernels may have to be compiled
_RETRY = 1.0  # [s] a reply is lost if it leaves before the node has discovered us: ask again


class ParameterRefused(GncError):
    """A node does not take a value, or has no such parameter."""


class TransitionRefused(GncError):
    """A node cannot go through a transition from where it is."""


class TransitionFailed(GncError):
    """A node tried a transition and did not get through."""

    exit_code: ClassVar[int] = 1


class ParameterInfo(NamedTuple):
    """A parameter of another node."""

    name: str
    value: Any
    description: str
    read_only: bool


class RemoteParameters:
    """The parameters of one node.

    Parameters
    ----------
    view
        The graph.
    name
        The node's full name.

    Raises
    ------
    GraphError
        The node serves no parameters.
    """

    def __init__(self, view: GraphView, name: str) -> None:
        self._view = view
        self.name = name
        self._client = AsyncParameterClient(view.node, name)
        _require_service(view, name, "parameter services", self._client.services_are_ready)

    def names(self) -> list[str]:
        """Names of all parameters, sorted."""
        answer = _ask(self._view, self.name, self._client.list_parameters)
        return sorted(answer.result.names)

    def values(self, names: Sequence[str]) -> dict[str, Any]:
        """Return values by name; None for what is declared but not set.

        Raises
        ------
        ParameterRefused
            The node does not have all of them.
        """
        # One that is declared but not set makes a node answer nothing at all: leave those out.
        types = _ask(self._view, self.name, lambda: self._client.get_parameter_types(list(names)))
        if len(types.types) != len(names):
            raise ParameterRefused(
                f"{self.name}: does not have all of {', '.join(names)}; required declared "
                "parameters; list them with `gnc inspect params NODE`"
            )
        given = [name for name, kind in zip(names, types.types, strict=True) if kind != NOT_SET]
        answer = _ask(self._view, self.name, lambda: self._client.get_parameters(given))
        found = dict(zip(given, map(_plain, answer.values), strict=True))
        return {name: found.get(name) for name in names}

    def describe(self, names: Sequence[str]) -> list[ParameterInfo]:
        """Return what there is to know of parameters that the node has."""
        values = self.values(names)
        described = self._descriptors(names)
        return [
            ParameterInfo(name, values[name], d.description, bool(d.read_only))
            for name, d in zip(names, described, strict=True)
        ]

    def get(self, name: str) -> ParameterInfo:
        """Return one parameter.

        Raises
        ------
        ParameterRefused
            The node has none of that name.
        """
        known = self.names()
        if name not in known:
            from difflib import get_close_matches

            near = get_close_matches(name, known, n=1)
            remedy = f"did you mean {near[0]}?" if near else "list them with `gnc inspect params`"
            raise ParameterRefused(
                f"{name}: no such parameter of {self.name}; required one of its {len(known)}; "
                f"{remedy}"
            )
        return self.describe([name])[0]

    def set(self, name: str, value: Any) -> Any:
        """Set a parameter; return the value now in force.

        Raises
        ------
        ParameterRefused
            With the node's own reason.
        """
        before = self.get(name).value
        value = _as_declared(value, before)
        parameter = _parameter(name, value)
        answer = _ask(self._view, self.name, lambda: self._client.set_parameters([parameter]))
        (result,) = answer.results
        if not result.successful:
            reason = " ".join(result.reason.split()) or "the node gives no reason"
            raise ParameterRefused(
                f"{self.name} {name}: received {value!r}; refused: {reason}; {before!r} stays"
            )
        return self.values([name])[name]

    def _descriptors(self, names: Sequence[str]) -> list[ParameterDescriptor]:
        answer = _ask(self._view, self.name, lambda: self._client.describe_parameters(list(names)))
        return list(answer.descriptors)


class RemoteLifecycle:
    """The life cycle of one node.

    Parameters
    ----------
    view
        The graph.
    name
        The node's full name.

    Raises
    ------
    GraphError
        The node has no life cycle.
    """

    def __init__(self, view: GraphView, name: str) -> None:
        self._view = view
        self.name = name
        node = view.node
        self._get = node.create_client(GetState, f"{name}/get_state")
        self._list = node.create_client(
            GetAvailableTransitions, f"{name}/get_available_transitions"
        )
        self._change = node.create_client(ChangeState, f"{name}/change_state")
        clients = (self._get, self._list, self._change)
        _require_service(
            view, name, "life cycle", lambda: all(client.service_is_ready() for client in clients)
        )

    def state(self) -> str:
        """Name of the state the node is in."""
        answer = _ask(self._view, self.name, lambda: self._get.call_async(GetState.Request()))
        return str(answer.current_state.label)

    def transitions(self) -> dict[str, str]:
        """Return the transitions that can be asked for now, and where they lead."""
        request = GetAvailableTransitions.Request()
        answer = _ask(self._view, self.name, lambda: self._list.call_async(request))
        return {
            item.transition.label: item.goal_state.label for item in answer.available_transitions
        }

    def change(self, transition: str) -> str:
        """Go through a transition; return the state after it.

        Raises
        ------
        TransitionRefused
            It cannot be asked for now.
        TransitionFailed
            The node refused it.
        """
        known = self.transitions()
        if transition not in known:
            raise TransitionRefused(
                f"{self.name}: received transition {transition!r} in state {self.state()}; "
                f"required one of {', '.join(known) or 'none: there is no way on'}"
            )
        request = ChangeState.Request(transition=Transition(label=transition))
        sent = self._change.call_async(request)  # once: asking again would be another transition
        if not self._view.spin_until(sent.done, _TRANSITION_PATIENCE):
            self._view.raise_interrupt()
            raise GraphError(f"{self.name}: no answer to {transition}; required one; see its log")
        if not sent.result().success:
            raise TransitionFailed(
                f"{self.name}: refused {transition}; it is {self.state()} now; see its log"
            )
        return self.state()


def _require_service(view: GraphView, name: str, what: str, is_ready: Callable[[], bool]) -> None:
    if not view.spin_until(is_ready, _PATIENCE):
        view.raise_interrupt()
        raise GraphError(
            f"{name}: has no {what} on ROS_DOMAIN_ID={view.domain_id}; required a node that has; "
            "list the nodes with `gnc inspect nodes`"
        )


def _ask(view: GraphView, name: str, send: Callable[[], Any]) -> Any:
    """Return the answer to a question that may be asked more than once."""
    asked: list[Any] = []
    for _ in range(round(_PATIENCE / _RETRY)):
        asked.append(send())
        if view.spin_until(lambda: any(future.done() for future in asked), _RETRY):
            return next(future.result() for future in asked if future.done())
        view.raise_interrupt()
    raise GraphError(
        f"{name}: does not answer; required an answer within {_PATIENCE:g} s; is it busy or gone?"
    )


def _plain(value: Any) -> Any:
    """Return a parameter value as Python's own types."""
    plain = parameter_value_to_python(value)
    return list(plain) if hasattr(plain, "__len__") and not isinstance(plain, str) else plain


def _parameter(name: str, value: Any) -> Parameter:
    try:
        return Parameter(name, value=value)
    except TypeError as error:
        raise ParameterRefused(
            f"{name}: received {value!r}; required what ROS 2 takes: a bool, an integer, a double, "
            "a text, or a list of one of these; quote a text that YAML takes for a bool"
        ) from error


def _as_declared(value: Any, before: Any) -> Any:
    """Let whole numbers stand for doubles where the parameter holds doubles."""
    if isinstance(before, float) and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    if isinstance(before, list) and isinstance(value, list):
        doubles = all(isinstance(v, float) for v in before)
        whole = all(isinstance(v, int | float) and not isinstance(v, bool) for v in value)
        return [float(v) for v in value] if before and doubles and whole else value
    return value
