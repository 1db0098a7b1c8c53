"""The graph: its nodes, topics, QoS profiles and frames, declared once.

Names are relative, so a namespace moves the whole graph; ``/clock`` and ``/diagnostics`` are
absolute by convention.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any, Final, NamedTuple

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, Vector3Stamped
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
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
from std_msgs.msg import String, UInt64
from visualization_msgs.msg import MarkerArray

PLANT: Final = "plant"
CONTROLLER: Final = "nmpc_controller"
GOVERNOR: Final = "reference_governor"
RECORDER: Final = "recorder"
NODES: Final = (PLANT, CONTROLLER, GOVERNOR, RECORDER)

INERTIAL_FRAME: Final = "inertial"
BODY_FRAME: Final = "body"

SLEW_ACTION: Final = "slew_to"
EVERY: Final = "*"
"""Among the topics of a recorder: all of the graph."""


def reliable(depth: int) -> QoSProfile:
    """Return a profile that delivers every message to whoever listens now."""
    return QoSProfile(
        depth=depth, history=HistoryPolicy.KEEP_LAST, reliability=ReliabilityPolicy.RELIABLE
    )


def latched(depth: int) -> QoSProfile:
    """Return a profile that also delivers the last messages to whoever joins later."""
    profile = reliable(depth)
    profile.durability = DurabilityPolicy.TRANSIENT_LOCAL
    return profile


STREAM: Final = reliable(1000)
"""Offered for what is published every step. A reader that stalls for less than a thousand steps
loses nothing; the plant waits for the recorder long before that (`RECORDER_WINDOW`)."""
RECORD: Final = reliable(5000)
"""Asked for by the recorder."""
COMMAND: Final = reliable(10)
EVENTS: Final = reliable(100)
LATCHED: Final = latched(1)
ROLL_CALL: Final = latched(10)


class Topic(NamedTuple):
    """A topic of the graph."""

    name: str
    type: Any
    publishers: tuple[str, ...]
    subscribers: tuple[str, ...]
    """Nodes that have to be matched before step 0, once for each of their subscriptions."""
    qos: QoSProfile = STREAM
    recorded: bool = True

    @property
    def is_latched(self) -> bool:
        """Whether a late joiner gets the last messages."""
        return bool(self.qos.durability == DurabilityPolicy.TRANSIENT_LOCAL)

    def is_recorded(self, wanted: Collection[str]) -> bool:
        """Whether a recorder asked for topics ``wanted`` (empty: all) takes this one."""
        names = {name.strip("/") for name in wanted}
        return self.recorded and (not names or not names.isdisjoint((EVERY, self.name.strip("/"))))

    def expected_subscribers(self, present: Collection[str], wanted: Collection[str] = ()) -> int:
        """Return how many subscriptions the nodes ``present`` in the graph have.

        ``wanted`` is what a recorder among them takes (empty: all).
        """
        recorders = (RECORDER,) if self.is_recorded(wanted) else ()
        return sum(name in present for name in self.subscribers + recorders)

    def expected_publishers(self, present: Collection[str]) -> int:
        """Return how many publishers the nodes ``present`` in the graph have."""
        return sum(name in present for name in self.publishers)


STATE: Final = Topic("attitude_state", AttitudeState, (PLANT,), (CONTROLLER, GOVERNOR))
REFERENCE: Final = Topic("attitude_reference", AttitudeReference, (GOVERNOR,), (CONTROLLER,))
TARGET: Final = Topic("target_attitude", AttitudeReference, (), (GOVERNOR,), COMMAND)
ACCEPTED_TARGET: Final = Topic("accepted_target", AttitudeReference, (GOVERNOR,), (), latched(10))
"""A target that the governor took in flight, and the step from which on it counts."""
TORQUE: Final = Topic("torque_command", TorqueCommand, (CONTROLLER,), (PLANT,))
SOLVER_STATUS: Final = Topic("solver_status", SolverStatus, (CONTROLLER,), ())
ATTITUDE_ERROR: Final = Topic("attitude_error", Vector3Stamped, (CONTROLLER,), ())
"""From the reference to the attitude, of each step that was answered: for viewers."""
GOVERNOR_STATUS: Final = Topic("governor_status", GovernorStatus, (GOVERNOR,), ())
INVARIANTS: Final = Topic("plant_invariants", PlantInvariants, (PLANT,), ())
POSE: Final = Topic("pose", PoseStamped, (PLANT,), ())
CLOCK: Final = Topic("/clock", Clock, (PLANT,), NODES)
"""Every node follows it by rclpy's own subscription; the recorder also records it."""
ZONE_MARKERS: Final = Topic("zone_markers", MarkerArray, (CONTROLLER,), (), LATCHED)
WALL_TIMING: Final = Topic("wall_timing", WallTiming, (PLANT,), ())
DIAGNOSTICS: Final = Topic("/diagnostics", DiagnosticArray, NODES, (), EVENTS)
"""Published when a count of something unwanted changes, and then only."""
WALL_STATUS: Final = Topic("wall_status", DiagnosticArray, (CONTROLLER,), (), EVENTS, False)
"""A few times a wall second: what a progress display shows."""
READY: Final = Topic("graph_ready", String, NODES[1:], (PLANT,), ROLL_CALL, False)
"""A node's name, once it is active and all its endpoints are matched."""
RECORDED: Final = Topic("recorded_step", UInt64, (RECORDER,), (PLANT,), COMMAND, False)
"""How far the recorder has come, so that a fast plant can wait for it."""

TOPICS: Final = (
    STATE,
    REFERENCE,
    TARGET,
    ACCEPTED_TARGET,
    TORQUE,
    SOLVER_STATUS,
    ATTITUDE_ERROR,
    GOVERNOR_STATUS,
    INVARIANTS,
    POSE,
    CLOCK,
    ZONE_MARKERS,
    WALL_TIMING,
    DIAGNOSTICS,
    WALL_STATUS,
    READY,
    RECORDED,
)


def foreign(wanted: Collection[str]) -> tuple[str, ...]:
    """Return what a recorder is asked for and the graph does not have."""
    known = {EVERY, *(topic.name.strip("/") for topic in TOPICS if topic.recorded)}
    return tuple(name for name in wanted if name.strip("/") not in known)


RECORDER_WINDOW: Final = 500
"""Steps that the plant may be ahead of the recorder; less than the depth of STREAM and RECORD."""
RECORDER_STRIDE: Final = 50
"""The recorder tells how far it is every so many steps."""
WALL_STATUS_PERIOD: Final = 0.2
"""Wall time between two reports for people [s]."""
