"""Records of arrays and of JSON objects, and what differs from a stored record.

Floating point depends on the machine: BLAS, numpy, numba and libm choose instructions by the
processor. On a machine that computes as the one that stored the record (`pinned.machine`), every
bit must be the same. On any other, integers and text must be the same and floating-point numbers
must agree to `TOLERANCE`.
"""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

Record = dict[str, Any]

TOLERANCE = 1e-8
"""Share of an array's largest magnitude. Without AVX, the shipped flights differ by up to 4e-11
(torque of `kalabic2014_nmpc`, whose terminal weights amplify rounding errors), and the smallest
curvature of a `sun_moon` solve, taken where rounding ends the iterations, by 6e-9."""

NOTHING = 1e-10
"""Arrays whose largest magnitude is below it hold rounding errors only."""

ROUGH = 0.1
"""Share of an array's largest magnitude that `rough_differences` allows."""

ROUNDED = frozenset({"iterations", "residual"})
"""Arrays decided by rounding errors: another machine need not have the same. A residual is what
rounding leaves of zero, and `iterations` counts how often a solve tried to lower it."""

_N_MARKS = 64
_N_SAMPLES = 8


def of_array(array: Any) -> Record:
    """Return shape, type, digest and marks of an array, and of floating-point numbers a summary.

    The marks, one letter for each of at most 64 blocks of rows, tell where a difference begins.
    """
    values = np.asarray(array)
    record = {
        "dtype": values.dtype.str,
        "shape": list(values.shape),
        "digest": hashlib.sha256(values.tobytes()).hexdigest()[:16],
        "marks": "".join(_mark(values[rows]) for rows in _blocks(values.shape)),
    }
    return record | _summary(values) if values.dtype.kind == "f" else record


def _blocks(shape: tuple[int, ...]) -> list[slice]:
    n = shape[0] if shape else 0
    size = max(1, -(-n // _N_MARKS))
    return [slice(first, min(first + size, n)) for first in range(0, n, size)]


def _mark(rows: Any) -> str:
    return base64.b64encode(hashlib.sha256(rows.tobytes()).digest())[:1].decode()


def _summary(values: Any) -> Record:
    flat = values.ravel()
    finite = flat[np.isfinite(flat)]
    n_samples = min(_N_SAMPLES, len(finite), len(np.unique(finite)))
    at = np.linspace(0, len(finite) - 1, n_samples).astype(int)
    return {
        "finite": len(finite),
        "largest": float(np.abs(finite).max()) if len(finite) else 0.0,
        "sum": float(finite.sum()),
        "samples": finite[at].tolist(),
    }


def array_differences(name: str, stored: Record, found: Record, *, exact: bool) -> Iterator[str]:
    """Yield one line where an array is another than the stored one."""
    for part in ("dtype", "shape"):
        if stored[part] != found[part]:
            yield f"{name}: {part} {found[part]}; pinned {stored[part]}"
            return
    if stored["digest"] == found["digest"]:
        return
    is_float = "samples" in stored
    if exact or not (is_float or _is_rounded(name)):
        yield f"{name}: {_first_rows(stored, found)}"
    elif not _is_rounded(name):
        yield from _beyond_tolerance(name, stored, found)


def rough_differences(name: str, stored: Record, found: Record) -> Iterator[str]:
    """Yield one line where a flight is another in the large: by more than `ROUGH`."""
    for part in ("dtype", "shape"):
        if stored[part] != found[part]:
            yield f"{name}: {part} {found[part]}; pinned {stored[part]}"
            return
    if "samples" not in stored or _is_rounded(name) or not np.isfinite(stored["largest"]):
        return
    allowed = ROUGH * max(stored["largest"], 1e-3)
    pairs = zip(found["samples"], stored["samples"], strict=False)
    far = max([abs(ours - theirs) for ours, theirs in pairs], default=0.0)
    far = max(far, abs(found["largest"] - stored["largest"]))
    if not far <= allowed:
        yield f"{name}: another by {far:.3g}; allowed {allowed:.3g}"


def _is_rounded(name: str) -> bool:
    return name.rsplit(".", 1)[-1].rsplit(" ", 1)[-1] in ROUNDED


def _first_rows(stored: Record, found: Record) -> str:
    pairs = zip(_blocks(tuple(stored["shape"])), stored["marks"], found["marks"], strict=True)
    differing = [rows for rows, ours, theirs in pairs if ours != theirs]
    if not differing:  # a scalar, or one of the 1 in 64 differences that a mark does not show
        return f"digest {found['digest']}; pinned {stored['digest']}"
    first, last = differing[0].start, differing[0].stop - 1
    where = f"row {first}" if first == last else f"rows {first} to {last}"
    return f"differs first in {where} of {stored['shape'][0]}"


def _beyond_tolerance(name: str, stored: Record, found: Record) -> Iterator[str]:
    if stored["finite"] != found["finite"]:
        yield f"{name}: {found['finite']} finite numbers; pinned {stored['finite']}"
        return
    if max(stored["largest"], found["largest"]) < NOTHING:
        return
    scale = TOLERANCE * stored["largest"]
    parts = [("largest", scale), ("sum", scale * stored["finite"])]
    for part, allowed in parts:
        if not abs(found[part] - stored[part]) <= allowed:
            yield f"{name}: {part} {found[part]!r}; pinned {stored[part]!r} +- {allowed:.1e}"
            return
    if len(found["samples"]) != len(stored["samples"]):
        return  # rounding made equal numbers of different ones: the samples stand elsewhere
    for index, (ours, theirs) in enumerate(zip(found["samples"], stored["samples"], strict=True)):
        if not abs(ours - theirs) <= scale:
            yield f"{name}: sample {index} is {ours!r}; pinned {theirs!r} +- {scale:.1e}"
            return


ANY = "*"
"""Value of a key that is there with a value of no interest: wall time, or a path."""


def of_json(value: Any, omitted: frozenset[str]) -> Record:
    """Return every value of a JSON object by its path; `ANY` for the keys that are omitted."""
    return dict(_leaves(value, "", omitted))


def _leaves(value: Any, path: str, omitted: frozenset[str]) -> Iterator[tuple[str, Any]]:
    if isinstance(value, Mapping) and value:
        for key, item in value.items():
            inner = f"{path}.{key}" if path else key
            yield from [(inner, ANY)] if key in omitted else _leaves(item, inner, omitted)
    elif isinstance(value, list) and value:
        for index, item in enumerate(value):
            yield from _leaves(item, f"{path}[{_label(item, index)}]", omitted)
    else:
        yield path, value


def _label(item: Any, index: int) -> Any:
    """Return the name of an item, that a new one before it does not change, or its index."""
    return item.get("check", index) if isinstance(item, Mapping) else index


def json_differences(stored: Record, found: Record, *, exact: bool) -> Iterator[str]:
    """Yield one line for each key that is new or missing, and where ``exact`` for each value."""
    yield from key_differences(stored, found)
    for path in stored.keys() & found.keys() if exact else ():
        if stored[path] != found[path]:
            yield f"{path}: {found[path]!r}; pinned {stored[path]!r}"


def key_differences(stored: Any, found: Any) -> Iterator[str]:
    """Yield one line for each key that is new or missing."""
    yield from (f"{key}: missing" for key in stored if key not in found)
    yield from (f"{key}: not pinned" for key in found if key not in stored)
