"""Random service calls of a stranger in the domain of a graph, for hostile_services.py."""

from __future__ import annotations

import ctypes
import math
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
import rclpy
from action_msgs.srv import CancelGoal
from geometry_msgs.msg import Quaternion
from lifecycle_msgs.srv import (
    ChangeState,
    GetAvailableStates,
    GetAvailableTransitions,
    GetState,
)
from rcl_interfaces.msg import Parameter, ParameterValue
from rcl_interfaces.srv import (
    DescribeParameters,
    GetParameters,
    GetParameterTypes,
    ListParameters,
    SetParameters,
    SetParametersAtomically,
)
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from spacecraft_gnc_msgs.action import SlewTo
from type_description_interfaces.srv import GetTypeDescription
from unique_identifier_msgs.msg import UUID

NODES = ("plant", "nmpc_controller", "reference_governor", "recorder")
PATIENCE = 30.0  # [s] wall for the answers to come
TOGETHER = 8  # calls that may be without an answer at a time
STORM = 100  # goals or cancels sent at once
SEND_GOAL, GET_RESULT = SlewTo.Impl.SendGoalService, SlewTo.Impl.GetResultService
WORDS = ("", "duration", "use_sim_time", "inertia", "no.such", "\0", "é" * 40, "a" * 1000, "...")
LABELS = ("", "", "configure", "activate", "deactivate", "cleanup", "shutdown", "destroy", "x" * 99)
ODD = (math.nan, math.inf, -math.inf, -0.0, 1e308, 5e-324, 0.1, 2.0)
SETS = (
    (SetParameters, "set_parameters"),
    (SetParametersAtomically, "set_parameters_atomically"),
)
READS = (
    (GetParameters, "get_parameters"),
    (GetParameterTypes, "get_parameter_types"),
    (DescribeParameters, "describe_parameters"),
    (ListParameters, "list_parameters"),
)
CHANGE = (ChangeState, "change_state")
LOOKS = (
    (GetState, "get_state"),
    (GetAvailableStates, "get_available_states"),
    (GetAvailableTransitions, "get_available_transitions"),
    (GetAvailableTransitions, "get_transition_graph"),
    (GetTypeDescription, "get_type_description"),
)
ACTION = (
    (SEND_GOAL, "slew_to/_action/send_goal"),
    (CancelGoal, "slew_to/_action/cancel_goal"),
    (GET_RESULT, "slew_to/_action/get_result"),
)


