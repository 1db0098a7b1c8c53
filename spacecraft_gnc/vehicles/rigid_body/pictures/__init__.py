"""Figures for print and moving pictures of flights."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

from spacecraft_gnc.drawing.figures import Maker
from spacecraft_gnc.vehicles.rigid_body.flown import Flown
from spacecraft_gnc.vehicles.rigid_body.pictures.comparison import comparison_makers
from spacecraft_gnc.vehicles.rigid_body.pictures.figures import flight_makers, record_makers


class RigidBodyFigures:
    """Implements `drawing.vehicle.VehicleFigures`."""

    def flight(self, run: Flown, *, title: str = "", error_scale: str = "log") -> dict[str, Maker]:
        """Return what draws each figure of one flight, by name."""
        flown = run.trajectory, run.scenario
        motion = flight_makers(*flown, title=title, error_scale=error_scale)
        return motion | record_makers(run.trajectory, run.telemetry, run.scenario)

    def comparison(self, runs: Sequence[Flown], *, error_scale: str = "log") -> dict[str, Maker]:
        """Return what draws the figures of several flights over each other, by name."""
        flown = {run.name: (run.trajectory, run.scenario) for run in runs}
        return comparison_makers(flown, error_scale=error_scale)

    def animate(self, runs: Sequence[Flown], path: Path, *, title: str = "") -> None:
        """Write a moving picture of flights side by side."""
        from spacecraft_gnc.vehicles.rigid_body.pictures.animation import save_animation

        save_animation(
            {run.name: (run.trajectory, run.scenario) for run in runs}, path, title=title
        )


FIGURES: Final = RigidBodyFigures()
