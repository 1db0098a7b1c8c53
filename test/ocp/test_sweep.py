"""The backward sweep against dense linear algebra and complex steps on the plain implementation."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from independent import Problem
from ocp_cases import independent, kernel_arguments, random_problem, random_rotation, random_weight

from spacecraft_gnc.ocp import AttitudeOcp, Weights
from spacecraft_gnc.ocp import _stage_kernels as stage
from spacecraft_gnc.ocp import _sweep_kernels as sweep
from spacecraft_gnc.types import Reference

# Sums of some hundred terms of mixed size, rounded in another order: 1e-16 times their condition.
ROUNDING = 1e-10
CHEAP = 1e-3  # share of the torque's weight with which the Hessian is often indefinite
AT_REST = np.zeros(46)  # the reference of one stage, of which a control reads its torque only
STEP = 1e-30  # complex step: no cancellation, exact to rounding


class Sweep:
    """One evaluated guess of a random problem, not a stationary one, with its derivatives."""

    def __init__(self, seed, torque_weight=1.0, m=3):
        rng = np.random.default_rng(seed)
        ocp, self.attitude, self.momentum = random_problem(rng, 8, (1.0, 4.0))
        w = ocp.weights
        weight = np.asarray(w.stage_torque) if m == 3 else 0.3
        actuators = None if m == 3 else 0.4 * rng.normal(size=(3, m))
        cheap = replace(w, stage_torque=torque_weight * weight)
        self.ocp = ocp = replace(ocp, weights=cheap, actuators=actuators)
        self.reference = random_rotation(rng)
        if seed % 2:
            motion = 0.3 * rng.normal(size=3), 0.1 * rng.normal(size=3)
            self.reference = Reference(self.reference, *motion)
        n = ocp.horizon
        self.guess = rng.normal(size=(n, 3)) * 0.2 * torque_weight
        self.constants, self.horizon = kernel_arguments(
            self.ocp, self.attitude, self.momentum, self.reference
        )
        self.resid, self.fac = np.empty((n, 3)), np.zeros((n, sweep.FACTOR_SIZE))
        self.status, self.norm, _ = sweep.evaluate(
            *self.constants, self.guess, *self.horizon[:4], self.resid, self.horizon[4]
        )

    @property
    def cost(self):
        _, data, zones, track = self.constants
        return stage.horizon_cost(data, zones, track, *self.horizon[:2], self.horizon[4])

    @property
    def state(self):
        return self.attitude, self.momentum, self.reference

    @property
    def torques(self):
        return self.horizon[2]

    @property
    def controls(self):
        return self.horizon[4][:, stage.Z_AT :] @ self.ocp.control_axes.T

    def factorize(self, rho=0.0):
        R, Pi, _, lam, W = self.horizon
        return sweep.factorize(*self.constants, R, Pi, lam, W, self.fac, rho, False)

    def torque_change(self, rho=0.0):
        """Newton's change of the torques, U times the step of the guess, and the slope."""
        self.factorize()
        maps = self.fac[:, sweep.U_AT : sweep.U_AT + 9].reshape(-1, 3, 3).copy()
        self.factorize(rho)
        step, zero = np.empty_like(self.guess), (0.0, 0.0, 0.0)
        slope = sweep.substitute(self.ocp.time_step, self.fac, self.resid, zero, zero, rho, step)
        return np.einsum("kij,kj->ki", maps, step), slope


@pytest.mark.parametrize("seed", range(25))
def test_the_residual_is_the_gradient_of_the_printed_cost(seed):
    at = Sweep(seed)
    assert at.status == 0
    plain = independent(at.ocp, at.reference)
    assert at.cost == pytest.approx(plain.cost(*at.state[:2], at.torques), rel=1e-10)
    expected = np.empty_like(at.torques)
    for k, i in np.ndindex(*expected.shape):
        moved = at.torques.astype(complex)
        moved[k, i] += 1j * STEP
        expected[k, i] = plain.cost(*at.state[:2], moved).imag / STEP
    gradient = -2.0 * at.ocp.time_step * at.resid
    assert np.abs(gradient - expected).max() < ROUNDING * max(1.0, np.abs(expected).max())
    assert at.norm == pytest.approx(np.linalg.norm(at.resid), rel=1e-14)


