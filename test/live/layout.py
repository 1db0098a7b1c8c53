"""The Foxglove layout, and what its panels show of a recorded bag."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from spacecraft_gnc.recording.bag import open_bag

NAME = "spacecraft_gnc.foxglove-layout.json"
LAYOUT = json.loads((Path(__file__).parents[2] / "config" / NAME).read_text())
PANELS: dict[str, Any] = LAYOUT["configById"]


def paths(config: dict[str, Any]) -> Iterator[str]:
    """Yield the message paths of one panel."""
    yield from (series["value"] for series in config.get("paths", ()))
    yield from config.get("topics", {})
    if "topicPath" in config:
        yield config["topicPath"]


def shown(bag: Path) -> dict[str, dict[str, list[tuple[float, Any]]]]:
    """Return (header stamp [s], value) of each path of each panel, as the app reads the bag.

    Of a path that ends at a topic, the value is the message; without a header, the stamp is NaN.
    """
    wanted = {path.partition(".")[0] for config in PANELS.values() for path in paths(config)}
    with open_bag(bag) as opened:
        messages: dict[str, list[Any]] = {topic: [] for topic in wanted}
        for topic, data in opened.messages(wanted):
            messages[topic].append(opened.decode(topic, data))
    return {
        name: {path: [_point(m, path) for m in messages[path.partition(".")[0]]] for path in all_}
        for name, all_ in ((name, list(paths(config))) for name, config in PANELS.items())
    }


def _point(message: Any, path: str) -> tuple[float, Any]:
    value = message
    for name in path.split(".")[1:]:
        value = getattr(value, name)
    header = getattr(message, "header", None)
    stamp = float("nan") if header is None else header.stamp.sec + 1e-9 * header.stamp.nanosec
    return stamp, value


def require_filled(bag: Path) -> None:
    """Check that whoever opens a bag with the layout sees something in every panel.

    Each curve has a finite number at a header stamp of its own for every message.
    """
    for name, series in shown(bag).items():
        for path, points in series.items():
            assert points, f"{name}: no message for {path}"
            if "." in path:
                stamps, values = np.array(points, dtype=float).T
                assert np.unique(stamps).size == len(points) > 10, f"{name}: {path}"
                assert np.isfinite(values).all(), f"{name}: {path}"
