"""A command's status, and what of it the record of a flight keeps."""

from __future__ import annotations

import numpy as np
import pytest

from spacecraft_gnc.loop import Command, Reference, Source, State
from spacecraft_gnc.ocp import Status
from spacecraft_gnc.vehicles.rigid_body.controllers.report import (
    SolveReport,
    Standstill,
)
from spacecraft_gnc.vehicles.rigid_body.controllers.solvers import ShootingController

REST = State(0, np.eye(3), np.zeros(3))
TARGET = Reference(np.eye(3), np.zeros(3), np.zeros(3))
STUCK = Standstill(0.9, escaping=False, active_constraint="star")


def test_the_status_is_that_of_the_solve(build):
    command = build().controller.command(REST, TARGET)
    assert command.report.standstill is None
    assert command.status is Status.CONVERGED


@pytest.mark.parametrize(("escaping", "status"), [(False, Status.STALLED), (True, Status.ESCAPING)])
def test_a_standstill_overrides_it(build, escaping, status):
    command = build().controller.command(REST, TARGET)
    report = command.report._replace(standstill=STUCK._replace(escaping=escaping))
    assert command._replace(report=report).status is status


def test_without_a_solve_there_is_no_status():
    assert Command(np.zeros(3), Source.ZERO, None).status is None


class Reporting(ShootingController):
    """A controller whose second step is a standstill, and whose third one solves nothing."""

    def command(self, state, reference):
        found = super().command(state, reference)
        stuck = found.report._replace(standstill=STUCK)
        return found._replace(report=[found.report, stuck, SolveReport(None)][state.step])


def test_the_record_keeps_the_status_of_the_command(build):
    loop = build(3)
    loop.controller = Reporting(loop.controller.solver)
    flown = loop.run()
    assert flown.status.tolist() == [Status.CONVERGED, Status.STALLED, -1]
    assert np.isfinite(flown.residual).tolist() == [True, True, False]
