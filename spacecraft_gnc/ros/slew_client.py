"""A client of the SlewTo action."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final, NamedTuple

from geometry_msgs.msg import Quaternion
from rclpy.action import ActionClient
from spacecraft_gnc_msgs.action import SlewTo

from spacecraft_gnc.ros.endpoints import full_topic_name
from spacecraft_gnc.ros.graph import GraphError, GraphView
from spacecraft_gnc.signals.attitude import SLEW_ACTION
from spacecraft_gnc.signals.graph import GOVERNOR
from spacecraft_gnc.types import Array

_PATIENCE = 5.0  # [s] wall for the server to answer

REFUSED: Final = "refused: "
"""How the message of a goal begins that the governor did not take."""


class SlewResult(NamedTuple):
    """How a slew ended."""

    reached: bool
    final_error: float
    """[rad]"""
    step: int
    message: str
    refused: bool
    """Whether the governor did not take the target: what was flown before goes on."""


def slew(
    view: GraphView,
    quaternion: Array,
    tolerance: float,
    on_feedback: Callable[[int, float, float], None],
    namespace: str = "",
) -> SlewResult:
    """Command a slew and wait for its end; Ctrl-C cancels it.

    Parameters
    ----------
    view
        The graph.
    quaternion
        (4,) target x, y, z, w, body to inertial.
    tolerance
        Error at which it has arrived [rad]; 0: the server's default.
    on_feedback
        Called with step, error [rad] and alpha.
    namespace
        Of the spacecraft; empty: the root.

    Raises
    ------
    GraphError
        No governor answers.
    TopicNameRefused
        If ``namespace`` cannot be one.
    """
    space = namespace.strip("/")
    action = full_topic_name(view.node, f"/{space}/{SLEW_ACTION}") if space else SLEW_ACTION
    client = ActionClient(view.node, SlewTo, action)
    if not view.spin_until(client.server_is_ready, _PATIENCE):
        view.raise_interrupt()
        if any(name == GOVERNOR for name in view.node.get_node_names()):
            raise GraphError(
                f"{action}: received a {GOVERNOR} without that action, whose vehicle is steered by "
                "more than an attitude; required one that takes attitudes; publish a target on its "
                "topic instead, if it has one (`gnc inspect topics`)"
            )
        raise GraphError(
            f"{action}: no action server on ROS_DOMAIN_ID={view.domain_id}; required a live "
            "graph with a reference_governor; start one with `gnc launch`, or give --domain-id"
        )

    def show(message: Any) -> None:
        f = message.feedback
        on_feedback(f.step, f.error_angle, f.alpha)

    x, y, z, w = quaternion.tolist()
    goal = SlewTo.Goal(target=Quaternion(x=x, y=y, z=z, w=w), tolerance=tolerance)
    sending = client.send_goal_async(goal, feedback_callback=show)
    if not view.spin_until(sending.done, _PATIENCE) or not sending.result().accepted:
        raise GraphError(
            f"{action}: the governor takes no goal now (not active, or too many of them); try again"
        )
    handle = sending.result()
    result = handle.get_result_async()
    if not view.spin_until(result.done):
        view.forgive_interrupt()
        handle.cancel_goal_async()
        if not view.spin_until(result.done, _PATIENCE):
            raise GraphError(f"{action}: canceled, but the governor did not confirm it")
    r = result.result().result
    refused = r.message.startswith(REFUSED)
    message = r.message.removeprefix(REFUSED)
    return SlewResult(r.reached, r.final_error, r.step, message, refused)
