"""Everything that is pinned of a shipped scenario: its arrays, its bag, and what `gnc` tells."""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import os
import subprocess
import sys
from collections import defaultdict
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from pinned import records
from pinned.machine import fingerprint
from rosbags.highlevel import AnyReader

from spacecraft_gnc.cli.main import main
from spacecraft_gnc.scenario import load_fleet

ROOT = Path(__file__).resolve().parents[2]
SHIPPED = sorted(path.stem for path in (ROOT / "config").glob("*.yaml"))

_WALL_ARRAYS = frozenset({"solve_time"})
_WALL_TOPICS = frozenset({"/wall_timing"})
_WALL_FIELDS = frozenset({"wall_solve_time", "wall_deadline_slack", "wall_decision_time"})
BY_SETS = frozenset(
    f"afrl_docking{which}" for which in ("", "_noise", "_thruster_failed", "_tilted")
)
"""Scenarios whose governor has admissible sets. Rounding decides which of their nearly parallel
rows are removed as redundant, and so by up to a hundredth how the reference moves: on a machine
that computes otherwise these flights agree in the large only."""
_ROUGHLY_EQUAL = ("constraints_kept", "phase", "thruster_lost", "thruster_loss_detected_at")
_ROUGHLY_TOLD = {
    "simulate": _ROUGHLY_EQUAL,
    "launch": (*_ROUGHLY_EQUAL, "missing_steps", "messages_lost"),
    "audit": ("steps", "passed"),
}
"""Values that commands tell of such a flight on every machine."""
_TEXT = "|u1"
"""Type of the record of a text."""
_ACTIVE = ("active_rows", "active_ahead", "multipliers")
"""Fields of the active rows of an admissible set, of which nearly parallel ones are many."""
_OMITTED = frozenset(
    {
        *(f"solve_time_{part}" for part in ("median", "p99", "max")),
        *(f"latency_{part}" for part in ("median", "p99", "max")),
        *("wall_time", "startup_time", "steps_per_second", "domain_id", "bytes", "warnings"),
        *("scenario", "out", "path", "bag", "bags", "source", "files", "logs", "wall_timing"),
    }
)
"""Keys of wall time, paths and sizes of files: their values are not pinned, their presence is."""


def told(*argv: str) -> records.Record:
    """Return what ``gnc ARGV --json`` prints, as a record."""
    stream = io.StringIO()
    with contextlib.redirect_stdout(stream):
        try:
            main([*argv, "--json", "--quiet"])
        except SystemExit as end:
            if end.code:
                raise RuntimeError(f"gnc {' '.join(argv)}: exit code {end.code}") from end
    return records.of_json(json.loads(stream.getvalue()), _OMITTED)


def simulated(name: str, folder: Path) -> dict[str, Any]:
    """Fly a scenario without ROS; return its arrays and what `simulate` and `check` tell."""
    file = folder / f"{name}.npz"
    summary = told("simulate", name, "--out", str(file))
    with np.load(file) as arrays:
        kept = [key for key in arrays.files if arrays[key].dtype.kind != "U"]
        flown = {key: records.of_array(arrays[key]) for key in kept if _is_pinned(key)}
    told_of = {"simulate": summary, "check": told("check", name)}
    return {"machine": fingerprint(), "arrays": flown, "json": told_of}


def _is_pinned(key: str) -> bool:
    """Tell whether an array, perhaps of one agent of several, is none of wall time."""
    return key.rpartition(".")[2] not in _WALL_ARRAYS


def recorded(name: str, folder: Path) -> dict[str, Any]:
    """Fly a scenario as a graph in one process; return its bag and what commands tell of it."""
    run = folder / name
    summary = _launch(name, run)
    told_of = {
        "launch": summary,
        "audit": told("audit", str(run)),
        "report": told("report", str(run), "--out", str(folder / f"{name}.html")),
    }
    exported: list[str] = []
    for agent, scenario in load_fleet(name).agents.items():
        one, prefix = (["--namespace", agent], f"{agent} ") if agent else ([], "")
        export = folder / f"{name}-{agent}.npz"
        method = scenario.controller.method
        told_of[f"{prefix}replay"] = told("replay", str(run), "--method", method, *one)
        target = ["--format", "npz", "--out", str(export)]
        told_of[f"{prefix}export"] = told("export", str(run), *target, *one)
        with np.load(export) as arrays:
            exported += sorted(f"{prefix}{key}" for key in arrays.files)
    topics = of_bag(run / "bag")
    return {"machine": fingerprint(), "topics": topics, "exported": exported, "json": told_of}


def _launch(name: str, run: Path) -> records.Record:
    command = [sys.executable, "-m", "spacecraft_gnc", "launch", name, "--composed", "--json"]
    alone = {key: value for key, value in os.environ.items() if key != "ROS_DOMAIN_ID"}
    done = subprocess.run(
        [*command, "--out", str(run)], cwd=ROOT, env=alone, stdout=subprocess.PIPE, check=True
    )
    return records.of_json(json.loads(done.stdout), _OMITTED)


