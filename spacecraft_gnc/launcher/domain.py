"""ROS domains on this machine: which are taken, by whom, and which is free.

A graph holds two locks while it lives: ``graph`` by its launcher, ``clock`` by its plant. Locks are
advisory file locks in the temporary folder, so that a process that dies gives them back. They are
locks of the open file description (`man fcntl`): unlike those of flock, they can be asked for
without being taken, so that who only looks is never seen as a graph, nor keeps one away.
"""

from __future__ import annotations

import fcntl
import json
import os
import socket
import struct
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, ClassVar, Final, NamedTuple

from spacecraft_gnc.errors import LaunchError

GRAPH: Final = "graph"
CLOCK: Final = "clock"
# RTPS 2.3, 9.6.1.1: ports 7400 + 250 d + offset. Up to domain 101 they stay below the ephemeral
# ports of Linux. Domain 0 is everybody's default, so it is left alone.
_FREE_DOMAINS: Final = range(1, 102)
_PORT_BASE: Final = 7400
_PORTS_PER_DOMAIN: Final = 250
_FIRST_PARTICIPANT: Final = 10
_FLOCK: Final = "hhqqi4x"  # struct flock: type, whence, start, length, process
_WHOLE_FILE: Final = struct.pack(_FLOCK, fcntl.F_WRLCK, os.SEEK_SET, 0, 0, 0)


class DomainTaken(LaunchError):
    """Another graph lives on the domain asked for."""

    exit_code: ClassVar[int] = 2


class Graph(NamedTuple):
    """A graph that runs on this machine now."""

    domain_id: int
    about: dict[str, Any]
    """What its holder wrote down: pid, scenario, ..."""


class DomainLock:
    """A held lock; give it back with `release`, or by the end of the process."""

    def __init__(self, kind: str, domain_id: int, descriptor: int) -> None:
        self.kind = kind
        self.domain_id = domain_id
        self._descriptor = descriptor

    def release(self) -> None:
        """Give the lock back. Doing so twice does nothing."""
        if self._descriptor >= 0:
            os.close(self._descriptor)  # the file stays: removing it would race with a new holder
            self._descriptor = -1


def claim(kind: str, domain_id: int, about: Mapping[str, Any]) -> DomainLock:
    """Take the lock of a kind on a domain.

    Raises
    ------
    DomainTaken
        Another process holds it; the message names that process.
    """
    lock = _try_claim(kind, domain_id, about)
    if lock is None:
        raise DomainTaken(_refusal(domain_id, _read(_path(kind, domain_id))))
    return lock


def claim_given(domain_id: int, about: Mapping[str, Any]) -> DomainLock:
    """Take a domain for a graph; refuse it where another graph or a lone plant lives.

    Raises
    ------
    DomainTaken
        The domain is in use.
    """
    lock = claim(GRAPH, domain_id, about)
    try:
        claim(CLOCK, domain_id, about).release()
    except DomainTaken:
        lock.release()
        raise
    return lock


def claim_free(about: Mapping[str, Any]) -> DomainLock:
    """Take a domain on which nothing lives, whoever it is.

    Raises
    ------
    LaunchError
        Every domain is taken.
    """
    for domain_id in _FREE_DOMAINS:
        if not _ports_free(domain_id):
            continue
        try:
            return claim_given(domain_id, about)
        except DomainTaken:
            continue
    raise LaunchError(
        f"ROS_DOMAIN_ID: every domain from {_FREE_DOMAINS[0]} to {_FREE_DOMAINS[-1]} is in use; "
        "required a free one; end other graphs, or give one with --set launcher.domain_id=N"
    )


def running_graphs() -> Iterator[Graph]:
    """Graphs of this user that hold a domain now."""
    for path in sorted(_folder().glob(f"{GRAPH}_*.lock")):
        if _is_held(path):
            yield Graph(int(path.stem.removeprefix(f"{GRAPH}_")), _read(path))


def _try_claim(kind: str, domain_id: int, about: Mapping[str, Any]) -> DomainLock | None:
    descriptor = os.open(_path(kind, domain_id), os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
    try:
        fcntl.fcntl(descriptor, fcntl.F_OFD_SETLK, _WHOLE_FILE)
    except (BlockingIOError, PermissionError):  # POSIX leaves open which
        os.close(descriptor)
        return None
    os.ftruncate(descriptor, 0)
    os.pwrite(descriptor, json.dumps({"pid": os.getpid(), **about}).encode(), 0)
    return DomainLock(kind, domain_id, descriptor)


def _is_held(path: Path) -> bool:
    with path.open("rb") as file:
        answer = fcntl.fcntl(file, fcntl.F_OFD_GETLK, _WHOLE_FILE)
    return bool(struct.unpack(_FLOCK, answer)[0] != fcntl.F_UNLCK)


def _path(kind: str, domain_id: int) -> Path:
    return _folder() / f"{kind}_{domain_id}.lock"


def _folder() -> Path:
    folder = Path(tempfile.gettempdir()) / f"spacecraft_gnc-{os.getuid()}"
    folder.mkdir(mode=0o700, exist_ok=True)
    return folder


def _read(path: Path) -> dict[str, Any]:
    try:
        about = json.loads(path.read_text())
    except (OSError, ValueError):  # the holder is just writing it
        return {}
    return about if isinstance(about, dict) else {}


def _refusal(domain_id: int, about: Mapping[str, Any]) -> str:
    holder = ", ".join(f"{key} {value}" for key, value in about.items()) or "another process"
    return (
        f"ROS_DOMAIN_ID: received {domain_id}, where another graph runs ({holder}); required a "
        "domain of its own; end that graph, or name no domain to take a free one"
    )


def _ports_free(domain_id: int) -> bool:
    """Whether no first participant of any DDS program listens on the domain."""
    port = _PORT_BASE + _PORTS_PER_DOMAIN * domain_id + _FIRST_PARTICIPANT
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind(("", port))
        except OSError:
            return False
    return True
