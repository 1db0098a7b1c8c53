"""One problem in all units: same iterates, torques and status, and an optimum by another model.

Problems are drawn without units by ``benchmarks/random_problems/draw.py``; their optima in
test/data/random_scales.json.gz are CasADi's. 5,000 of them: ``benchmarks/random_problems/run.py``.
"""

from __future__ import annotations

import gzip
import importlib.util
import json
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from ocp_cases import independent

from spacecraft_gnc import lie
from spacecraft_gnc.ocp import (
    AttitudeOcp,
    PenaltyContinuation,
    ShootingSolver,
    StateContinuation,
    Weights,
)

ROOT = Path(__file__).parents[2]
STORED = ROOT / "test" / "data" / "random_scales.json.gz"
SAME = 1e-8  # of the largest torque: the Newton correction that a CONVERGED solve may have
CASE_1_START = lie.exp(np.array([0.25, 0.5, 0.5]))
# Nearest to one another of 1e-12 in all: the units' own rounding enters the data.
FACTORS = [1e-12, 1e-11, 1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9, 1e12]


@pytest.fixture(scope="module")
def draw():
    name = "random_problems_draw"
    path = ROOT / "benchmarks" / "random_problems" / "draw.py"
    spec = importlib.util.spec_from_file_location(name, path)
    module = sys.modules[name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def stored(draw):
    """Problem, optimal controls without units, cost, for each row of the file."""
    rows = json.loads(gzip.decompress(STORED.read_bytes()))
    return [
        (draw.Drawn.of(row["drawn"]), np.array(row["controls"]), row["cost"], row["moved"])
        for row in rows
    ]


def case_1(mass=1.0, time=1.0, cost=1.0):
    """Case I in other units."""
    torque, momentum = mass / time**2, mass / time
    weights = Weights(
        0.01 * cost / time, 0.01 * cost / time / momentum**2, cost / time / torque**2,
        0.01 * cost, 0.01 * cost / momentum**2,
    )  # fmt: skip
    return AttitudeOcp(
        mass * np.diag([1.0, 0.8, 0.8]), 0.4 * time, 5, weights, 0.01 * torque,
        1e10 * cost / time / torque**4,
    )  # fmt: skip


def assert_case_1_is_the_same(mass, time, cost):
    plain = ShootingSolver(case_1()).solve(CASE_1_START, np.zeros(3))
    found = ShootingSolver(case_1(mass, time, cost)).solve(CASE_1_START, np.zeros(3))
    assert found.status is plain.status
    assert found.iterations == plain.iterations
    difference = np.abs(found.torques * (time**2 / mass) - plain.torques).max()
    assert difference <= 1e-12 * np.abs(plain.torques).max()
    assert found.cost == pytest.approx(cost * plain.cost, rel=1e-12)


@pytest.mark.parametrize("cost", FACTORS)
def test_case_1_with_other_weights(cost):
    assert_case_1_is_the_same(1.0, 1.0, cost)


@pytest.mark.parametrize("mass", [1e-6, 1e-3, 1e3, 1e5, 1e8])
def test_case_1_with_other_masses(mass):
    assert_case_1_is_the_same(mass, 1.0, 1.0)


@pytest.mark.parametrize("time", [1e-6, 1e-3, 60.0, 3600.0, 1e5])
def test_case_1_in_other_units_of_time(time):
    assert_case_1_is_the_same(1.0, time, 1.0)


@given(st.floats(-6.0, 8.0), st.floats(-4.0, 4.0), st.floats(-12.0, 12.0))
def test_case_1_in_any_units(mass, time, cost):
    assert_case_1_is_the_same(10.0**mass, 10.0**time, 10.0**cost)


@given(st.integers(-19, 26), st.integers(-13, 13), st.integers(-40, 40))
def test_case_1_in_units_of_powers_of_two_is_equal_bit_for_bit(mass, time, cost):
    units = 2.0**mass, 2.0**time, 2.0**cost
    plain = ShootingSolver(case_1()).solve(CASE_1_START, np.zeros(3))
    found = ShootingSolver(case_1(*units)).solve(CASE_1_START, np.zeros(3))
    assert (found.torques * (units[1] ** 2 / units[0]) == plain.torques).all()
    assert found.iterations == plain.iterations
    assert found.cost == units[2] * plain.cost


def test_a_problem_in_units_of_powers_of_two_has_the_same_iterates(draw, stored):
    """Whatever it is, and also where it is not solved: no constant has a unit."""
    units = (2.0**11, 2.0**-7, 2.0**30), (2.0**-15, 2.0**9, 2.0**-33)
    unlike = []
    for problem, *_ in stored:
        plain, *others = (
            ShootingSolver(ocp).solve(*state)
            for ocp, state in (draw.in_units(problem, u) for u in ((1.0, 1.0, 1.0), *units))
        )
        for found, (mass, time, cost) in zip(others, units, strict=True):
            same = found.status is plain.status and found.iterations == plain.iterations
            torques = found.torques * (time**2 / mass)
            same = same and np.array_equal(torques, plain.torques, equal_nan=True)
            if not same or not (found.cost == cost * plain.cost or np.isnan(plain.cost)):
                unlike.append((problem.seed, plain.status.name, found.status.name))
    assert unlike == []


def solved(ocp, state):
    """Cold, and by the continuations where that fails."""
    solution = ShootingSolver(ocp).solve(*state)
    for way in (PenaltyContinuation, StateContinuation):
        if not solution.converged:
            solution = way(ocp).solve(*state)
    return solution


def test_the_optima_are_those_of_an_independent_model(draw, stored):
    """At inertias 1e-6 to 1e8 kg m^2, limits 1e-6 to 1e3 N m; another minimum is no worse one."""
    same, missed, wrong = 0, [], []
    for problem, controls, cost, moved in stored:
        mass, time, unit = problem.units
        ocp, state = draw.in_units(problem, problem.units)
        solution = solved(ocp, state)
        if not solution.converged:
            missed.append((problem.seed, solution.status.name))
            continue
        difference = np.abs(solution.controls * (time**2 / mass) - controls).max()
        excess = solution.cost / unit - cost
        size = 1e-9 * moved + 1e-13 * cost  # of the part that the controls move, and rounding
        if difference <= SAME * np.abs(controls).max() and abs(excess) <= size:
            same += 1
        elif not excess < -1e-6 * moved:
            wrong.append((problem.seed, difference, excess))
    assert wrong == []
    assert missed == []
    assert same >= len(stored) - 2


def test_the_gradient_of_another_implementation_is_zero_at_the_torques(draw, stored):
    """By the complex step of the printed cost, without units; its curvature makes it a step."""
    checked = 0
    for problem, *_ in stored:
        ocp, state = draw.in_units(problem, problem.units)
        if problem.horizon > 5 or ocp.actuators is not None:
            continue
        solution = solved(ocp, state)
        plain, (attitude, momentum, reference) = draw.in_units(problem, (1.0, 1.0, 1.0))
        other = independent(plain, reference)
        u = solution.torques * (problem.units[1] ** 2 / problem.units[0])
        gradient = np.empty(u.size)
        for i in range(u.size):
            moved = u.astype(complex)
            moved.ravel()[i] += 1e-30j
            gradient[i] = other.cost(attitude, momentum, moved).imag / 1e-30
        hessian = plain.hessian(u, attitude, momentum, reference)
        np.linalg.cholesky(hessian)
        step = np.linalg.solve(hessian, gradient)
        assert np.abs(step).max() <= SAME * np.abs(u).max(), problem.seed
        checked += 1
    assert checked >= 12


def test_a_heavy_spacecraft_with_small_torque_weights():
    """The cost is that of its own torques, and the limit kept as the penalty has it."""
    ocp = AttitudeOcp(
        1e4 * np.diag([1.0, 0.8, 0.8]), 0.4, 5,
        Weights(0.01, 1e-10, 1e-10 * np.diag([1.0, 4.0, 9.0]), 0.01, 1e-10), 100.0, 1e-6,
    )  # fmt: skip
    solution = ShootingSolver(ocp).solve(CASE_1_START, np.zeros(3))
    other = independent(ocp)
    assert solution.converged
    own = other.cost(CASE_1_START, np.zeros(3), solution.torques)
    assert solution.cost == pytest.approx(own, rel=1e-13)
    light = AttitudeOcp(
        np.diag([1.0, 0.8, 0.8]), 0.4, 5,
        Weights(0.01, 1e-2, 1e-2 * np.diag([1.0, 4.0, 9.0]), 0.01, 1e-2), 0.01, 1e10,
    )  # fmt: skip
    right = ShootingSolver(light).solve(CASE_1_START, np.zeros(3))
    assert np.abs(solution.torques / 1e4 - right.torques).max() < 1e-14
    assert solution.cost == pytest.approx(right.cost, rel=1e-12)
