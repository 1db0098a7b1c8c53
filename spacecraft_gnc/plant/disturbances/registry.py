"""Disturbances by name.

Another package adds its own by an entry point in the group ``spacecraft_gnc.disturbances``, which
names a class with a class method ``from_parameters(parameters, inertia)`` that returns a
`Disturbance`. Its own parameters are in ``parameters.plugin``: those that the scenario's section of
the plant gives as ``plugin.<name>``. A built-in one wins over an entry point of the same name.
"""

from __future__ import annotations

from importlib import metadata
from typing import TYPE_CHECKING, Any, Final

from spacecraft_gnc.errors import GncError, ParameterError
from spacecraft_gnc.parameters.problems import shown, suggestion
from spacecraft_gnc.plant.disturbances.parameters import BUILT_IN, DisturbanceParameters
from spacecraft_gnc.types import Matrix3

if TYPE_CHECKING:
    from spacecraft_gnc.plant.disturbances.torques import Disturbance, Disturbances

GROUP: Final = "spacecraft_gnc.disturbances"


def names() -> tuple[str, ...]:
    """Return the names known, the built-in ones first."""
    plugins = (entry.name for entry in metadata.entry_points(group=GROUP))
    return tuple(dict.fromkeys([*BUILT_IN, *sorted(plugins)]))


def not_installed(parameters: DisturbanceParameters) -> tuple[str, ...]:
    """Return those of the names that ``parameters`` lists that are not known here."""
    known = names()
    return tuple(name for name in parameters.disturbances if name not in known)


def build(parameters: DisturbanceParameters, inertia: Matrix3) -> Disturbances:
    """Return the disturbances that ``parameters`` lists.

    Parameters
    ----------
    parameters : DisturbanceParameters
        Section of the plant.
    inertia : (3, 3) array
        Inertia of the whole spacecraft, body frame [kg m^2].

    Raises
    ------
    GncError
        If a name is unknown, a plug-in is broken, or a part refuses its parameters; the first
        reason of `refusals`.
    """
    from spacecraft_gnc.plant.disturbances.torques import Disturbances

    return Disturbances(
        {name: _build(name, parameters, inertia) for name in parameters.disturbances}
    )


def refusals(parameters: DisturbanceParameters, inertia: Matrix3) -> tuple[GncError, ...]:
    """Return every reason why `build` would refuse; each names the parameter first."""
    found = []
    for name in parameters.disturbances:
        try:
            _build(name, parameters, inertia)
        except GncError as error:
            found.append(error)
    return tuple(found)


def _build(name: str, parameters: DisturbanceParameters, inertia: Matrix3) -> Disturbance:
    if name in BUILT_IN:
        part: Disturbance = BUILT_IN[name].from_parameters(parameters, inertia)
        return part
    try:
        part = _plugin(name).from_parameters(parameters, inertia)
    except GncError:
        raise
    except Exception as error:  # a plug-in may raise anything, when it is imported too
        raise _broken(name, f"fails with {type(error).__name__}: {error}") from error
    if not callable(getattr(part, "torque", None)):
        raise _broken(name, "returns an object without a method torque(motion)")
    return part


def _plugin(name: str) -> Any:
    for entry in metadata.entry_points(group=GROUP):
        if entry.name == name:
            return entry.load()
    known = names()
    raise ParameterError(
        f"disturbances: received {shown(name)}; required one of {', '.join(known)}; "
        f"{suggestion(name, known)}"
    )


def _broken(name: str, reason: str) -> ParameterError:
    line = " ".join(reason.split())  # whatever the plug-in raised
    return ParameterError(
        f"disturbances: received {shown(name)}, a plug-in that {line}; required a class with a "
        "class method from_parameters(parameters, inertia); mend or reinstall its package"
    )
