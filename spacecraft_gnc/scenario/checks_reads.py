"""Whether the method and the governor read what is given for them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import lru_cache
from typing import Final

from spacecraft_gnc.parameters.checked import Checked
from spacecraft_gnc.parameters.problems import shown, suggestion
from spacecraft_gnc.vehicles.registry import CONTROLLERS, GOVERNORS, KEYS
from spacecraft_gnc.vehicles.vehicle import GovernorLaw, Method, Vehicle

_CONTROLLER: Final = "nmpc_controller"
_VARIANT: Final = "variant"


@lru_cache(maxsize=64)
def readers(laws: tuple[Method, ...] | tuple[GovernorLaw, ...]) -> Mapping[str, tuple[str, ...]]:
    """Return the methods or laws that read a parameter, where not all of them do."""
    found: dict[str, tuple[str, ...]] = {}
    for law in laws:
        for name in sorted(law.reads):
            found[name] = (*found.get(name, ()), law.name)
    return found


def check_reads(checked: Checked, vehicle: Vehicle) -> None:
    """Add a problem for each parameter that method or governor would ignore.

    A default that is stated changes nothing, and the launcher states them all: only values that
    differ are refused. A method or a governor of another package may read anything.
    """
    for group, laws in ((CONTROLLERS, vehicle.methods), (GOVERNORS, vehicle.governors)):
        section, _, noun = KEYS[group].partition(".")
        chosen = checked.get(section, noun)
        if chosen not in [law.name for law in laws]:
            continue
        for name, known in readers(laws).items():
            if chosen not in known and checked.is_changed(section, name):
                need = f"a {noun} that reads it ({' or '.join(known)}), not {chosen}"
                remedy = f"remove it, or set {noun}: {known[0]}"
                checked.complain(section, name, shown(checked.get(section, name)), need, remedy)
    method = vehicle.method(str(checked.get(_CONTROLLER, "method")))
    if method is not None:
        _check_variant(checked, method)


def unread_by(vehicle: Vehicle, method: str, names: Iterable[str]) -> Iterator[str]:
    """Yield those of a controller's parameters that a method of the vehicle would ignore."""
    own = vehicle.method(method)
    if own is None:
        return
    known = readers(vehicle.methods)
    for name in names:
        ignored = method not in known.get(name, (method,))
        if ignored or (name == _VARIANT and not own.variants):
            yield name


def _check_variant(checked: Checked, method: Method) -> None:
    variant, known = checked.get(_CONTROLLER, _VARIANT), method.variants
    if checked.is_changed(_CONTROLLER, _VARIANT) and variant not in known:
        need = f"one of {', '.join(known)}" if known else f"no variant: {method.name} has none"
        remedy = suggestion(str(variant), known)
        checked.complain(_CONTROLLER, _VARIANT, shown(variant), need, remedy)
