"""Signals of the rigid body: state, torque command, status and telemetry."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

from spacecraft_gnc.governors.planned.report import Cause, Phase, Planned, PlanReport
from spacecraft_gnc.loop.protocols import Source, State
from spacecraft_gnc.signals import ANY, INFINITE, ROTATION, Field, Message, Rule, Signal
from spacecraft_gnc.signals.applied import Applied
from spacecraft_gnc.signals.attitude import (
    ACCEPTED_TARGET,
    ATTITUDE_ERROR,
    BODY_FRAME,
    GOVERNOR_STATUS,
    INERTIAL_FRAME,
    POSE,
    REFERENCE,
    TARGET,
    quaternion_of,
)
from spacecraft_gnc.signals.graph import (
    CONTROL,
    CONTROLLER,
    GOVERNOR,
    GUIDANCE,
    MOTION,
    PLANT,
    SETUP,
)
from spacecraft_gnc.signals.qos import latched
from spacecraft_gnc.signals.structures import QUATERNION, VECTOR3
from spacecraft_gnc.types import Vector3

_OF_A_SOLVE: Final = Rule(when=("status", 0))
"""Finite in what SolverStatus.CONVERGED says was found."""
_MARGIN_OF_A_SOLVE: Final = INFINITE._replace(when=_OF_A_SOLVE.when)
_SOURCE: Final = Rule(most=max(Source))
_SOURCES: Final = tuple(Source)


class StateAndRate(NamedTuple):
    """A state, and the body rate that the inertia makes of its momentum."""

    state: State
    angular_velocity: Vector3
    """(3,) [rad/s]."""


class Torque(NamedTuple):
    """A torque as commanded or applied."""

    control: Vector3
    """(3,) body frame [N m]."""
    source: Source


def _pack_motion(motion: StateAndRate) -> tuple[Any, ...]:
    _, attitude, momentum = motion.state
    return attitude, quaternion_of(attitude), momentum, motion.angular_velocity


def _unpack_state(message: Message) -> State:
    attitude = message.array("attitude").reshape(3, 3)
    return State(message.step, attitude, message.array("angular_momentum"))


def _pack_torque(command: Any) -> tuple[Any, ...]:
    return command.control, int(command.source)


def _pack_plan(planned: Planned) -> tuple[Any, ...]:
    solution = planned.solution
    problem = solution.problem
    torque_bounds, momentum_bounds = problem.limits[:2], problem.limits[2:]
    return (
        planned.number,
        planned.first_step,
        int(planned.cause),
        int(solution.status),
        problem.body.time_step,
        problem.body.inertia.ravel(),
        torque_bounds.ravel(),
        momentum_bounds.ravel(),
        problem.goal,
        solution.attitude,
        solution.momentum,
        solution.torque,
        solution.co_momentum,
        solution.zeta,
        solution.torque_multipliers,
        solution.momentum_multipliers,
        solution.cost,
        solution.residuals.largest,
        solution.min_curvature,
        solution.iterations,
        len(solution.tried),
        solution.solve_time,
    )


def _pack_plan_step(report: PlanReport) -> tuple[Any, ...]:
    return (
        report.number,
        report.plan_step,
        int(report.phase),
        report.attitude_error,
        report.momentum_error,
        report.attitude,
        report.momentum,
        report.torque,
        report.reference.angular_velocity,
        report.reference.torque,
        report.nominal_torque,
    )


def _unpack_torque(message: Message) -> Torque:
    return Torque(message.array("torque"), _SOURCES[message["source"]])


STATE: Final = Signal(
    name="attitude_state",
    type="spacecraft_gnc_msgs/msg/AttitudeState",
    fields={
        "attitude": Field("float64[9]", "-", ROTATION),
        "orientation": Field(QUATERNION, "-"),
        "angular_momentum": Field(VECTOR3, "N m s"),
        "angular_velocity": Field(VECTOR3, "rad/s"),
    },
    publishers=(PLANT,),
    subscribers=(CONTROLLER, GOVERNOR),
    frame=INERTIAL_FRAME,
    unique=True,
    rank=MOTION,
    pack=_pack_motion,
    unpack=_unpack_state,
)
TORQUE: Final = Signal(
    name="torque_command",
    type="spacecraft_gnc_msgs/msg/TorqueCommand",
    fields={"torque": Field(VECTOR3, "N m"), "source": Field("uint8", "-", _SOURCE)},
    publishers=(CONTROLLER,),
    subscribers=(PLANT,),
    frame=BODY_FRAME,
    rank=CONTROL,
    pack=_pack_torque,
    unpack=_unpack_torque,
)
SOLVER_STATUS: Final = Signal(
    name="solver_status",
    type="spacecraft_gnc_msgs/msg/SolverStatus",
    fields={
        "method": Field("string"),
        "formulation": Field("string"),
        "status": Field("uint8", "-"),
        "iterations": Field("uint32", "-"),
        "residual": Field("float64", "-", _OF_A_SOLVE),
        "cost": Field("float64", "-", _OF_A_SOLVE),
        "first_costate": Field("float64[6]", "cost per rad; cost per N m s", _OF_A_SOLVE),
        "torque_margin": Field("float64", "N m", _MARGIN_OF_A_SOLVE),
        "zone_margins": Field("float64[]", "rad", _OF_A_SOLVE),
        "min_curvature": Field("float64", "cost per (N m)^2", ANY),
        "closed_loop_radius": Field("float64", "-", ANY),
        "active_constraint": Field("string"),
        "predicted_attitudes": Field("float64[]", "-", _OF_A_SOLVE),
        "predicted_momenta": Field("float64[]", "N m s", _OF_A_SOLVE),
        "predicted_torques": Field("float64[]", "N m", _OF_A_SOLVE),
        "wall_solve_time": Field("float64", "s", ANY),
        "wall_deadline_slack": Field("float64", "s", ANY),
    },
    publishers=(CONTROLLER,),
    frame=BODY_FRAME,
    rank=CONTROL + 1,
)
INVARIANTS: Final = Signal(
    name="plant_invariants",
    type="spacecraft_gnc_msgs/msg/PlantInvariants",
    fields={
        "kinetic_energy": Field("float64", "J"),
        "inertial_momentum": Field(VECTOR3, "N m s"),
        "orthogonality_error": Field("float64", "-"),
        "applied_torque": Field(VECTOR3, "N m"),
        "applied_source": Field("uint8", "-", _SOURCE),
        "external_torque": Field(VECTOR3, "N m"),
    },
    publishers=(PLANT,),
    frame=INERTIAL_FRAME,
    unique=True,
    rank=MOTION + 1,
)
ZONE_MARKERS: Final = Signal(
    name="zone_markers",
    type="visualization_msgs/msg/MarkerArray",
    fields={"markers": Field("visualization_msgs/Marker[]")},
    start=(),
    publishers=(CONTROLLER,),
    qos=latched(1),
    rank=SETUP,
)
ATTITUDE_PLAN: Final = Signal(
    name="attitude_plan",
    type="spacecraft_gnc_msgs/msg/AttitudePlan",
    fields={
        "number": Field("uint32", "-"),
        "first_step": Field("uint64", "-"),
        "cause": Field("uint8", "-", Rule(most=max(Cause))),
        "status": Field("uint8", "-"),
        "time_step": Field("float64", "s"),
        "inertia": Field("float64[9]", "kg m^2"),
        "torque_bounds": Field("float64[6]", "N m", INFINITE),
        "momentum_bounds": Field("float64[6]", "N m s", INFINITE),
        "goal": Field("float64[9]", "-", ROTATION),
        "attitudes": Field("float64[]", "-"),
        "momenta": Field("float64[]", "N m s"),
        "torques": Field("float64[]", "N m"),
        "co_momenta": Field("float64[]", "N m"),
        "zeta": Field("float64[3]", "kg m^2 N m"),
        "torque_multipliers": Field("float64[]", "N m"),
        "momentum_multipliers": Field("float64[]", "N m/s"),
        "cost": Field("float64", "N^2 m^2"),
        "residual": Field("float64", "-"),
        "min_curvature": Field("float64", "-", ANY),
        "iterations": Field("uint32", "-"),
        "starts": Field("uint32", "-"),
        "wall_solve_time": Field("float64", "s", ANY),
    },
    publishers=(CONTROLLER, GOVERNOR),
    frame=BODY_FRAME,
    every_step=False,
    qos=latched(10),
    rank=GUIDANCE + 2,
    pack=_pack_plan,
)
"""A plan, from the step on at which it is taken."""
PLAN_STATUS: Final = Signal(
    name="plan_status",
    type="spacecraft_gnc_msgs/msg/PlanStatus",
    fields={
        "number": Field("uint32", "-"),
        "plan_step": Field("int64", "-"),
        "phase": Field("uint8", "-", Rule(most=max(Phase))),
        "attitude_error": Field("float64", "rad"),
        "momentum_error": Field(VECTOR3, "N m s"),
        "attitude": Field("float64[9]", "-", ROTATION),
        "momentum": Field(VECTOR3, "N m s"),
        "torque": Field(VECTOR3, "N m"),
        "reference_rate": Field(VECTOR3, "rad/s"),
        "reference_torque": Field(VECTOR3, "N m"),
        "nominal_torque": Field(VECTOR3, "N m", ANY),
    },
    publishers=(CONTROLLER, GOVERNOR),
    frame=BODY_FRAME,
    rank=GUIDANCE + 3,
    pack=_pack_plan_step,
)
"""Of each step of whoever plans."""
APPLIED: Final = Applied(INVARIANTS, "applied_torque", "applied_source", TORQUE, "torque")
SIGNALS: Final = (
    STATE,
    REFERENCE,
    TARGET,
    ACCEPTED_TARGET,
    TORQUE,
    SOLVER_STATUS,
    ATTITUDE_ERROR,
    GOVERNOR_STATUS,
    INVARIANTS,
    ATTITUDE_PLAN,
    PLAN_STATUS,
    POSE,
    ZONE_MARKERS,
)
