"""The terminal controller, its Riccati equation, and the level of the terminal set."""

from __future__ import annotations

import math

import numpy as np
import pytest
from terminal_cases import INERTIA, RATE, flip, paper, random_case

from spacecraft_gnc import lie
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.ocp import TerminalSetOcp, _level_kernels
from spacecraft_gnc.ocp.terminal_level import ball, decrease_level, nearest_violation


def linear_model(ocp):
    h, inverse = ocp.time_step, np.linalg.inv(ocp.inertia)
    A = np.block([[np.eye(3), h * inverse], [np.zeros((3, 3)), np.eye(3)]])
    return A, np.vstack([np.zeros((3, 3)), h * np.eye(3)])


def test_the_terminal_cost_is_the_linear_loops_cost_to_go():
    """P = sum of the stage costs of x+ = (A + B K) x, the stage costs taken from the exact ones."""
    for seed in range(5):
        ocp, *_ = random_case(np.random.default_rng(seed))
        A, B = linear_model(ocp)
        P, K = ocp.terminal
        closed = A + B @ K
        assert np.abs(np.linalg.eigvals(closed)).max() < 1.0
        inverse = np.linalg.inv(ocp.inertia)

        def quadratic(x, u, ocp=ocp, inverse=inverse):
            """Twice L at a small deviation: second differences of the printed traces."""
            e = 1e-4
            attitude, rate = lie.exp(e * x[:3]), lie.exp(e * ocp.time_step * inverse @ x[3:])
            cost = np.trace(ocp.weights.stage_attitude @ (np.eye(3) - attitude))
            cost += np.trace(ocp.stage_rate @ (np.eye(3) - rate)) / ocp.time_step**2
            return 2.0 * cost / e**2 + u @ ocp.weights.stage_torque @ u

        x = np.random.default_rng(seed).normal(size=6)
        later = closed @ x
        assert x @ P @ x - later @ P @ later == pytest.approx(quadratic(x, K @ x), rel=1e-6)


@pytest.mark.parametrize("unit", [(1e-7, 1.0, 1.0), (1e7, 1.0, 1.0), (1.0, 1e4, 1e-9)], ids=str)
@pytest.mark.parametrize("terminal_set", ["true", "without_kappa"])
def test_the_terminal_set_is_the_same_in_other_units(unit, terminal_set):
    mass, time, cost = unit
    plain = paper(terminal_set=terminal_set)
    ocp = TerminalSetOcp(
        mass * INERTIA, 0.1 * time, 5, cost, cost * time**2 * RATE,
        1000.0 * cost * (time**2 / mass) ** 2, 0.1, 0.02 * mass / time**2, terminal_set,
    )  # fmt: skip
    units = np.repeat([1.0, mass / time], 3)
    P = ocp.terminal.riccati * np.outer(units, units) / cost
    assert plain.terminal.riccati == pytest.approx(P, rel=1e-9, abs=1e-9)
    K = ocp.terminal.gain * units / (mass / time**2)
    assert plain.terminal.gain == pytest.approx(K, rel=1e-9, abs=1e-12)
    assert ocp.level.value / cost == pytest.approx(plain.level.value, rel=1e-9)
    assert ocp.level.bound_by == plain.level.bound_by


def test_levels_of_the_paper():
    with_kappa, without = paper().level, paper(terminal_set="without_kappa").level
    assert with_kappa.value == pytest.approx(37.8247, abs=1e-4)
    assert with_kappa.bound_by == "torque limit"
    # PAPER_NOTES has 1941 by sampling alone: an upper bound of the exact one
    assert without.value == pytest.approx(1907.864, abs=1e-3)
    assert without.bound_by == "half a turn"
    assert flip().level.value == pytest.approx(497.0406, abs=1e-3)
    assert paper(terminal_set="false").level is None
    assert with_kappa.violating_share == pytest.approx(1.0 - 0.01 ** (1.0 / with_kappa.samples))


def test_bounds_by_the_torque_limit_and_by_half_a_turn_are_exact():
    rng = np.random.default_rng(3)
    for _ in range(10):
        ocp, *_ = random_case(rng, limits=(0.02, 0.5))
        P, K = ocp.terminal
        root = np.linalg.inv(np.linalg.cholesky(P)).T
        for rows, level, bound in (
            (K, ocp.terminal.torque_level(ocp.max_torque), ocp.max_torque),
            (np.eye(3, 6), ocp.terminal.half_turn_level(), math.pi),
        ):
            worst = math.sqrt(level) * np.linalg.svd(rows @ root)[1][0]  # largest |rows x| there
            assert worst == pytest.approx(bound, rel=1e-10)


def test_the_decrease_holds_in_the_set_by_an_independent_evaluation():
    ocp = paper(terminal_set="without_kappa")
    P, K = ocp.terminal
    root = math.sqrt(ocp.level.value) * np.linalg.inv(np.linalg.cholesky(P)).T
    for x in ball(np.random.default_rng(0).random((200, 7))) @ root.T:
        attitude, torque = lie.exp(x[:3]), K @ x
        later = ocp.body.step(attitude, x[3:], torque)
        y = np.concatenate([lie.log(later[0]), later[1]])
        F = attitude.T @ later[0]
        stage = np.trace(np.eye(3) - attitude) + np.trace(RATE @ (np.eye(3) - F)) / 0.01
        excess = 0.5 * (y @ P @ y - x @ P @ x) + 0.1 * (stage + 500.0 * torque @ torque)
        assert excess <= 0.0
        kernel = _level_kernels.excess(ocp.body.packed, ocp.data, K, tuple(x[:3]), tuple(x[3:]))
        assert kernel * 0.5 * (x @ P @ x) == pytest.approx(excess, rel=1e-9, abs=1e-9)


def test_a_decrease_that_fails_early_limits_the_level():
    """With a cheap torque and little room left by lambda."""
    ocp = TerminalSetOcp(INERTIA, 0.4, 5, 1.0, RATE, 0.01, 0.9, 0.0, "without_kappa")
    assert ocp.level.bound_by == "cost decrease (31)"
    problem = (ocp.body.packed, ocp.data, ocp.terminal)
    assert ocp.level.value < 0.5 * ocp.terminal.half_turn_level()
    assert nearest_violation(*problem) == pytest.approx(ocp.level.value, rel=1e-5)
    assert decrease_level(*problem, bound=0.5 * ocp.level.value).bound_by == "torque limit"


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"stage_cost_scale": 1.0}, "stage_cost_scale: received 1.0"),
        ({"terminal_set": "maybe"}, "terminal_set: received 'maybe'"),
        ({"stage_attitude": 0.0}, "weights.stage_attitude: received a singular matrix"),
        ({"stage_rate": -1.0}, "weights.stage_rate: received"),
        ({"stage_torque": 0.0}, "weights.stage_torque: received"),
        ({"max_torque": -1.0}, "max_torque: received"),
    ],
)
def test_wrong_values_are_refused(changes, message):
    with pytest.raises(ParameterError, match=message):
        TerminalSetOcp(INERTIA, 0.1, 5, **changes)
