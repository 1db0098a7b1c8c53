"""Outcome of a launch."""

from __future__ import annotations

import signal
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import ClassVar

from spacecraft_gnc.errors import LaunchError


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """Result of a finished launch.

    Attributes
    ----------
    domain_id
        ROS_DOMAIN_ID it ran on.
    steps
        Control steps flown.
    simulated_time
        [s]
    wall_time
        From the first state to the last [s].
    startup_time
        From the start of the launcher to the first torque [s]; NaN if none was received.
    missed_deadlines
        Steps whose torque was late.
    restarts
        Nodes that died and were restarted.
    bags
        Folders of the recordings; more than one if the recorder was restarted.
    strangers
        Publishers on topics of the flight that are none of its nodes: topic and node.
    refused
        Messages that each node, and the launcher, refused: by topic and kind.
    """

    domain_id: int
    steps: int
    simulated_time: float
    wall_time: float
    startup_time: float
    missed_deadlines: int
    restarts: tuple[str, ...]
    bags: tuple[str, ...]
    strangers: tuple[str, ...] = ()
    refused: Mapping[str, Mapping[str, int]] = field(default_factory=dict)


class NodeDied(LaunchError):
    """A node ended unexpectedly, or never started.

    Parameters
    ----------
    message
        The node, and how it ended.
    last_output
        The last lines of its log.
    told
        Whether the message was shown when it happened.
    """

    def __init__(self, message: str, last_output: Sequence[str], *, told: bool = False) -> None:
        self.last_output = tuple(last_output)
        self.told = told
        super().__init__(message)


class NodeRefused(LaunchError):
    """A node could not be configured or activated."""

    exit_code: ClassVar[int] = 2


class Interrupted(LaunchError):
    """The user ended the launch; every node was stopped and the bag closed.

    Parameters
    ----------
    number
        The signal: SIGINT or SIGTERM.
    """

    def __init__(self, number: int) -> None:
        self.exit_code = 128 + number  # type: ignore[misc]  # as a shell reports it
        super().__init__(f"ended by {signal.Signals(number).name}")