class Stranger:
    """A client of everything that the nodes of a graph serve.

    Parameters
    ----------
    domain_id
        ROS_DOMAIN_ID of the graph.
    seed
        Of what it asks for.
    nodes
        Whom it asks.
    """

    def __init__(self, domain_id: int, seed: int, nodes: Sequence[str] = NODES) -> None:
        self.random = np.random.default_rng(seed)
        self.nodes = nodes
        self.sent: Counter[str] = Counter()
        self.answered: Counter[str] = Counter()
        self.accepted = self.transitions = self.unanswered = 0
        self.stops = False
        """Set from elsewhere: the flight is over."""
        self.goals: list[UUID] = []
        self._open: list[tuple[str, Any]] = []
        self._clients: dict[tuple[type, str], Any] = {}
        self._context = rclpy.Context()
        rclpy.init(args=[], context=self._context, domain_id=domain_id)
        self._node = Node("stranger", context=self._context, start_parameter_services=False)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        for node in nodes:  # all at once: to discover each takes a while
            for kind, service in (*SETS, *READS, CHANGE, *LOOKS):
                self._create(kind, f"{node}/{service}")
        for kind, name in ACTION:
            self._create(kind, name)

    def close(self) -> None:
        """Leave the domain."""
        self._executor.shutdown()
        self._node.destroy_node()
        rclpy.shutdown(context=self._context)

    # How it asks.

    def client(self, kind: type, name: str) -> Any:
        """Return the client of a service, which answers by now."""
        client = self._clients[kind, name]
        if not client.service_is_ready():
            self._spin(client.service_is_ready)
        return client

    def _create(self, kind: type, name: str) -> None:
        self._clients[kind, name] = self._node.create_client(kind, name)

    def call(self, kind: type, name: str, request: Any, *, waits: bool = True) -> Any:
        """Send a request; return the future of its answer."""
        label = name.rpartition("/")[2]
        self.sent[label] += 1
        future = self.client(kind, name).call_async(request)
        if waits:
            self._open.append((label, future))
            self._spin(lambda: len(self._unanswered()) < TOGETHER)
        return future

    def collect(self) -> None:
        """Wait for the answers that are still to come."""
        self._spin(lambda: not self._unanswered())
        self.unanswered = len(self._open)

    def _unanswered(self) -> list[Any]:
        still = []
        for label, future in self._open:
            if future.done():
                self.answered[label] += 1
                self._note(future.result())
            else:
                still.append((label, future))
        self._open = still
        return still

    def _note(self, answer: Any) -> None:
        self.accepted += bool(getattr(answer, "accepted", False))
        self.transitions += bool(isinstance(answer, ChangeState.Response) and answer.success)

    def _spin(self, done: Callable[[], bool]) -> None:
        patience = time.monotonic() + PATIENCE
        while not done() and time.monotonic() < patience:
            self._executor.spin_once(timeout_sec=0.05)

    # What it asks for.

    def attack(self, calls: int) -> None:
        """Make at least ``calls`` calls, of random kinds, and wait for their answers."""
        kinds = (self.set, self.read, self.change, self.look, self.slew, self.cancel, self.result)
        kinds = (*kinds, self.cut_off)
        while sum(self.sent.values()) < calls and not self.stops:
            self._any(kinds)()
        self.collect()

    def _storms(self, send: Callable[[], Any]) -> None:
        """Send a request; one in twenty times a storm of them, of which the last is answered."""
        if self.random.random() > 0.05:
            send()
            return
        self.collect()  # a storm pushes what waits out of the queue
        for _ in range(STORM - 1):
            send(waits=False)
        last = send()
        self._spin(last.done)

    def _any(self, choices: Sequence[Any]) -> Any:
        return choices[int(self.random.integers(len(choices)))]

    def _some(self, choices: Sequence[Any]) -> list[Any]:
        return [self._any(choices) for _ in range(self._any((0, 1, 1, 2, 7, 300)))]

    def set(self) -> None:
        """Set parameters, of types that there are and of others."""
        node = self._any(self.nodes)
        kind, service = self._any(SETS)
        wanted = [Parameter(name=n, value=self._value()) for n in self._some(WORDS)[:20]]
        self.call(kind, f"{node}/{service}", kind.Request(parameters=wanted))

    def _value(self) -> ParameterValue:
        numbers = [self._any(ODD) for _ in range(self._any((0, 1, 9, 500)))]
        return ParameterValue(
            type=int(self._any((*range(11), 99, 255))),
            bool_value=False,
            double_value=self._any(ODD),
            integer_value=self._any((-(1 << 63), (1 << 63) - 1, 0)),
            string_value=self._any(WORDS),
            double_array_value=numbers,
            string_array_value=self._some(WORDS)[:20],
            byte_array_value=[b"\xff"] * len(numbers),
        )

    def read(self) -> None:
        """Read parameters."""
        node = self._any(self.nodes)
        kind, service = self._any(READS)
        request = kind.Request()
        if kind is ListParameters:
            request.prefixes, request.depth = self._some(WORDS), self._any((0, 1, (1 << 64) - 1))
        else:
            request.names = self._some(WORDS)
        self.call(kind, f"{node}/{service}", request)

    def change(self) -> None:
        """Ask for a transition."""
        request = ChangeState.Request()
        request.transition.id = int(self._any((*range(12), 97, 99, 255)))
        request.transition.label = self._any(LABELS)
        self.call(ChangeState, f"{self._any(self.nodes)}/change_state", request)

    def look(self) -> None:
        """Look at a life cycle, or at the description of a type."""
        node = self._any(self.nodes)
        kind, service = self._any(LOOKS)
        request = kind.Request()
        if kind is GetTypeDescription:
            request.type_name, request.type_hash = self._any(WORDS), self._any(WORDS)
        self.call(kind, f"{node}/{service}", request)

    def slew(self) -> None:
        """Send a goal, or a storm of them."""

        def send(*, waits: bool = True) -> Any:
            request = SEND_GOAL.Request(goal_id=self._uuid(), goal=self._goal())
            self.goals.append(request.goal_id)
            return self.call(SEND_GOAL, "slew_to/_action/send_goal", request, waits=waits)

        self._storms(send)

    def _goal(self) -> Any:
        if self.random.random() < 0.3:
            return SlewTo.Goal(target=Quaternion(w=1.0), tolerance=self._any((0.0, 1e-9, 1e-3)))
        x, y, z, w = (self._any((*ODD[:3], 0.0, 1e308, 5.0)) for _ in range(4))
        return SlewTo.Goal(target=Quaternion(x=x, y=y, z=z, w=w), tolerance=self._any(ODD))

    def _uuid(self) -> UUID:
        if self.goals and self.random.random() < 0.2:
            return self._any(self.goals)
        return UUID(uuid=self.random.integers(0, 256, 16, dtype=np.uint8))

    def cancel(self) -> None:
        """Cancel one goal, or all, or all before a time; or do so in a storm."""

        def send(*, waits: bool = True) -> Any:
            request = CancelGoal.Request()
            if self.random.random() < 0.5:
                request.goal_info.goal_id = self._uuid()
            request.goal_info.stamp.sec = self._any((0, 0, -1, (1 << 31) - 1))
            request.goal_info.stamp.nanosec = self._any((0, (1 << 32) - 1))
            return self.call(CancelGoal, "slew_to/_action/cancel_goal", request, waits=waits)

        self._storms(send)

    def result(self) -> None:
        """Ask for the result of a goal, and do not wait: it may fly on."""
        request = GET_RESULT.Request(goal_id=self._uuid())
        self.call(GET_RESULT, "slew_to/_action/get_result", request, waits=False)

    def cut_off(self) -> None:
        """Send a request of which nothing but the header arrives; nobody can answer that."""
        node = self._any(self.nodes)
        kind, service = self._any((SETS[0], READS[0]))
        client = self.client(kind, f"{node}/{service}")
        with _serialized_as_nothing(kind):
            client.call_async(kind.Request())
            self.sent["cut off"] += 1


@contextmanager
def _serialized_as_nothing(kind: type) -> Iterator[None]:
    """Have this process write no byte of a request's content."""
    package, _, _ = kind.__module__.partition(".")
    library = ctypes.CDLL(f"lib{package}__rosidl_typesupport_fastrtps_c.so")
    name = f"{package}__srv__{kind.__name__}_Request"
    find = library[f"rosidl_typesupport_fastrtps_c__get_message_type_support_handle__{name}"]
    find.restype = ctypes.POINTER(ctypes.c_void_p)
    callbacks = ctypes.cast(find()[1], ctypes.POINTER(ctypes.c_void_p))  # 2: cdr_serialize
    nothing = ctypes.CFUNCTYPE(ctypes.c_bool, ctypes.c_void_p, ctypes.c_void_p)(lambda _, __: True)
    before, callbacks[2] = callbacks[2], ctypes.cast(nothing, ctypes.c_void_p).value
    try:
        yield
    finally:
        callbacks[2] = before
