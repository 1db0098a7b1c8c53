"""Checks of a scenario: craft and their lists, orbit and control period, loss, margins."""

from __future__ import annotations

import math
import re
from typing import Any, Final

from spacecraft_gnc.parameters.checked import Checked
from spacecraft_gnc.parameters.problems import shown, suggestion
from spacecraft_gnc.vehicles.formation import admissible
from spacecraft_gnc.vehicles.formation.orbit import orbital_period

_PLANT, _CONTROLLER, _GOVERNOR = "plant", "nmpc_controller", "reference_governor"
WHOLE: Final = 1e-9
"""Share by which an orbit may miss a whole number of control periods."""
FEWEST_SAMPLES: Final = 3
MOST_CANDIDATES: Final = 10_000_000
"""Combinations of shifts that one step can enumerate."""
_NAMESPACE: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_MARGINS: Final = ("delta_v_margin", "separation_margin", "communication_angle_margin_deg")
_PLACES: Final = ("initial_phase", "initial_along_track_offset", "initial_amplitude")
_STATES: Final = {"initial_position": "initial_velocity", "initial_velocity": "initial_position"}


def check(checked: Checked) -> None:
    """Add a problem for each pair of values that do not fit together."""
    craft = checked.get(_PLANT, "spacecraft")
    if isinstance(craft, list) and _PLANT in checked.given:
        _check_craft(checked, craft)
        if len(craft) > 1:
            _check_starts(checked, len(craft))
            _check_phases(checked, len(craft))
            _check_loss(checked, craft)
    _check_step(checked)
    _check_margins(checked)
    samples = _check_orbit(checked)
    if samples is None:
        return
    if isinstance(craft, list):
        _check_candidates(checked, len(craft), samples)
    if not checked.problems and _PLANT in checked.given:
        admissible.check(checked, samples)


def _check_craft(checked: Checked, craft: list[Any]) -> None:
    """Check that there are two or more craft, each with a namespace of its own."""
    if len(craft) < 2:
        value = f"{len(craft)}: {shown(craft)}"
        checked.complain(_PLANT, "spacecraft", value, "two spacecraft or more", "add another one")
    for name in craft:
        if not _NAMESPACE.fullmatch(name):
            need = (
                "a ROS namespace of one word: letters, digits and _, of which no digit comes first"
            )
            checked.complain(_PLANT, "spacecraft", shown(name), need, "rename the craft")
    plain = [name.strip("/") for name in craft]
    for name in sorted({name for name in plain if plain.count(name) > 1}):
        need = "a namespace of its own for each craft"
        checked.complain(_PLANT, "spacecraft", f"{shown(name)} twice", need, "rename one of them")


def _check_starts(checked: Checked, count: int) -> None:
    """Check that each craft has a start: its state, or else its place on an ellipse."""
    given = [name for name in _STATES if checked.get(_PLANT, name)]
    for name in given:
        other = _STATES[name]
        if other not in given and checked.get(_PLANT, other) is not None:
            need = f"{other} beside it"
            value = shown(checked.get(_PLANT, name))
            checked.complain(_PLANT, name, value, need, f"add it, or remove {name}")
        _check_length(checked, _PLANT, name, count, 3)
    for name in () if given else _PLACES:
        _check_length(checked, _PLANT, name, count)


def _check_length(checked: Checked, section: str, name: str, count: int, each: int = 1) -> bool:
    """Check that a list has so many numbers for each craft."""
    value = checked.get(section, name)
    if not isinstance(value, list):
        return False
    if len(value) == each * count:
        return True
    need = f"{each * count}, {'one' if each == 1 else each} for each of {count} craft"
    remedy = "give as many, or change plant.spacecraft"
    checked.complain(section, name, f"{len(value)} numbers: {shown(value)}", need, remedy)
    return False


def _check_phases(checked: Checked, count: int) -> None:
    """Check that each craft has a place of its own in the desired formation."""
    if not _check_length(checked, _GOVERNOR, "phase", count):
        return
    phases, samples = checked.get(_GOVERNOR, "phase"), _samples(checked)
    if not isinstance(phases, list) or samples is None:
        return
    places = [phase % samples for phase in phases]
    if len(set(places)) == len(places):
        return
    second = next(i for i, place in enumerate(places) if place in places[:i])
    craft: Any = checked.get(_PLANT, "spacecraft")
    pair = f"{craft[places.index(places[second])]} and {craft[second]}"
    value = f"{shown(phases)}, in which {pair} share a place"
    need = (
        f"a different place for each craft, counted modulo the {samples} control steps of the orbit"
    )
    checked.complain(_GOVERNOR, "phase", value, need, "move one of them")


def _period(checked: Checked) -> tuple[str, float] | None:
    """Return the section that gives the control period, and the period [s]."""
    for section in (_CONTROLLER, _PLANT):
        value = checked.get(section, "time_step")
        if not isinstance(value, float):
            return None
        if value > 0.0:
            return section, value
    return None


def _count(checked: Checked) -> float | None:
    """Return the control periods of an orbit; None where a value was refused."""
    found, altitude = _period(checked), checked.get(_PLANT, "altitude")
    if found is None or not isinstance(altitude, float):
        return None
    return orbital_period(altitude) / found[1]


