"""Linear periodic model against the nonlinear motion, and what the regulator does with it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from docking_pair import (
    FULL_INERTIA,
    MASS,
    PERIOD,
    STARTS,
    N,
    Q,
    R,
    T,
    fly,
    pair,
    rotation,
)

from spacecraft_gnc.ocp.periodic_lqr import periodic_lqr
from spacecraft_gnc.vehicles.docking.linear import HELD, coordinates, linearize

CASES = (
    {},
    {"tilt": 0.7, "inertia": FULL_INERTIA, "attitude": rotation([0.4, 0.1, -0.6])},
    {"tilt": math.pi / 2.0, "inertia": FULL_INERTIA, "gravity_gradient": True},
)


def flow(motion, step, x, wrench):
    """Coordinates after one step of the nonlinear motion."""
    state = (x[:3], x[3:6], rotation(x[6:9]), x[9:])
    return coordinates(*motion.advance(T * step, *state, wrench[:3], wrench[3:])[:4])


def slopes(function, size, h):
    """Central differences of fourth order, one column for each of ``size`` arguments."""
    columns = []
    for e in h * np.eye(size):
        near, far = function(e) - function(-e), function(2.0 * e) - function(-2.0 * e)
        columns.append((8.0 * near - far) / (12.0 * h))
    return np.array(columns).T


@pytest.mark.parametrize("options", CASES)
def test_matrices_are_the_derivatives_of_the_nonlinear_motion(options):
    motion = pair(**options)
    model = linearize(motion, PERIOD)
    for k in (0, 37, 150):
        wrench, rest = model.feedforward[k], np.zeros(12)
        by_x = slopes(lambda e: flow(motion, k, rest + e, wrench), 12, 1e-3)  # noqa: B023
        by_u = slopes(lambda e: flow(motion, k, rest, wrench + e), 6, 1e-3)  # noqa: B023
        # Under a wrench held over the step the flow leaves the docked state by 1e-6, where the
        # holding wrench changes within the step; the model does not.
        tolerance = 1e-9 if not options else 2e-6
        assert np.abs(by_x - model.transition[k]).max() < tolerance
        assert np.abs(by_u - model.control[k]).max() < tolerance
        assert np.abs(flow(motion, k, rest, wrench) - model.residual[k]).max() < 1e-10


@pytest.mark.parametrize("options", CASES)
def test_feedforward_holds_the_docked_port(options):
    motion = pair(**options)
    model = linearize(motion, PERIOD)
    assert np.abs(model.residual).max() < 1e-6
    state = (np.zeros(3), np.zeros(3), np.eye(3), np.zeros(3))
    gains = periodic_lqr(model.transition, model.control, Q, R).gains
    farthest = 0.0
    for k in range(2 * PERIOD):
        wrench = model.wrench(k, coordinates(*state), np.zeros(6), gains)
        state = motion.advance(T * k, *state, wrench[:3], wrench[3:])[:4]
        farthest = max(farthest, float(np.abs(state[0]).max()))
    assert farthest < 1e-5


@pytest.mark.parametrize("options", CASES)
def test_reference_feedforward_is_the_derivative_of_the_holding_wrench(options):
    """Along a port held at (rho, delta), inverse dynamics by the motion itself over a moment."""
    step, h, v = 37, 1e-3, np.array([0.02, -0.01, 0.015, 0.01, -0.02, 0.005])
    model = linearize(pair(**options), PERIOD)
    motion = pair(**options, period=h, substeps=1)

    def needed(t, v):
        x = HELD @ v
        state = (x[:3], x[3:6], rotation(x[6:9]), x[9:])
        drift = motion.advance(t, *state, np.zeros(3), np.zeros(3))
        w_dot = (drift.angular_velocity - x[9:]) / h
        moment = -state[2] @ motion.inertia @ state[2].T @ w_dot
        turned = motion.advance(t, *state, np.zeros(3), moment)
        return np.concatenate([-MASS * (turned.port_velocity - x[3:6]) / h, moment])

    times = T * (step + np.array([0.5 - math.sqrt(0.15), 0.5, 0.5 + math.sqrt(0.15)]))
    mean = [np.dot([5.0, 8.0, 5.0], [needed(t, s * v) for t in times]) / 18.0 for s in (-1, 0, 1)]
    assert np.abs(mean[1] - model.feedforward[step]).max() < 1e-7
    found = model.reference_feedforward[step] @ v
    assert np.abs(0.5 * (mean[2] - mean[0]) - found).max() < 1e-7


def test_a_held_reference_is_reached():
    motion = pair(tilt=0.7)
    model = linearize(motion, PERIOD)
    gains = periodic_lqr(model.transition, model.control, Q, R).gains
    reference = np.array([5.0, 1.0, -0.5, 0.0, 0.0, 0.0])
    x = fly(motion, model, gains, ([6.0, 1.0, 0.0], [0.1, 0.0, 0.1]), 200, reference)[0]
    assert np.abs(x[-1] - HELD @ reference).max() < 1e-3  # nonlinear in the offset


def test_the_model_repeats_with_the_rotation_of_the_chief():
    motion = pair(tilt=0.7)
    once, twice = linearize(motion, PERIOD), linearize(motion, 2 * PERIOD)
    for name in once.__slots__:
        one, two = getattr(once, name), getattr(twice, name)
        assert np.abs(two - np.concatenate([one, one])).max() < 1e-11, name
        assert not two.flags.writeable


def test_a_chief_at_rest_needs_one_step_of_period():
    model = linearize(pair(spin=0.0), 7)
    assert np.ptp(model.transition, axis=0).max() < 1e-15
    # At (0.82, 0, 0.1) m: 3 n^2 x outward pulls away, n^2 z pulls back.
    expected = MASS * N**2 * np.array([-3.0 * 0.82, 0.0, 0.1])
    assert np.allclose(model.feedforward[0, :3], expected, rtol=1e-12, atol=1e-15)


def test_averaged_model_is_the_mean_of_the_period():
    model = linearize(pair(tilt=0.7), PERIOD)
    mean = model.averaged()
    assert mean.period == 1
    assert np.allclose(mean.transition[0], model.transition.mean(axis=0), atol=1e-15)
    x, wrench = np.linspace(0.1, 1.2, 12), np.linspace(0.1, 0.6, 6)
    assert np.array_equal(mean.predict(3, x, wrench), mean.predict(11, x, wrench))


# --- the figures of docs/docking.md ---------------------------------------------------------


@pytest.mark.parametrize(
    ("start", "force", "sight", "clear"),
    [(0, 1.703, -0.858, -0.390), (1, 1.020, -0.350, -0.015), (2, 2.484, -1.325, -0.657)],
)
def test_ungoverned_flights_of_the_report(start, force, sight, clear):
    """1.70 N and a line-of-sight violation from the first start; the third breaks all three."""
    motion = pair()
    model = linearize(motion, PERIOD)
    gains = periodic_lqr(model.transition, model.control, Q, R).gains
    x, wrench, *margins = fly(motion, model, gains, STARTS[start], 120)
    found = np.abs(wrench[:, :3]).max(), margins[0].min(), margins[1].min()
    assert np.allclose(found, (force, sight, clear), rtol=0.0, atol=6e-4)
    assert np.linalg.norm(x[-1, :3]) < 2e-3


def test_prediction_follows_the_nonlinear_flight():
    motion = pair()
    model = linearize(motion, PERIOD)
    gains = periodic_lqr(model.transition, model.control, Q, R).gains
    x, wrench, *_ = fly(motion, model, gains, STARTS[0], 60)
    once = [model.predict(k, x[k], wrench[k]) - x[k + 1] for k in range(60)]
    assert np.abs(once)[:, :3].max() < 1e-3  # [m]
    ahead = x[0]
    for k in range(60):
        ahead = model.predict(k, ahead, model.wrench(k, ahead, np.zeros(6), gains))
        assert np.abs(ahead - x[k + 1])[:3].max() < 0.01


@pytest.mark.parametrize("tilt_deg", [30.0, 60.0, 90.0])
def test_the_periodic_law_holds_closer_than_the_averaged_one(tilt_deg):
    motion = pair(tilt=math.radians(tilt_deg))
    model = linearize(motion, PERIOD)
    offsets = []
    for law in (model, model.averaged()):
        gains = periodic_lqr(law.transition, law.control, Q, R).gains
        x = fly(motion, law, gains, ([1.0, 0.0, 0.0], [0.0, 0.0, 0.0]), 80 + PERIOD)[0]
        offsets.append(np.linalg.norm(x[-PERIOD:, :3], axis=1).max())
    assert offsets[0] < 1e-3
    assert offsets[1] > 2e-3
