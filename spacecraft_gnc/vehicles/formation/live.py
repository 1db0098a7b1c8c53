"""Live view of a formation: the craft on their paths, values, charts and readouts."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import combinations
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from spacecraft_gnc.drawing.live import Readout, duration, number, source_readout
from spacecraft_gnc.drawing.sources import source_name
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.formation.craft import craft
from spacecraft_gnc.vehicles.formation.decision import Answer
from spacecraft_gnc.vehicles.formation.events import Standing, standing_name, standing_of
from spacecraft_gnc.vehicles.formation.flown import angle_limit, ellipse, limit_of
from spacecraft_gnc.vehicles.formation.geometry import communication_angles_deg, pairs, separations
from spacecraft_gnc.vehicles.formation.hill import transition
from spacecraft_gnc.vehicles.formation.live_panels import PanelsOf
from spacecraft_gnc.vehicles.formation.metrics import healthy_pairs
from spacecraft_gnc.vehicles.formation.orbit import mean_motion
from spacecraft_gnc.vehicles.formation.scenario import Scenario
from spacecraft_gnc.vehicles.formation.signals import GOVERNOR_STATUS, REFERENCE, STATE
from spacecraft_gnc.vehicles.formation.summary import answer_name, length

_UNKNOWN: Final = "unknown"
_WELL: Final = (answer_name(Answer.OPTIMAL), answer_name(Answer.PASSED), _UNKNOWN)
_MOODS: Final = {
    standing_name(Standing.DEADLOCK): "bad",
    standing_name(Standing.PASSAGE): "warn",
}


class FormationLive:
    """Implements `drawing.live.VehicleLive`."""

    fields: Final[Mapping[str, str]] = MappingProxyType(
        {
            **{
                name: f"{GOVERNOR_STATUS}/{name}"
                for name in ("constraint", "refused", "passages_left")
            },
            "applied_delta_v": f"{STATE}/applied_delta_v",
            "applied_source": f"{STATE}/applied_source",
            "state_step": f"{STATE}/step",
            "reference_step": f"{REFERENCE}/step",
        }
    )
    history: Final = (
        "position", "separation", "delta_v", "angle_deg", "error", "shift", "shift_cost",
        "state_cost", "standing", "answer", "source",
    )  # fmt: skip

    def constants(self, scenario: Scenario | None) -> dict[str, Any]:
        """Return limits and motion (0: not known), the natural ellipse, the names of the craft."""
        return {
            "target": None,
            "max_delta_v": limit_of(scenario, "max_delta_v"),
            "min_separation": limit_of(scenario, "min_separation"),
            "max_angle_deg": angle_limit(scenario),
            "craft": () if scenario is None else craft(scenario),
            "ring": ellipse(scenario),
            "mean_motion": 0.0 if scenario is None else mean_motion(scenario.plant.altitude),
            "time_step": 0.0 if scenario is None else scenario.period,
            "trail": "position",
        }

    def panels(self, scenario: Scenario | None) -> list[Any]:
        """Return the charts."""
        return PanelsOf(scenario).all()

    def values(self, row: Mapping[str, Any], constants: Mapping[str, Any]) -> dict[str, Any]:
        """Return what is shown of a step."""
        position, places = row.get("position"), _places(row, constants)
        healthy, concluded = _bools(row.get("healthy")), _bools(row.get("lost"))
        apart = None if position is None else separations(position)
        angle = _angles(position, places, healthy)
        return {
            "craft": {name: i for i, name in enumerate(constants["craft"] or _numbered(position))},
            "position": position,
            "places": _expected(places, concluded),
            "answers": healthy,
            "concluded": concluded,
            "separation": apart,
            "angle_deg": angle,
            "error": _errors(position, places),
            "delta_v": _delta_v(row, healthy),
            "shift": _shift(row.get("time_shift")),
            "links": _links(apart, angle, constants),
            "standing": _standing(row),
            "answer": answer_name(_integer(row.get("status"))),
            "source": _source(row),
            **{name: row.get(name) for name in _GOVERNED},
            **{name: constants[name] for name in _LIMITS},
        }

    def readouts(self, values: Mapping[str, Any], governed: bool) -> dict[str, list[Readout]]:
        """Return the lines beside the picture."""
        groups = {"craft": list(_craft(values)), "pairs": list(_pairs(values))}
        if governed:
            groups["governor"] = list(_governor(values))
        return groups

    def line(self, values: Mapping[str, Any]) -> list[str]:
        """Return a few words about a step."""
        parts = [] if values["standing"] == _UNKNOWN else [values["standing"]]
        if values["separation"] is not None:
            parts.append(f"at least {length(float(values['separation'].min()))} apart")
        away = _farthest(values)
        if math.isfinite(away):
            parts.append(f"up to {length(away)} off")
        lines = (*_craft(values), *_pairs(values), *_governor(values))
        return parts + [f"{it.label} {it.text}" for it in lines if it.mood == "bad" and it.text]


LIVE: Final = FormationLive()
_LIMITS: Final = ("max_delta_v", "min_separation", "max_angle_deg")
_GOVERNED: Final = (
    "shift_cost", "state_cost", "n_admissible", "governor_margin", "constraint", "refused",
    "passages_left", "solve_time",
)  # fmt: skip


def _bools(flags: Any) -> Any:
    """Return flags; None where nothing is told."""
    return None if flags is None or not np.size(flags) else np.asarray(flags, dtype=bool)


def _integer(value: Any) -> int:
    return -1 if value is None else int(value)


def _numbered(position: Array | None) -> tuple[str, ...]:
    return () if position is None else tuple(str(i + 1) for i in range(len(position)))


def _places(row: Mapping[str, Any], constants: Mapping[str, Any]) -> Array | None:
    """Return where the craft are to be.

    The reference of the newest step may not have come yet: an earlier one is moved on along the
    natural motion, where that is known.
    """
    places, velocity = row.get("reference_position"), row.get("reference_velocity")
    newest, told = row.get("state_step"), row.get("reference_step")
    behind = 0 if newest is None or told is None else newest - told
    if behind == 0 or places is None:
        return places
    if velocity is None or not constants["mean_motion"]:
        return None
    over = transition(constants["mean_motion"], behind * constants["time_step"])
    return np.asarray((np.hstack([places, velocity]) @ over.T)[:, :3])


def _expected(places: Array | None, concluded: Any) -> Array | None:
    """Return where craft are to be; NaN of those concluded lost."""
    if places is None or concluded is None:
        return places
    return np.where(concluded[:, None], math.nan, places)


def _angles(position: Array | None, places: Array | None, healthy: Any) -> Array | None:
    if position is None or places is None:
        return None
    found = communication_angles_deg(position, places)
    return found if healthy is None else np.where(healthy_pairs(healthy[None])[0], found, math.nan)


def _errors(position: Array | None, places: Array | None) -> Array | None:
    if position is None or places is None:
        return None
    return np.asarray(np.linalg.norm(position - places, axis=1))


def _delta_v(row: Mapping[str, Any], healthy: Any) -> Array | None:
    """Return the size of each delta-v: of a step of a flight, or else of the step before.

    A lost craft gives none.
    """
    commanded = row.get("delta_v")
    if commanded is None:
        applied = row.get("applied_delta_v")
        commanded = None if applied is None else np.reshape(applied, (-1, 3))
    if commanded is None:
        return None
    size = np.asarray(np.linalg.norm(commanded, axis=1))
    return size if healthy is None else np.where(healthy, size, 0.0)


def _shift(shift: Any) -> Array | None:
    return None if shift is None else np.where(np.asarray(shift) < 0, math.nan, shift)


def _links(apart: Array | None, angle: Array | None, constants: Mapping[str, Any]) -> Array | None:
    """Return first and second craft of each pair, and whether its constraints are kept, flat."""
    if apart is None:
        return None
    m = round(0.5 + math.sqrt(0.25 + 2.0 * len(apart)))
    broken = apart < constants["min_separation"]
    if angle is not None and constants["max_angle_deg"]:
        broken |= angle > constants["max_angle_deg"]
    return np.column_stack([pairs(m), ~broken]).ravel()


def _standing(row: Mapping[str, Any]) -> str:
    status, formed, deadlocked = (row.get(key) for key in ("status", "formed", "deadlocked"))
    told = (np.array([_integer(status)]), *(np.array([bool(x)]) for x in (formed, deadlocked)))
    return standing_name(int(standing_of(*told)[0]))


def _source(row: Mapping[str, Any]) -> str:
    """Return where the commands came from; of several craft the one that is no method's answer."""
    told = row.get("source")
    if told is None:
        sources = np.ravel(row.get("applied_source", ())).tolist()
        others = [source for source in sources if source != Source.METHOD]
        told = (others or sources or [-1])[0]
    return source_name(_integer(told), _UNKNOWN)


