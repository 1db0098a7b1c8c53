"""Parts of a live page, and the protocol of a vehicle's own part of it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, NamedTuple, Protocol

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.drawing.sources import source_name
from spacecraft_gnc.drawing.style import prefixed
from spacecraft_gnc.loop.protocols import Source

INK: Final = "#e6ebf1"
WARN: Final = "#f2b134"
BANDS: Final = dict(
    zip(
        map(source_name, Source),
        ("#2fc79b", "#58aef0", "#f2b134", "#f58a45", "#f0554a", "#3d8bfd"),
        strict=True,
    )
)
"""Color of each source of a command, on a dark page."""
_WELL: Final = (Source.OPTIMAL, Source.NEIGHBORING_EXTREMAL, Source.METHOD)


class Series(NamedTuple):
    """What a panel draws: one value of the flight."""

    key: str
    """Of the value, a number or an array."""
    names: Sequence[str] = ()
    """Of a number itself, or of the components of an array; empty: they are numbered."""
    color: str = ""
    """Empty: one for each component."""
    first: int = 0
    """Place of the first component's color among those, so that other values have other ones."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Panel:
    """A chart of the page.

    Attributes
    ----------
    kind
        ``strip``: curves over time; ``bars``: components now; ``band``: a word over time.
    name, title
        Short name, and heading.
    series
        What is drawn; of bars and bands one.
    unit
        Of the values; a prefix is put before it unless ``log`` or it is an angle.
    log
        Whether a strip is logarithmic.
    limit
        Largest value on both sides of zero; 0: none, or not known.
    norm
        Name of the norm that bars show as well, and that the limit applies to.
    colors
        Of the words of a band.
    numbered
        What a component is called before its number.
    """

    kind: str
    name: str
    title: str
    series: Sequence[Series]
    unit: str = ""
    log: bool = False
    limit: float = 0.0
    norm: str = ""
    colors: Mapping[str, str] | None = None
    numbered: str = ""

    def as_json(self) -> dict[str, Any]:
        """Return it as JSON-able values."""
        told = {name: getattr(self, name) for name in self.__slots__}
        return told | {"series": [one._asdict() for one in self.series]}


class Cuboid(NamedTuple):
    """A body of the picture."""

    name: str
    size: Any
    """(3,) edges [m]."""
    port: Any
    """(3,) docking port, body frame [m]."""

    def as_json(self) -> dict[str, Any]:
        """Return it as JSON-able values."""
        return {"name": self.name, "size": list(map(float, self.size)),
                "port": list(map(float, self.port))}  # fmt: skip


class Readout(NamedTuple):
    """A line of words beside the picture."""

    label: str
    text: str
    """Empty: not known, and the line is left out."""
    mood: str = ""
    """``warn`` or ``bad`` where a reader should notice it."""


class VehicleLive(Protocol):
    """What the live page and the dashboard show of a vehicle.

    A row holds what a flight keeps of a step, by the names of its columns and of `fields`; what is
    not known is None or absent.
    """

    @property
    def fields(self) -> Mapping[str, str]:
        """Further names of a row -> ``"topic/field"`` of the message that carries the value."""

    @property
    def history(self) -> Sequence[str]:
        """Values that panels draw over time."""

    def constants(self, scenario: Any) -> dict[str, Any]:
        """Return what stays all along, by name; ``scenario``: None where it is not known.

        ``target`` (3, 3), None where it is not known, ``zones`` (`drawing.zones.Zone`) and
        ``rims`` (m, k, 3) of wheels in the body (`drawing.geometry.rim`), if there are any, are
        drawn on the sphere. Where there are ``bodies`` (`Cuboid`), these are drawn in place of it,
        the first at rest in the origin, with ``region`` (8, 3), corners in the order of
        `drawing.solids.CORNERS`, and ``trail``, name of the value that is their path. Where there
        are ``craft``, names, these are drawn as points, with ``ring`` (k, 3), the closed path that
        they are to be on, and ``trail``, name of the value (m, 3) that is where they are. The rest
        is numbers and words.
        """

    def panels(self, scenario: Any) -> Sequence[Panel]:
        """Return the charts."""

    def values(self, row: Mapping[str, Any], constants: Mapping[str, Any]) -> dict[str, Any]:
        """Return what is shown of a step, by name: numbers, arrays, words and mappings of these.

        The sphere shows ``attitude``, ``reference`` and ``target`` (3, 3), body to inertial, and of
        wheels ``turning`` (m,), speed over its limit, ``healthy`` and ``diagnosed`` (m,), whether
        each works and whether it counts as working on board. Bodies are where ``bodies`` has them,
        by name: ``position`` (3,) and ``attitude`` (3, 3); ``aim`` (3,) is where the path is to go.
        Craft are where the trail has them, and are to be at ``places`` (m, 3); ``links`` has
        [first, second, whether their constraints are kept] of each pair, flat, and ``answers``
        (m,) whether each does what it is told.
        """

    def readouts(self, values: Mapping[str, Any], governed: bool) -> dict[str, Iterable[Readout]]:
        """Return the lines beside the picture, by the name of their group."""

    def line(self, values: Mapping[str, Any]) -> list[str]:
        """Return a few words about a step, for logs."""


