"""The largest time step: it holds for the whole free motion, and asks for no more than needed."""

from __future__ import annotations

import math
import os

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from strategies import inertias, rotations, unit_vectors

from spacecraft_gnc import lie
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.dynamics._lgvi_kernels import propagate
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.solvability import is_surely_free, largest_free_step, largest_step

DRAWS = 30 if os.environ.get("NUMBA_DISABLE_JIT") == "1" else 300  # minutes, interpreted
STEPS = 5000
ZERO = np.zeros(3)


def random_inertia(rng):
    a, b, c = rng.uniform(0.02, 1.0, 3)
    axes, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    inertia = axes @ np.diag([b + c, a + c, a + b]) @ axes.T
    return 0.5 * (inertia + inertia.T)


def survives(inertia, momentum, step):
    """Whether the free body makes all of its steps."""
    attitudes, momenta = np.empty((STEPS + 1, 3, 3)), np.empty((STEPS + 1, 3))
    attitudes[0], momenta[0] = np.eye(3), momentum
    body = RigidBody(inertia, step)
    return propagate(body.packed, step, attitudes, momenta, np.zeros((1, 3)), STEPS) == STEPS


@pytest.mark.parametrize("kind", ["fixed", "random"])
def test_free_bodies_never_fail_within_it_and_fail_right_beyond_it(kind):
    """At 0.9 of the limit of the first direction alone, 120 of 300 bodies failed."""
    rng = np.random.default_rng(0)
    within, beyond, first = 0, 0, 0
    for _ in range(DRAWS):
        inertia = np.diag([1.0, 0.7, 0.5]) if kind == "fixed" else random_inertia(rng)
        momentum = rng.normal(size=3)
        step = RigidBody(inertia, 1.0).largest_time_step(momentum)
        within += survives(inertia, momentum, 0.9999 * step)
        beyond += survives(inertia, momentum, 1.0001 * step)
        first += survives(inertia, momentum, 0.9 * largest_step(inertia, momentum))
    assert within == DRAWS
    assert beyond <= 0.02 * DRAWS
    assert first < 0.9 * DRAWS  # the draws tell the two apart


@settings(max_examples=25)
@given(inertias(), unit_vectors())
def test_it_is_the_smallest_along_the_continuous_motion(inertia, momentum):
    inverse = np.linalg.inv(inertia)
    end = 40.0 * np.linalg.eigvalsh(inertia)[2] / np.ptp(np.linalg.eigvalsh(inertia)).clip(0.05)
    path = solve_ivp(
        lambda _, p: np.cross(p, inverse @ p), (0.0, end), momentum, method="DOP853",
        rtol=1e-12, atol=1e-12, t_eval=np.linspace(0.0, end, 1500),
    ).y.T  # fmt: skip
    along = min(largest_step(inertia, p) for p in path)
    free = largest_free_step(inertia, momentum)
    assert free <= along * (1.0 + 1e-9)
    # Samples of the path come close to its extremes, where they are smooth.
    assert free >= along * (1.0 - 0.02)


@given(inertias(), unit_vectors(), st.floats(1e-6, 1e6))
def test_it_lies_between_the_sphere_and_the_first_direction(inertia, direction, size):
    momentum = size * direction
    nonstandard = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    sphere = 2.0 * np.linalg.eigvalsh(nonstandard)[0] / size
    free = largest_free_step(inertia, momentum)
    assert sphere * (1.0 - 1e-9) <= free <= largest_step(inertia, momentum) * (1.0 + 1e-9)


@given(inertias(), unit_vectors(), st.floats(1e-6, 1e6), st.floats(0.5, 1.5))
def test_what_surely_exists_exists(inertia, direction, size, share):
    """A step of that share of the one that the sphere allows; beyond it, nothing is sure."""
    momentum = size * direction
    nonstandard = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    step = share * 2.0 * float(np.linalg.eigvalsh(nonstandard)[0]) / size
    if is_surely_free(inertia, momentum, step):
        assert step <= largest_free_step(inertia, momentum)
        assert RigidBody(inertia, step).is_solvable(momentum)
    else:
        assert share > 1.0 - 1e-6
    assert is_surely_free(inertia, ZERO, step)


@given(rotations(), unit_vectors(), st.sampled_from([0.5, 0.9, 1.5]))
def test_a_body_of_revolution_precesses_through_all_directions_about_its_axis(axes, p, ratio):
    inertia = axes @ np.diag([1.0, 1.0, ratio]) @ axes.T
    inertia = 0.5 * (inertia + inertia.T)
    across = np.hypot(*(axes.T @ p)[:2])
    turned = axes @ np.array([across, 0.0, (axes.T @ p)[2]])
    expected = min(largest_step(inertia, turned), largest_step(inertia, p))
    assert largest_free_step(inertia, p) == pytest.approx(expected, rel=1e-6)


def test_a_sphere_and_a_momentum_of_zero():
    momentum = np.array([0.3, -0.2, 0.6])  # of size 0.7: less than a quarter turn, h |Pi| <= J
    assert largest_free_step(np.eye(3), momentum) == pytest.approx(1.0 / 0.7, rel=1e-14)
    assert RigidBody(np.eye(3), 0.1).largest_time_step(ZERO) == math.inf
    assert largest_step(np.eye(3), ZERO) == math.inf


@pytest.mark.parametrize("momentum", [[0.0, 3.0, 0.0], [1.2, -1.9, 0.4], [1e8, 2e8, -1e8]])
def test_a_momentum_beyond_the_limit_is_refused_with_the_time_step_that_works(momentum):
    inertia, momentum = np.diag([1.0, 0.7, 0.5]), np.array(momentum)
    with pytest.raises(ParameterError, match=r"Kalabic.*time step of at most") as caught:
        RigidBody(inertia, 1.0).step(np.eye(3), momentum, ZERO)
    assert survives(inertia, momentum, float(str(caught.value).split("at most ")[1].split(" s")[0]))


def test_the_condition_is_sufficient_and_not_necessary():
    """A plate turning about an axis in its plane: a step beyond (3) has a plain solution."""
    nonstandard = np.diag([1.0, 0.1, 1.0])
    body = RigidBody(np.trace(nonstandard) * np.eye(3) - nonstandard, 1.0)
    turns = {}
    for degrees in (10.0, 11.0, 34.0, 36.0):
        F = lie.exp(np.array([math.radians(degrees), 0.0, 0.0]))
        skew, symmetric = F @ nonstandard - nonstandard @ F.T, F @ nonstandard + nonstandard @ F.T
        momentum = np.array([skew[2, 1], skew[0, 2], skew[1, 0]])
        plain = float(np.linalg.eigvalsh(symmetric)[0]) > 0.0
        turns[degrees] = body.is_solvable(momentum), plain
    assert turns[10.0] == (True, True)
    assert turns[11.0] == turns[34.0] == (False, True)
    assert turns[36.0] == (False, False)
