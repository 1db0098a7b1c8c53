"""Namespaces of the spacecraft in a recording."""

from __future__ import annotations

from pathlib import Path

from spacecraft_gnc.analysis.reader import is_npz
from spacecraft_gnc.loop.flight import agents_in
from spacecraft_gnc.recording.bag import open_bag
from spacecraft_gnc.recording.steps import flight_namespaces
from spacecraft_gnc.vehicles.known_signals import state_signals


def agents(
    path: Path, namespace: str | None = None, *, allow_unfinished: bool = False
) -> tuple[str | None, ...]:
    """Return the namespaces to read, one after the other.

    Parameters
    ----------
    path
        Bag folder, .mcap file, or .npz file of ``gnc simulate``.
    namespace
        The only one asked for; None: all.
    allow_unfinished
        As of `open_bag`.

    Returns
    -------
    tuple
        Without slashes; (None,) where there is one spacecraft, or whoever reads it says why not.

    Raises
    ------
    RecordingError
        If there is no readable bag.
    """
    if namespace is not None:
        return (namespace,)
    if is_npz(path):
        known = agents_in(path)
        return known if len(known) > 1 else (None,)
    with open_bag(path, allow_unfinished=allow_unfinished) as bag:
        found = flight_namespaces(bag, state_signals())
    return tuple(name.strip("/") for name in found) if len(found) > 1 else (None,)
