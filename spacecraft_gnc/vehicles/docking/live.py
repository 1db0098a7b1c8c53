"""Live view of a docking: both bodies, values, charts and readouts."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.drawing.live import (
    INK,
    WARN,
    Cuboid,
    Panel,
    Readout,
    Series,
    duration,
    listed,
    magnitude,
    number,
    source_panel,
    source_readout,
)
from spacecraft_gnc.drawing.sources import source_name
from spacecraft_gnc.vehicles.docking.decision import Answer, Phase
from spacecraft_gnc.vehicles.docking.flown import limit_of, sight
from spacecraft_gnc.vehicles.docking.geometry import deputy_center
from spacecraft_gnc.vehicles.docking.scenario import Scenario
from spacecraft_gnc.vehicles.docking.signals import COMMAND, GOVERNOR_STATUS, REFERENCE
from spacecraft_gnc.vehicles.docking.state import DIRECTIONS
from spacecraft_gnc.vehicles.docking.summary import answer_name, phase_name

_SHOWN: Final = (
    "port_offset", "port_velocity", "angular_velocity", "line_of_sight_margin", "clearance",
    "slack", "solve_time", "constraint", "active", "thrusters",
)  # fmt: skip
_LIMITS: Final = ("max_force", "max_moment", "clearance_tolerance")
_PHASES: Final = dict(zip(map(phase_name, Phase), ("#2fc79b", "#f2b134", "#58aef0"), strict=True))
"""Color of each phase, on a dark page."""
_ANSWERS: Final = dict(
    zip(
        map(answer_name, Answer),
        ("#2fc79b", "#f0554a", "#f0554a", "#f2b134", "#93a1b1"),
        strict=True,
    )
)
_UNKNOWN: Final = phase_name(-1)
_CUT: Final = 0.5  # [m] above which margins are all the same to a reader
_REACH: Final = 1.1  # of the pyramid that is drawn, in distances at the start


class DockingLive:
    """Implements `drawing.live.VehicleLive`."""

    fields: Final[Mapping[str, str]] = MappingProxyType(
        {
            **{name: f"{GOVERNOR_STATUS}/{name}" for name in ("constraint", "active")},
            "wrench": f"{COMMAND}/wrench",
            "reference_offset": f"{REFERENCE}/port_offset",
        }
    )
    history: Final = (
        "distance", "angle_deg", "margin_shown", "clearance_shown", "force", "moment", "flown",
        "answer", "source", "port",
    )  # fmt: skip

    def constants(self, scenario: Scenario | None) -> dict[str, Any]:
        """Return limits (0: not known), both bodies and the pyramid, if they are known."""
        limits: dict[str, Any] = {name: limit_of(scenario, name) for name in _LIMITS}
        if scenario is None:
            return {**limits, "target": None}
        p = scenario.plant
        return {
            **limits,
            "target": None,
            "bodies": (
                Cuboid("chief", p.chief_size, p.chief_port),
                Cuboid("deputy", p.deputy_size, p.deputy_port),
            ),
            "region": sight(p, max(_REACH * float(p.initial_port_offset[0]), 1.0)),
            "trail": "port",
        }

    def panels(self, scenario: Scenario | None) -> list[Panel]:
        """Return the charts."""
        limits = {name: limit_of(scenario, name) for name in _LIMITS}
        charts = [
            Panel(
                kind="bars", name="force", title="Force now", unit="N",
                series=[Series("force", "xyz")], limit=limits["max_force"],
            ),
            Panel(
                kind="strip", name="distance", title="Distance of the ports", unit="m", log=True,
                series=[Series("distance", ["distance"], INK)],
            ),
            Panel(
                kind="strip", name="angle", title="Angle between the bodies", unit="deg", log=True,
                series=[Series("angle_deg", ["angle"], INK)],
            ),
            Panel(
                kind="strip", name="margins", title=f"Margins, cut at {_CUT:g} m", unit="m",
                series=[
                    Series("margin_shown", ["line of sight"], "#2fc79b"),
                    Series("clearance_shown", ["clearance"], WARN),
                ],
            ),
            Panel(
                kind="strip", name="forces", title="Force", unit="N",
                series=[Series("force", "xyz")], limit=limits["max_force"],
            ),
            Panel(
                kind="strip", name="moments", title="Moment", unit="N m",
                series=[Series("moment", "xyz")], limit=limits["max_moment"],
            ),
            Panel(kind="band", name="phase", title="Phase", series=[Series("flown")],
                  colors=_PHASES),
        ]  # fmt: skip
        if scenario is not None and scenario.governor.governor != "none":
            series = [Series("answer")]
            charts.append(
                Panel(kind="band", name="answer", title="Governor", series=series, colors=_ANSWERS)
            )
        return [*charts, source_panel("Command")]

    def values(self, row: Mapping[str, Any], constants: Mapping[str, Any]) -> dict[str, Any]:
        """Return what is shown of a step."""
        offset, attitude = (row.get(name) for name in ("port_offset", "attitude"))
        source, phase, status, lost = (
            row.get(name) for name in ("source", "phase", "status", "lost_thruster")
        )
        margin, clearance = (row.get(name) for name in ("line_of_sight_margin", "clearance"))
        return {
            **{name: row.get(name) for name in _SHOWN},
            **_wrench(row),
            "attitude": attitude,
            "distance": math.nan if offset is None else float(np.linalg.norm(offset)),
            "angle_deg": _angle_deg(attitude),
            "margin_shown": _cut(margin),
            "clearance_shown": _cut(clearance),
            "tolerance": constants.get("clearance_tolerance", 0.0),
            "flown": phase_name(-1 if phase is None else int(phase)),
            "answer": answer_name(-1 if status is None else int(status)),
            "source": source_name(-1 if source is None else int(source), "unknown"),
            "lost_thruster": -1 if lost is None else int(lost),
            **_placed(offset, attitude, _aim(row), constants.get("bodies", ())),
        }

    def readouts(self, values: Mapping[str, Any], governed: bool) -> dict[str, list[Readout]]:
        """Return the lines beside the picture."""
        groups = {"state": list(_state(values)), "constraints": list(_constraints(values))}
        if governed:
            groups["governor"] = list(_governor(values))
        return {**groups, "thrusters": list(_thrusters(values))}

    def line(self, values: Mapping[str, Any]) -> list[str]:
        """Return a few words about a step."""
        parts = []
        if math.isfinite(values["distance"]):
            parts.append(f"ports {values['distance']:.4g} m apart, {values['angle_deg']:.3g} deg")
        if values["force"] is not None:
            parts.append(f"force {listed(values['force'])} N ({values['source']})")
        if values["flown"] not in (_UNKNOWN, phase_name(Phase.DOCKING)):
            parts.append(values["flown"])
        parts += [f"{line.label} {line.text}" for line in _alarms(values)]
        return parts


LIVE: Final = DockingLive()


def _wrench(row: Mapping[str, Any]) -> dict[str, Any]:
    """Return force and moment, of a flight's columns or of a message."""
    wrench = row.get("wrench")
    if wrench is None:
        return {name: row.get(name) for name in ("force", "moment")}
    return {"force": wrench[:3], "moment": wrench[3:]}


