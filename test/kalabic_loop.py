"""Loop of Kalabic et al. 2014, section V-A, assembled from its parts."""

from __future__ import annotations

import math

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.governors.attitude import AttitudeGovernor
from spacecraft_gnc.governors.feedback import AttitudeFeedback
from spacecraft_gnc.governors.feedback_loop import FeedbackPredictor
from spacecraft_gnc.governors.reference_set import ReferenceSet
from spacecraft_gnc.loop import State
from spacecraft_gnc.ocp import PointingZone

INERTIA = np.diag([10.0, 8.0, 8.0])
H = 0.1
LIMIT = 0.02
FEEDBACK = AttitudeFeedback(np.diag([0.1, 0.2, 0.3]), 0.2, INERTIA)
BODY = RigidBody(INERTIA, H)
EARTH = PointingZone("inclusion", [0, 0, 1], [0, 0, 1], math.radians(60.0), 1.0)
REFERENCES = ReferenceSet((EARTH,), math.radians(0.1), ("earth",))
START = State(0, lie.exp(math.radians(57.0) * np.array([0.8, 0.6, 0.0])), np.zeros(3))


def predictor(references=REFERENCES, **changes):
    """Return the predictor of the loop, with the paper's torque limit."""
    options = {"max_torque": LIMIT} | changes
    return FeedbackPredictor(FEEDBACK, H, 1, references, **options)


def governor(target=None, references=REFERENCES, planner=None, first=None, **changes):
    """Return the governor of the loop; the target is I."""
    wanted = np.eye(3) if target is None else target
    return AttitudeGovernor(
        predictor(references, **changes), references, wanted,
        planner=planner, initial_reference=first,
    )  # fmt: skip


def fly(law, state, n_steps, feedback=FEEDBACK, body=BODY):
    """Yield (state, decision, torque) of each step of the governed loop."""
    for _ in range(n_steps):
        decision = law.decide(state)
        torque = feedback.torque(state, decision.reference.attitude)
        yield state, decision, torque
        state = State(state.step + 1, *body.step(state.attitude, state.momentum, torque))
