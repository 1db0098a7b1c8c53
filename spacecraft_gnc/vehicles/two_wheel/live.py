"""Live view of a spacecraft with wheels: values, charts and readouts."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.drawing.live import (
    Panel,
    Readout,
    Series,
    attitude_readouts,
    attitude_values,
    error_panel,
    listed,
    magnitude,
    number,
    source_panel,
    source_readout,
)
from spacecraft_gnc.drawing.sources import source_name
from spacecraft_gnc.vehicles.two_wheel.controllers.report import Mode, Rest
from spacecraft_gnc.vehicles.two_wheel.flown import limit_of, turning, wheel_rims
from spacecraft_gnc.vehicles.two_wheel.scenario import Scenario
from spacecraft_gnc.vehicles.two_wheel.signals import DIAGNOSIS
from spacecraft_gnc.vehicles.two_wheel.summary import RESTS, direction, mode_name

_SHOWN: Final = (
    "angular_velocity", "wheel_speed", "wheel_acceleration", "total_momentum", "healthy",
    "diagnosed", "rest", "remaining_rate", "pointing_loss", "wheel_residual", "wheel_threshold",
    "wheel_response",
)  # fmt: skip
_UNKNOWN: Final = mode_name(-1)
_MODES: Final = dict(
    zip(map(mode_name, Mode), ("#2fc79b", "#58aef0", "#f2b134", "#f0554a"), strict=True)
)
"""Color of each mode, on a dark page."""
_MOODS: Final = {mode_name(mode): "warn" for mode in Mode if mode is not Mode.NOMINAL}
_LIMITS: Final = ("max_wheel_speed", "max_wheel_acceleration")


class WheelLive:
    """Implements `drawing.live.VehicleLive`."""

    fields: Final[Mapping[str, str]] = MappingProxyType(
        {f"wheel_{name}": f"{DIAGNOSIS}/{name}" for name in ("residual", "threshold", "response")}
    )
    history: Final = (
        "error_deg", "target_error_deg", "wheel_speed", "wheel_acceleration", "source", "mode",
    )  # fmt: skip

    def constants(self, scenario: Scenario | None) -> dict[str, Any]:
        """Return limits [rad/s], [rad/s^2] (0: none), ``rims`` of the wheels, ``target`` (3, 3)."""
        target = None if scenario is None else scenario.governor.target_rotation_vector
        return {
            **{name: limit_of(scenario, name) for name in _LIMITS},
            "target": None if target is None else lie.exp(target),
            "zones": (),
            "rims": () if scenario is None else wheel_rims(scenario),
        }

    def panels(self, scenario: Scenario | None) -> list[Panel]:
        """Return the charts."""
        limits = self.constants(scenario)
        governed = scenario is not None and scenario.governor.governor != "none"
        return [
            Panel(
                kind="bars", name="speed_now", title="Wheel speeds now", unit="rad/s",
                series=[Series("wheel_speed")], numbered="wheel ", limit=limits["max_wheel_speed"],
            ),
            error_panel(governed),
            Panel(
                kind="strip", name="speed", title="Wheel speeds", unit="rad/s",
                series=[Series("wheel_speed")], numbered="wheel ", limit=limits["max_wheel_speed"],
            ),
            Panel(
                kind="strip", name="acceleration", title="Wheel accelerations",
                unit="rad/s²", series=[Series("wheel_acceleration")], numbered="wheel ",
                limit=limits["max_wheel_acceleration"],
            ),
            source_panel("Command"),
            Panel(kind="band", name="mode", title="Flown", series=[Series("mode")], colors=_MODES),
        ]  # fmt: skip

    def values(self, row: Mapping[str, Any], constants: Mapping[str, Any]) -> dict[str, Any]:
        """Return what is shown of a step."""
        source, mode, speed = (row.get(name) for name in ("source", "mode", "wheel_speed"))
        limit = constants.get("max_wheel_speed", 0.0)
        return {
            **attitude_values(row, constants),
            **{name: row.get(name) for name in _SHOWN},
            "mode": mode_name(-1 if mode is None else int(mode)),
            "turning": None if speed is None else turning(speed, limit),
            "source": source_name(-1 if source is None else int(source), "unknown"),
        }

    def readouts(self, values: Mapping[str, Any], governed: bool) -> dict[str, list[Readout]]:
        """Return the lines beside the picture."""
        return {
            "state": [*attitude_readouts(values, governed), *_state(values)],
            "wheels": list(_wheels(values)),
            "diagnosis": list(_diagnosis(values)),
        }

    def line(self, values: Mapping[str, Any]) -> list[str]:
        """Return a few words about a step."""
        parts = []
        if math.isfinite(values["error_deg"]):
            parts.append(f"{values['error_deg']:.4g} deg off the reference")
        if values["wheel_speed"] is not None:
            parts.append(f"wheels at {listed(values['wheel_speed'])} rad/s")
        if values["wheel_acceleration"] is not None:
            parts.append(f"({values['source']})")
        if values["mode"] not in (_UNKNOWN, mode_name(Mode.NOMINAL)):
            parts.append(f"flown {values['mode']}")
        return parts


LIVE: Final = WheelLive()


def _state(values: Mapping[str, Any]) -> Iterator[Readout]:
    if values["wheel_acceleration"] is not None:
        yield source_readout("command", values["source"])
    yield Readout("rate of the bus", magnitude(values["angular_velocity"], "rad/s"))
    yield Readout("total momentum", magnitude(values["total_momentum"], "N m s"))


def _wheels(values: Mapping[str, Any]) -> Iterator[Readout]:
    """Yield the speed of each wheel; one that does not answer stands out."""
    speeds, healthy = values["wheel_speed"], values["healthy"]
    for i, speed in enumerate(() if speeds is None else speeds.tolist()):
        lost = healthy is not None and not healthy[i]
        text = f"{speed:.4g} rad/s{', lost' if lost else ''}"
        yield Readout(f"wheel {i + 1}", text, "bad" if lost else "")


def _diagnosis(values: Mapping[str, Any]) -> Iterator[Readout]:
    """Yield what is believed on board: mode, residuals of wheels that stand out, what is held."""
    mode, trusted = values["mode"], values["diagnosed"]
    yield Readout("flown", "" if mode == _UNKNOWN else mode, _MOODS.get(mode, ""))
    excluded = [] if trusted is None else np.flatnonzero(~trusted).tolist()
    yield Readout("excluded", ", ".join(f"wheel {i + 1}" for i in excluded), "warn")
    names = "wheel_residual", "wheel_threshold", "wheel_response"
    residual, threshold, response = (values[name] for name in names)
    for i in excluded:
        if residual is not None and math.isfinite(residual[i]):
            bound = f"{abs(residual[i]):.3g} rad/s, bound {threshold[i]:.2g}"
            yield Readout(f"residual {i + 1}", bound, "warn")
        if response is not None and math.isfinite(response[i]):
            yield Readout(f"answer {i + 1}", f"{100.0 * response[i]:.0f} % of its command")
    rest = -1 if values["rest"] is None else int(values["rest"])
    if mode not in (_UNKNOWN, mode_name(Mode.NOMINAL)) and 0 <= rest < len(Rest):
        yield Readout("rest", RESTS[Rest(rest)], "" if rest == Rest.AT_TARGET else "warn")
        yield from _held(values)


def _held(values: Mapping[str, Any]) -> Iterator[Readout]:
    """Yield the rotation that remains, its axis, and how well it points."""
    rate, loss = values["remaining_rate"], values["pointing_loss"]
    size = 0.0 if rate is None else float(np.linalg.norm(rate))
    if size > 0.0:
        yield Readout("keeps turning at", magnitude(rate, "rad/s"), "warn")
        yield Readout("about body axis", direction(rate / size))
    if loss is not None and (loss > 0.0 or size > 0.0):
        what = "axis" if size > 0.0 else "held"  # of what turns, the axis is all that is pointed
        mood = "warn" if loss > 0.0 else ""
        yield Readout(f"{what} off the target by", number(math.degrees(loss), 3, "°"), mood)
