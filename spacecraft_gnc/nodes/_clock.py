"""Simulated time of a node: rclpy's clock, set by the stamps of states that a guard admitted."""

from __future__ import annotations

from rclpy.clock import ClockType
from rclpy.node import Node
from rclpy.time import Time

from spacecraft_gnc.signals.message import Stamp


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

    def set(self, stamp: Stamp) -> None:
        """Let it be the time of a state of the flight."""
        seconds, nanoseconds = stamp
        now = Time(seconds=seconds, nanoseconds=nanoseconds, clock_type=ClockType.ROS_TIME)
        self._clock.set_ros_time_override(now)
