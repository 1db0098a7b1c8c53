"""Server of the SlewTo action: one target at a time, a new one replaces it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeAlias

import numpy as np
from rclpy.action import CancelResponse, GoalResponse
from spacecraft_gnc_msgs.action import SlewTo

from spacecraft_gnc import lie
from spacecraft_gnc.errors import GncError
from spacecraft_gnc.loop.protocols import State
from spacecraft_gnc.nodes._action_server import GuardedActionServer
from spacecraft_gnc.nodes._door import UsersDoor
from spacecraft_gnc.nodes._node import GncNode
from spacecraft_gnc.ros.slew_client import REFUSED
from spacecraft_gnc.signals.attitude import SLEW_ACTION
from spacecraft_gnc.types import Matrix3, Vector3

_FEEDBACK_STRIDE = 10  # control steps between two feedback messages
_NORM_TOLERANCE = 1e-3  # room for quaternions typed in with a few digits
_STOPPED = "the governor was stopped"

Answer: TypeAlias = "Callable[[GncError | None], None]"
"""Told why a target was not taken; None: it was."""


@dataclass(slots=True, eq=False)
class _Slew:
    """A goal: put to the governor, then flown."""

    handle: Any
    target: Matrix3
    tolerance: float
    message: str = ""
    reached: bool = False
    error: float = math.nan
    step: int = 0


class SlewServer:
    """Serves SlewTo on behalf of the governor.

    Parameters
    ----------
    node
        The node that hosts the action.
    door
        What it does not admit is rejected: the client is told no reason, but the server keeps
        nothing of it either.
    set_target
        Takes a target (3, 3) and tells by an `Answer`, now or later, whether the governor took it.
    tolerance, rate_tolerance
        A slew has arrived below this error [rad] (unless the goal names its own) and body rate
        [rad/s].
    """

    def __init__(
        self,
        node: GncNode,
        door: UsersDoor,
        set_target: Callable[[Matrix3, Answer], None],
        tolerance: float,
        rate_tolerance: float,
    ) -> None:
        self._set_target = set_target
        self._tolerance = tolerance
        self._rate_tolerance = rate_tolerance
        self._slew: _Slew | None = None
        self._asked: list[_Slew] = []
        self._door = door
        self._server = GuardedActionServer(
            node,
            SlewTo,
            SLEW_ACTION,
            _result,
            goal_callback=self._admit,
            handle_accepted_callback=self._accept,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )

    def destroy(self) -> None:
        """Withdraw the action."""
        self.stop()
        self._server.destroy()

    def stop(self) -> None:
        """Abort every goal: the governor answers no more."""
        self.preempt(_STOPPED)
        for slew in self._asked:
            _end(slew, "abort", _STOPPED)
        self._asked.clear()

    def preempt(self, reason: str) -> None:
        """Abort the goal being flown, if there is one."""
        self._end("abort", reason)

    def update(self, state: State, angular_velocity: Vector3, alpha: float) -> None:
        """Judge the goal being flown by the state of a new step; tell the client now and then."""
        slew = self._slew
        if slew is None:
            return
        slew.step = state.step
        slew.error = lie.angle_between(state.attitude, slew.target)
        rate = math.sqrt(float(angular_velocity @ angular_velocity))
        if slew.handle.is_cancel_requested:
            self._end("canceled", "canceled; the target stays commanded")
        elif slew.error < slew.tolerance and rate < self._rate_tolerance:
            slew.reached = True
            self._end("succeed", "target reached")
        elif state.step % _FEEDBACK_STRIDE == 0:
            feedback = SlewTo.Feedback(step=state.step, error_angle=slew.error, alpha=alpha)
            slew.handle.publish_feedback(feedback)

    def _admit(self, _: Any) -> GoalResponse:
        return GoalResponse.ACCEPT if self._door.admits(SLEW_ACTION) else GoalResponse.REJECT

    def _accept(self, handle: Any) -> None:
        """Put a goal to the governor.

        The goal is executed at its end only, when its result is known: while a coroutine waits for
        something, the EventsExecutor asks it again and again, and takes a whole processor core.
        """
        slew = _Slew(handle, np.eye(3), self._tolerance)
        self._asked.append(slew)
        try:
            slew.target = _target(handle.request.target)
            slew.tolerance = _tolerance(handle.request.tolerance) or self._tolerance
        except _BadGoal as error:
            self._begin(slew, error)
        else:
            self._set_target(slew.target, partial(self._begin, slew))

    def _begin(self, slew: _Slew, refusal: GncError | None) -> None:
        """Fly a goal that was taken; an older one goes on where it was not."""
        if slew not in self._asked:
            return  # stopped meanwhile
        self._asked.remove(slew)
        if refusal is not None:
            _end(slew, "abort", f"{REFUSED}{refusal}")
            return
        self.preempt("preempted by a newer target")
        self._slew = slew

    def _end(self, outcome: str, message: str) -> None:
        slew, self._slew = self._slew, None
        if slew is not None:
            _end(slew, outcome, message)


def _end(slew: _Slew, outcome: str, message: str) -> None:
    slew.message = message
    slew.handle.execute(partial(_result, slew=slew))
    getattr(slew.handle, outcome)()


def _result(_: Any, slew: _Slew) -> SlewTo.Result:
    return SlewTo.Result(
        reached=slew.reached, final_error=slew.error, step=slew.step, message=slew.message
    )


class _BadGoal(GncError):
    """A goal that makes no sense."""


def _target(quaternion: Any) -> Matrix3:
    q = np.array([quaternion.x, quaternion.y, quaternion.z, quaternion.w])
    norm = math.hypot(*q)  # of huge numbers infinity, without a warning
    if not abs(norm - 1.0) <= _NORM_TOLERANCE:
        raise _BadGoal(
            f"target: received a quaternion x, y, z, w = {q.tolist()} of norm {norm:.6g}; required "
            f"norm 1 within {_NORM_TOLERANCE:g}; normalize it"
        )
    return lie.from_quaternion_xyzw(q)


def _tolerance(value: float) -> float:
    if not 0.0 <= value <= math.pi:
        raise _BadGoal(
            f"tolerance: received {value} rad; required 0 (the server's default) to pi; correct it"
        )
    return value
