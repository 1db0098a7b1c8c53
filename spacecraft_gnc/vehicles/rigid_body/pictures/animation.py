"""Animated GIF of one flight, or of several side by side."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.moving import frame_times, require_few, write_gif
from spacecraft_gnc.vehicles.rigid_body.pictures._animated_run import animated_run
from spacecraft_gnc.vehicles.rigid_body.pictures._scene import Scene

if TYPE_CHECKING:
    from spacecraft_gnc.loop.flight import Flight
    from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario


def save_animation(
    flights: Mapping[str, tuple[Flight, Scenario | None]], path: Path, *, title: str = ""
) -> None:
    """Write the moving picture of flights, which starts again at its end, in one step.

    Parameters
    ----------
    flights
        Flight and scenario by name, three at the most; the scenario gives the torque limit and
        the pointing zones with the axes of the instruments.
    path
        The .gif file.
    title
        Heading.

    Raises
    ------
    ParameterError
        If there are more flights.
    RecordingError
        If the file cannot be written; nothing is left then.
    """
    require_few(list(flights))
    runs = [animated_run(name, *flown, i) for i, (name, flown) in enumerate(flights.items())]
    with style.applied():
        write_gif(Scene(runs, title).frame, frame_times(runs), path)
