"""Core values to serialized messages and back."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from geometry_msgs.msg import PoseStamped
from rclpy.serialization import deserialize_message
from rosgraph_msgs.msg import Clock
from spacecraft_gnc_msgs.msg import (
    AttitudeReference,
    AttitudeState,
    GovernorStatus,
    PlantInvariants,
    SolverStatus,
    TorqueCommand,
    WallTiming,
)
from std_msgs.msg import Header, String

from spacecraft_gnc import lie
from spacecraft_gnc.loop import guards
from spacecraft_gnc.loop.protocols import (
    Command,
    GovernorDecision,
    Invariants,
    Reference,
    Source,
    State,
)
from spacecraft_gnc.nodes._cdr import Layout
from spacecraft_gnc.nodes._topics import BODY_FRAME, INERTIAL_FRAME
from spacecraft_gnc.types import Vector3

if TYPE_CHECKING:  # the governor and the recorder need no solver
    from spacecraft_gnc.ocp.solution import Solution

_NS_PER_S = 1_000_000_000
_INERTIAL = Header(frame_id=INERTIAL_FRAME)
_BODY = Header(frame_id=BODY_FRAME)
_STATE = Layout(AttitudeState(header=_INERTIAL))
_REFERENCE = Layout(AttitudeReference(header=_INERTIAL))
_TORQUE = Layout(TorqueCommand(header=_BODY))
_INVARIANTS = Layout(PlantInvariants(header=_INERTIAL))
_POSE = Layout(PoseStamped(header=_INERTIAL))
_CLOCK = Layout(Clock())
_WALL_TIMING = Layout(WallTiming())

# Where the numbers lie: every message of ours starts with seconds, nanoseconds, step.
_STEP = 2
_ATTITUDE = slice(3, 12)
_STATE_MOMENTUM = slice(16, 19)
_STATE_RATE = slice(19, 22)
_REFERENCE_RATE = slice(16, 19)
_REFERENCE_TORQUE = slice(19, 22)
_TORQUE_VECTOR = slice(3, 6)
_TORQUE_SOURCE = 6
_SOURCES = tuple(Source)

Stamp = tuple[int, int]
"""Seconds and nanoseconds."""


class Refused(Exception):
    """A message that must not reach a core, and why."""


class Torque(NamedTuple):
    """A torque command as received."""

    step: int
    torque: Vector3
    source: Source


def period_ns(period: float) -> int:
    """Return the control period in whole nanoseconds: simulated time never rounds again."""
    return round(period * _NS_PER_S)


def stamp_of(step: int, period_in_ns: int) -> Stamp:
    """Return the simulated time t_k of a control step."""
    return divmod(step * period_in_ns, _NS_PER_S)


def encode_state(stamp: Stamp, state: State, angular_velocity: Vector3) -> bytes:
    """Serialize an AttitudeState."""
    return _STATE.pack(
        [
            *stamp,
            state.step,
            *state.attitude.ravel().tolist(),
            *lie.to_quaternion_xyzw(state.attitude).tolist(),
            *state.momentum.tolist(),
            *angular_velocity.tolist(),
        ]
    )


def decode_state(data: bytes, last_step: int) -> tuple[Stamp, State, Vector3]:
    """Return stamp, state and body rate (3,) [rad/s] of an AttitudeState.

    Raises
    ------
    Refused
        If it is no state, or older than ``last_step``.
    """
    v = _read(_STATE, data)
    attitude, momentum = v[_ATTITUDE], v[_STATE_MOMENTUM]
    _check(guards.reject_state(v[_STEP], attitude, momentum, last_step))
    _check(guards.reject_vector("angular_velocity", v[_STATE_RATE]))
    state = State(v[_STEP], np.array(attitude).reshape(3, 3), np.array(momentum))
    return (v[0], v[1]), state, np.array(v[_STATE_RATE])


def encode_reference(stamp: Stamp, step: int, reference: Reference) -> bytes:
    """Serialize an AttitudeReference."""
    return _REFERENCE.pack(
        [
            *stamp,
            step,
            *reference.attitude.ravel().tolist(),
            *lie.to_quaternion_xyzw(reference.attitude).tolist(),
            *reference.angular_velocity.tolist(),
            *reference.torque.tolist(),
        ]
    )


def decode_reference(data: bytes, last_step: int = 0) -> tuple[int, Reference]:
    """Return step and reference of an AttitudeReference.

    Raises
    ------
    Refused
        If it is no reference, or older than ``last_step``.
    """
    v = _read(_REFERENCE, data)
    rate, torque = v[_REFERENCE_RATE], v[_REFERENCE_TORQUE]
    _check(guards.reject_reference(v[_STEP], v[_ATTITUDE], last_step))
    _check(guards.reject_vector("angular_velocity", rate))
    _check(guards.reject_vector("torque", torque))
    attitude = np.array(v[_ATTITUDE]).reshape(3, 3)
    return v[_STEP], Reference(attitude, np.array(rate), np.array(torque))


def encode_torque(stamp: Stamp, step: int, command: Command) -> bytes:
    """Serialize a TorqueCommand."""
    return _TORQUE.pack([*stamp, step, *command.torque.tolist(), int(command.source)])


def decode_torque(data: bytes) -> Torque:
    """Return a TorqueCommand.

    Raises
    ------
    Refused
        If it is none.
    """
    v = _read(_TORQUE, data)
    torque, source = v[_TORQUE_VECTOR], v[_TORQUE_SOURCE]
    _check(guards.reject_vector("torque", torque))
    if source >= len(_SOURCES):
        raise Refused(f"source is {source}; required 0 to {len(_SOURCES) - 1}")
    return Torque(v[_STEP], np.array(torque), _SOURCES[source])


def encode_invariants(
    stamp: Stamp, step: int, invariants: Invariants, applied: tuple[Vector3, Source]
) -> bytes:
    """Serialize a PlantInvariants; ``applied`` is what acted over the step that ended now."""
    energy, momentum, orthogonality_error = invariants
    torque, source = applied
    return _INVARIANTS.pack(
        [
            *stamp,
            step,
            energy,
            *momentum.tolist(),
            orthogonality_error,
            *torque.tolist(),
            int(source),
        ]
    )


def encode_pose(stamp: Stamp, state: State) -> bytes:
    """Serialize a PoseStamped at the origin of the inertial frame."""
    quaternion = lie.to_quaternion_xyzw(state.attitude).tolist()
    return _POSE.pack([*stamp, 0.0, 0.0, 0.0, *quaternion])


def encode_clock(stamp: Stamp) -> bytes:
    """Serialize a Clock."""
    return _CLOCK.pack(stamp)


def encode_wall_timing(stamp: Stamp, step: int, timing: Sequence[float]) -> bytes:
    """Serialize a WallTiming from its six fields after ``step``."""
    return _WALL_TIMING.pack([*stamp, step, *timing])


def decode_string(data: bytes) -> str:
    """Return the text of a String."""
    return str(deserialize_message(data, String).data)


class GovernorStatusEncoder:
    """Serializes GovernorStatus; one layout for each name of a constraint."""

    def __init__(self) -> None:
        self._layouts: dict[str, Layout] = {}

    def encode(self, stamp: Stamp, step: int, decision: GovernorDecision) -> bytes:
        """Serialize the decision of one step."""
        name = decision.active_constraint
        layout = self._layouts.get(name)
        if layout is None:
            prototype = GovernorStatus(header=_INERTIAL, active_constraint=name)
            layout = self._layouts[name] = Layout(prototype)
        return layout.pack(
            [
                *stamp,
                step,
                decision.alpha,
                decision.admissible,
                decision.margin,
                decision.evaluations,
            ]
        )


class SolverStatusEncoder:
    """Serializes SolverStatus; one layout for each shape of a horizon.

    Parameters
    ----------
    method
        The controller's name.
    horizon
        Steps of the horizon, for messages without a solve.
    """

    def __init__(self, method: str, horizon: int) -> None:
        self._method = method
        self._horizon = horizon
        self._layouts: dict[tuple[int, int], Layout] = {}

    def encode(
        self, stamp: Stamp, step: int, solution: Solution | None, wall: tuple[float, float]
    ) -> bytes:
        """Serialize a solve with its wall time and slack; None: no solve was made."""
        if solution is None:
            plan = [math.nan] * (15 * self._horizon + 12)
            return self._layout(self._horizon, 0).pack([*stamp, step, *_NO_SOLVE, *plan, *wall])
        zone_margins = solution.zone_margins.tolist()
        return self._layout(len(solution.torques), len(zone_margins)).pack(
            [
                *stamp,
                step,
                int(solution.status),
                solution.iterations,
                solution.residual,
                solution.cost,
                *solution.costates[0].tolist(),
                solution.torque_margin,
                *zone_margins,
                math.nan,  # the curvature costs more than the solve: audits compute it
                math.nan,
                *solution.attitudes.ravel().tolist(),
                *solution.momenta.ravel().tolist(),
                *solution.torques.ravel().tolist(),
                *wall,
            ]
        )

    def _layout(self, horizon: int, n_zones: int) -> Layout:
        layout = self._layouts.get((horizon, n_zones))
        if layout is None:
            prototype = SolverStatus(
                header=_BODY,
                method=self._method,
                zone_margins=[0.0] * n_zones,
                predicted_attitudes=[0.0] * (9 * (horizon + 1)),
                predicted_momenta=[0.0] * (3 * (horizon + 1)),
                predicted_torques=[0.0] * (3 * horizon),
            )
            layout = self._layouts[horizon, n_zones] = Layout(prototype)
        return layout


_NO_SOLVE = [SolverStatus.NOT_FINITE, 0, *([math.nan] * 2), *([math.nan] * 6), *([math.nan] * 3)]


def _read(layout: Layout, data: bytes) -> list[Any]:
    try:
        return layout.read(data)
    except (RuntimeError, ValueError) as error:
        name = layout.message_type.__name__
        raise Refused(f"{len(data)} bytes that are no {name} ({error})") from error


def _check(reason: str | None) -> None:
    if reason is not None:
        raise Refused(reason)
