"""Gupta's Case I as a closed loop, built by hand."""

from __future__ import annotations

import numpy as np
import pytest

from spacecraft_gnc import lie
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.governors import PassThroughGovernor
from spacecraft_gnc.loop import ClosedLoop
from spacecraft_gnc.loop.controllers import ShootingController
from spacecraft_gnc.loop.plants import RigidBodyPlant
from spacecraft_gnc.ocp import AttitudeOcp, ShootingSolver, Weights

INERTIA = np.diag([1.0, 0.8, 0.8])


@pytest.fixture
def build():
    """Return a factory of Case I's closed loop with a given number of control steps."""

    def make(n_steps=375, substeps=1):
        body = RigidBody(INERTIA, 0.4 / substeps)
        attitude = lie.exp(np.array([0.25, 0.5, 0.5]))
        plant = RigidBodyPlant(body, attitude, np.zeros(3), n_steps, substeps)
        ocp = AttitudeOcp(INERTIA, 0.4, 5, Weights(), max_torque=0.01, torque_penalty=1e10)
        return ClosedLoop(
            plant, ShootingController(ShootingSolver(ocp)), PassThroughGovernor(np.eye(3))
        )

    return make
