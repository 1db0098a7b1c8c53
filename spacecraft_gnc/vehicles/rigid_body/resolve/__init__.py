"""Re-solution of every recorded step: numbers, costs, a table and a figure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from spacecraft_gnc.vehicles.rigid_body.resolve.comparison import compare
from spacecraft_gnc.vehicles.rigid_body.resolve.replay import resolve
from spacecraft_gnc.vehicles.rigid_body.resolve.table import differences, sides

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from spacecraft_gnc.vehicles.rigid_body.resolve.replay import Resolved


class RigidBodyReplay:
    """Implements `vehicles.replay.VehicleReplay`."""

    control = "torque"
    resolve = staticmethod(resolve)
    compare = staticmethod(compare)
    sides = staticmethod(sides)
    differences = staticmethod(differences)

    def figure(self, resolved: Resolved, names: tuple[str, str], title: str = "") -> Figure:
        """Draw recorded and replayed torque, their difference, iterations and solve times."""
        from spacecraft_gnc.vehicles.rigid_body.resolve.figure import figure

        return figure(resolved, names, title)


REPLAY: Final = RigidBodyReplay()