def _farthest(values: Mapping[str, Any]) -> float:
    """Return how far the farthest craft that answers is from its place [m]; NaN: not known."""
    away, answers = values["error"], values["answers"]
    if away is None:
        return math.nan
    known = away if answers is None else away[answers]
    return float(known.max()) if known.size else math.nan


def _craft(values: Mapping[str, Any]) -> Iterator[Readout]:
    """Yield of each craft how far it is from its place, and what it does."""
    for name, i in values["craft"].items():
        away, delta_v = (_of(values[key], i) for key in ("error", "delta_v"))
        yield Readout(f"{name} off", length(away) if math.isfinite(away) else "")
        most = values["max_delta_v"]
        mood = "bad" if 0.0 < most * (1.0 + 1e-9) < delta_v else ""
        yield Readout(f"{name} delta-v", number(delta_v, 3, " m/s"), mood)
        yield from _fate(name, _of(values["answers"], i), _of(values["concluded"], i))
    if values["source"] != _UNKNOWN:
        yield source_readout("command", values["source"])


def _of(values: Any, i: int) -> float:
    return math.nan if values is None else float(values[i])


def _fate(name: str, answers: float, concluded: float) -> Iterator[Readout]:
    """Yield whether a craft is lost, and whether that is concluded on board."""
    if answers == 0.0:
        yield Readout(name, "lost", "bad")
    if concluded == 1.0:
        alarm = answers == 1.0
        text = "taken for lost, a false alarm" if alarm else "taken for lost"
        yield Readout(f"{name} is", text, "bad" if alarm else "warn")


