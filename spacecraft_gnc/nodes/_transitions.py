"""Who may change the state of a node: in a launch the launcher alone."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Final

from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState

from spacecraft_gnc.errors import LaunchError
from spacecraft_gnc.launcher.environment import SUPERVISED

if TYPE_CHECKING:
    from rclpy.service import Service

    from spacecraft_gnc.nodes._ends import NodeWithEnds

_CONFIGURE: Final = "configure"
_ACTIVATE: Final = "activate"
_LONGEST_LABEL: Final = 40  # characters
_NAMES: Final = {
    Transition.TRANSITION_CONFIGURE: _CONFIGURE,
    Transition.TRANSITION_CLEANUP: "cleanup",
    Transition.TRANSITION_ACTIVATE: _ACTIVATE,
    Transition.TRANSITION_DEACTIVATE: "deactivate",
    Transition.TRANSITION_UNCONFIGURED_SHUTDOWN: "shutdown",
    Transition.TRANSITION_INACTIVE_SHUTDOWN: "shutdown",
    Transition.TRANSITION_ACTIVE_SHUTDOWN: "shutdown",
}


class Transitions:
    """Requests to change the state of a node.

    A request does not tell who sent it. A launcher asks each node to be configured and then to be
    activated, and for nothing else; it ends the process, not the life cycle. So these two are
    carried out, whoever asks for them, and asked for again they succeed without effect: a stranger
    who is first has done the launcher's work. Everything else is refused, or ends the node by name,
    as ``launcher.on_foreign_transition`` says. A node started by hand has no launcher, and does
    what it is asked for.

    Parameters
    ----------
    node
        Whose state it is.
    """

    def __init__(self, node: NodeWithEnds) -> None:
        self._node = node
        self._is_supervised = os.environ.get(SUPERVISED) == "1"
        self._carry_out: Any = None

    def guard(self, service: Service) -> None:
        """Stand before a service, if it is the one that changes the state."""
        if service.srv_type is ChangeState and self._is_supervised:
            self._carry_out, service.callback = service.callback, self._answer

    def _answer(self, request: Any, response: Any) -> Any:
        wanted = _name(request.transition)
        node = self._node
        if wanted not in (_CONFIGURE, _ACTIVATE):
            self._refuse(wanted)
        if node.active if wanted == _ACTIVATE else node.configured:
            response.success = True
            return response
        return self._carry_out(request, response)

    def _refuse(self, wanted: str) -> None:
        error = LaunchError(
            f"{self._node.ROLE}: transition {wanted} was requested by somebody else than the "
            "launcher; required none during a launch; find out who else is on this ROS_DOMAIN_ID"
        )
        is_told = self._node.configured  # before that, not even its scenario is known
        if is_told and self._node.scenario.launcher.on_foreign_transition == "stop":
            self._node.fail(error)
        raise error


def _name(transition: Transition) -> str:
    """Return the name of a transition; a label goes first, as in rclpy."""
    label = " ".join(str(transition.label)[:_LONGEST_LABEL].split())
    return label or _NAMES.get(transition.id, f"number {transition.id}")
