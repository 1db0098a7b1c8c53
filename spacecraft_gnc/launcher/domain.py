"""ROS domains on this machine: which are in use, by whom, and which is free.

A running graph holds two locks: ``graph`` by its launcher, ``clock`` by its plant. They are
advisory file locks in the temporary folder, which the system releases when a process dies, and
belong to the open file description (`man fcntl`): unlike flock locks, they can be queried without
being acquired, so a query is never mistaken for a graph and never blocks one.
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
# ports of Linux. Domain 0 is the default of ROS 2, so it is not used.
_FREE_DOMAINS: Final = range(1, 102)
_PORT_BASE: Final = 7400
_PORTS_PER_DOMAIN: Final = 250
_FIRST_PARTICIPANT: Final = 10
_FLOCK: Final = "hhqqi4x"  # struct flock: type, whence, start, length, process
_WHOLE_FILE: Final = struct.pack(_FLOCK, fcntl.F_WRLCK, os.SEEK_SET, 0, 0, 0)


class DomainTaken(LaunchError):
    """Another graph runs on the requested domain."""

    exit_code: ClassVar[int] = 2


class Graph(NamedTuple):
    """A graph running on this machine."""

    domain_id: int
    about: dict[str, Any]
    """What its holder wrote down: pid, scenario, ..."""


class DomainLock:
    """A held lock, released by `release` or by the end of the process."""

    def __init__(self, kind: str, domain_id: int, descriptor: int) -> None:
        self.kind = kind
        self.domain_id = domain_id
        self._descriptor = descriptor

    def release(self) -> None:
        """Release the lock; a second call does nothing."""
        if self._descriptor >= 0:
            os.close(self._descriptor)  # keep the file: removing it would race with a new holder
            self._descriptor = -1


def claim(kind: str, domain_id: int, about: Mapping[str, Any]) -> DomainLock:
    """Acquire the lock of a kind on a domain.

    Raises
    ------
    DomainTaken
        If another process holds it; the message names that process.
    """
    lock = _try_claim(kind, domain_id, about)
    if lock is None:
        raise DomainTaken(_refusal(domain_id, _read(_path(kind, domain_id))))
    return lock


def claim_given(domain_id: int, about: Mapping[str, Any]) -> DomainLock:
    """Reserve a domain for a graph, unless another graph or a single plant uses it.

    Raises
    ------
    DomainTaken
        If the domain is in use.
    """
    lock = claim(GRAPH, domain_id, about)
    try:
        claim(CLOCK, domain_id, about).release()
    except DomainTaken:
        lock.release()
        raise
    return lock


def claim_free(about: Mapping[str, Any]) -> DomainLock:
    """Reserve a domain that no process of any user uses.

    Raises
    ------
    LaunchError
        If every domain is in use.
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
    """Graphs of this user that currently hold a domain."""
    for path in sorted(_folder().glob(f"{GRAPH}_*.lock")):
        if _is_held(path):
            yield Graph(int(path.stem.removeprefix(f"{GRAPH}_")), _read(path))


def about(domain_id: int) -> dict[str, Any]:
    """Return what the launcher of a running graph wrote down; nothing where none holds it."""
    return next((graph.about for graph in running_graphs() if graph.domain_id == domain_id), {})


def _try_claim(kind: str, domain_id: int, about: Mapping[str, Any]) -> DomainLock | None:
    descriptor = os.open(_path(kind, domain_id), os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
    try:
        fcntl.fcntl(descriptor, fcntl.F_OFD_SETLK, _WHOLE_FILE)
    except (BlockingIOError, PermissionError):  # POSIX allows either
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
    except (OSError, ValueError):  # the holder is writing it
        return {}
    return about if isinstance(about, dict) else {}


def _refusal(domain_id: int, about: Mapping[str, Any]) -> str:
    holder = ", ".join(f"{key} {value}" for key, value in about.items()) or "another process"
    return (
        f"ROS_DOMAIN_ID: received {domain_id}, where another graph runs ({holder}); required a "
        "domain of its own; end that graph, or name no domain to take a free one"
    )


def _ports_free(domain_id: int) -> bool:
    """Whether no DDS program listens on the domain as its first participant."""
    port = _PORT_BASE + _PORTS_PER_DOMAIN * domain_id + _FIRST_PARTICIPANT
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind(("", port))
        except OSError:
            return False
    return True
