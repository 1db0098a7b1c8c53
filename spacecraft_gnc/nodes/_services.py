"""Guard around the services of a node: every request is answered, and none ends the node."""

from __future__ import annotations

from collections.abc import Sequence, Sized
from typing import TYPE_CHECKING, Any, Final

from rcl_interfaces.msg import ParameterDescriptor, ParameterType, SetParametersResult
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.parameter import Parameter

from spacecraft_gnc.nodes._transitions import Transitions

if TYPE_CHECKING:
    from rclpy.service import Service

    from spacecraft_gnc.nodes._ends import NodeWithEnds

_LONGEST: Final = 1000  # list or text in a request: more than a node has parameters
_LONGEST_REASON: Final = 300  # characters
_NAMELESS: Final = "received a parameter without a name; required one that is declared; name it"


def guard_services(node: NodeWithEnds) -> None:
    """Guard the services that a node has by now: of parameters, life cycle and types.

    Whatever goes wrong with a request gives the failed answer of its type, and is refused as a
    message is: counted, logged and told on /diagnostics. Under rclpy's EventsExecutor (7.1) it
    would leave ``spin_once``, and whoever asked would wait for ever.
    """
    node.set_descriptor("use_sim_time", _SIMULATED)
    node.add_on_set_parameters_callback(_require_names)
    transitions = Transitions(node)
    for service in list(node.services):
        transitions.guard(service)
        _Guard(node, service)


class _Guard:
    """Stands between the executor and a service."""

    def __init__(self, node: NodeWithEnds, service: Service) -> None:
        self._node = node
        self._name = service.service_name
        self._answer, self._send = service.callback, service.send_response
        service.callback, service.send_response = self.answer, self.send

    def answer(self, request: Any, response: Any) -> Any:
        """Return the answer to a request; if there is none, that it failed."""
        try:
            _require_brevity(request)
            return self._answer(request, response)
        except Exception as error:  # noqa: BLE001 - whatever a request of a stranger leads to
            reason = shortened(error)
            self._node.refuse(self._name, reason, "request")
            return _failed(request, response, reason)

    def send(self, response: Any, header: Any) -> None:
        """Send an answer; whoever asked may be gone."""
        try:
            self._send(response, header)
        except Exception as error:  # noqa: BLE001 - likewise
            self._node.refuse(self._name, f"cannot be answered: {shortened(error)}", "request")


def shortened(error: Exception) -> str:
    """Return what an error says, without the long lists that it may quote."""
    text = " ".join(str(error).split()) or type(error).__name__
    return text if len(text) <= _LONGEST_REASON else f"{text[:_LONGEST_REASON]}..."


def _require_brevity(message: Any) -> None:
    """Refuse what would keep the node busy for seconds, or come back as quoted in the answer."""
    for field in message.get_fields_and_field_types():
        value = getattr(message, field)
        if isinstance(value, Sized) and len(value) > _LONGEST:
            raise ValueError(
                f"{field}: received a length of {len(value)}; required {_LONGEST} at most; ask for "
                "less at once"
            )
        for part in value if isinstance(value, list) else [value]:
            if hasattr(part, "get_fields_and_field_types"):
                _require_brevity(part)


def _require_names(parameters: Sequence[Parameter]) -> SetParametersResult:
    """Refuse a parameter of an empty name, which rclpy (7.1) does not see to be undeclared."""
    successful = all(parameter.name for parameter in parameters)
    return SetParametersResult(successful=successful, reason="" if successful else _NAMELESS)


def _failed(request: Any, response: Any, reason: str) -> Any:
    """Return the answer that says that a request failed, where its type has a place for that."""
    refusal = SetParametersResult(successful=False, reason=reason)
    if isinstance(response, SetParameters.Response):  # one result for each; some may be there
        missing = len(request.parameters) - len(response.results)
        response.results = [*response.results, *[refusal] * missing]
        return response
    failed = type(response)()  # of the lists, empty ones: all or nothing
    if isinstance(response, SetParametersAtomically.Response):
        failed.result = refusal
    elif hasattr(response, "failure_reason"):
        failed.failure_reason = reason
    return failed


_SIMULATED: Final = ParameterDescriptor(
    name="use_sim_time",
    type=ParameterType.PARAMETER_BOOL,
    description="always true: a node lives in simulated time",
    read_only=True,
)