def of_bag(bag: Path) -> dict[str, Any]:
    """Return type, payloads and fields of each topic; the fields survive the addition of one."""
    payloads: dict[str, list[bytes]] = defaultdict(list)
    fields: dict[str, dict[str, list[Any]]] = defaultdict(lambda: defaultdict(list))
    types = {}
    with AnyReader([bag]) as reader:
        for connection, _, data in reader.messages():
            topic = connection.topic
            if topic in _WALL_TOPICS:
                continue
            types[topic] = connection.msgtype
            message = reader.deserialize(data, connection.msgtype)
            walls = 8 * sum(hasattr(message, field) for field in _WALL_FIELDS)  # they come last
            payloads[topic].append(bytes(data)[: len(data) - walls])
            for path, value in _fields(message, ""):
                fields[topic][path].append(value)
    return {
        topic: {
            "type": types[topic],
            "messages": len(payloads[topic]),
            "payloads": hashlib.sha256(b"".join(payloads[topic])).hexdigest()[:16],
            "fields": {path: _of_field(values) for path, values in fields[topic].items()},
        }
        for topic in sorted(types)
    }


def _fields(message: Any, path: str) -> Iterator[tuple[str, Any]]:
    for name in message.__dataclass_fields__:
        value, inner = getattr(message, name), f"{path}.{name}" if path else name
        if name.startswith("_") or name in _WALL_FIELDS:
            continue
        if hasattr(value, "__dataclass_fields__"):
            yield from _fields(value, inner)
        elif isinstance(value, list):
            for item in value:
                is_message = hasattr(item, "__dataclass_fields__")
                yield from _fields(item, f"{inner}[]") if is_message else [(f"{inner}[]", item)]
        else:
            yield inner, value


def _of_field(values: list[Any]) -> records.Record:
    if isinstance(values[0], str):
        text = "\0".join(values).encode()
        return records.of_array(np.frombuffer(text, dtype=np.uint8))
    arrays = [np.asarray(value) for value in values]
    same = len({array.shape for array in arrays}) == 1
    return records.of_array(np.array(arrays) if same else np.concatenate(arrays))


def differences(name: str, was: dict[str, Any], found: dict[str, Any]) -> list[str]:
    """Return one line for each thing that is another than the stored one."""
    exact = was["machine"] == found["machine"]
    if not exact and name in BY_SETS:
        return [f"{name}: {line}" for line in _rough_differences(was, found)]
    lines = [*_told_differences(was["json"], found["json"], exact)]
    if "arrays" in was:
        lines += _array_differences("", was["arrays"], found["arrays"], exact)
    if "topics" in was:
        lines += _bag_differences(was["topics"], found["topics"], exact)
        exported = records.key_differences(was["exported"], found["exported"])
        lines += [f"gnc export: {line}" for line in exported]
    return [f"{name}: {line}" for line in lines]


def _rough_differences(was: dict[str, Any], found: dict[str, Any]) -> Iterator[str]:
    """Yield what is another in the large of a flight that is decided by rounding errors."""
    for command, keys in _ROUGHLY_TOLD.items():
        ours, theirs = (each["json"].get(command, {}) for each in (found, was))
        for key in [key for key in keys if key in theirs]:
            if ours.get(key) != theirs[key]:
                yield f"gnc {command} --json: {key} {ours.get(key)!r}; pinned {theirs[key]!r}"
    ours, theirs = _rough_arrays(found), _rough_arrays(was)
    yield from records.key_differences(theirs, ours)
    for key in [key for key in theirs if key in ours]:
        yield from records.rough_differences(key, theirs[key], ours[key])


def _rough_arrays(of: dict[str, Any]) -> dict[str, Any]:
    """Return the arrays of a flight, or the fields of its bag, without the names of active rows."""
    topics = of.get("topics", {})
    fields = {
        f"{topic} {path}": record
        for topic in topics
        for path, record in topics[topic]["fields"].items()
        if record["dtype"] != _TEXT and path not in _ACTIVE
    }
    return {**of.get("arrays", {}), **fields}


def _told_differences(was: Any, found: Any, exact: bool) -> Iterator[str]:
    yield from records.key_differences(was, found)
    for command in [key for key in was if key in found]:
        lines = records.json_differences(was[command], found[command], exact=exact)
        yield from (f"gnc {command} --json: {line}" for line in lines)


def _array_differences(prefix: str, was: Any, found: Any, exact: bool) -> Iterable[str]:
    yield from (f"{prefix}{line}" for line in records.key_differences(was, found))
    for key in [key for key in was if key in found]:
        yield from records.array_differences(f"{prefix}{key}", was[key], found[key], exact=exact)


def _bag_differences(was: Any, found: Any, exact: bool) -> Iterator[str]:
    yield from records.key_differences(was, found)
    for topic in [topic for topic in was if topic in found]:
        ours, theirs = found[topic], was[topic]
        lines = [
            f"{topic}: {part} {ours[part]}; pinned {theirs[part]}"
            for part in ("type", "messages")
            if ours[part] != theirs[part]
        ]
        lines += _array_differences(f"{topic} ", theirs["fields"], ours["fields"], exact)
        is_known = theirs["payloads"] != ""  # stored when they had a field of wall time
        if exact and not lines and is_known and ours["payloads"] != theirs["payloads"]:
            lines.append(f"{topic}: payloads differ though no field does: their layout")
        yield from lines
