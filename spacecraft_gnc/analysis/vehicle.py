"""Access to the parts of a recorded run's vehicle."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from spacecraft_gnc.errors import ParameterError, RecordingError
from spacecraft_gnc.lazy import Lazy
from spacecraft_gnc.parameters.sections import DEFAULT_VEHICLE
from spacecraft_gnc.scenario.provenance import RUN_RECORD
from spacecraft_gnc.vehicles.registry import VEHICLES, is_known, vehicle_of

if TYPE_CHECKING:
    from spacecraft_gnc.recording.bag import Bag
    from spacecraft_gnc.scenario import Scenario
    from spacecraft_gnc.vehicles.vehicle import Vehicle


def part(name: str, scenario: Scenario | None = None) -> Any:
    """Return a part of the vehicle that flew, imported when it is first needed.

    Parameters
    ----------
    name
        Of the part, an attribute of `Vehicle`.
    scenario
        What flew; None: not known, and then it is the vehicle of scenarios that name none.

    Raises
    ------
    ParameterError
        If the vehicle has no such part.
    """
    return part_of(name, _vehicle(scenario))


def part_of(name: str, vehicle: Vehicle) -> Any:
    """Return a part of a vehicle, likewise.

    Raises
    ------
    ParameterError
        If it has no such part.
    """
    found: Lazy | None = getattr(vehicle, name)
    if found is None:
        raise ParameterError(
            f"vehicle {vehicle.name}: received a flight to read by its part {name!r}, which it "
            "does not have; required a vehicle with that part; see docs/architecture.md"
        )
    return found.load()


def has_part(name: str, scenario: Scenario | None = None) -> bool:
    """Tell whether the vehicle that flew has a part."""
    return getattr(_vehicle(scenario), name) is not None


def _vehicle(scenario: Scenario | None) -> Vehicle:
    return vehicle_of(DEFAULT_VEHICLE) if scenario is None else scenario.vehicle


def common_part(name: str, scenarios: Sequence[Scenario | None]) -> Any:
    """Return, likewise, the part that draws several runs beside each other.

    Raises
    ------
    ParameterError
        If they are of different vehicles.
    """
    vehicles = dict.fromkeys(_vehicle(scenario).name for scenario in scenarios)
    if len(vehicles) > 1:
        raise ParameterError(
            f"runs: received flights of vehicles {', '.join(vehicles)}; required flights of one; "
            "give them one vehicle at a time, or one spacecraft of a bag with --namespace"
        )
    return part(name, scenarios[0])


def require_vehicle(bag: Bag) -> None:
    """Refuse a bag whose vehicle is not installed, where its flight is to be understood.

    Raises
    ------
    RecordingError
        With its name and package, as the recorder wrote them down.
    """
    run = bag.metadata().get(RUN_RECORD, {})
    for key, name in run.items():  # of several agents: sc1.vehicle
        if key.rpartition(".")[2] != "vehicle" or not name or is_known(VEHICLES, name):
            continue
        package = run.get(f"{key}_package", "")
        origin = f" of package {package}" if package else ""
        raise RecordingError(
            f"{bag.path}: received a flight of vehicle {name!r}{origin}, which is not installed; "
            "required it, for what its numbers mean; install it (gnc inspect, export and recover "
            "need no vehicle)"
        )
