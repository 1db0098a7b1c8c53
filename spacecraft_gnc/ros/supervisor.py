"""ROS 2 node of the launcher: drives life cycles and listens for progress."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import rclpy
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from spacecraft_gnc_msgs.msg import WallTiming

from spacecraft_gnc.launcher.environment import prepare
from spacecraft_gnc.ros.endpoints import message_type
from spacecraft_gnc.ros.qos import ros_qos
from spacecraft_gnc.signals import Signal
from spacecraft_gnc.signals.graph import CONTROLLER, PLANT, WALL_STATUS, WALL_TIMING
from spacecraft_gnc.signals.members import Place, role_of, space_of

if TYPE_CHECKING:
    from typing_extensions import Self


class Stage(Enum):
    """How far a node has come."""

    STARTING = "starting"
    CONFIGURING = "configuring"
    CONFIGURED = "configured"
    ACTIVATING = "activating"
    ACTIVE = "active"
    REFUSED = "refused"


@dataclass(slots=True)
class Progress:
    """What the graph last told about itself."""

    step: int = -1
    """Last control step reported; -1: none."""
    wall_elapsed: float = 0.0
    """Since step 0 [s]."""
    latency: float = math.nan
    """State to torque [s]."""
    missed_deadlines: int = 0
    status_step: int = -1
    """Control step that the next three belong to; -1: none."""
    distance: float = math.nan
    """From where it is to go [m]; NaN: it is not a matter of place."""
    attitude_error: float = math.nan
    """Angle from the attitude that it is to have [rad]."""
    solve_time: float = math.nan
    """[s]"""


class _Status(NamedTuple):
    """What a controller last told."""

    step: int
    distance: float
    error: float
    solve_time: float


def _farness(status: _Status) -> tuple[float, ...]:
    """Return what orders controllers by how far they have to go: by place, then by attitude."""
    return tuple(-1.0 if math.isnan(far) else far for far in (status.distance, status.error))


class Supervisor:
    """Brings nodes to life and knows how they fare. Use it as a context manager.

    Parameters
    ----------
    names
        Nodes to look after, relative to the root namespace.
    domain_id
        ROS_DOMAIN_ID of the graph.
    """

    def __init__(self, names: Sequence[str], domain_id: int) -> None:
        prepare(os.environ)
        options = SignalHandlerOptions.NO
        rclpy.init(args=[], domain_id=domain_id, signal_handler_options=options)
        self._node = Node(f"launcher_{os.getpid()}", start_parameter_services=False)
        self._executor = EventsExecutor()
        self._executor.add_node(self._node)
        self._nodes = {name: _Managed(self._node, name) for name in names}
        self.progress = Progress()
        self._status: dict[str, _Status] = {}
        self._listen(WALL_TIMING, "", self._on_timing)
        for space in dict.fromkeys(space_of(n) for n in names if role_of(n) == CONTROLLER):
            self._listen(WALL_STATUS, space, partial(self._on_status, space))

    def _listen(self, signal: Signal, space: str, callback: Callable[[Any], None]) -> None:
        kind, qos = message_type(signal.type), ros_qos(signal.qos)
        self._node.create_subscription(kind, Place("", space).topic(signal), callback, qos)

    def __enter__(self) -> Self:
        """Return the supervisor."""
        return self

    def __exit__(self, *_: object) -> None:
        """Leave the graph."""
        self._executor.remove_node(self._node)
        del self._executor  # it holds our callbacks, and we it: no garbage collector sees that
        self._node.destroy_node()
        rclpy.try_shutdown()

    def spin(self, wall_time: float) -> None:
        """Handle what arrives for about ``wall_time`` seconds, and push every node on."""
        deadline = time.monotonic() + wall_time
        self._push()
        while (remaining := deadline - time.monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=remaining)
        self._push()

    def stages(self) -> dict[str, Stage]:
        """Return how far each node has come."""
        return {name: node.stage for name, node in self._nodes.items()}

    def _push(self) -> None:
        """Configure all together; activate when all are configured, the plant last."""
        stages = [node.stage for node in self._nodes.values()]
        all_configured = not {Stage.STARTING, Stage.CONFIGURING} & set(stages)
        for name, node in self._nodes.items():
            others = (n.stage for other, n in self._nodes.items() if other != name)
            allowed = name != PLANT or all(stage is Stage.ACTIVE for stage in others)
            node.push(may_activate=all_configured and allowed)

    def _on_timing(self, message: WallTiming) -> None:
        progress = self.progress
        progress.step = message.step
        progress.wall_elapsed = message.wall_elapsed
        progress.latency = message.wall_latency
        progress.missed_deadlines = message.missed_deadlines

    def _on_status(self, space: str, message: Any) -> None:
        """Show the controller that is furthest from where it is to go."""
        values = {entry.key: entry.value for entry in message.status[0].values}
        names = ("distance", "attitude_error", "wall_solve_time")
        told = (float(values.get(name, math.nan)) for name in names)
        self._status[space] = _Status(int(values.get("step", -1)), *told)
        shown, progress = max(self._status.values(), key=_farness), self.progress
        progress.status_step, progress.solve_time = shown.step, shown.solve_time
        progress.distance, progress.attitude_error = shown.distance, shown.error


class _Managed:
    """One lifecycle node, seen from outside.

    A reply is lost if it leaves before the node has discovered us: a service has no late joiners.
    So a node that does not answer for a while is asked what state it is in.
    """

    def __init__(self, node: Node, name: str) -> None:
        self._change = node.create_client(ChangeState, f"{name}/change_state")
        self._get = node.create_client(GetState, f"{name}/get_state")
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
