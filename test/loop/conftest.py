"""Gupta's Case I as a closed loop, built by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from spacecraft_gnc import lie
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.governors import PassThroughGovernor
from spacecraft_gnc.loop import ClosedLoop
from spacecraft_gnc.ocp import AttitudeOcp, ShootingSolver, Weights
from spacecraft_gnc.vehicles.rigid_body.controllers.solvers import ShootingController
from spacecraft_gnc.vehicles.rigid_body.controllers.standstill import StandstillMonitor
from spacecraft_gnc.vehicles.rigid_body.plant import RigidBodyPlant

INERTIA = np.diag([1.0, 0.8, 0.8])


@pytest.fixture
def build():
    """Return a factory of Case I's closed loop, with changes of its start and its problem.

    ``watch``: names of the zones, with which a standstill monitor is set up.
    """

    def make(n_steps=375, substeps=1, start=(0.25, 0.5, 0.5), watch=None, **changes):
        body = RigidBody(INERTIA, 0.4 / substeps)
        plant = RigidBodyPlant(body, lie.exp(np.array(start)), np.zeros(3), n_steps, substeps)
        problem = {"weights": Weights(), "max_torque": 0.01, "torque_penalty": 1e10} | changes
        ocp = AttitudeOcp(INERTIA, 0.4, 5, **problem)
        monitor = None if watch is None else StandstillMonitor(ocp, math.radians(0.1), watch)
        controller = ShootingController(ShootingSolver(ocp), monitor)
        return ClosedLoop(plant, controller, PassThroughGovernor(np.eye(3)))

    return make
