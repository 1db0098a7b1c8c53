"""An action server that no request ends, and that keeps nothing for long."""

from __future__ import annotations

from collections import Counter
from collections.abc import Awaitable, Sequence
from typing import TYPE_CHECKING, Any, Final

from action_msgs.msg import GoalStatus
from rclpy.action import ActionServer

from spacecraft_gnc.nodes._services import shortened

if TYPE_CHECKING:
    from spacecraft_gnc.nodes._node import GncNode

_RESULT_KEPT: Final = 10  # [s] wall after the end of a goal; rclpy's 900 s keep every goal at hand
# Requests for the result of one goal that has not ended. They are answered together, and what is
# queued for a client of the action (10 answers, its own or not) must not push its own out.
_MOST_WAITING: Final = 4


class GuardedActionServer(ActionServer):
    """rclpy's action server (7.1), with three differences.

    What goes wrong with a request is refused as a message is, and does not leave the executor. A
    result expires after some wall time: under simulated time it could be gone before its client
    asks for it, or stay for ever. A goal that flies on answers a bounded number of requests for
    its result.

    Parameters
    ----------
    node
        Hosts the action.
    kind, name
        Of the action.
    execute
        Called with the handle of a goal at its end; returns the result.
    callbacks
        The others of rclpy's server.
    """

    def __init__(self, node: GncNode, kind: type, name: str, execute: Any, **callbacks: Any):
        self._host = node
        self._action = name
        self._waiting: Counter[bytes] = Counter()
        super().__init__(
            _InWallTime(node), kind, name, execute, result_timeout=_RESULT_KEPT, **callbacks
        )
        self._node = node

    def refuse(self, reason: str) -> None:
        """Count a refused request, and tell about it."""
        self._host.refuse(self._action, reason, "request")

    # What rclpy calls.

    def take_data(self) -> dict[str, Any]:
        """Take a request."""
        try:
            return dict(super().take_data())
        except Exception as error:  # noqa: BLE001 - whatever a request of a stranger leads to
            self.refuse(shortened(error))
            return {}

    async def execute(self, taken_data: dict[str, Any]) -> None:
        """Answer a request."""
        await self._contain(super().execute(taken_data))

    async def _execute_goal(self, execute_callback: Any, goal_handle: Any) -> None:
        await self._contain(super()._execute_goal(execute_callback, goal_handle))

    async def _execute_get_result_request(self, taken: Sequence[Any]) -> None:
        header, request = taken
        goal = bytes(request.goal_id.uuid)
        future = self._result_futures.get(goal)
        if future is not None and not future.done():
            self._waiting[goal] += 1
            if self._waiting[goal] > _MOST_WAITING:
                self.refuse("received too many requests for the result of one goal; ask once")
                unknown = self._action_type.Impl.GetResultService.Response()
                unknown.status = GoalStatus.STATUS_UNKNOWN
                self._handle.send_result_response(header, unknown)
                return
        await super()._execute_get_result_request(taken)

    async def _execute_expire_goals(self, expired_goals: Sequence[Any]) -> None:
        for goal in expired_goals:
            self._waiting.pop(bytes(goal.goal_id.uuid), None)
        await super()._execute_expire_goals(expired_goals)

    async def _contain(self, work: Awaitable[None]) -> None:
        try:
            await work
        except Exception as error:  # noqa: BLE001 - as above
            self.refuse(shortened(error))


class _InWallTime:
    """A node whose clock is one that nobody can set."""

    def __init__(self, node: GncNode) -> None:
        self._node = node

    def get_clock(self) -> Any:
        return self._node.steady

    def __getattr__(self, name: str) -> Any:
        return getattr(self._node, name)
