"""Many states at once: the numbers of single solves, and one bad row named."""

from __future__ import annotations

import math

import numpy as np
import pytest
from ocp_cases import random_rotation

from spacecraft_gnc import lie
from spacecraft_gnc.errors import ParameterError, ShapeError
from spacecraft_gnc.ocp import (
    AttitudeOcp,
    PointingZone,
    ShootingOptions,
    ShootingSolver,
    Status,
    Weights,
)

INERTIA = np.diag([1.0, 0.8, 0.9])
ZONES = (
    PointingZone("exclusion", [1, 0, 0], [0.0, 0.0, 1.0], 0.4, 10.0),
    PointingZone("inclusion", [0, 0, 1], [0.0, 1.0, 1.0], 1.0, 5.0),
)


def states(n, seed=1):
    rng = np.random.default_rng(seed)
    return np.array([random_rotation(rng) for _ in range(n)]), rng.normal(size=(n, 3)) * 0.1


@pytest.mark.parametrize("formulation", ["backward_sweep", "single_shooting"])
@pytest.mark.parametrize("step_rule", ["backtracking", "full", "damped", "chord"])
def test_every_row_is_a_single_solve_bit_for_bit(formulation, step_rule):
    ocp = AttitudeOcp(INERTIA, 0.4, 6, Weights(), 0.05, 1e6, ZONES)
    options = ShootingOptions(formulation=formulation, step_rule=step_rule)
    solver, reference = ShootingSolver(ocp, options=options), lie.exp(np.array([0.2, 0.1, -0.3]))
    attitudes, momenta = states(40)
    momenta[7] = [0.0, 3.0, 0.0]  # no step exists: its row fails, and no other
    batch = solver.solve_batch(attitudes, momenta, reference)
    assert batch.status[7] == Status.UNSOLVABLE_STEP
    assert np.count_nonzero(batch.converged) > 30
    for i in range(40):
        # A chord carries over what it factorized: each row is that of a new solver.
        alone = ShootingSolver(ocp, options=options) if step_rule == "chord" else solver
        single = alone.solve(attitudes[i], momenta[i], reference)
        assert (batch.status[i], batch.iterations[i]) == (single.status, single.iterations)
        assert bool(batch.converged[i]) == single.converged
        if not single.converged:
            continue
        for name in (
            "torques", "attitudes", "momenta", "costates", "residual", "cost", "min_curvature",
            "zone_margins",
        ):  # fmt: skip
            assert np.array_equal(getattr(batch, name)[i], getattr(single, name)), name


def test_controls_other_than_three_and_no_zones():
    B = np.array([[1.0, -1.0, 0.0, 0.2], [0.0, 1.0, -1.0, 0.1], [0.3, 0.2, 0.1, 1.0]])
    ocp = AttitudeOcp(INERTIA, 0.4, 4, max_torque=0.01, actuators=B)
    solver = ShootingSolver(ocp)
    attitudes, momenta = states(5)
    batch = solver.solve_batch(attitudes, momenta)
    assert batch.zone_margins.shape == (5, 0)
    assert batch.torques.shape == (5, 4, 3)
    for i in range(5):
        single = solver.solve(attitudes[i], momenta[i])
        assert np.array_equal(batch.torques[i], single.torques)


def test_the_rows_of_a_batch_belong_to_it_alone():
    solver = ShootingSolver(AttitudeOcp(INERTIA, 0.4, 4))
    attitudes, momenta = states(5)
    first = solver.solve_batch(attitudes, momenta)
    kept = first.torques.copy()
    solver.solve_batch(*states(5, seed=2))
    solver.solve(np.eye(3), np.zeros(3))
    assert np.array_equal(first.torques, kept)
    assert np.array_equal(attitudes, states(5)[0])  # what was given is not written to


@pytest.mark.parametrize(
    ("attitudes", "momenta"),
    [
        (np.eye(3), np.zeros(3)),
        (np.zeros((0, 3, 3)), np.zeros((0, 3))),
        (np.zeros((4, 3, 3)), np.zeros((3, 3))),
        (np.zeros((4, 9)), np.zeros((4, 3))),
        (np.zeros((4, 3, 3)), np.zeros((4, 4))),
    ],
)
def test_bad_shapes_are_refused(attitudes, momenta):
    with pytest.raises(ShapeError, match=r"(attitudes|momenta): .*required \(|attitudes, momenta"):
        ShootingSolver(AttitudeOcp(INERTIA, 0.4, 4)).solve_batch(attitudes, momenta)


@pytest.mark.parametrize(
    ("row", "attitude", "momentum", "words"),
    [
        (3, 1.1 * np.eye(3), np.zeros(3), r"attitudes\[3\]"),
        (0, np.diag([1.0, 1.0, -1.0]), np.zeros(3), r"attitudes\[0\]"),
        (4, np.full((3, 3), math.nan), np.zeros(3), r"attitudes\[4\]"),
        (2, np.eye(3), np.array([0.0, math.inf, 0.0]), r"momenta\[2\]"),
    ],
)
def test_a_row_that_is_no_state_is_named(row, attitude, momentum, words):
    attitudes, momenta = states(5)
    attitudes[row], momenta[row] = attitude, momentum
    with pytest.raises(ParameterError, match=words):
        ShootingSolver(AttitudeOcp(INERTIA, 0.4, 4)).solve_batch(attitudes, momenta)


def test_a_reference_that_is_none_is_refused():
    with pytest.raises(ParameterError, match="reference"):
        ShootingSolver(AttitudeOcp(INERTIA, 0.4, 4)).solve_batch(*states(2), 2.0 * np.eye(3))
