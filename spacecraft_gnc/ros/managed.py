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

    A reply is lost if it leaves before the node has discovered us: a service has no late joiners.
    So a node that does not answer for a while is asked what state it is in.

    Parameters
    ----------
    node
        Asks.
    name
        Of the node that is asked.
    """

    def __init__(self, node: Node, name: str) -> None:
        self._change = node.create_client(ChangeState, f"{name}/{_CHANGE}")
        self._get = node.create_client(GetState, f"{name}/{_GET}")
        self._answer: Any = None
        self._look: Any = None
        self._looks = 0
        self._patience_ends = 0.0
        self.stage = Stage.STARTING

    def push(self, *, may_activate: bool) -> None:
        """Take the next step toward ACTIVE, if it can be taken now."""
        if self.stage is Stage.STARTING and self._change.service_is_ready():
            self._ask(Stage.CONFIGURING)
        elif self.stage is Stage.CONFIGURED and may_activate:
            self._ask(Stage.ACTIVATING)
        elif self._answer is not None:
            self._read_answer()

    def _ask(self, stage: Stage) -> None:
        request = ChangeState.Request()
        request.transition.id = _TRANSITION[stage]
        self._answer = self._change.call_async(request)
        self.stage = stage
        self._looks = 0
        self._be_patient()

    def _be_patient(self) -> None:
        self._look = None
        self._patience_ends = time.monotonic() + _PATIENCE

    def _read_answer(self) -> None:
        if self._answer.done():
            success = self._answer.result().success
            self._answer = None
            self.stage = _NEXT[self.stage] if success else Stage.REFUSED
        elif self._look is not None and self._look.done():
            self._read_state(self._look.result().current_state.label)
        elif time.monotonic() >= self._patience_ends:
            self._look = self._get.call_async(GetState.Request())
            self._patience_ends = time.monotonic() + _PATIENCE

    def _read_state(self, label: str) -> None:
        if label == _LABEL[self.stage]:
            self._answer = None
            self.stage = _NEXT[self.stage]
        elif label == _LABEL_BEFORE[self.stage] and self._looks >= _LOOKS_BEFORE_ASKING_AGAIN:
            self._ask(self.stage)  # the request itself was lost, or will be refused again
        else:
            self._looks += 1
            self._be_patient()


_PATIENCE = 1.0  # [s] wall time without an answer
_LOOKS_BEFORE_ASKING_AGAIN = 5
_TRANSITION = {
    Stage.CONFIGURING: Transition.TRANSITION_CONFIGURE,
    Stage.ACTIVATING: Transition.TRANSITION_ACTIVATE,
}
_NEXT = {Stage.CONFIGURING: Stage.CONFIGURED, Stage.ACTIVATING: Stage.ACTIVE}
_LABEL = {Stage.CONFIGURING: "inactive", Stage.ACTIVATING: "active"}
_LABEL_BEFORE = {Stage.CONFIGURING: "unconfigured", Stage.ACTIVATING: "inactive"}
