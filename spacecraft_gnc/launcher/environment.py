"""Environment variables that ROS 2 processes of ours start with."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Mapping, MutableMapping
from pathlib import Path
from typing import ClassVar, Final

from spacecraft_gnc.errors import LaunchError

DOMAIN_ID: Final = "ROS_DOMAIN_ID"
SUPERVISED: Final = "SPACECRAFT_GNC_SUPERVISED"
"""Set for a node that the launcher started: the end of its standard input ends the node."""
TELL_WHERE: Final = signal.SIGUSR1
"""Makes a node that the launcher started write to its log where every thread is."""
_LARGEST_DOMAIN = 232  # UDP ports end at 65535
_DISCOVERY_RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
_PROFILES = ("FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE")
_TRANSPORTS = "FASTDDS_BUILTIN_TRANSPORTS"
_MIDDLEWARE = "RMW_IMPLEMENTATION"
_INDEX = Path("share", "ament_index", "resource_index", "rmw_typesupport")
_SELECTOR = "rmw_implementation"  # listed there, and loads one of the others
_FOLDER = Path(__file__).parent.parent / "nodes"
_ON_THIS_MACHINE = _FOLDER / "fastdds_profile.xml"
_FARTHER = _FOLDER / "fastdds_discovery.xml"
# The ROS wheels set both or neither; a process with the first alone cannot import rclpy.
_BOOTSTRAPPED = "_ROS_WHEELS_BOOTSTRAP_COMPLETE"
_LIBRARY_PATH = "LD_LIBRARY_PATH"


class MiddlewareMissing(LaunchError):
    """RMW_IMPLEMENTATION names no middleware that is installed."""

    exit_code: ClassVar[int] = 2


class DomainRefused(LaunchError):
    """ROS_DOMAIN_ID is no domain."""

    exit_code: ClassVar[int] = 2


def prepare(environment: MutableMapping[str, str]) -> None:
    """Keep a process of ours on this machine, and easy to find and to kill, unless told not to.

    rmw_fastrtps forces shared memory upon the range LOCALHOST, whatever a profile says. Shared
    memory does not survive a kill (see ``fastdds_profile.xml``), so the loopback device is asked
    for by a profile, and the range left to it.
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
    """Refuse a middleware that is not installed: rclpy would end the process when imported.

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
    """Return the domain that an environment asks for; 0 by default.

    Raises
    ------
    DomainRefused
        ROS_DOMAIN_ID holds no admissible number.
    """
    text = environment.get(DOMAIN_ID) or "0"
    if not text.isdecimal() or int(text) > _LARGEST_DOMAIN:
        raise DomainRefused(
            f"{DOMAIN_ID}: received {text!r}; required 0 to {_LARGEST_DOMAIN}; correct or unset it"
        )
    return int(text)


def for_node(base: Mapping[str, str], domain_id: int) -> dict[str, str]:
    """Return the environment of a node process on a domain."""
    environment = dict(base)
    prepare(environment)
    environment[DOMAIN_ID] = str(domain_id)
    environment[SUPERVISED] = "1"
    environment["PYTHONUNBUFFERED"] = "1"  # a log shows the last words of a killed node
    if _LIBRARY_PATH not in environment:
        environment.pop(_BOOTSTRAPPED, None)
    return environment
