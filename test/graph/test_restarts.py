"""Controllers and governors killed in lockstep: the flight is that without ROS, bit for bit."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from graph.comparison import CASE1, assert_equals_simulation
from graph.killing import kill_controller_between_steps

from spacecraft_gnc.signals.graph import CONTROLLER

pytestmark = pytest.mark.graph
RESTARTS = (
    "plant.command_timeout=120.0",  # a busy machine may take long to start a process
    "launcher.on_node_death=restart",
)


def log_of(out: Path, name: str) -> str:
    return (out / "logs" / f"{name}.log").read_text()


def test_a_restarted_controller_goes_on_where_the_other_ended(graph: Any, at: Any) -> None:
    changes = ("plant.duration=800.0", *RESTARTS)
    out = graph.fly(*changes, display=at(300, kill_controller_between_steps))
    assert graph.outcome.restarts == (CONTROLLER,)
    assert "took up the memory of step " in log_of(out, CONTROLLER)
    assert_equals_simulation(out / "bag", *changes, scenario=CASE1)
