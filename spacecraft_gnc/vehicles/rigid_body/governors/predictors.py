"""Predictors of a scenario's loop, compiled where its controller has a compiled loop."""

from __future__ import annotations

from spacecraft_gnc import lie
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.governors.controller_loop import ControllerLoopPredictor, ShootingLoopPredictor
from spacecraft_gnc.governors.feedback import AttitudeFeedback
from spacecraft_gnc.governors.feedback_loop import FeedbackPredictor
from spacecraft_gnc.governors.prediction import Predictor
from spacecraft_gnc.governors.reference_set import ReferenceSet
from spacecraft_gnc.ocp import ShootingSolver
from spacecraft_gnc.vehicles.rigid_body.controllers.feedback.controller import FeedbackController
from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario


def predictor_of(scenario: Scenario, references: ReferenceSet) -> Predictor:
    """Return the predictor of a scenario's loop, with the body that its controller believes."""
    controller = scenario.build_controller()
    if isinstance(controller, FeedbackController):
        return feedback_predictor(scenario, controller.feedback, references)
    c, g = scenario.controller, scenario.governor
    solver = getattr(controller, "solver", None)
    compiled = isinstance(solver, ShootingSolver)
    kind = ShootingLoopPredictor if compiled else ControllerLoopPredictor
    return kind(
        controller,
        RigidBody(c.inertia, scenario.plant.time_step),
        scenario.substeps,
        references,
        lie.exp(g.target_rotation_vector),
        max_torque=g.max_torque,
        max_momentum=g.max_momentum,
        horizon=g.prediction_horizon,
    )


def feedback_predictor(
    scenario: Scenario,
    law: AttitudeFeedback,
    references: ReferenceSet,
    horizon: int | None = None,
) -> FeedbackPredictor:
    """Return the predictor of a feedback law; ``horizon`` replaces that of the scenario."""
    g = scenario.governor
    return FeedbackPredictor(
        law,
        scenario.plant.time_step,
        scenario.substeps,
        references,
        max_torque=g.max_torque,
        max_momentum=g.max_momentum,
        level=g.lyapunov_level,
        horizon=g.prediction_horizon if horizon is None else horizon,
    )
