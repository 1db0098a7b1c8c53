"""A method that takes its time, from a package of its own, flies like any other."""

from __future__ import annotations

import statistics
import time
from pathlib import Path
from typing import Any

import pytest
import rclpy
from graph.comparison import assert_equals_simulation
from node_messages import ends
from rcl_interfaces.srv import GetParameters
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future

from spacecraft_gnc.analysis.reader import read_flight
from spacecraft_gnc.launcher.launcher import Launcher
from spacecraft_gnc.launcher.outcome import NodeDied
from spacecraft_gnc.launcher.progress import Display
from spacecraft_gnc.vehicles.rigid_body.signals import TORQUE

pytestmark = pytest.mark.graph

SOLVE = 0.3  # [s] wall
AT_ONCE = 0.1  # [s] wall; a node that solves in its executor takes SOLVE
CALLS = 5
N_STEPS = 10
PATIENCE = 30.0  # [s] wall
OVERRIDES = ("plant.duration=4.0", "nmpc_controller.method=patient")
PATIENT = f"""
import time
from spacecraft_gnc.vehicles.rigid_body.controllers.solvers import ShootingController

class PatientController(ShootingController):
    name = "patient"
    slow = True

    @classmethod
    def from_scenario(cls, scenario):
        controller = super().from_scenario(scenario)
        controller.broken = scenario.controller.plugin.get("broken", False)
        return controller

    def command(self, state, reference):
        end = time.perf_counter() + {SOLVE}
        while time.perf_counter() < end:  # as Python code that keeps the interpreter busy
            pass
        if self.broken:
            raise ZeroDivisionError("a defect")
        return super().command(state, reference)
"""
ENTRY_POINTS = "[spacecraft_gnc.controllers]\npatient = patient:PatientController\n"


@pytest.fixture
def patient(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    """Install a package with the method ``patient`` here and in the nodes."""
    folder: Path = tmp_path_factory.mktemp("site")
    (folder / "patient.py").write_text(PATIENT)
    metadata = folder / "patient-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: patient\nVersion: 1.0\n")
    (metadata / "entry_points.txt").write_text(ENTRY_POINTS)
    monkeypatch.syspath_prepend(folder)
    monkeypatch.setenv("PYTHONPATH", str(folder))


class Warned(Display):
    """Keeps what is warned of."""

    def __init__(self) -> None:
        self.warnings: list[str] = []

    def warn(self, text: str) -> None:
        self.warnings.append(text)


class Questioner:
    """Asks the controller for a parameter while the graph flies."""

    def __init__(self) -> None:
        self.answered_after: list[float] = []
        """[s] wall, of each call."""
        self.flown_on = Future()
        """Done once the controller has sent a torque after the last answer."""

    def __call__(self, launcher: Launcher) -> None:
        context = rclpy.Context()
        rclpy.init(args=[], context=context, domain_id=launcher._domain_id)
        executor = SingleThreadedExecutor(context=context)
        node = Node("questioner", context=context)
        executor.add_node(node)
        client = node.create_client(GetParameters, "nmpc_controller/get_parameters")
        assert client.wait_for_service(PATIENCE)
        for _ in range(CALLS):
            asked = time.perf_counter()
            answer = client.call_async(GetParameters.Request(names=["horizon"]))
            executor.spin_until_future_complete(answer, PATIENCE)
            assert answer.result().values[0].integer_value == 5
            self.answered_after.append(time.perf_counter() - asked)
        kind, name, qos = ends(TORQUE)
        node.create_subscription(kind, name, self.flown_on.set_result, qos)
        executor.spin_until_future_complete(self.flown_on, PATIENCE)
        node.destroy_node()
        executor.shutdown()
        rclpy.shutdown(context=context)


@pytest.mark.usefixtures("patient")
def test_a_slow_method_flies_the_same_and_answers_meanwhile(graph: Any, at: Any) -> None:
    questioner = Questioner()
    out = graph.fly(*OVERRIDES, display=at(1, questioner))
    assert graph.exit_codes == dict.fromkeys(graph.exit_codes, 0)
    assert graph.outcome.missed_deadlines == 0
    assert_equals_simulation(out / "bag", *OVERRIDES)
    assert questioner.flown_on.done()
    assert statistics.median(questioner.answered_after) < AT_ONCE


@pytest.mark.usefixtures("patient")
def test_in_free_run_its_late_answers_are_counted_and_warned_of(graph: Any) -> None:
    display = Warned()
    free_run = ("plant.mode=free_run", f"plant.real_time_factor={0.4 / (SOLVE / 3.0)}")
    out = graph.fly(*OVERRIDES, *free_run, display=display)
    assert graph.exit_codes == dict.fromkeys(graph.exit_codes, 0)
    assert graph.outcome.missed_deadlines > N_STEPS // 2
    (warning,) = display.warnings
    assert "torques came after their deadline" in warning
    flight = read_flight(out / "bag")
    assert flight.trajectory.n_steps == N_STEPS
    assert flight.info.missing["solver_status"]  # of several states the last was answered


@pytest.mark.usefixtures("patient")
def test_its_exception_ends_the_run(graph: Any) -> None:
    with pytest.raises(NodeDied, match="nmpc_controller") as caught:
        graph.fly(*OVERRIDES, "nmpc_controller.plugin.broken=true")
    assert caught.value.exit_code == 1
    assert graph.exit_codes["nmpc_controller"] == 1