def attitude_values(row: Mapping[str, Any], constants: Mapping[str, Any]) -> dict[str, Any]:
    """Return ``attitude``, ``reference`` and ``target`` of a row, and the angles between them.

    ``error_deg`` and ``target_error_deg`` lead to reference and target [deg]; NaN: not known.
    """
    attitude, reference, target = (row.get(name) for name in ("attitude", "reference", "target"))
    target = constants.get("target") if target is None else target
    return {
        "attitude": attitude,
        "reference": reference,
        "target": target,
        "error_deg": _angle_deg(attitude, reference),
        "target_error_deg": _angle_deg(attitude, target),
    }


def _angle_deg(attitude: Any, aim: Any) -> float:
    if attitude is None or aim is None:
        return math.nan
    return math.degrees(lie.angle_between(aim, attitude))


def attitude_readouts(values: Mapping[str, Any], governed: bool) -> list[Readout]:
    """Return the lines about `attitude_values`."""
    aims = (("reference", values["error_deg"]), ("target", values["target_error_deg"]))
    return [
        Readout(f"error to {aim}", number(angle, 4, "°"))
        for aim, angle in aims[: 2 if governed else 1]
    ]


def error_panel(governed: bool) -> Panel:
    """Return the chart of the angles of `attitude_values`."""
    series = [Series("error_deg", ["to reference"], INK)]
    if governed:
        series.append(Series("target_error_deg", ["to target"], WARN))
    return Panel(
        kind="strip", name="error", title="Attitude error", series=series, unit="deg", log=True
    )


def source_panel(what: str) -> Panel:
    """Return the chart of where the commands came from; ``what`` they are, in a word."""
    series = [Series("source")]
    return Panel(kind="band", name="source", title=f"{what} from", series=series, colors=BANDS)


def source_readout(what: str, source: str) -> Readout:
    """Return where a command came from; one that is no answer of the method stands out."""
    well = source in map(source_name, _WELL)
    return Readout(f"{what} from", source, "" if well else "warn")


def number(value: float | None, digits: int, unit: str = "") -> str:
    """Return a number with significant digits; empty where it is not finite."""
    known = value is not None and math.isfinite(value)
    return f"{value:.{digits}g}{unit}" if known else ""


def small(value: float | None) -> str:
    """Return a number that may be tiny; empty where it is not finite."""
    if value is None or not math.isfinite(value):
        return ""
    return f"{value:.4g}" if abs(value) >= 0.01 else f"{value:.2e}"


def duration(value: float | None) -> str:
    """Return a wall time [s] in micro- or milliseconds; empty where it is not finite."""
    if value is None or not math.isfinite(value):
        return ""
    return f"{value * 1e6:.0f} µs" if value < 1e-3 else f"{value * 1e3:.2f} ms"


def magnitude(vector: Any, unit: str) -> str:
    """Return the norm of a vector with an SI prefix; empty where it is None or zero."""
    norm = 0.0 if vector is None else float(np.linalg.norm(vector))
    shown = prefixed(unit, np.array([norm]))
    return f"{shown.factor * norm:.3g} {shown.label}" if norm > 0.0 else ""


def listed(values: Any, digits: int = 3) -> str:
    """Return the components of an array; empty where it is None."""
    return "" if values is None else ", ".join(f"{v:.{digits}g}" for v in np.ravel(values))
