"""Signals that every graph has, whatever flies: clock, readiness, progress, diagnostics."""

from __future__ import annotations

from typing import Final

from spacecraft_gnc.signals.qos import COMMAND, EVENTS, latched
from spacecraft_gnc.signals.rules import ANY
from spacecraft_gnc.signals.signal import STAMPED, Field, Signal
from spacecraft_gnc.signals.structures import TIME

PLANT: Final = "plant"
CONTROLLER: Final = "nmpc_controller"
GOVERNOR: Final = "reference_governor"
RECORDER: Final = "recorder"
ROLES: Final = (PLANT, CONTROLLER, GOVERNOR, RECORDER)

SETUP, MOTION, TICK, WISH, GUIDANCE, CONTROL = 0, 10, 20, 30, 40, 50
"""Ranks: the order of cause and effect in a step."""

CLOCK: Final = Signal(
    name="/clock",
    type="rosgraph_msgs/msg/Clock",
    fields={"clock": Field(TIME)},
    start=(),
    publishers=(PLANT,),
    shared=True,
    sealed=False,
    rank=TICK,
)
"""For whoever follows simulated time. The nodes of the graph take it from the stamps of states,
which are sealed: a message of fixed size, as this is, has no room for a seal."""
WALL_TIMING: Final = Signal(
    name="wall_timing",
    type="spacecraft_gnc_msgs/msg/WallTiming",
    fields={
        "wall_elapsed": Field("float64", "s"),
        "wall_latency": Field("float64", "s", ANY),
        "wall_deadline_slack": Field("float64", "s", ANY),
        "missed_deadlines": Field("uint64", "-"),
        "held_commands": Field("uint64", "-"),
        "rejected_messages": Field("uint64", "-"),
    },
    publishers=(PLANT,),
    every_step=False,
    shared=True,
)
_DIAGNOSTIC_FIELDS: Final = {"status": Field("diagnostic_msgs/DiagnosticStatus[]")}
DIAGNOSTICS: Final = Signal(
    name="/diagnostics",
    type="diagnostic_msgs/msg/DiagnosticArray",
    fields=_DIAGNOSTIC_FIELDS,
    start=STAMPED,
    publishers=ROLES,
    shared=True,
    qos=EVENTS,
)
"""Published when a count of something unwanted changes, and then only."""
WALL_STATUS: Final = Signal(
    name="wall_status",
    type="diagnostic_msgs/msg/DiagnosticArray",
    fields=_DIAGNOSTIC_FIELDS,
    start=STAMPED,
    publishers=(CONTROLLER,),
    recorded=False,
    of_craft=True,
    qos=EVENTS,
)
"""A few times a wall second: what a progress display shows."""
READY: Final = Signal(
    name="graph_ready",
    type="std_msgs/msg/String",
    fields={"data": Field("string")},
    start=(),
    publishers=(CONTROLLER, GOVERNOR, RECORDER),
    subscribers=(PLANT, RECORDER),
    recorded=False,
    shared=True,
    qos=latched(100),
)
"""A node's full name, once it is active and all its endpoints are matched.

The plant begins when all are ready. The recorder's acknowledgment tells a restarted node that it is
heard."""
RECORDED: Final = Signal(
    name="recorded_step",
    type="std_msgs/msg/String",
    fields={"data": Field("string")},
    start=(),
    publishers=(RECORDER,),
    subscribers=(PLANT,),
    recorded=False,
    shared=True,
    qos=COMMAND,
)
"""How far the recorder has come, so that a fast plant can wait for it; decimal."""
SIGNALS: Final = (CLOCK, WALL_TIMING, DIAGNOSTICS, WALL_STATUS, READY, RECORDED)

RECORDER_WINDOW: Final = 500
"""Steps that the plant may be ahead of the recorder; less than the depth of STREAM and RECORD."""
RECORDER_STRIDE: Final = 50
"""The recorder tells how far it is every so many steps."""
WALL_STATUS_PERIOD: Final = 0.2
"""Wall time between two reports for people [s]."""
