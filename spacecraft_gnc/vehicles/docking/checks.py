"""Checks of a scenario: ports, rotation of the chief, thrusters, start, target and hold point."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from spacecraft_gnc.parameters.checked import Checked
from spacecraft_gnc.parameters.problems import shown
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.docking import admissible

_PLANT, _CONTROLLER, _GOVERNOR = "plant", "nmpc_controller", "reference_governor"
_SLACK: Final = 1e-9
"""Share of a length or a control period by which values may be off."""
_AXES: Final = "xyz"
_MARGINS: Final = ("force_margin", "moment_margin", "distance_margin")
_METHOD_OF: Final = {"periodic": "periodic_lqr", "time_invariant": "time_invariant_lqr"}
"""Method whose loop the sets of a law are made for."""
_NOISES: Final = ("position_noise", "velocity_noise", "attitude_noise", "rate_noise")


def check(checked: Checked) -> None:
    """Add a problem for each pair of values that do not fit together."""
    _check_port(checked, "chief", 1.0)
    _check_port(checked, "deputy", -1.0)
    _check_loss(checked)
    _check_noise(checked)
    _check_law(checked)
    if not checked.problems and _PLANT in checked.given:
        admissible.check(checked)


def _check_port(checked: Checked, body: str, side: float) -> None:
    """Check that a port lies on the face that the other body docks at."""
    name = f"{body}_port"
    port, size = checked.get(_PLANT, name), checked.get(_PLANT, f"{body}_size")
    if not isinstance(port, list) or not isinstance(size, list):
        return
    half = 0.5 * np.array(size)
    face, beyond = side * half[0], np.abs(port) - half
    off = side * port[0] - half[0]
    if abs(off) <= _SLACK * half[0] and (beyond[1:] <= _SLACK * half[1:]).all():
        return
    sign = "+" if side > 0.0 else "-"
    need = (
        f"a point on face {sign}x of the {body}, which faces the other one: x = {face:g} m, "
        f"|y| <= {half[1]:g} m, |z| <= {half[2]:g} m; it is {_told(beyond, off)}"
    )
    checked.complain(_PLANT, name, f"{shown(port)} m", *_split(need, "move it there"))


def _split(need: str, remedy: str) -> tuple[str, str]:
    """Return a requirement and, with what is wrong about it, the remedy."""
    requirement, _, wrong = need.partition("; ")
    return requirement, f"{wrong}: {remedy}" if wrong else remedy


def _told(beyond: Array, off: float) -> str:
    """Return where a port is in words, from how far it is beyond each pair of faces."""
    outside = [f"{beyond[i]:.4g} m along {_AXES[i]}" for i in range(3) if beyond[i] > 0.0]
    if outside:
        return f"outside the body by {', '.join(outside)}"
    return f"{-off:.4g} m behind that face, {'on another' if not beyond.max() else 'in the body'}"


def _check_loss(checked: Checked) -> None:
    """Check that a thruster is lost within the flight, and that somebody notices."""
    direction, at = checked.get(_PLANT, "thruster_lost"), checked.get(_PLANT, "thruster_lost_at")
    duration, period = checked.get(_PLANT, "duration"), checked.get(_CONTROLLER, "time_step")
    if not direction:
        if checked.is_changed(_PLANT, "thruster_lost_at") and direction is not None:
            need = "thruster_lost beside it, the direction that is lost then"
            checked.complain(_PLANT, "thruster_lost_at", f"{shown(at)} s", need, "add it")
        return
    if isinstance(at, float) and isinstance(duration, float) and isinstance(period, float):
        last = (math.floor(duration / period + _SLACK) - 1) * period
        if at > last + _SLACK * period:
            need = f"a time up to the start of the last control step ({last:g} s)"
            remedy = "lose it earlier, or lengthen the flight"
            checked.complain(_PLANT, "thruster_lost_at", f"{at!r} s", need, remedy)
    blind = checked.get(_GOVERNOR, "governor") == "none"
    if blind or checked.get(_GOVERNOR, "aborts") is False:
        why = "governor: none does not notice it" if blind else "with aborts: false nothing is done"
        checked.warn(
            _PLANT, "thruster_lost",
            f"received {direction!r}, but {why}; required a governor that aborts; choose it, "
            "unless the loss is flown on purpose",
        )  # fmt: skip


def _check_noise(checked: Checked) -> None:
    """Warn where nothing is kept free for the noise of navigation."""
    noisy = [name for name in _NOISES if checked.get(_PLANT, name)]
    governed = checked.get(_GOVERNOR, "governor") not in (None, "none")
    if noisy and governed and not any(checked.get(_GOVERNOR, name) for name in _MARGINS):
        value = shown(checked.get(_PLANT, noisy[0]))
        checked.warn(
            _PLANT, noisy[0],
            f"received {value} with no margin; required {', '.join(_MARGINS)} for the constraints "
            "to hold with noise; set them in reference_governor",
        )  # fmt: skip


def _check_law(checked: Checked) -> None:
    """Warn of a governor whose sets are those of another law than the method's."""
    governor, method = checked.get(_GOVERNOR, "governor"), checked.get(_CONTROLLER, "method")
    fitting = _METHOD_OF.get(str(governor))
    if fitting and method in _METHOD_OF.values() and method != fitting:
        checked.warn(
            _GOVERNOR, "governor",
            f"received {governor!r} with method {method!r}, of whose loop its sets are not; "
            f"required method {fitting!r} for the constraints to be kept; change one of them",
        )  # fmt: skip
