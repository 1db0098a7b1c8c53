"""Simulated time of a node: rclpy's clock, set by the stamps of states that a guard admitted."""

from __future__ import annotations

from collections.abc import Sequence

from rcl_interfaces.msg import SetParametersResult
from rclpy.clock import ClockType
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.time import Time

from spacecraft_gnc.signals.message import Stamp

_USE_SIM_TIME = "use_sim_time"


class SimulatedClock:
    """Sets a node's ROS time, in place of rclpy's own subscription to /clock.

    That one takes a tick from anybody, is best effort, and ends the node at a negative time.

    Parameters
    ----------
    node
        Made with ``use_sim_time``.
    """

    def __init__(self, node: Node) -> None:
        self._clock = node.get_clock()
        node._time_source.detach_node()  # noqa: SLF001 - rclpy has no public way to it
        node.add_on_set_parameters_callback(_keep_simulated)

    def set(self, stamp: Stamp) -> None:
        """Let it be the time of a state of the flight."""
        seconds, nanoseconds = stamp
        now = Time(seconds=seconds, nanoseconds=nanoseconds, clock_type=ClockType.ROS_TIME)
        self._clock.set_ros_time_override(now)


def _keep_simulated(parameters: Sequence[Parameter]) -> SetParametersResult:
    """Refuse to leave simulated time: the plant owns the time of every node."""
    is_refused = any(p.name == _USE_SIM_TIME and p.value is not True for p in parameters)
    reason = f"{_USE_SIM_TIME}: required true: the plant owns the time" if is_refused else ""
    return SetParametersResult(successful=not is_refused, reason=reason)