def _pairs(values: Mapping[str, Any]) -> Iterator[Readout]:
    """Yield distance and angle of each pair; what breaks a limit stands out."""
    least, most = values["min_separation"], values["max_angle_deg"]
    for i, names in enumerate(combinations(values["craft"], 2)):
        pair = "-".join(names)
        apart, angle = (_of(values[key], i) for key in ("separation", "angle_deg"))
        near = "bad" if apart < least else ""
        yield Readout(f"{pair} apart", length(apart) if math.isfinite(apart) else "", near)
        yield Readout(f"{pair} angle", number(angle, 3, "°"), "bad" if 0.0 < most < angle else "")


def _governor(values: Mapping[str, Any]) -> Iterator[Readout]:
    """Yield how the shifts were chosen, and what keeps the governor from cheaper ones."""
    answer, standing = values["answer"], values["standing"]
    yield Readout("formation", "" if standing == _UNKNOWN else standing, _MOODS.get(standing, ""))
    yield Readout("shifts", "" if answer == _UNKNOWN else answer, "" if answer in _WELL else "warn")
    shift = values["shift"]
    yield Readout("time shifts", "" if shift is None else ", ".join(f"{s:g}" for s in shift))
    yield Readout("cost W", number(values["shift_cost"], 4))
    yield Readout("cost Omega", number(values["state_cost"], 4))
    count = _integer(values["n_admissible"])
    yield Readout("allowed", f"{count}" if count >= 0 else "", "" if count else "warn")
    yield Readout("passages left", f"{values['passages_left'] or ''}")
    room = values["governor_margin"]
    yield Readout("least room", number(None if room is None else 100.0 * room, 3, " %"),
                  "bad" if room is not None and room < 0.0 else "")  # fmt: skip
    yield Readout("least room in", _named(values["constraint"]))
    yield Readout("cheapest refused for", _named(values["refused"]))
    yield Readout("takes", duration(values["solve_time"]))


def _named(constraint: str | None) -> str:
    """Return the name of a constraint, without the numbers that follow it."""
    return (constraint or "").partition(":")[0]