@pytest.mark.parametrize("rho", [0.0, 0.3, 1e3])
@pytest.mark.parametrize("seed", range(30))
def test_the_sweep_solves_newtons_dense_system(seed, rho):
    at = Sweep(seed)
    h = at.ocp.time_step
    # rho adds rho I to the inverse of U, of which the Hessian to the torques holds 2 h times.
    H = at.ocp.hessian(at.torques, *at.state) + 2.0 * h * rho * np.eye(at.guess.size)
    g = at.ocp.gradient(at.torques, *at.state).ravel()
    change, slope = at.torque_change(rho)
    du = change.ravel()
    # The backward error: what elimination without pivoting loses is no matter of H's condition.
    size = np.linalg.norm(H) * np.linalg.norm(du) + np.linalg.norm(g)
    assert np.linalg.norm(H @ du + g) < ROUNDING * size
    assert slope == pytest.approx(g @ du, rel=1e-9, abs=ROUNDING * size)


def test_the_pivot_is_positive_exactly_where_the_hessian_is():
    definite = 0
    for seed in range(200):
        at = Sweep(seed, CHEAP)
        stage_found = at.factorize()
        pivot = sweep.smallest_pivot(at.ocp.time_step, at.fac)
        smallest = np.linalg.eigvalsh(at.ocp.hessian(at.torques, *at.state))[0]
        assert (pivot > 0.0) == (smallest > 0.0)
        assert (stage_found < 0) == (smallest > 0.0)
        if smallest > 0.0:  # a Schur complement of a definite matrix lies above its spectrum
            assert pivot >= smallest * (1.0 - 1e-8)
        definite += smallest > 0.0
    assert 20 <= definite <= 180  # both kinds have been seen


@pytest.mark.parametrize("m", [1, 2, 4, 5])
def test_all_this_holds_for_other_numbers_of_actuators(m):
    """U has rank m < 3, or the controls are more than the torque's components."""
    definite, indefinite = 0, 0
    for seed in range(60):
        at = Sweep(seed, CHEAP, m)
        if at.status != 0:  # the body turns too far in a step
            continue
        B, u = np.asarray(at.ocp.torque_map), at.controls
        assert np.abs(u @ B.T - at.torques).max() < 1e-13 * np.abs(u).max()
        g = at.ocp.gradient(u, *at.state)
        expected = -2.0 * at.ocp.time_step * at.resid @ B
        assert np.abs(g - expected).max() < ROUNDING * max(1.0, np.abs(g).max())
        change, slope = at.torque_change()
        H = at.ocp.hessian(u, *at.state)
        pivot = sweep.smallest_pivot(at.ocp.time_step, at.fac)
        smallest, largest = np.linalg.eigvalsh(H)[[0, -1]]
        assert (pivot > 0.0) == (smallest > 0.0)
        definite += smallest > 0.0
        indefinite += smallest < 0.0
        if smallest > 1e-8 * largest:
            du = -np.linalg.solve(H, g.ravel()).reshape(u.shape)
            # Of the dense solve, and of |u|^2 - max_torque^2, which `hessian` takes by difference.
            noise = 1e-14 * largest / smallest + 2.0 * ROUNDING
            assert np.abs(du @ B.T - change).max() < noise * np.abs(du @ B.T).max()
            assert slope == pytest.approx(g.ravel() @ du.ravel(), rel=1e-6)
    assert min(definite, indefinite) >= 5


def test_the_direction_at_a_saddle_has_negative_curvature():
    seen = 0
    for seed in range(60):
        at = Sweep(seed, CHEAP)
        found = at.factorize()
        if found < 0:
            continue
        seen += 1
        maps = at.fac[:, sweep.U_AT : sweep.U_AT + 9].reshape(-1, 3, 3)
        step = np.empty_like(at.guess)
        size = sweep.descent_at_saddle(at.ocp.time_step, at.fac, found, step)
        du = np.einsum("kij,kj->ki", maps, step)
        H = at.ocp.hessian(at.torques, *at.state)
        assert du.ravel() @ H @ du.ravel() < 0.0
        assert not du[:found].any()  # it starts at that stage
        assert np.linalg.norm(du[found]) == pytest.approx(size)
        assert du[found][np.argmax(np.abs(du[found]))] > 0.0
    assert seen > 10


