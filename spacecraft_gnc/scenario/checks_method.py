"""Whether the method reads what is given for it."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from typing import Final

from spacecraft_gnc.parameters.problems import shown, suggestion
from spacecraft_gnc.scenario import registry
from spacecraft_gnc.scenario.checked import Checked

_CONTROLLER: Final = "nmpc_controller"
_NOMINAL_RUN: Final = "nominal_rotation_vector"
_LONGEST_EXAMINED: Final = 1000  # steps: some seconds of computation before the flight
_OF_A_NOMINAL_RUN: Final = ("nominal_momentum", "exact_every")


def readers() -> dict[str, tuple[str, ...]]:
    """Return the built-in methods that read a parameter, where not all of them do."""
    found: dict[str, tuple[str, ...]] = {}
    for method, built_in in registry.BUILT_IN["controllers"].items():
        for name in sorted(built_in.traits.reads):
            found[name] = (*found.get(name, ()), method)
    return found


def check_method(checked: Checked) -> None:
    """Add a problem for each parameter that the method would ignore, and for an unknown variant.

    A default that is stated changes nothing, and the launcher states them all: only values that
    differ are refused. A method of another package may read anything.
    """
    method = checked.get(_CONTROLLER, "method")
    built_in = registry.BUILT_IN["controllers"].get(str(method))
    if built_in is None:
        return
    _check_variant(checked, str(method), built_in.traits.variants)
    for name, known in readers().items():
        if method not in known and checked.is_changed(_CONTROLLER, name):
            need = f"a method that reads it ({' or '.join(known)}), not {method}"
            remedy = f"remove it, or set method: {known[0]}"
            _complain(checked, name, need, remedy)
    _check_horizon(checked, built_in.traits.reads)
    if _NOMINAL_RUN not in built_in.traits.reads or checked.get(_CONTROLLER, _NOMINAL_RUN) != []:
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
    known = readers()
    for name in names:
        ignored = method not in known.get(name, (method,))
        if ignored or (name == "variant" and not built_in.traits.variants):
            yield name


def _check_horizon(checked: Checked, read: Collection[str]) -> None:
    """Refuse a horizon with which the look at the start, before the flight, takes minutes."""
    horizon = checked.get(_CONTROLLER, "horizon")
    governor = checked.get("reference_governor", "governor")
    if governor == "attitude" and "horizon" in read:
        who = "behind reference_governor.governor: attitude, which predicts the whole flight"
    elif "terminal_set" in read:
        who = "of method: terminal_set, which has to be feasible at the start"
    else:
        return
    if isinstance(horizon, int) and horizon > _LONGEST_EXAMINED:
        _complain(checked, "horizon", f"at most {_LONGEST_EXAMINED} steps {who}", "shorten it")


def _check_variant(checked: Checked, method: str, known: tuple[str, ...]) -> None:
    variant = checked.get(_CONTROLLER, "variant")
    if checked.is_changed(_CONTROLLER, "variant") and variant not in known:
        need = f"one of {', '.join(known)}" if known else f"no variant: {method} has none"
        _complain(checked, "variant", need, suggestion(str(variant), known))


def _complain(checked: Checked, name: str, need: str, remedy: str) -> None:
    checked.complain(_CONTROLLER, name, shown(checked.get(_CONTROLLER, name)), need, remedy)
