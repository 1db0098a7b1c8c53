"""Pictures of the parts of Kolmanovsky et al. 2016."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from spacecraft_gnc.studies.report import Report


def figures(*parts: Report) -> Iterator[tuple[str, Figure]]:
    """Yield name and figure, part by part."""
    for part in parts:
        yield from part.draw()
