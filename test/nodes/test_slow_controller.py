"""A slow controller computes beside the executor, and the node stays what it is."""

from __future__ import annotations

import threading
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from node_messages import PERIOD_NS, encode_reference, encode_state, ends, tell, torque_step
from rcl_interfaces.srv import GetParameters
from rclpy.node import Node

from spacecraft_gnc import lie
from spacecraft_gnc.lazy import Lazy
from spacecraft_gnc.loop import Command, Reference, State
from spacecraft_gnc.nodes import _worker
from spacecraft_gnc.nodes.nmpc_controller import ControllerNode
from spacecraft_gnc.signals.message import stamp_of
from spacecraft_gnc.vehicles.rigid_body import descriptor
from spacecraft_gnc.vehicles.rigid_body.controllers.solvers import ShootingController
from spacecraft_gnc.vehicles.rigid_body.signals import STATE, TORQUE

PATIENCE = 30.0  # [s] wall: after this a test has failed
ZERO = np.zeros(3)
TURNED = lie.exp(np.array([0.1, 0.2, 0.0]))


class Gated(ShootingController):
    """Shooting whose every solve waits until the test lets it go on."""

    slow = True
    begun: threading.Semaphore
    gate: threading.Semaphore
    threads: list[int]
    error: Exception | None

    def command(self, state: State, reference: Reference) -> Command:
        self.threads.append(threading.get_ident())
        self.begun.release()
        assert self.gate.acquire(timeout=PATIENCE)
        if self.error is not None:
            raise self.error
        return super().command(state, reference)

    @classmethod
    def await_solve(cls) -> None:
        assert cls.begun.acquire(timeout=PATIENCE)


