"""The pattern of active limits tells active sets apart, whatever the horizon and the zones."""

from __future__ import annotations

import itertools
import math

import numpy as np
from ocp_cases import kernel_arguments

from spacecraft_gnc import lie
from spacecraft_gnc.ocp import AttitudeOcp, PointingZone, Weights
from spacecraft_gnc.ocp import _stage_kernels as stage
from spacecraft_gnc.ocp import _sweep_kernels as sweep

LIMIT = 0.01
REST = np.zeros(3)


def pattern_of(ocp, guess, attitude):
    """Return the pattern at a guess, and the active set of (stage, limit) and (stage, zone)."""
    constants, (R, Pi, u, lam, W) = kernel_arguments(ocp, attitude, REST, np.eye(3))
    resid = np.empty_like(guess)
    status, _, pattern = sweep.evaluate(*constants, guess, R, Pi, u, lam, resid, W)
    assert status == 0
    limit = ocp.max_torque or math.inf
    active = {(k, "torque") for k in range(len(u)) if np.linalg.norm(u[k]) > limit}
    for i, zone in enumerate(ocp.zones):
        value = R[1:-1].transpose(0, 2, 1) @ zone.inertial_axis @ zone.body_axis
        excess = zone.sign * (value - math.cos(zone.half_angle))
        active |= {(k + 1, i) for k in np.flatnonzero(excess > 0.0)}
    return pattern, frozenset(active)


def test_each_of_120_stages_at_its_limit_has_a_pattern_of_its_own():
    """An int64 of one bit a stage forgot all but the last 64."""
    ocp = AttitudeOcp(np.diag([1.0, 0.8, 0.8]), 0.4, 120, max_torque=LIMIT)
    patterns = set()
    for k in range(-1, ocp.horizon):
        guess = np.zeros((ocp.horizon, 3))
        if k >= 0:
            guess[k, 0] = 2.0 * LIMIT
        pattern, active = pattern_of(ocp, guess, np.eye(3))
        assert active == ({(k, "torque")} if k >= 0 else frozenset())
        patterns.add(pattern)
    assert len(patterns) == ocp.horizon + 1


def test_the_pattern_tells_which_zones_act_and_not_how_many():
    zones = tuple(PointingZone("exclusion", axis, axis, 0.3, 1.0) for axis in np.eye(3))
    ocp = AttitudeOcp(np.diag([1.0, 0.8, 0.8]), 0.4, 6, Weights(), LIMIT, 1e4, zones)
    found = {}
    for axis in np.eye(3):  # about each axis a quarter turn leaves one zone violated
        guess = np.zeros((ocp.horizon, 3))
        pattern, active = pattern_of(ocp, guess, lie.exp(0.5 * math.pi * axis))
        assert len({zone for _, zone in active}) == 1
        found[pattern] = active
    assert len(found) == 3


def test_patterns_are_equal_exactly_where_the_active_sets_are():
    rng = np.random.default_rng(3)
    axes = rng.normal(size=(8, 3))
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    zones = tuple(
        PointingZone("exclusion", body, inertial, 1.2, 1.0)
        for body, inertial in itertools.pairwise(axes)
    )
    inertia = np.array([[1.0, 0.1, 0.0], [0.1, 0.8, 0.05], [0.0, 0.05, 0.7]])
    ocp = AttitudeOcp(inertia, 0.4, 100, Weights(), LIMIT, 1e4, zones)
    by_pattern, by_set = {}, {}
    for _ in range(60):
        attitude = lie.exp(0.5 * rng.normal(size=3))
        guess = 0.007 * rng.normal(size=(ocp.horizon, 3))
        for factor in (1.0, 1.0 + 1e-9, 1.001, 1.02):  # neighbors, many with the same active set
            pattern, active = pattern_of(ocp, factor * guess, attitude)
            assert by_pattern.setdefault(pattern, active) == active
            assert by_set.setdefault(active, pattern) == pattern
    assert 60 < len(by_set) < 240


def test_no_two_neighboring_sets_share_a_hash():
    """Sets that differ least, 760,000: one and two of 1,000 stages, 62 of 64, all sets of 18."""
    rows = [[k] for k in range(1, 1001)] + list(itertools.combinations(range(1, 1001), 2))
    pairs_of_64 = itertools.combinations(range(1, 65), 2)
    found = {0}
    for row in rows:
        found.add(chained(row))
    without = {chained([k for k in range(1, 65) if k not in out]) for out in pairs_of_64}
    assert len(found) == 1 + len(rows)
    assert not found & without
    assert len(without) == 64 * 63 // 2
    subsets = [[k for k in range(18) if bits >> k & 1] for bits in range(1, 1 << 18)]
    assert len({chained([k + 1 for k in subset]) for subset in subsets}) == len(subsets)


def test_each_zone_at_each_stage_has_a_pattern_of_its_own():
    """A zone on the stage of its own number once had the pattern of no zone."""
    alone = {(k, i): chained([k, chained([i])]) for k in range(1, 200) for i in range(1, 40)}
    assert len({0, *alone.values()}) == 1 + len(alone)
    two = {chained([k, chained([i]), j, chained([m])]) for k, i, j, m in few() if k != j}
    both = {chained([k, chained([i, m])]) for k, i, _, m in few() if i != m}
    assert len(two) == 12 * 11 * 6 * 6
    assert len(both) == 12 * 6 * 5
    assert len({0, *alone.values()} & (two | both)) == 0
    assert not two & both


def few():
    return itertools.product(range(1, 13), range(1, 7), range(1, 13), range(1, 7))


def test_a_zone_that_acts_on_one_stage_alone_is_seen():
    zones = tuple(PointingZone("exclusion", axis, axis, 0.3, 1.0) for axis in np.eye(3))
    ocp = AttitudeOcp(np.diag([1.0, 0.8, 0.8]), 0.4, 6, Weights(), zones=zones)
    rng = np.random.default_rng(4)
    patterns = {}
    for _ in range(2000):
        guess = 0.3 * rng.normal(size=(ocp.horizon, 3))
        pattern, active = pattern_of(ocp, guess, lie.exp(rng.normal(size=3)))
        assert patterns.setdefault(active, pattern) == pattern
    assert len(set(patterns.values())) == len(patterns)
    alone = {one for active in patterns if len(active) == 1 for one in active}
    assert alone >= {(k, i) for k in (1, 3, 4, 5) for i in range(3)}


def chained(numbers):
    pattern = 0
    for number in numbers:
        pattern = stage.hashed(pattern, number)
    return pattern


def test_the_hash_is_the_same_interpreted():
    plain = getattr(stage.hashed, "py_func", stage.hashed)  # NUMBA_DISABLE_JIT
    compiled, interpreted = 0, 0
    for number in range(1, 2000):
        compiled, interpreted = stage.hashed(compiled, number), plain(interpreted, number)
        assert compiled == interpreted
        assert 0 <= interpreted < 2**63
