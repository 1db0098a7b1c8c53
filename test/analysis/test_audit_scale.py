"""What an audit asks of a plan does not depend on the units of its cost."""

from __future__ import annotations

import pytest
from flown_bags import first_of, fly, sections

from spacecraft_gnc.analysis.audit import audit_bag
from spacecraft_gnc.vehicles.rigid_body.audit.corrections import AGES, CORRECTIONS

WEIGHTS = {
    "stage_attitude": 0.01,
    "stage_momentum": 0.01,
    "stage_torque": 1.0,
    "terminal_attitude": 0.01,
    "terminal_momentum": 0.01,
}


def in_units(unit, **controller):
    """Return those sections with every weight and the penalty multiplied: the same optimum."""
    weights = {name: unit * weight for name, weight in WEIGHTS.items()}
    return sections(
        nmpc_controller={"weights": weights, "torque_penalty": unit * 1e10, **controller}
    )


@pytest.mark.parametrize("unit", [1e-12, 1e-11, 1e-6, 1.0, 1e6, 1e12])
def test_plans_without_any_torque_never_pass_for_converged(tmp_path, unit):
    flown = fly(tmp_path, in_units(unit), idle=True)
    audit = audit_bag(flown)
    failed = [check.name for check in audit.checks if check.first]
    assert failed == ["converged (backward_sweep)"]
    assert first_of(audit) == (failed[0], 0, "solver_status.residual")


@pytest.mark.parametrize("unit", [1.0, 1e2, 1e4])
def test_optimal_plans_pass(tmp_path, unit):
    audit = audit_bag(fly(tmp_path, in_units(unit)))
    assert audit.passed, audit.first


def test_a_neighboring_extremal_far_from_the_exact_solve_is_caught(tmp_path):
    """Flown by a tolerance of half the limit, and recorded as by a thousandth of a thousandth."""
    loose, tight = (
        sections(nmpc_controller={"method": "neighboring_extremal", "ne_tolerance": tolerance})
        for tolerance in (0.5, 1e-6)
    )
    flown = fly(tmp_path / "loose", loose)
    assert audit_bag(flown).passed
    audit = audit_bag(fly(tmp_path / "tight", loose, claimed=tight))
    assert first_of(audit)[::2] == (CORRECTIONS, "solver_status.predicted_torques")


@pytest.mark.parametrize(
    ("horizon", "limit"), [(5, 0.01), (20, 0.01), (60, 0.01), (1, 0.0), (20, 0.0)]
)
def test_neighboring_extremals_pass_whatever_their_horizon(tmp_path, horizon, limit):
    """Their first torque is cut by what the penalty lets through, which grows with the horizon.

    Without a limit their tolerance is a share of the last exact plan's torque.
    """
    scenario = sections(
        plant={"duration": 40.0, "initial_rotation_vector": [-0.44, 1.12, -1.02]},
        nmpc_controller={
            "method": "neighboring_extremal",
            "horizon": horizon,
            "max_torque": limit,
            "weights": WEIGHTS,
        },
    )
    audit = audit_bag(fly(tmp_path, scenario))
    assert audit.passed, audit.first
    corrected = {check.name: check.steps for check in audit.checks}[CORRECTIONS]
    assert corrected > 20


def test_corrections_without_an_exact_solve_before_them_are_caught(tmp_path):
    """Flown with an exact solve every fourth step at the latest, told as every second one."""
    flown, told = (
        sections(nmpc_controller={"method": "neighboring_extremal", "ne_max_age": age})
        for age in (3, 1)
    )
    audit = audit_bag(fly(tmp_path, flown, claimed=told))
    assert first_of(audit)[::2] == (AGES, "solver_status.formulation")
    assert audit_bag(fly(tmp_path / "honest", flown)).passed


@pytest.mark.parametrize("weight", [1e6, 1e10])
def test_a_weight_that_no_axis_sees_hides_no_idle_flight(tmp_path, weight):
    scenario = sections(
        plant={"initial_rotation_vector": [1.0, 0.0, 0.0], "initial_momentum": [0.0, 0.0, 0.0]},
        nmpc_controller={
            "weights": {
                f"{which}_attitude": [weight, 0.0, 0.0, 0.0, 0.01, 0.0, 0.0, 0.0, 0.01]
                for which in ("stage", "terminal")
            }
        },
    )
    assert audit_bag(fly(tmp_path / "honest", scenario)).passed
    audit = audit_bag(fly(tmp_path / "idle", scenario, idle=True))
    assert not audit.passed