def _samples(checked: Checked) -> int | None:
    """Return the whole number of control periods of an orbit; None: it is none."""
    count = _count(checked)
    if count is None or count < FEWEST_SAMPLES - 0.5 or abs(count - round(count)) > WHOLE * count:
        return None
    return round(count)


def _check_orbit(checked: Checked) -> int | None:
    """Return the control periods of an orbit; refuse one of no whole number of them."""
    count, found, altitude = _count(checked), _period(checked), checked.get(_PLANT, "altitude")
    samples = _samples(checked)
    if count is None or found is None or samples is not None:
        return samples
    section, period = found
    orbit = orbital_period(float(altitude))  # type: ignore[arg-type]
    whole = max(FEWEST_SAMPLES, round(count))
    value = f"{period!r} s, of which the orbit ({orbit:.10g} s) has {count:.10g}"
    need = f"a period of which it has a whole number, {FEWEST_SAMPLES} or more"
    remedy = f"use {orbit / whole!r} ({whole} control steps), or leave it out"
    checked.complain(section, "time_step", value, need, remedy)
    return None


def _check_step(checked: Checked) -> None:
    """Check that the plant makes one step in a control period: its motion has none within."""
    step, found = checked.get(_PLANT, "time_step"), _period(checked)
    if not isinstance(step, float) or found is None:
        return
    period = found[1]
    if round(period / step) > 1:
        need = f"the control period ({period!r} s), over which the motion is advanced at once"
        checked.complain(_PLANT, "time_step", f"{step!r} s", need, "leave it out")


def _check_loss(checked: Checked, craft: list[Any]) -> None:
    """Check that a craft of the formation is lost within the flight, and that somebody notices."""
    lost, at = checked.get(_PLANT, "spacecraft_lost"), checked.get(_PLANT, "spacecraft_lost_at")
    if lost is None:
        return
    if not lost:
        if checked.is_changed(_PLANT, "spacecraft_lost_at"):
            need = "spacecraft_lost beside it, the craft that is lost then"
            checked.complain(_PLANT, "spacecraft_lost_at", f"{shown(at)} s", need, "add it")
        return
    names = [name.strip("/") for name in craft]
    if str(lost).strip("/") not in names:
        need = f"one of the craft {', '.join(names)}"
        checked.complain(_PLANT, "spacecraft_lost", shown(lost), need,
                         suggestion(str(lost), names))  # fmt: skip
    _check_time_of_loss(checked, at)
    if checked.get(_GOVERNOR, "governor") == "none":
        checked.warn(
            _PLANT, "spacecraft_lost",
            f"received {lost!r}, but governor: none does not notice it; required a governor that "
            "does; choose it, unless the loss is flown on purpose",
        )  # fmt: skip


def _check_time_of_loss(checked: Checked, at: Any) -> None:
    found, duration = _period(checked), checked.get(_PLANT, "duration")
    if not isinstance(at, float) or not isinstance(duration, float) or found is None:
        return
    period = found[1]
    last = (math.floor(duration / period * (1.0 + WHOLE)) - 1) * period
    if at > last * (1.0 + WHOLE):
        need = f"a time up to the start of the last control step ({last:.10g} s)"
        remedy = "give an earlier time, or lengthen the flight"
        checked.complain(_PLANT, "spacecraft_lost_at", f"{at!r} s", need, remedy)


def _check_margins(checked: Checked) -> None:
    """Refuse margins that leave nothing of a limit; warn of none where they are needed."""
    if checked.get(_GOVERNOR, "governor") != "time_shift":
        return
    for name, limit, unit in (
        ("delta_v_margin", "max_delta_v", "m/s"),
        ("communication_angle_margin_deg", "max_communication_angle_deg", "deg"),
    ):
        margin, bound = checked.get(_GOVERNOR, name), checked.get(_PLANT, limit)
        if isinstance(margin, float) and isinstance(bound, float) and margin >= bound:
            need = f"less than plant.{limit} ({bound:g} {unit}), so that something is left of it"
            remedy = f"lower it, or raise {limit}"
            checked.complain(_GOVERNOR, name, f"{margin!r} {unit}", need, remedy)
    motion = checked.get(_PLANT, "motion")
    kept = any(checked.get(_GOVERNOR, name) != 0.0 for name in _MARGINS)
    if motion not in (None, "hill") and not kept:
        checked.warn(
            _PLANT, "motion",
            f"received {motion!r} with no margin; required {', '.join(_MARGINS)} for the "
            "constraints to hold with what the governor's linear model leaves out; set them in "
            "reference_governor",
        )  # fmt: skip


def _check_candidates(checked: Checked, count: int, samples: int) -> None:
    """Check that all combinations of shifts can be enumerated at each step."""
    if checked.get(_GOVERNOR, "governor") != "time_shift":
        return
    candidates = samples**count
    if candidates > MOST_CANDIDATES:
        most = math.floor(MOST_CANDIDATES ** (1.0 / count) + WHOLE)
        value = f"{count} craft, for which there are {samples}^{count} = {candidates:.3g} shifts"
        need = f"at most {MOST_CANDIDATES:.0e} to choose from at each step"
        remedy = f"fly fewer craft, or at most {most} control steps to an orbit"
        checked.complain(_PLANT, "spacecraft", value, need, remedy)
