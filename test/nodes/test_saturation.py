"""A command beyond what the hardware can do acts within its limits, is counted and told of."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticStatus
from node_messages import tell
from rclpy.serialization import deserialize_message, serialize_message
from spacecraft_gnc_msgs.msg import PlantInvariants, TorqueCommand
from std_msgs.msg import Header

from spacecraft_gnc.nodes._saturation_watch import SaturationWatch
from spacecraft_gnc.nodes.plant import PlantNode
from spacecraft_gnc.plant.actuators import Actuators, component_limits
from spacecraft_gnc.signals.message import stamp_of
from spacecraft_gnc.vehicles.rigid_body.plant import RigidBodyPlant
from spacecraft_gnc.vehicles.rigid_body.signals import INVARIANTS

LIMIT = 0.01  # [N m]


@pytest.fixture
def plant(ros: Any, monkeypatch: pytest.MonkeyPatch) -> Any:
    """A plant node whose actuators give 0.01 N m about an axis, at step 0."""
    build = RigidBodyPlant.from_scenario

    def limited(scenario: Any, **how: Any) -> RigidBodyPlant:
        made = build(scenario, **how)
        made.actuators = Actuators(component_limits(LIMIT), "N m")
        return made

    monkeypatch.setattr(RigidBodyPlant, "from_scenario", staticmethod(limited))
    node = ros.add(PlantNode())
    node.trigger_configure()
    node.trigger_activate()
    assert node.active, node.failure
    node._awaited.clear()
    node._pace.begin(0.0)
    return node


def commanded(plant: Any, *torque: float) -> PlantInvariants:
    """Send a torque for the step at which the plant is; return what it tells of that step."""
    told: list[bytes] = []
    (agent,) = plant._agents.values()
    agent.publish[INVARIANTS] = told.append
    seconds, nanoseconds = stamp_of(plant.step, plant._period_ns)
    stamp = Time(sec=seconds, nanosec=nanoseconds)
    message = TorqueCommand(header=Header(stamp=stamp), step=plant.step)
    message.torque.x, message.torque.y, message.torque.z = torque
    tell(plant, "torque_command", serialize_message(message))
    (data,) = told
    return deserialize_message(data, PlantInvariants)


def test_a_strangers_command_acts_within_the_limits(plant: Any) -> None:
    diagnosed: list[tuple[str, dict[str, Any]]] = []

    def diagnose(level: bytes, text: str, values: dict[str, Any], stamp: Any) -> None:
        assert (level, stamp) == (DiagnosticStatus.WARN, stamp_of(plant.step, plant._period_ns))
        diagnosed.append((text, values))

    plant.diagnose = diagnose
    momenta = []
    for torque, acted in (
        ((0.005, -0.01, 0.0), (0.005, -0.01, 0.0)),
        ((1e9, -0.02, 0.001), (0.01, -0.01, 0.001)),
        ((-1e300, 0.0, 0.0), (-0.01, 0.0, 0.0)),
    ):
        told = commanded(plant, *torque)
        assert (told.applied_torque.x, told.applied_torque.y, told.applied_torque.z) == acted
        (agent,) = plant._agents.values()
        momenta.append(agent.core.state.momentum)
    assert plant.step == 3
    assert plant.refused == 0
    assert np.abs(np.diff(momenta, axis=0)).max() <= 0.4 * LIMIT * (1.0 + 1e-12)
    (told_of, values) = diagnosed[0]
    assert told_of == (
        "actuators saturated at step 1: asked for [1e+09, -0.02, 0.001] N m, given "
        "[0.01, -0.01, 0.001] N m (so far 1 step)"
    )
    assert values == {"step": 1, "saturated_steps": 1}
    assert len(diagnosed) == 1  # the next is due a simulated second later
    plant._finish()
    assert diagnosed[-1][1] == {"step": 2, "saturated_steps": 2}
    assert "(2 of 375 steps in all)" in diagnosed[-1][0]


class Flown:
    """Actuators that are asked for too much whenever it is said so, and their watch."""

    def __init__(self, period: float) -> None:
        self.actuators = Actuators(component_limits(1.0), "N m")
        still = SimpleNamespace()  # a plant of another package, without actuators
        self.watch = SaturationWatch({"sc1": self, "sc2": still}, period)
        self.step = 0

    def look(self, control: float) -> str | None:
        self.actuators.drive(self.step, np.array([control]))
        self.step += 1
        trouble = self.watch.look(self.step)
        return None if trouble is None else trouble.text


def test_within_the_limits_nothing_is_told() -> None:
    flown = Flown(0.4)
    assert [flown.look(1.0) for _ in range(50)] == [None] * 50
    assert flown.watch.conclude(50) is None


@pytest.mark.parametrize(("period", "told_at"), [(2.0, [0, 1, 3, 7, 15, 31]), (0.1, [0, 10, 21])])
def test_doublings_are_told_a_second_apart(period: float, told_at: list[int]) -> None:
    flown = Flown(period)
    texts = [flown.look(-3.0) for _ in range(40)]
    assert [k for k, text in enumerate(texts) if text] == told_at
    assert texts[0] == (
        "/sc1: actuators saturated at step 0: asked for [-3] N m, given [-1] N m (so far 1 step)"
    )
    last = flown.watch.conclude(40)
    assert last is not None
    assert last.text.endswith("(40 of 40 steps in all)")
    flown.actuators.reset()
    flown.watch.reset()
    assert flown.watch.conclude(40) is None
    assert flown.look(3.0)
