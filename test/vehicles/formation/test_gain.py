"""Feedback gain of a craft: the report's, by another solver, and the flight without a governor."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are

from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.vehicles.formation import hill
from spacecraft_gnc.vehicles.formation.geometry import separations
from spacecraft_gnc.vehicles.formation.lqr import formation_gain
from spacecraft_gnc.vehicles.formation.orbit import mean_motion, orbital_period

N = mean_motion(350e3)
A = hill.transition(N, orbital_period(350e3) / 50)
B = hill.impulse_input(A)


def test_the_gain_is_that_of_the_report_s_weights_in_kilometers():
    to_km = 1e-3 * np.eye(6)
    A_km = to_km @ A @ np.linalg.inv(to_km)
    B_km = to_km @ B / 1e-3
    Q, R = np.diag([1.0, 1.0, 1.0, 1e-3, 1e-3, 1e-3]), 1e8 * np.eye(3)
    P = solve_discrete_are(A_km, B_km, Q, R)
    K = -np.linalg.solve(R + B_km.T @ P @ B_km, B_km.T @ P @ A_km)
    gain = formation_gain(A)
    assert gain == pytest.approx(K, rel=1e-9, abs=1e-9 * np.abs(K).max())
    assert np.abs(np.linalg.eigvals(A + B @ gain)).max() < 1.0
    assert np.abs(np.linalg.eigvals(A - B @ gain)).max() > 1.0  # the sign matters


def test_no_other_impulse_of_a_step_is_cheaper():
    """The cost over all steps, the first impulse changed: least at the law's."""
    weights = {"position": 2e-6, "velocity": 5.0, "delta_v": 30.0}
    K = formation_gain(A, **weights)
    Q = np.diag(np.repeat([2e-6, 5.0], 3))

    def cost(first):
        state, u, total = np.array([300.0, -500.0, 200.0, 0.1, -0.2, 0.3]), first, 0.0
        for _ in range(400):
            total += state @ Q @ state + 30.0 * u @ u
            state = A @ state + B @ u
            u = K @ state
        return total

    law = K @ np.array([300.0, -500.0, 200.0, 0.1, -0.2, 0.3])
    for axis in np.eye(3):
        changes = [cost(law + d * axis) - cost(law) for d in (-1e-3, 1e-3)]
        assert min(changes) > 0.0
        assert changes[0] == pytest.approx(changes[1], rel=1e-4)


def test_without_a_governor_the_start_of_the_notes_breaks_the_limits_by_the_known_figures():
    natural = hill.natural_states(N, 1000.0, 50)
    states = hill.start_states(
        N, 1000.0, 50, [45, 21, 10], [6103.0, 8325.0, 5036.0], [1.53, 1.705, 0.877]
    )
    K, largest, least = formation_gain(A), 0.0, np.inf
    for k in range(150):
        delta_v = (states - natural[(k + np.array([16, 0, 33])) % 50]) @ K.T
        largest = max(largest, np.linalg.norm(delta_v, axis=1).max())
        least = min(least, separations(states[:, :3]).min())
        states = states @ A.T + delta_v @ B.T
    assert largest == pytest.approx(1.219, abs=5e-4)
    assert least == pytest.approx(579.0, abs=0.5)
    assert np.abs(states - natural[(150 + np.array([16, 0, 33])) % 50]).max() < 10.0


@pytest.mark.parametrize("weights", [{"position": 0.0}, {"delta_v": 0.0}, {"velocity": -1.0}])
def test_impossible_weights_are_refused(weights):
    [name] = weights
    with pytest.raises(ParameterError, match=f"{name}: received"):
        formation_gain(A, **weights)