def _aim(row: Mapping[str, Any]) -> Any:
    """Return the port offset of the reference, likewise."""
    reference = row.get("reference")
    return row.get("reference_offset") if reference is None else reference[:3]


def _placed(offset: Any, attitude: Any, aim: Any, bodies: Any) -> dict[str, Any]:
    """Return where the deputy, its port and the port's reference are, chief frame [m]."""
    if offset is None or attitude is None or not bodies:
        return {"bodies": {}, "port": offset, "aim": None}
    chief, deputy = bodies
    center = deputy_center(chief.port, deputy.port, offset, attitude)
    return {
        "bodies": {"deputy": {"position": center, "attitude": attitude}},
        "port": chief.port + offset,
        "aim": None if aim is None else chief.port + aim,
    }


def _angle_deg(attitude: Any) -> float:
    return math.nan if attitude is None else math.degrees(lie.angle_between(np.eye(3), attitude))


def _cut(margin: float | None) -> float:
    return math.nan if margin is None else min(margin, _CUT)


def _state(values: Mapping[str, Any]) -> Iterator[Readout]:
    yield Readout("ports apart", number(values["distance"], 4, " m"))
    yield Readout("angle", number(values["angle_deg"], 4, "°"))
    yield Readout("offset", _with_unit(values["port_offset"], "m"))
    yield Readout("port speed", magnitude(values["port_velocity"], "m/s"))
    yield Readout("relative rate", magnitude(values["angular_velocity"], "rad/s"))
    if values["force"] is not None:
        yield source_readout("command", values["source"])


def _with_unit(vector: Any, unit: str) -> str:
    return "" if vector is None else f"{listed(vector)} {unit}"


def _constraints(values: Mapping[str, Any]) -> Iterator[Readout]:
    """Yield the margins; one that is broken stands out."""
    for name, key, least in (
        ("line of sight", "line_of_sight_margin", 0.0),
        ("clearance", "clearance", -values["tolerance"]),
    ):
        value = values[key]
        broken = value is not None and value < least
        yield Readout(name, number(value, 4, " m"), "bad" if broken else "")


def _governor(values: Mapping[str, Any]) -> Iterator[Readout]:
    """Yield how the reference was found, and what keeps it from the target."""
    answer = values["answer"]
    well = answer in (answer_name(Answer.OPTIMAL), answer_name(Answer.PASSED), _UNKNOWN)
    yield Readout("reference", "" if answer == _UNKNOWN else answer, "" if well else "bad")
    phase = values["flown"]
    usual = phase == phase_name(Phase.DOCKING)
    yield Readout("phase", "" if phase == _UNKNOWN else phase, "" if usual else "warn")
    slack = math.nan if values["slack"] is None else round(100.0 * values["slack"], 4) + 0.0
    yield Readout("slack", number(slack, 3, " %"), "bad" if slack < 0.0 else "")
    yield Readout("held back by", values["active"] or "")
    yield Readout("next", values["constraint"] or "")
    yield Readout("takes", duration(values["solve_time"]))


def _thrusters(values: Mapping[str, Any]) -> Iterator[Readout]:
    """Yield what does not answer, and what is concluded on board."""
    answers = values["thrusters"]
    lost = (
        []
        if answers is None
        else [DIRECTIONS[i] for i in np.flatnonzero(~np.asarray(answers, bool))]
    )
    yield Readout("lost", ", ".join(lost), "bad")
    found = values["lost_thruster"]
    if found >= 0:
        alarm = DIRECTIONS[found] not in lost
        text = f"{DIRECTIONS[found]}{', a false alarm' if alarm else ''}"
        yield Readout("taken for lost", text, "bad" if alarm else "warn")


def _alarms(values: Mapping[str, Any]) -> Iterator[Readout]:
    """Yield the lines that a reader has to notice."""
    lines = (*_constraints(values), *_governor(values), *_thrusters(values))
    return (line for line in lines if line.mood == "bad" and line.text)