def one_stage(penalty, limit, seed):
    """Control law of one stage for a full weight: package, plain implementation, lambda2."""
    rng = np.random.default_rng(seed)
    weight = random_weight(rng, -1, 1)
    ocp = AttitudeOcp(
        np.diag([1.0, 0.8, 0.9]), 0.4, 1, Weights(stage_torque=weight), limit, penalty
    )
    eye, zero = np.eye(3), np.zeros((3, 3))
    plain = Problem(
        eye, 0.4, 1, zero, zero, np.asarray(ocp.weights.stage_torque), zero, zero,
        limit**2, penalty, [], eye,
    )  # fmt: skip
    multiplier = rng.normal(size=3) * limit * rng.uniform(0.1, 30.0)
    return ocp, plain, multiplier


def control_of(ocp, multiplier):
    """Torque, its excess sigma, and the matrix U of the kernels."""
    W = np.zeros((1, stage.work_size(3)))
    u, sigma = stage.control(ocp.data, AT_REST, tuple(multiplier), W, 0)
    W[0, stage.SIGMA_AT] = sigma
    U = stage.control_sensitivity(ocp.data, W, 0, False)
    return np.array(u), sigma, np.array(U).reshape(3, 3)


@pytest.mark.parametrize("penalty", [1e2, 1e4, 1e7, 1e10])
@pytest.mark.parametrize("limit", [0.01, 0.3])
def test_control_and_its_sensitivity_equal_the_plain_ones(penalty, limit):
    active = 0
    # The plain root finder takes H0 = |u|^2 - alpha by difference: 2 mu0 H0 is off by that much.
    noise = 1e-11 + 8.0 * penalty * limit**2 * np.finfo(float).eps
    for seed in range(20):
        ocp, plain, multiplier = one_stage(penalty, limit, seed)
        u, sigma, U = control_of(ocp, multiplier)
        active += sigma > 0.0
        assert np.abs(u - plain.control(multiplier)).max() < noise * np.linalg.norm(multiplier)
        columns = [plain.control(multiplier + 1j * STEP * e).imag / STEP for e in np.eye(3)]
        assert np.abs(U - np.array(columns).T).max() < 10.0 * noise * np.abs(U).max()
    assert 0 < active < 20


@pytest.mark.parametrize("penalty", [1e2, 1e10])
def test_33_of_bagherzadeh_holds_as_corrected_not_as_printed(penalty):
    """With 4 mu (u . du) u; the printed +2 mu S(u) S(du) S(u) is -2 mu (u . du) u."""
    seen, misprint = 0, math.inf
    for seed in range(20):
        ocp, plain, multiplier = one_stage(penalty, 0.3, seed)
        u, sigma, U = control_of(ocp, multiplier)
        if sigma == 0.0:
            continue
        seen += 1
        S3 = 0.5 * (np.trace(plain.Q3) * np.eye(3) - plain.Q3)
        rest, bend = S3 + sigma * np.eye(3), penalty * np.outer(u, u)
        size = np.abs(U).max()
        corrected = rest + 4.0 * bend
        noise = 1e-11 + 10.0 * np.finfo(float).eps * np.linalg.cond(corrected)  # of the inverse
        assert np.abs(U - np.linalg.inv(corrected)).max() < noise * size
        printed = np.linalg.inv(rest - 2.0 * bend)
        misprint = min(misprint, np.abs(U - printed).max() / size)
    assert seen > 5
    # At a hard limit either form keeps u on its sphere: the error shows at small penalties only.
    assert misprint > 0.1 if penalty == 1e2 else misprint < 1e-6


def test_the_estimated_sensitivity_leaves_out_the_limit():
    ocp, plain, multiplier = one_stage(1e4, 0.01, 3)
    W = np.zeros((1, stage.work_size(3)))
    _, W[0, stage.SIGMA_AT] = stage.control(ocp.data, AT_REST, tuple(100.0 * multiplier), W, 0)
    assert W[0, stage.SIGMA_AT] > 0.0
    U = np.array(stage.control_sensitivity(ocp.data, W, 0, True)).reshape(3, 3)
    S3 = 0.5 * (np.trace(plain.Q3) * np.eye(3) - plain.Q3)
    assert np.abs(U - np.linalg.inv(S3)).max() < 1e-12 * np.abs(U).max()
