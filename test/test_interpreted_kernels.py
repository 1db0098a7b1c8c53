"""Every kernel gives the same numbers compiled and interpreted."""

from __future__ import annotations

import numpy as np
from both_ways import compiled_and_interpreted

PROGRAM = """
import math, sys
import numpy as np
from spacecraft_gnc import lie
from spacecraft_gnc.vehicles.rigid_body.audit import _audit_kernels
from spacecraft_gnc.vehicles.rigid_body.audit.problem import Problem
from spacecraft_gnc.vehicles.rigid_body.audit.plans import Certifier, Plans
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.governors import tail
from spacecraft_gnc.governors.attitude import AttitudeGovernor
from spacecraft_gnc.governors.controller_loop import ShootingLoopPredictor
from spacecraft_gnc.governors.feedback import AttitudeFeedback
from spacecraft_gnc.governors.feedback_loop import FeedbackPredictor
from spacecraft_gnc.governors.pass_through import PassThroughGovernor
from spacecraft_gnc.governors.reference_set import ReferenceSet
from spacecraft_gnc.vehicles.rigid_body.controllers.solvers import ShootingController
from spacecraft_gnc.vehicles.rigid_body.plant import RigidBodyPlant
from spacecraft_gnc.loop import ClosedLoop
from spacecraft_gnc.ocp import terminal_level
from spacecraft_gnc.ocp import (
    AttitudeOcp, NeighboringExtremal, NeighboringOptions, PointingZone, ShootingOptions,
    ShootingSolver, TerminalSetOcp, TerminalSetSolver, Weights, linearize,
)
from spacecraft_gnc.ocp.transfer import (
    AttitudeTransfer, TransferSolver, shortest_possible_steps,
)
from spacecraft_gnc.types import Reference, State

J = np.array([[1.0, 0.05, -0.1], [0.05, 0.8, 0.02], [-0.1, 0.02, 0.9]])
Q = np.array([[1.0, 0.2, 0.1], [0.2, 0.9, 0.0], [0.1, 0.0, 1.1]])
zone = PointingZone("exclusion", [1, 0, 0], [math.cos(0.3), math.sin(0.3), 0.0], 0.2, 1.0)
ocp = AttitudeOcp(J, 0.4, 4, Weights(0.1 * Q, 0.05 * Q, Q, 0.1 * Q, 0.2 * Q), 0.05, 1e4, (zone,))
R, Pi = lie.exp(np.array([0.02, 0.3, 0.55])), np.array([0.05, 0.0, -0.15])
u = np.full((4, 3), 0.03)
s = ShootingSolver(ocp).solve(R, Pi, lie.exp(np.array([0.1, 0.0, 0.2])))
assert s.converged
attitudes, momenta = RigidBody(J, 0.1).simulate(R, Pi, u[0], 20)
found = {}
for formulation in ("backward_sweep", "single_shooting"):  # every step rule, each variant
    for rule, variant in (("full", "exact"), ("damped", "estimated_du"), ("chord", "exact")):
        options = ShootingOptions(formulation=formulation, step_rule=rule, max_iterations=60)
        o = ShootingSolver(ocp, variant, options).solve(R, Pi)
        assert o.converged
        found[f"{formulation}_{rule}"] = o.torques
        found[f"{formulation}_{rule}_numbers"] = [o.iterations, o.cost, o.min_curvature]
around = linearize(s)
found |= {"gains": around.gains, "closed_loop": around.closed_loop, "margins": s.zone_margins}
batch = ShootingSolver(ocp).solve_batch([R, R.T], [Pi, -Pi])
found |= {"batch": batch.torques, "batch_status": batch.status}
B = np.array([[1.0, -1.0, 0.0, 0.2], [0.0, 1.0, -1.0, 0.1], [0.3, 0.2, 0.1, 1.0]])
four = AttitudeOcp(J, 0.4, 3, max_torque=0.01, actuators=B)
found["controls"] = ShootingSolver(four).solve(R, Pi).controls
near = NeighboringExtremal(ocp, NeighboringOptions(tolerance=1.0))
near.solve(R, Pi)
o = near.solve(R @ lie.exp(np.array([1e-4, 0.0, 0.0])), Pi)
assert o.formulation == "neighboring_extremal"
found |= {"near": o.torques, "near_error": near.error_bound}
omega = np.array([0.05, 0.1, -0.07])
turn = Reference(R.T, omega, np.cross(omega, J @ omega) + 0.01)
for formulation in ("backward_sweep", "single_shooting"):
    o = ShootingSolver(ocp, options=ShootingOptions(formulation=formulation)).solve(R, Pi, turn)
    assert o.converged
    found |= {f"moving_{formulation}": o.torques, f"moving_{formulation}_cost": o.cost}
near.reset()
near.solve(R, Pi, turn)
o = near.solve(R, Pi, turn._replace(attitude=turn.attitude @ lie.exp(1e-4 * omega)))
assert o.formulation == "neighboring_extremal"
found |= {"near_moving": o.torques, "gradient_moving": ocp.gradient(u, R, Pi, turn)}
flat = AttitudeOcp(np.diag([1.0, 0.8, 0.8]), 0.4, 30)  # a saddle, and the way off it
o = ShootingSolver(flat).solve(lie.exp(np.array([math.pi, 0.0, 0.0])), np.zeros(3))
assert o.converged and o.cost < 0.4
found |= {"off_saddle": o.cost, "off_saddle_torques": np.abs(o.torques)}
loop = ShootingController(ShootingSolver(AttitudeOcp(J, 0.4, 4, max_torque=0.05)))
predictor = ShootingLoopPredictor(
    loop, RigidBody(J, 0.2), 2, ReferenceSet((zone,)), np.eye(3), max_momentum=0.5, horizon=8
)
o = predictor.predict(State(0, R.T, Pi), np.eye(3))
assert o.constraint == "convergence" and o.violation_step == 8
found |= {"loop_margin": o.margin, "loop_radius": predictor.settled.radius}
plant = RigidBodyPlant(RigidBody(J, 0.2), R.T, Pi, 5, 2)
governor = PassThroughGovernor(np.eye(3))
assert plant.stretch(loop, governor, 5) is not None  # flown at once
o = ClosedLoop(plant, loop, governor).run()
found |= {"at_once_torques": o.torque, "at_once_attitude": o.final_attitude}
tail.SAMPLES, tail.FLIGHTS = 64, 3  # interpreted, thousands would take minutes
law = AttitudeFeedback(0.2 * J, 0.4, J)
ahead = FeedbackPredictor(law, 0.2, 2, ReferenceSet((zone,), 0.01), max_torque=0.02)
governor = AttitudeGovernor(ahead, ahead.reference_set, R, alpha_tolerance=0.01)
state = State(0, lie.exp(np.array([-0.1, 0.3, 0.5])), np.array([0.001, 0.0, 0.002]))
decision = governor.decide(state)
assert 0.0 < decision.alpha < 1.0 and decision.active_constraint == "torque limit"
found |= {
    "reference": decision.reference.attitude, "governor_margin": decision.margin,
    "tail": [ahead.tail.level, ahead.tail.growth, ahead.horizon, decision.violation_step],
    "feedback": law.torque(state, R), "lyapunov": law.lyapunov(state, R),
    "tracking": law.torque(state, turn),
}
terminal_level.RAYS, terminal_level.SAMPLES = 64, 256  # interpreted, they take their time
kalabic = TerminalSetOcp(J, 0.2, 8, Q, 0.5 * Q, 2.0 * Q, 0.1, 0.5, "true")
tight = kalabic._with(level=kalabic.level._replace(value=0.03))
o = TerminalSetSolver(tight).solve(R, Pi, lie.exp(np.array([0.1, 0.0, 0.2])))
assert o.converged and o.terminal_multiplier > 0.0
found |= {"terminal_torques": o.torques, "terminal_cost": o.cost}
found |= {"terminal_reached": o.terminal_level, "terminal_level": kalabic.level.value}
def certified(problem, o, has_set):
    plan = (o.reference, o.attitudes, o.momenta, o.torques, o.costates[0], o.feedforward)
    certifier = Certifier(Problem.of(problem), (), has_set)
    c = certifier.certify(Plans(*(np.ascontiguousarray(x[None]) for x in plan)))
    numbers = [c.cost[0], c.residual[0], c.curvature[0], c.multiplier[0], c.largest[0]]
    return [*numbers, *c.costates[0]]
found |= {"certificate": certified(ocp, s, False), "set_certificate": certified(tight, o, True)}
body, ends = RigidBody(J, 0.2), (np.empty((1, 3, 3)), np.empty((1, 3)))
_audit_kernels.resume(body.packed, 0.2, 2, R[None].copy(), Pi[None].copy(), u[:1].copy(), *ends)
found |= {"resumed_attitude": ends[0], "resumed_momentum": ends[1]}
for homotopy in (True, False):
    bounds = {"torque": 0.04, "momentum": 0.09} if homotopy else {}
    transfer = AttitudeTransfer(body=RigidBody(J, 0.4), n_steps=20, goal=R, **bounds)
    o = TransferSolver(starts=1, homotopy=homotopy).solve(transfer)
    assert o.converged and bool(o.active) == homotopy
    found |= {f"transfer_{homotopy}": o.torque, f"transfer_{homotopy}_co": o.co_momentum}
    found[f"transfer_{homotopy}_least"] = shortest_possible_steps(transfer)
np.savez(
    sys.argv[1], torques=s.torques, costates=s.costates, cost=s.cost, curvature=s.min_curvature,
    attitudes=attitudes, momenta=momenta, gradient=ocp.gradient(u, R, Pi),
    hessian=ocp.hessian(u, R, Pi), value=ocp.cost(u, R, Pi), **found,
)
"""


def test_compiled_and_interpreted_kernels_agree(tmp_path):
    compiled, interpreted = compiled_and_interpreted(PROGRAM, tmp_path)
    assert compiled.keys() == interpreted.keys()
    for name, value in compiled.items():
        size = max(1.0, float(np.abs(value).max()))
        # The way off a saddle starts from rounding; it ends where the residual is 1e-12.
        tolerance = 1e-10 if name.startswith("off_saddle") else 1e-12
        assert np.abs(value - interpreted[name]).max() < tolerance * size, name
