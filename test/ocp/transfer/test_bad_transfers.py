"""Refused transfers: one line that names the argument, the value and the remedy."""

from __future__ import annotations

import numpy as np
import pytest
from transfer_cases import figure_4

from spacecraft_gnc.errors import GncError
from spacecraft_gnc.ocp.transfer import TransferSolver


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"n_steps": 0}, "n_steps: received 0"),
        ({"torque": 0.0}, "torque: received bounds"),
        ({"momentum": (0.0, 70.0)}, "momentum: received bounds"),
        ({"torque": [1.0, 2.0]}, "torque: received bounds"),
        ({"start_momentum": [80.0, 0.0, 0.0]}, r"start_momentum: received \[80.0, 0.0, 0.0\]"),
        ({"goal_momentum": [0.0, -71.0, 0.0]}, "goal_momentum: received"),
        ({"goal": 2.0 * np.eye(3)}, "goal: received"),
        ({"body": None}, "body: received None"),
    ],
)
def test_refused(changes, message):
    with pytest.raises(GncError, match=message) as caught:
        figure_4(**changes)
    assert "\n" not in str(caught.value)


def test_refused_solver():
    with pytest.raises(GncError, match="starts: received 9"):
        TransferSolver(starts=9)
    with pytest.raises(GncError, match="problem: received 'x'"):
        TransferSolver().solve("x")
    with pytest.raises(GncError, match="torque: received an array of shape"):
        TransferSolver().solve(figure_4(), (np.zeros((3, 3)), np.zeros((191, 3))))
