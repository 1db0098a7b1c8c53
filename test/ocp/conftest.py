"""Problems shared by the tests of the solvers."""

from __future__ import annotations

import numpy as np
import pytest

from spacecraft_gnc import lie
from spacecraft_gnc.ocp import AttitudeOcp, Weights

CASE_1_INERTIA = np.diag([1.0, 0.8, 0.8])


@pytest.fixture(scope="session")
def case_1():
    """Gupta's Case I: problem, initial attitude, initial momentum."""
    ocp = AttitudeOcp(CASE_1_INERTIA, 0.4, 5, Weights(), max_torque=0.01, torque_penalty=1e10)
    return ocp, lie.exp(np.array([0.25, 0.5, 0.5])), np.zeros(3)
