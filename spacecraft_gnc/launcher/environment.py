"""Environment variables that ROS 2 processes of ours start with."""

from __future__ import annotations

from collections.abc import Mapping, MutableMapping
from pathlib import Path
from typing import Final

from spacecraft_gnc.errors import LaunchError

DOMAIN_ID: Final = "ROS_DOMAIN_ID"
SUPERVISED: Final = "SPACECRAFT_GNC_SUPERVISED"
"""Set for a node that the launcher started: the end of its standard input ends the node."""
_LARGEST_DOMAIN = 232  # UDP ports end at 65535
_DISCOVERY_RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
_PROFILES = ("FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE")
# A process killed while it holds a lock in shared memory can block those that share it, and leaves
# its segments behind; on the loopback device UDP was measured to be as fast.
_TRANSPORTS = ("FASTDDS_BUILTIN_TRANSPORTS", "UDPv4")
_PROFILE_FILE = Path(__file__).parent.parent / "nodes" / "fastdds_profile.xml"
# The ROS wheels set both or neither; a process with the first alone cannot import rclpy.
_BOOTSTRAPPED = "_ROS_WHEELS_BOOTSTRAP_COMPLETE"
_LIBRARY_PATH = "LD_LIBRARY_PATH"


def prepare(environment: MutableMapping[str, str]) -> None:
    """Keep a process of ours on this machine, and easy to find and to kill, unless told not to."""
    environment.setdefault(_DISCOVERY_RANGE, "LOCALHOST")
    environment.setdefault(*_TRANSPORTS)
    if not any(name in environment for name in _PROFILES):
        environment[_PROFILES[0]] = str(_PROFILE_FILE)


def domain_id(environment: Mapping[str, str]) -> int:
    """Return the domain that an environment asks for; 0 by default.

    Raises
    ------
    LaunchError
        ROS_DOMAIN_ID holds no admissible number.
    """
    text = environment.get(DOMAIN_ID) or "0"
    if not text.isdecimal() or int(text) > _LARGEST_DOMAIN:
        raise LaunchError(
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
