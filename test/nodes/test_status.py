"""SolverStatus says what a command says."""

from __future__ import annotations

import math

import numpy as np
import pytest
from rclpy.serialization import deserialize_message
from spacecraft_gnc_msgs.msg import SolverStatus

from spacecraft_gnc import lie
from spacecraft_gnc.loop import Command, Reference, Source, State
from spacecraft_gnc.scenario import from_sections
from spacecraft_gnc.vehicles.rigid_body.controllers.report import (
    SolveReport,
    Standstill,
    solution_of,
)
from spacecraft_gnc.vehicles.rigid_body.outputs import Outputs
from spacecraft_gnc.vehicles.rigid_body.signals import SOLVER_STATUS

HORIZON = 5
ZONE = {"body_axis": [1.0, 0.0, 0.0], "inertial_axis": [0.0, 0.0, 1.0], "half_angle_deg": 5.0}
START = State(3, lie.exp(np.array([0.1, 0.0, 0.0])), np.zeros(3))
TARGET = Reference(np.eye(3), np.zeros(3), np.zeros(3))
WALL = (0.25, math.nan)


SECTION = {"horizon": HORIZON, "zone_names": ["star"], "zones": {"star": ZONE}}
INERTIA = np.diag([1.0, 0.8, 0.8]).ravel().tolist()
SCENARIO = from_sections({"plant": {"inertia": INERTIA}, "nmpc_controller": SECTION})


@pytest.fixture
def solved() -> Command:
    return SCENARIO.build_controller().command(START, TARGET)


def decoded(command: Command) -> SolverStatus:
    told = dict(Outputs(SCENARIO).controller(START, TARGET, command, WALL))
    data = SOLVER_STATUS.encode((1, 2), 3, told[SOLVER_STATUS])
    return deserialize_message(data, SolverStatus)


def test_a_solve(solved: Command) -> None:
    solution = solution_of(solved)
    assert solution is not None
    message = decoded(solved)
    assert (message.header.stamp.sec, message.header.stamp.nanosec, message.step) == (1, 2, 3)
    assert (message.method, message.formulation) == ("shooting", solution.formulation)
    assert message.status == SolverStatus.CONVERGED
    assert message.residual == solution.residual
    assert np.array_equal(message.zone_margins, solution.zone_margins)
    assert np.array_equal(message.min_curvature, solution.min_curvature, equal_nan=True)
    assert math.isnan(message.closed_loop_radius)
    assert message.active_constraint == ""
    assert np.array_equal(message.predicted_torques, solution.torques.ravel())
    assert message.wall_solve_time == WALL[0]


@pytest.mark.parametrize("escaping", [False, True])
def test_a_standstill(solved: Command, escaping: bool) -> None:
    solution = solution_of(solved)
    report = SolveReport(solution, Standstill(1.5, escaping, "star"))
    message = decoded(solved._replace(report=report))
    assert message.status == (SolverStatus.ESCAPING if escaping else SolverStatus.STALLED)
    assert message.closed_loop_radius == 1.5
    assert message.active_constraint == "star"
    assert solution is not None
    assert message.formulation == solution.formulation


def test_no_solve() -> None:
    message = decoded(Command(np.zeros(3), Source.ZERO, None))
    assert message.status == SolverStatus.NO_SOLVE
    assert (message.formulation, message.active_constraint) == ("", "")
    assert all(math.isnan(x) for x in (message.residual, message.min_curvature, message.cost))
    assert len(message.predicted_torques) == 3 * HORIZON
