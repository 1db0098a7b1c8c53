"""What a flight under attack is compared with: the same flight without ROS, and its own log."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

import numpy as np
from hostile_flight import NODES, PERIOD, ROOT, SCENARIO, Flight
from hostile_side import Side

sys.path[:0] = [str(ROOT), str(ROOT / "test")]

from graph.comparison import compared  # noqa: E402

from spacecraft_gnc.analysis.audit import audit_bag  # noqa: E402
from spacecraft_gnc.analysis.reader import read_flight  # noqa: E402
from spacecraft_gnc.errors import GncError  # noqa: E402
from spacecraft_gnc.recording.bag import open_bag  # noqa: E402
from spacecraft_gnc.recording.rebuild import rebuild  # noqa: E402
from spacecraft_gnc.ros.graph_of import signals_of  # noqa: E402
from spacecraft_gnc.scenario import load, load_fleet  # noqa: E402
from spacecraft_gnc.signals.graph import CLOCK, RECORDER  # noqa: E402

_REJECTED: Final = "rejected "
_DEEP: Final = 1000  # messages that DDS keeps
_TRACES: Final = ("Traceback", "terminate called", "Segmentation", "Fatal Python error")


def differing(bag: Path, changes: Sequence[str] = ()) -> tuple[int, list[str]]:
    """Compare a bag with `gnc simulate`, to the last bit, as far as the bag goes.

    Returns
    -------
    steps, names
        Control steps compared, and the columns that differ or lack a step, or why it is unreadable.
    """
    try:
        own = read_flight(bag, allow_unfinished=True).trajectory
    except GncError as error:
        return 0, [f"unreadable bag ({str(error).rpartition(f'{bag.name}: ')[2][:160]})"]
    steps = max(len(own.torque), 1)
    others = [change for change in changes if not change.startswith("plant.duration=")]
    simulated = load(SCENARIO, [*others, f"plant.duration={steps * PERIOD!r}"]).build().run()
    names = []
    for name in compared(simulated):
        ours, theirs = (np.asarray(getattr(flight, name)) for flight in (own, simulated))
        n = min(len(ours), len(theirs)) if ours.ndim else 1
        ours, theirs = (np.atleast_1d(values)[:n] for values in (ours, theirs))
        # a step without a solve has no residual: NaN on both sides
        if n < min(steps, len(np.atleast_1d(theirs))) or not np.array_equal(
            ours, theirs, equal_nan=ours.dtype.kind == "f"
        ):
            names.append(name)
    return steps, names


def audit_failures(bag: Path, *, unfinished: bool = False) -> str:
    """Return why an audit of a bag fails; empty: it passes."""
    try:
        audit = audit_bag(bag, allow_unfinished=unfinished)
    except GncError as error:
        return str(error)
    return "" if audit.first is None else f"{audit.first[0].name}: {audit.first[1]}"[:300]


def recovered(bag: Path) -> tuple[Path, str]:
    """Return a bag that can be read, and whether it is ``whole`` or ``recovered``.

    Raises
    ------
    GncError
        If neither can be had.
    """
    if (bag / "metadata.yaml").exists():
        with open_bag(bag):
            return bag, "whole"
    return rebuild(bag).folder, "recovered"


def last_step(bag: Path) -> int:
    """Return the last step whose state is in a bag."""
    return len(read_flight(bag, allow_unfinished=True).trajectory.torque)


def traces(flight: Flight) -> list[str]:
    """Return the nodes, or the launcher, that tell of a defect of theirs."""
    texts = {name: flight.log(name) for name in NODES}
    texts["launcher"] = flight.errors.text + flight.output.text
    return [name for name, text in texts.items() if any(trace in text for trace in _TRACES)]


def refused(side: Side) -> Counter[tuple[str, str]]:
    """Return how many messages each (node, topic) says that it refused, as it told last."""
    found: Counter[tuple[str, str]] = Counter()
    for node, values in {told["node"]: told["values"] for told in side.said("diagnostic")}.items():
        for key, count in values.items():
            if key.startswith(_REJECTED):
                topic = key.removeprefix(_REJECTED).rpartition("/")[0].strip("/")
                found[node, topic] += int(count)
    return found


def refusals_due(sent: Mapping[str, int]) -> dict[tuple[str, str], int]:
    """Return how many refusals each (node, topic) owes for messages sent, by topic.

    Each node that hears a topic refuses each of its messages, but for two kinds of topics that are
    left out: those of which DDS keeps only the last few, so that nobody knows how many arrive, and
    targets at the recorder, which records what users sent, good or bad.
    """
    due: dict[tuple[str, str], int] = {}
    for _, signal in signals_of(load_fleet(SCENARIO)):
        topic = signal.name.strip("/")
        heard = [
            *signal.subscribers,
            *([RECORDER] if signal.recorded and signal.publishers else []),
        ]
        if signal.qos.depth >= _DEEP and topic != CLOCK.name.strip("/"):
            due |= {(node, topic): sent.get(topic, 0) for node in heard}
    recorded = sent.get(CLOCK.name.strip("/"), 0)
    return due | ({(RECORDER, "clock"): recorded} if recorded else {})
