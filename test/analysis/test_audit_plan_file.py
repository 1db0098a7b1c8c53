"""An audit of a flight that began with the plan of a file, which is not there any more."""

from __future__ import annotations

import numpy as np
from flown_bags import fly
from planned_bags import governed, lines

from spacecraft_gnc.analysis.audit import audit_bag
from spacecraft_gnc.ocp.transfer import TransferSolver
from spacecraft_gnc.ocp.transfer.starts import make_start
from spacecraft_gnc.scenario import from_sections
from spacecraft_gnc.vehicles.rigid_body.planner.file import save_plan
from spacecraft_gnc.vehicles.rigid_body.planner.transfer import first_plan, transfer_of


def test_governor_that_flew_the_plan_of_a_file_passes(tmp_path):
    scenario = from_sections(governed())
    problem = transfer_of(scenario)
    start = make_start(problem, "off axis 2-")
    plan = TransferSolver().solve(problem, (start.torque, start.momentum))
    assert plan.converged
    assert not np.array_equal(plan.torque, first_plan(scenario).torque)  # found anew: other bits
    file = save_plan(tmp_path / "plan.npz", plan)
    bag = fly(tmp_path, governed({"file": str(file)}))
    file.unlink()
    audit = audit_bag(bag)
    assert audit.passed, audit.first
    assert lines(audit)["decision of the governor"].verdict == "pass"
