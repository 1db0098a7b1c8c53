"""A lifecycle node seen from outside: how far it has come, and what takes it further."""

from __future__ import annotations

import time
from enum import Enum
from typing import Any, Final

from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from rclpy.node import Node

_CHANGE: Final = "change_state"
_GET: Final = "get_state"
SERVICES: Final = (_CHANGE, _GET)
"""Of a node: what is asked of it."""


class Stage(Enum):
    """How far a node has come."""

    STARTING = "starting"
    CONFIGURING = "configuring"
    CONFIGURED = "configured"
    ACTIVATING = "activating"
    ACTIVE = "active"
    REFUSED = "refused"


class Managed:
    """One lifecycle node, seen from outside.

    Before each transition the node is asked what state it is in, and then for the transition that
    is missing: somebody else may have answered the request before, such as a node of the same name
    that a killed launcher left behind on the domain, or somebody else may have asked first. While
    several answer to the name, nothing is concluded from what they say, for some seconds: by then
    such a node has ended, and a stranger must not hold up the start.

    A reply is lost if it leaves before the node has discovered us: a service has no late joiners.
    So a node that does not answer for a while is asked what state it is in, too.

    Parameters
    ----------
    node
        Asks.
    name
        Of the node that is asked.
    """

    def __init__(self, node: Node, name: str) -> None:
        self._node = node
        self._service = f"/{name}/{_CHANGE}"
        self._change = node.create_client(ChangeState, f"{name}/{_CHANGE}")
        self._get = node.create_client(GetState, f"{name}/{_GET}")
        self._answer: Any = None
        self._look: Any = None
        self._looks = self._looks_at_several = 0
        self._patience_ends = 0.0
        self.stage = Stage.STARTING

    def push(self, *, may_activate: bool) -> None:
        """Take the next step toward ACTIVE, if it can be taken now."""
        if self.stage is Stage.STARTING and self._is_there():
            self._approach(Stage.CONFIGURING)
        elif self.stage is Stage.CONFIGURED and may_activate:
            self._approach(Stage.ACTIVATING)
        elif self.stage in _TRANSITION:
            self._go_on()

    def _is_there(self) -> bool:
        return self._change.service_is_ready() and self._get.service_is_ready()

    def _approach(self, stage: Stage) -> None:
        self.stage = stage
        self._look_at_state()

    def _go_on(self) -> None:
        """Take what has been answered."""
        if self._answer is not None and self._answer.done():
            self._arrive(success=self._answer.result().success)
        elif self._look is not None and self._look.done():
            self._read_state(self._look.result().current_state.label)
        elif time.monotonic() >= self._patience_ends:
            self._look_at_state()

    def _look_at_state(self) -> None:
        self._look = self._get.call_async(GetState.Request())
        self._be_patient()

    def _read_state(self, label: str) -> None:
        self._look = None
        is_asked = self._answer is not None and self._looks < _LOOKS_BEFORE_ASKING_AGAIN
        if self._are_several():
            self._looks_at_several += 1
            self._be_patient()
        elif label in _LABELS_BEYOND[self.stage]:
            self._arrive(success=True)
        elif is_asked or label not in _STAGE_FROM:  # in the middle of it
            self._looks += 1
            self._be_patient()
        else:  # also if a request was lost, or what was configured is so no more
            self._ask(_STAGE_FROM[label])

    def _are_several(self) -> bool:
        """Tell whether there is a reason to wait until one is left."""
        may_wait = self._looks_at_several < _LOOKS_AT_SEVERAL
        return may_wait and self._node.count_services(self._service) > 1

    def _ask(self, stage: Stage) -> None:
        request = ChangeState.Request()
        request.transition.id = _TRANSITION[stage]
        self._answer = self._change.call_async(request)
        self.stage = stage
        self._looks = 0
        self._be_patient()

    def _arrive(self, *, success: bool) -> None:
        self._answer = self._look = None
        self.stage = _NEXT[self.stage] if success else Stage.REFUSED

    def _be_patient(self) -> None:
        self._patience_ends = time.monotonic() + _PATIENCE


_PATIENCE = 1.0  # [s] wall time without an answer
_LOOKS_BEFORE_ASKING_AGAIN = 5
_LOOKS_AT_SEVERAL = 5
_TRANSITION = {
    Stage.CONFIGURING: Transition.TRANSITION_CONFIGURE,
    Stage.ACTIVATING: Transition.TRANSITION_ACTIVATE,
}
_NEXT = {Stage.CONFIGURING: Stage.CONFIGURED, Stage.ACTIVATING: Stage.ACTIVE}
_STAGE_FROM = {"unconfigured": Stage.CONFIGURING, "inactive": Stage.ACTIVATING}
_LABELS_BEYOND = {Stage.CONFIGURING: ("inactive", "active"), Stage.ACTIVATING: ("active",)}
