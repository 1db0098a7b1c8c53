"""Environment variables of the ROS 2 processes."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Mapping, MutableMapping
from pathlib import Path
from typing import ClassVar, Final

from spacecraft_gnc.errors import LaunchError
from spacecraft_gnc.signals.seal import KEY, OFF

DOMAIN_ID: Final = "ROS_DOMAIN_ID"
SUPERVISED: Final = "SPACECRAFT_GNC_SUPERVISED"
"""Set for a node that the launcher started: the end of its standard input ends the node."""
LOG: Final = "SPACECRAFT_GNC_LOG"
"""Where a node that the launcher started writes once the launcher has gone."""
MEMORY: Final = "SPACECRAFT_GNC_MEMORY"
"""Descriptor of the open file in which a node's memory outlives its process."""
TELL_WHERE: Final = signal.SIGUSR1
"""Makes a node that the launcher started write to its log where every thread is."""
_LARGEST_DOMAIN = 232  # UDP ports end at 65535
_DISCOVERY_RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
_PROFILES = ("FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE")
_TRANSPORTS = "FASTDDS_BUILTIN_TRANSPORTS"
_MIDDLEWARE = "RMW_IMPLEMENTATION"
_INDEX = Path("share", "ament_index", "resource_index", "rmw_typesupport")
_SELECTOR = "rmw_implementation"  # listed among them, but only loads one of the others
_FOLDER = Path(__file__).parent.parent / "nodes"
_ON_THIS_MACHINE = _FOLDER / "fastdds_profile.xml"
_FARTHER = _FOLDER / "fastdds_discovery.xml"
# The ROS wheels set both or neither; a process with only the first cannot import rclpy.
_BOOTSTRAPPED = "_ROS_WHEELS_BOOTSTRAP_COMPLETE"
_LIBRARY_PATH = "LD_LIBRARY_PATH"


class MiddlewareMissing(LaunchError):
    """RMW_IMPLEMENTATION names a middleware that is not installed."""

    exit_code: ClassVar[int] = 2


class DomainRefused(LaunchError):
    """ROS_DOMAIN_ID is not a valid domain."""

    exit_code: ClassVar[int] = 2


def prepare(environment: MutableMapping[str, str]) -> None:
    """Restrict discovery to this machine by default, by a profile without shared memory.

    rmw_fastrtps forces shared memory for the range LOCALHOST, whatever the profile says. A killed
    process can block others that share its memory (see ``fastdds_profile.xml``), so the profile
    selects the loopback device and determines the range.
    """
    if any(environment.get(name) for name in _PROFILES):
        environment.setdefault(_DISCOVERY_RANGE, "LOCALHOST")
    elif environment.get(_DISCOVERY_RANGE, "LOCALHOST") == "LOCALHOST":
        environment[_DISCOVERY_RANGE] = "SYSTEM_DEFAULT"
        environment[_PROFILES[0]] = str(_ON_THIS_MACHINE)
    else:
        environment.setdefault(_TRANSPORTS, "UDPv4")
        environment[_PROFILES[0]] = str(_FARTHER)


def require_middleware(environment: Mapping[str, str]) -> None:
    """Refuse a missing middleware, because importing rclpy would then end the process.

    Raises
    ------
    MiddlewareMissing
        If RMW_IMPLEMENTATION names one that no install prefix lists.
    """
    wanted = environment.get(_MIDDLEWARE)
    prefixes = [*environment.get("AMENT_PREFIX_PATH", "").split(os.pathsep), sys.prefix]
    found = {file.name for prefix in prefixes if prefix for file in Path(prefix, _INDEX).glob("*")}
    installed = sorted(found - {_SELECTOR})
    if wanted and installed and wanted not in installed:
        raise MiddlewareMissing(
            f"{_MIDDLEWARE}: received {wanted!r}; required a middleware that is installed "
            f"({', '.join(installed)}); unset it, or install {wanted}"
        )


def domain_id(environment: Mapping[str, str]) -> int:
    """Return the domain requested by an environment; 0 by default.

    Raises
    ------
    DomainRefused
        If ROS_DOMAIN_ID is not a valid number.
    """
    text = environment.get(DOMAIN_ID) or "0"
    if not text.isdecimal() or int(text) > _LARGEST_DOMAIN:
        raise DomainRefused(
            f"{DOMAIN_ID}: received {text!r}; required 0 to {_LARGEST_DOMAIN}; correct or unset it"
        )
    return int(text)


def for_node(base: Mapping[str, str], domain_id: int, key: bytes = b"") -> dict[str, str]:
    """Return the environment of a node process on a domain, of the flight that has a key."""
    environment = dict(base)
    environment[KEY] = key.hex() or OFF
    prepare(environment)
    environment[DOMAIN_ID] = str(domain_id)
    environment[SUPERVISED] = "1"
    environment.pop(MEMORY, None)
    environment["PYTHONUNBUFFERED"] = "1"  # keeps the last output of a killed node
    if _LIBRARY_PATH not in environment:
        environment.pop(_BOOTSTRAPPED, None)
    return environment