@pytest.fixture
def controller(ros: Any, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Return an active node around `Gated` that sends its torques to the list ``sent``."""
    for name, value in {
        "begun": threading.Semaphore(0),
        "gate": threading.Semaphore(0),
        "threads": [],
        "error": None,
    }.items():
        monkeypatch.setattr(Gated, name, value, raising=False)
    first, *others = descriptor.VEHICLE.methods
    gated = replace(first, build=Lazy(f"{__name__}:Gated.from_scenario"))
    vehicle = replace(descriptor.VEHICLE, methods=(gated, *others))
    monkeypatch.setattr(descriptor, "VEHICLE", vehicle)
    node = activated(ros.add(ControllerNode()))
    node.sent = []
    node._outlets[TORQUE] = node.sent.append
    yield node
    Gated.gate.release(9)  # no thread outlives its test
    node.trigger_shutdown()


def activated(node: ControllerNode) -> Any:
    node.trigger_configure()
    node.trigger_activate()
    assert node.active, node.failure
    return node


def state(step: int) -> bytes:
    return encode_state(stamp_of(step, PERIOD_NS), State(step, TURNED, ZERO), ZERO)


def reference(step: int) -> bytes:
    return encode_reference(stamp_of(step, PERIOD_NS), step, Reference(np.eye(3), ZERO, ZERO))


def ask(controller: Any, step: int) -> None:
    tell(controller, "attitude_state", state(step))
    tell(controller, "attitude_reference", reference(step))


def steps(controller: Any) -> list[int]:
    return [torque_step(data) for data in controller.sent]


def test_the_node_is_responsive_while_it_solves(ros: Any, controller: Any) -> None:
    ask(controller, 0)
    Gated.gate.release()
    ros.spin_until(lambda: controller.sent)
    reports: list[bytes] = []
    controller._publish_wall_status = reports.append
    ask(controller, 1)
    Gated.await_solve()
    Gated.await_solve()  # from here on the second solve waits for us
    ros.spin_until(lambda: reports)
    client = ros.add(Node("client"))
    states = client.create_publisher(*ends(STATE))
    ros.spin_until(states.get_subscription_count)
    states.publish(state(7))
    ros.spin_until(lambda: controller.get_clock().now().nanoseconds == 7 * PERIOD_NS)
    service = client.create_client(GetParameters, "nmpc_controller/get_parameters")
    ros.spin_until(service.service_is_ready)
    answer = service.call_async(GetParameters.Request(names=["horizon"]))
    ros.spin_until(answer.done)
    assert answer.result().values[0].integer_value == 5
    assert steps(controller) == [0]
    Gated.gate.release()
    ros.spin_until(lambda: steps(controller) == [0, 1])
    assert len(set(Gated.threads)) == 1
    assert threading.get_ident() not in Gated.threads


def test_the_bytes_are_those_of_a_solve_in_the_executor(ros: Any, controller: Any) -> None:
    ask(controller, 0)
    Gated.gate.release()
    ros.spin_until(lambda: controller.sent)
    in_thread = controller.sent.copy()
    controller._worker.close()
    controller._worker = None
    controller._controller.reset()
    controller._answered = -1
    Gated.gate.release()
    controller._answer_if_due()
    assert controller.sent == in_thread * 2
    assert Gated.threads[-1] == threading.get_ident()


def test_a_fast_controller_stays_in_the_executor(ros: Any) -> None:
    node = activated(ros.add(ControllerNode()))
    assert node._worker is None


def test_the_latest_state_wins_and_the_others_are_counted(ros: Any, controller: Any) -> None:
    for step in range(4):
        ask(controller, step)
    Gated.gate.release(2)
    ros.spin_until(lambda: len(controller.sent) == 2)
    assert steps(controller) == [0, 3]
    assert controller._skipped == 2
    assert len(Gated.threads) == 2


def test_a_repeated_state_waits_for_its_own_torque(ros: Any, controller: Any) -> None:
    ask(controller, 0)
    Gated.gate.release()
    ros.spin_until(lambda: controller.sent)
    ask(controller, 1)
    tell(controller, "attitude_state", state(1))
    assert steps(controller) == [0]
    Gated.gate.release()
    ros.spin_until(lambda: len(controller.sent) == 2)
    tell(controller, "attitude_state", state(1))
    assert controller.sent[1] == controller.sent[2]


def test_a_result_that_comes_after_deactivation_is_dropped(ros: Any, controller: Any) -> None:
    ask(controller, 0)
    worker = controller._worker
    Gated.gate.release()
    controller.trigger_deactivate()  # joins the thread: the result is on its way to the executor
    assert not worker._thread.is_alive()
    controller.trigger_activate()
    ros.spin_until(lambda: not worker.busy)
    assert controller.sent == []
    ask(controller, 0)
    Gated.gate.release()
    ros.spin_until(lambda: steps(controller) == [0])


def test_a_solve_without_end_does_not_hold_the_node(
    ros: Any, controller: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_worker, "_PATIENCE", 0.0)
    ask(controller, 0)
    assert controller.trigger_deactivate().name == "SUCCESS"
    worker = controller._worker
    assert worker._thread.is_alive()
    assert controller.trigger_activate().name == "FAILURE"
    assert "solve of the last one goes on" in str(controller.failure)
    Gated.gate.release()
    ros.spin_until(lambda: not worker.busy)
    assert controller.sent == []
    worker._thread.join(PATIENCE)
    assert controller.trigger_activate().name == "SUCCESS"


def test_a_node_configured_anew_does_not_wait_for_it(
    ros: Any, controller: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_worker, "_PATIENCE", 0.0)
    ask(controller, 0)
    worker = controller._worker
    for transition in ("deactivate", "cleanup", "configure", "activate"):
        assert getattr(controller, f"trigger_{transition}")().name == "SUCCESS"
    assert worker._thread.is_alive()
    sent: list[bytes] = []
    controller._outlets[TORQUE] = sent.append
    ask(controller, 0)
    Gated.gate.release(2)
    ros.spin_until(lambda: sent and not worker.busy)
    assert [torque_step(data) for data in sent] == [0]


def test_an_exception_in_the_thread_ends_the_node(ros: Any, controller: Any) -> None:
    Gated.error = ZeroDivisionError("a defect")
    ask(controller, 0)
    Gated.gate.release()
    ros.spin_until(lambda: controller.finished)
    assert controller.failure is Gated.error
    assert controller.sent == []


def test_so_does_one_in_what_is_done_with_the_result(ros: Any, controller: Any) -> None:
    controller._outlets[TORQUE] = None
    ask(controller, 0)
    Gated.gate.release()
    ros.spin_until(lambda: controller.finished)
    assert isinstance(controller.failure, TypeError)
