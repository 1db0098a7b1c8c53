"""Checks of a scenario against its constraints and limits: start, rotation, target, hold point."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, Final, NamedTuple

import numpy as np

from spacecraft_gnc.parameters.checked import Checked
from spacecraft_gnc.parameters.problems import shown
from spacecraft_gnc.vehicles.docking.holding import (
    DOCKED,
    Limits,
    Pose,
    clearance,
    hold_wrench,
    largest_spin_rate,
    line_of_sight_margin,
    use_of,
)

_PLANT, _CONTROLLER, _GOVERNOR = "plant", "nmpc_controller", "reference_governor"
WHOLE: Final = 1e-6
"""Share by which a rotation may miss a whole number of control periods."""
MOST_STEPS: Final = 5000
"""Control periods of a rotation, for each of which there is a gain and a set."""
_ROUNDING: Final = 1e-9  # [m]


class Held(NamedTuple):
    """A pose that the deputy is to hold, and the parameter that gives it."""

    name: str
    words: str
    pose: Pose


def check(checked: Checked) -> None:
    """Add a problem for each thing that cannot be flown within the constraints."""
    plant, governor = checked.section(_PLANT), checked.section(_GOVERNOR)
    governed = governor.governor != "none"
    _check_start(checked, plant)
    if governed and not _check_margins(checked, plant, governor):
        return
    share = governor.steady_share if governed else 1.0
    force, moment = (governor.force_margin, governor.moment_margin) if governed else (0.0, 0.0)
    limits = Limits(share * (plant.max_force - force), share * (plant.max_moment - moment))
    start = Pose(plant.initial_port_offset, plant.initial_rotation_vector)
    poses = list(_poses(governor))
    of = "steady_share of each limit less its margin" if governed else "the limits"
    if not _check_rate(checked, plant, limits, poses, of):
        return
    _check_period(checked, plant)
    for held in poses:
        _check_held(checked, plant, held, governor.distance_margin if governed else 0.0)
        _check_hold(checked, plant, held, limits)
    if governed and not checked.problems and max(_use(plant, start, limits)) > 1.0:
        _warn_of_start(checked, plant, start, limits)


def _check_start(checked: Checked, plant: Any) -> None:
    """Refuse a start with broken constraints, with each of them and by how much."""
    start = Pose(plant.initial_port_offset, plant.initial_rotation_vector)
    for name, need, remedy in _broken(plant, start, 0.0):
        key = f"initial_{name}"
        checked.complain(_PLANT, key, shown(checked.get(_PLANT, key)), need, remedy)


def _check_held(checked: Checked, plant: Any, held: Held, margin: float) -> None:
    """Refuse a target or hold point at which constraints are broken."""
    for _, need, remedy in _broken(plant, held.pose, margin):
        value = shown(checked.get(_GOVERNOR, held.name))
        checked.complain(_GOVERNOR, held.name, value, need, remedy)


def _broken(plant: Any, pose: Pose, margin: float) -> Iterator[tuple[str, str, str]]:
    """Yield parameter, requirement and remedy of each constraint that a pose breaks."""
    extra = f" less a margin of {margin:g} m" if margin else ""
    half, slack = plant.line_of_sight_half_angle_deg, plant.line_of_sight_slack
    outside = margin - line_of_sight_margin(plant, pose.port_offset)
    if outside > _ROUNDING:
        need = (
            f"|y| and |z| of at most tan({half:g} deg) x + {slack:g} m{extra}, the line-of-sight "
            f"pyramid, which it leaves by {outside:.4g} m"
        )
        yield "port_offset", need, "move it inside"
    behind = -clearance(plant, pose) - plant.clearance_tolerance + margin
    if behind > _ROUNDING:
        tolerance = f"up to {plant.clearance_tolerance:g} m behind it{extra}"
        need = (
            f"every vertex of the deputy before the chief's docking face, {tolerance}, which one "
            f"exceeds by {behind:.4g} m"
        )
        yield "port_offset", need, "move it away, or turn it"


def _check_margins(checked: Checked, plant: Any, governor: Any) -> bool:
    """Refuse margins that leave nothing of a limit, or that the docked deputy breaks."""
    force, moment = plant.max_force, plant.max_moment
    tolerance, slack = plant.clearance_tolerance, plant.line_of_sight_slack
    docked = ("docked vertices lie on the docking face", "the docked port is the pyramid's apex")
    rooms = (
        ("force_margin", "N", force, f"max_force ({force:g} N)", ""),
        ("moment_margin", "N m", moment, f"max_moment ({moment:g} N m)", ""),
        ("distance_margin", "m", tolerance, f"clearance_tolerance ({tolerance:g} m)", docked[0]),
        ("distance_margin", "m", slack, f"line_of_sight_slack ({slack:g} m)", docked[1]),
    )
    fits = True
    for name, unit, room, other, why in rooms:
        if getattr(governor, name) >= room:
            value = f"{getattr(governor, name):g} {unit}, which leaves no admissible reference"
            need = f"less than {other}" + (f", as {why}" if why else "")
            remedy = f"lower it, or raise {other.partition(' ')[0]}"
            checked.complain(_GOVERNOR, name, value, need, remedy)
            fits = False
    return fits


def _check_rate(checked: Checked, plant: Any, limits: Limits, poses: list[Held], of: str) -> bool:
    """Refuse a chief at which the docked port cannot be held, with the largest rate that works.

    ``of``: what the limits are, in words.
    """
    force, moment = _use(plant, DOCKED, limits)
    if max(force, moment) <= 1.0:
        return True
    told, name = _told(limits, force, moment), "max_force" if force >= moment else "max_moment"
    if largest_spin_rate(plant, DOCKED, limits) is None:
        need = f"enough to hold the docked port, which takes {told} even where the chief is at rest"
        checked.complain(_PLANT, name, shown(checked.get(_PLANT, name)), need, "raise it")
        return False
    value = f"{plant.chief_spin_rate!r} rad/s, at which holding the docked port takes {told}"
    works = [
        (rate, held.words)
        for held in poses
        if (rate := largest_spin_rate(plant, held.pose, limits)) is not None
    ]
    most, words = min(works)
    need = f"at most {most:.6g} rad/s, for {words} to be held within {of}"
    remedy = f"lower it to {_whole_below(most, _period(checked))} or less, or raise {name}"
    checked.complain(_PLANT, "chief_spin_rate", value, need, remedy)
    return False


def _check_period(checked: Checked, plant: Any) -> None:
    """Refuse a rotation of no whole number of control periods, with the nearest rates."""
    rate, period = float(plant.chief_spin_rate), _period(checked)
    if not rate:
        return
    count = 2.0 * math.pi / (rate * period)
    value = f"{rate!r} rad/s, a rotation of {count:.6g} control periods"
    if count > MOST_STEPS * (1.0 + WHOLE):
        need = f"a rotation of at most {MOST_STEPS} control periods of {period:g} s, or none"
        remedy = f"raise it to {_rate(MOST_STEPS, period)}, or set 0.0"
        checked.complain(_PLANT, "chief_spin_rate", value, need, remedy)
    elif abs(count - round(count)) > WHOLE * count or round(count) < 1:
        need = f"a rotation of a whole number of control periods of {period:g} s"
        nearest = sorted({max(1, math.floor(count)), max(1, math.ceil(count))})
        rates = (f"{_rate(p, period)} ({p} control periods)" for p in nearest)
        checked.complain(_PLANT, "chief_spin_rate", value, need, f"use {' or '.join(rates)}")


def _check_hold(checked: Checked, plant: Any, held: Held, limits: Limits) -> None:
    """Refuse a target or hold point that takes more than the limits to hold."""
    use = _use(plant, held.pose, limits)
    if max(use) <= 1.0:
        return
    value = f"{shown(checked.get(_GOVERNOR, held.name))}, which takes {_told(limits, *use)} to hold"
    most = largest_spin_rate(plant, held.pose, limits)
    slower = "" if most is None else (
        f", or lower plant.chief_spin_rate to {_whole_below(most, _period(checked))} or less"
    )  # fmt: skip
    need = f"{held.words} that can be held within these"
    checked.complain(_GOVERNOR, held.name, value, need, f"move it nearer{slower}")


def _warn_of_start(checked: Checked, plant: Any, start: Pose, limits: Limits) -> None:
    """Warn of a start that cannot be held, from which the governor may find no reference."""
    told = _told(limits, *_use(plant, start, limits))
    checked.warn(
        _PLANT, "initial_port_offset",
        f"received {shown(plant.initial_port_offset.tolist())}, which takes {told} to hold; "
        "required less for the start itself to be an admissible reference; start nearer, or lower "
        "chief_spin_rate",
    )  # fmt: skip


def _poses(governor: Any) -> Iterator[Held]:
    """Yield what the deputy may have to hold."""
    target = Pose(governor.target_port_offset, governor.target_rotation_vector)
    yield Held("target_port_offset", "the target", target)
    if governor.governor != "none" and governor.aborts:
        hold = Pose(governor.hold_port_offset, np.zeros(3))
        yield Held("hold_port_offset", "the hold point", hold)


def _use(plant: Any, pose: Pose, limits: Limits) -> tuple[float, float]:
    return use_of(limits, hold_wrench(plant, pose))


def _told(limits: Limits, force: float, moment: float) -> str:
    """Return what is taken in words, beside what there is."""
    return (
        f"{force * limits.force:.4g} N of {limits.force:g} N and {moment * limits.moment:.4g} N m "
        f"of {limits.moment:g} N m"
    )


def _whole_below(rate: float, period: float) -> str:
    """Return the largest rate up to one whose rotation is a whole number of control periods."""
    if not rate:
        return "0.0"
    return _rate(math.ceil(2.0 * math.pi / (rate * period) * (1.0 - WHOLE)), period)


def _rate(steps: int, period: float) -> str:
    """Return the rate of a rotation in so many control periods, as it can be pasted."""
    return repr(2.0 * math.pi / (steps * period))


def _period(checked: Checked) -> float:
    return float(checked.section(_CONTROLLER).time_step)
