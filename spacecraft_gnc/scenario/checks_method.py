"""Whether the method reads what is given for it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Final

from spacecraft_gnc.scenario import registry
from spacecraft_gnc.scenario.checked import Checked
from spacecraft_gnc.scenario.problems import shown, suggestion

_CONTROLLER: Final = "nmpc_controller"
_NEWTON: Final = ("shooting", "neighboring_extremal")
_NEIGHBORING: Final = ("neighboring_extremal",)
_TERMINAL_SET: Final = ("terminal_set",)
_PENALISED: Final = ("shooting", "neighboring_extremal", "slsqp", "fsolve")
_OPTIMAL: Final = (*_PENALISED, *_TERMINAL_SET)
_FEEDBACK: Final = ("feedback",)
READERS: Final = {
    "formulation": _NEWTON,
    "step_rule": _NEWTON,
    "damping": _NEWTON,
    "continuation": _NEWTON,
    "nominal_rotation_vector": _NEIGHBORING,
    "nominal_momentum": _NEIGHBORING,
    "exact_every": _NEIGHBORING,
    "ne_tolerance": _NEIGHBORING,
    "ne_max_age": _NEIGHBORING,
    "terminal_set": _TERMINAL_SET,
    "stage_cost_scale": _TERMINAL_SET,
    "weights.stage_rate": _TERMINAL_SET,
    "weights.stage_momentum": _PENALISED,
    "weights.terminal_attitude": _PENALISED,
    "weights.terminal_momentum": _PENALISED,
    "torque_penalty": _PENALISED,
    "actuators": _PENALISED,
    "standstill_error_deg": _PENALISED,
    "weights.stage_attitude": _OPTIMAL,
    "weights.stage_torque": _OPTIMAL,
    "horizon": _OPTIMAL,
    "residual_tolerance": _OPTIMAL,
    "max_iterations": _OPTIMAL,
    "feedback_attitude_gain": _FEEDBACK,
    "feedback_momentum_gain": _FEEDBACK,
}
"""Parameter -> built-in methods that read it; those that all read are absent."""
_OF_A_NOMINAL_RUN: Final = ("nominal_momentum", "exact_every")


def check_method(checked: Checked) -> None:
    """Add a problem for each parameter that the method would ignore, and for an unknown variant.

    A default that is stated changes nothing, and the launcher states them all: only values that
    differ are refused. A method of another package may read anything.
    """
    method = checked.get(_CONTROLLER, "method")
    built_in = registry.BUILT_IN["controllers"].get(str(method))
    if built_in is None:
        return
    _check_variant(checked, str(method), built_in.variants)
    for name, readers in READERS.items():
        if method not in readers and checked.is_changed(_CONTROLLER, name):
            need = f"a method that reads it ({' or '.join(readers)}), not {method}"
            remedy = f"remove it, or set method: {readers[0]}"
            _complain(checked, name, need, remedy)
    nominal = checked.get(_CONTROLLER, "nominal_rotation_vector")
    if method not in _NEIGHBORING or nominal != []:
        return
    for name in _OF_A_NOMINAL_RUN:
        if checked.is_changed(_CONTROLLER, name):
            need = "nominal_rotation_vector beside it, as there is no nominal run without"
            _complain(checked, name, need, "give nominal_rotation_vector, or remove it")


def unread_by(method: str, names: Iterable[str]) -> Iterator[str]:
    """Yield those of a controller's parameters that a method of this package would ignore."""
    built_in = registry.BUILT_IN["controllers"].get(method)
    if built_in is None:
        return
    for name in names:
        ignored = method not in READERS.get(name, (method,))
        if ignored or (name == "variant" and not built_in.variants):
            yield name


def _check_variant(checked: Checked, method: str, known: tuple[str, ...]) -> None:
    variant = checked.get(_CONTROLLER, "variant")
    if checked.is_changed(_CONTROLLER, "variant") and variant not in known:
        need = f"one of {', '.join(known)}" if known else f"no variant: {method} has none"
        _complain(checked, "variant", need, suggestion(str(variant), known))


def _complain(checked: Checked, name: str, need: str, remedy: str) -> None:
    checked.complain(_CONTROLLER, name, shown(checked.get(_CONTROLLER, name)), need, remedy)
