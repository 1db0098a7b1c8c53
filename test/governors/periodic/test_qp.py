"""The quadratic program: optimality conditions, SciPy, infeasibility."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize

from spacecraft_gnc.errors import ParameterError, ShapeError
from spacecraft_gnc.governors.periodic import qp

EXACT = 1e-7  # of residuals: the solver's tolerance of 1e-9 times numbers up to a hundred


def program(seed, q, r):
    """Return weight matrix, wish, rows and bounds, feasible at a random point."""
    generator = np.random.default_rng(seed)
    root = generator.normal(size=(q, q))
    rows = generator.normal(size=(r, q))
    bounds = rows @ generator.normal(size=q) + generator.uniform(0.0, 1.0, size=r)
    return root @ root.T + 0.1 * np.eye(q), 3.0 * generator.normal(size=q), rows, bounds


@given(st.integers(0, 10**6), st.integers(1, 6), st.integers(1, 80))
def test_the_answer_satisfies_the_optimality_conditions(seed, q, r):
    matrix, wish, rows, bounds = program(seed, q, r)
    found = qp.nearest_reference(qp.Weight(matrix), wish, rows, bounds)
    assert found.status == qp.OPTIMAL
    v, lam = found.reference, found.multipliers
    slack = bounds - rows @ v
    size = 1.0 + np.abs(lam).max()
    assert np.abs(matrix @ (v - wish) + rows.T @ lam).max() < EXACT * size
    assert slack.min() > -EXACT
    assert lam.min() >= 0.0
    assert np.abs(lam * slack).max() < EXACT * size


@pytest.mark.parametrize("seed", range(5))
def test_scipy_finds_the_same_reference(seed):
    matrix, wish, rows, bounds = program(seed, 4, 12)
    found = qp.nearest_reference(qp.Weight(matrix), wish, rows, bounds)
    other = minimize(
        lambda v: 0.5 * (v - wish) @ matrix @ (v - wish),
        wish,
        jac=lambda v: matrix @ (v - wish),
        constraints={"type": "ineq", "fun": lambda v: bounds - rows @ v, "jac": lambda _: -rows},
        method="SLSQP",
        options={"ftol": 1e-12, "maxiter": 500},
    )
    assert other.success
    assert np.abs(other.x - found.reference).max() < 1e-5


@pytest.mark.parametrize("seed", range(5))
def test_no_set_of_active_rows_gives_a_nearer_reference(seed):
    matrix, wish, rows, bounds = program(seed, 3, 10)
    found = qp.nearest_reference(qp.Weight(matrix), wish, rows, bounds)
    nearest, least = wish, np.inf
    for active in itertools.chain(*(itertools.combinations(range(10), i) for i in range(4))):
        h = rows[list(active)]
        conditions = np.block([[matrix, h.T], [h, np.zeros((len(h), len(h)))]])
        v = np.linalg.solve(conditions, np.append(matrix @ wish, bounds[list(active)]))[:3]
        cost = (v - wish) @ matrix @ (v - wish)
        if (rows @ v <= bounds + 1e-9).all() and cost < least:
            nearest, least = v, cost
    assert np.abs(nearest - found.reference).max() < EXACT


def test_an_admissible_wish_is_granted():
    matrix, _, rows, bounds = program(0, 3, 10)
    inside = qp.nearest_reference(qp.Weight(matrix), np.zeros(3), rows, bounds).reference
    found = qp.nearest_reference(qp.Weight(matrix), inside, rows, bounds + 1e-6)
    assert np.array_equal(found.reference, inside)
    assert found.iterations == 0
    assert not found.multipliers.any()


def test_contradicting_rows_are_told():
    rows = np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0]])
    found = qp.nearest_reference(qp.Weight([1, 2]), np.zeros(2), rows, np.array([-1.0, 0.5, 1.0]))
    assert found.status == qp.INFEASIBLE
    assert np.isnan(found.reference).all()


@pytest.mark.parametrize(
    "matrix", [[1.0, 0.0], [1.0, -1.0], [[1.0, 2.0], [0.0, 1.0]], [[1.0, 2.0], [2.0, 1.0]]]
)
def test_a_weight_has_to_be_positive_definite(matrix):
    with pytest.raises(ParameterError, match=r"weight: .* not positive definite"):
        qp.Weight(matrix)


def test_a_weight_has_to_be_of_numbers():
    with pytest.raises(ParameterError, match=r"weight: .* positive definite"):
        qp.Weight(np.ones((2, 3)))
    with pytest.raises(ShapeError, match="weight"):
        qp.Weight(["a"])
