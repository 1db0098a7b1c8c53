"""The graph flies the closed loop, bit for bit and every time."""

from __future__ import annotations

import math
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from graph.comparison import assert_equals_simulation
from live.layout import require_filled, shown
from rosbags.highlevel import AnyReader

from spacecraft_gnc import lie
from spacecraft_gnc.analysis.reader import read_flight
from spacecraft_gnc.vehicles.rigid_body.signals import SOLVER_STATUS

pytestmark = pytest.mark.graph

SHORT = "plant.duration=20.0"


def payloads(bag: Path) -> dict[str, list[bytes]]:
    """Messages of each topic in order, without what tells of wall time."""
    found: dict[str, list[bytes]] = defaultdict(list)
    with AnyReader([bag]) as reader:
        for connection, _, data in reader.messages():
            if connection.topic == "/wall_timing":
                continue
            # wall_solve_time and wall_deadline_slack come last
            end = -16 if connection.topic == "/solver_status" else None
            found[connection.topic].append(bytes(data)[:end])
    return dict(found)


def test_the_wall_fields_are_the_last_of_solver_status() -> None:
    assert [*SOLVER_STATUS.fields][-2:] == ["wall_solve_time", "wall_deadline_slack"]


def test_two_launches_and_a_composed_one_are_identical(graph: Any) -> None:
    first = graph.fly(SHORT)
    assert graph.exit_codes == dict.fromkeys(graph.exit_codes, 0)
    assert len(graph.exit_codes) == 4
    second = graph.fly(SHORT)
    third = graph.fly(SHORT, "launcher.composed=true")
    assert graph.exit_codes == {"graph": 0}
    expected = payloads(first / "bag")
    counts = {topic.strip("/"): len(messages) for topic, messages in expected.items()}
    assert counts == {
        "attitude_state": 51,
        "attitude_reference": 51,
        "plant_invariants": 51,
        "governor_status": 51,
        "pose": 51,
        "torque_command": 50,
        "solver_status": 50,
        "attitude_error": 50,
        "clock": 50,
        "zone_markers": 1,
    }
    assert payloads(second / "bag") == expected
    assert payloads(third / "bag") == expected
    assert_equals_simulation(first / "bag", SHORT)
    require_filled(first / "bag")
    require_attitude_error(first / "bag")


def require_attitude_error(bag: Path) -> None:
    """Check the first panel of the layout: how far the attitude is from the reference."""
    series = shown(bag)["Plot!error"]
    told = np.array([[value for _, value in series[path]] for path in sorted(series)]).T
    flown = read_flight(bag).trajectory
    expected = [
        lie.log(R_ref.T @ R) for R_ref, R in zip(flown.reference, flown.attitude, strict=True)
    ]
    np.testing.assert_allclose(told, expected, rtol=0.0, atol=1e-15)
    assert np.linalg.norm(told[0]) == pytest.approx(0.75)  # [rad] of Case I at its start


def test_case_1(graph: Any) -> None:
    out = graph.fly()
    assert_equals_simulation(out / "bag")
    flown = read_flight(out / "bag").trajectory
    assert len(flown.time) == 375
    assert flown.cost[0] == pytest.approx(0.01587107410188242, abs=1e-12)
    assert np.linalg.norm(flown.torque, axis=1).max() == pytest.approx(0.01, abs=1e-8)
    assert graph.outcome.steps == 375
    assert math.isfinite(graph.outcome.startup_time)
    assert (out / "logs" / "plant.log").read_text().count("flew 375 steps") == 1


def test_control_period_of_several_integrator_steps(graph: Any) -> None:
    overrides = (SHORT, "plant.time_step=0.1", "nmpc_controller.time_step=0.4")
    out = graph.fly(*overrides)
    assert_equals_simulation(out / "bag", *overrides)


def test_free_run(graph: Any) -> None:
    out = graph.fly(SHORT, "plant.mode=free_run", "plant.real_time_factor=10.0")
    flown = read_flight(out / "bag")
    assert not flown.info.missing
    assert len(flown.trajectory.time) == 50
    assert graph.outcome.wall_time == pytest.approx(2.0, rel=0.1)


def test_without_a_recorder(graph: Any) -> None:
    out = graph.fly("plant.duration=2.0", record=False)
    assert set(graph.exit_codes) == {"plant", "nmpc_controller", "reference_governor"}
    assert not (out / "bag").exists()
    assert graph.outcome.bags == ()
