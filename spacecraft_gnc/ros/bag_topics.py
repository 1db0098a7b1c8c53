"""Topic definitions for a bag: types, schemas and quality of service."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from pathlib import Path

from rclpy.utilities import get_rmw_implementation_identifier

from spacecraft_gnc.recording.qos import qos_yaml
from spacecraft_gnc.recording.schema_text import InstalledInterfaces, schema_text
from spacecraft_gnc.recording.writer import BagWriter
from spacecraft_gnc.ros.parameters import parameter_files
from spacecraft_gnc.scenario import Fleet
from spacecraft_gnc.scenario.provenance import version_of
from spacecraft_gnc.signals.qos import QosProfile

_WHEEL = "ros-jazzy-rclpy"  # as PyPI has it; ROS 2 itself calls it rclpy


def announce(
    bag: BagWriter, name: str, type_name: str, offered: Iterable[QosProfile], *, gapless: bool
) -> None:
    """Add a topic to a bag, with its definition as installed on this machine.

    Parameters
    ----------
    bag
        Where to.
    name
        Full name.
    type_name
        ``pkg/msg/Type``.
    offered
        Profiles of its publishers.
    gapless
        Whether a control step without a message is a loss.

    Raises
    ------
    RecordingError
        If the definition is not installed.
    """
    interfaces = InstalledInterfaces(prefixes())
    bag.add_topic(
        name,
        type_name,
        schema_text(type_name, interfaces.definition),
        qos_yaml=qos_yaml(*offered),
        type_hash=interfaces.type_hash(type_name),
        gapless=gapless,
    )


def scenario_text(fleet: Fleet) -> bytes:
    """Return the parameter file that flies, comments and all; without one, its contents."""
    files = list(parameter_files(sys.argv))
    return files[0].read_bytes() if len(files) == 1 else fleet.to_yaml().encode()


def middleware() -> dict[str, str]:
    """Return versions that only a node knows."""
    return {
        "rclpy": version_of(_WHEEL) or version_of("rclpy"),
        "rmw": get_rmw_implementation_identifier(),
    }


def prefixes() -> list[Path]:
    """Install prefixes: sourced workspaces, then the environment of this interpreter."""
    listed = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    return [Path(entry) for entry in (*listed, sys.prefix) if entry]
