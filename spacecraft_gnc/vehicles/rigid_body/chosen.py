"""Method and governor law that a scenario under check has chosen."""

from __future__ import annotations

from spacecraft_gnc.parameters.checked import Checked
from spacecraft_gnc.vehicles.rigid_body.controllers.methods import METHODS
from spacecraft_gnc.vehicles.rigid_body.governors.laws import LAWS
from spacecraft_gnc.vehicles.rigid_body.parameters.governor import AttitudeLawParameters
from spacecraft_gnc.vehicles.vehicle import GovernorLaw, Method


def own_method(checked: Checked) -> Method | None:
    """Return the method; None where it is another package's."""
    name = checked.get("nmpc_controller", "method")
    return next((method for method in METHODS if method.name == name), None)


def method_reads(checked: Checked, parameters: type) -> bool:
    """Tell whether the method is one of ours that reads these parameters."""
    method = own_method(checked)
    return method is not None and reads_all(method, parameters)


def reads_all(method: Method, parameters: type) -> bool:
    """Tell whether a method reads these parameters, a dataclass that methods share."""
    return method.parameters is not None and issubclass(method.parameters, parameters)


def own_law(checked: Checked) -> GovernorLaw | None:
    """Return the governor law; None where it is another package's."""
    name = checked.get("reference_governor", "governor")
    return next((law for law in LAWS if law.name == name), None)


def is_governed(checked: Checked) -> bool:
    """Tell whether the governor is ours that predicts the flight."""
    law = own_law(checked)
    return law is not None and law.parameters is AttitudeLawParameters


def moves(checked: Checked) -> bool:
    """Tell whether the governor is one of ours whose reference moves by itself."""
    law = own_law(checked)
    return law is not None and law.moves
