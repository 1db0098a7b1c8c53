"""Hundreds of random problems from a cold start, and forty against CasADi with IPOPT."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from ocp_cases import random_problem

from spacecraft_gnc.ocp import (
    AttitudeOcp,
    PointingZone,
    ShootingOptions,
    ShootingSolver,
    StateContinuation,
    Status,
    Weights,
)

REFERENCE = Path(__file__).parents[1] / "data" / "random_ipopt.npz"
PATIENT = ShootingOptions(max_iterations=200)


def largest_gradient(solution, attitude, momentum):
    """Largest component of the cost's gradient in units of lambda, over what it may be."""
    ocp = solution.ocp
    gradient = ocp.gradient(solution.torques, attitude, momentum) / (2.0 * ocp.time_step)
    tolerance = PATIENT.residual_tolerance * (1.0 + np.abs(solution.costates).max())
    # `gradient` takes |u|^2 - max_torque^2 by difference: some units in the last place of alpha.
    noise = ocp.torque_penalty * ocp.max_torque**3 * np.finfo(float).eps
    # Ten times: `gradient` starts from the torques, whose last digits grow over fifty steps.
    return np.abs(gradient).max() / (10.0 * tolerance + 40.0 * noise)


def test_random_problems_are_solved_from_nothing():
    rng = np.random.default_rng(0)
    solved, zones, saturated, failures = 0, 0, 0, []
    for i in range(600):
        ocp, attitude, momentum = random_problem(rng)
        solution = ShootingSolver(ocp, options=PATIENT).solve(attitude, momentum)
        if not solution.converged:
            failures.append((i, solution.status.name, ocp, attitude, momentum))
            continue
        solved += 1
        zones += len(ocp.zones) > 0 and solution.zone_margins.min() < 0.0
        saturated += abs(solution.torque_margin) < 1e-3 * ocp.max_torque
        assert solution.min_curvature > 0.0
        assert largest_gradient(solution, attitude, momentum) < 1.0
        if ocp.horizon <= 12:
            np.linalg.cholesky(ocp.hessian(solution.torques, attitude, momentum))
    assert solved >= 0.995 * 600
    assert zones > 30  # the sample is what it is meant to be
    assert saturated > 150
    for *_, ocp, attitude, momentum in failures:  # and a continuation finds the rest
        assert StateContinuation(ocp, PATIENT).solve(attitude, momentum).converged


def stored_problems():
    """Problem, state, and IPOPT's torques and cost, for each row of the file."""
    with np.load(REFERENCE) as stored:
        data = dict(stored)
    for i in range(len(data["cost"])):
        row = {name: values[i] for name, values in data.items()}
        zones = tuple(
            PointingZone("exclusion", zone[:3], zone[3:6], float(zone[6]), float(zone[7]))
            for zone in row["zones"]
            if np.isfinite(zone).all()
        )
        names = ("stage_attitude", "stage_momentum", "stage_torque")
        weights = Weights(
            *(row[name] for name in names), row["terminal_attitude"], row["terminal_momentum"]
        )
        horizon = int(row["horizon"])
        ocp = AttitudeOcp(
            row["inertia"], float(row["time_step"]), horizon, weights,
            float(row["max_torque"]), float(row["torque_penalty"]), zones,
        )  # fmt: skip
        state = (row["attitude"], row["momentum"], row["reference"])
        yield ocp, state, row["torque"][:horizon], float(row["cost"])


def test_the_optima_are_those_of_casadi_and_ipopt():
    same, constrained = 0, 0
    for ocp, state, torque, cost in stored_problems():
        assert ocp.cost(torque, *state) == pytest.approx(cost, rel=1e-9)  # the same problem
        solution = ShootingSolver(ocp, options=PATIENT).solve(*state)
        assert solution.status is Status.CONVERGED
        if solution.cost != pytest.approx(cost, rel=1e-9):
            continue  # another local minimum
        same += 1
        constrained += min([solution.torque_margin, *solution.zone_margins]) < 0.0  # a penalty acts
        # IPOPT ends at a gradient of 1e-12 and a smallest curvature of about 1e-2.
        assert np.abs(solution.torques - torque).max() < 1e-8
    assert same >= 35
    assert constrained >= 10
