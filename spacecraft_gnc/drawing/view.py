"""What the 3-D views of a page have in common: their words, their code and their states."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib import resources
from typing import Any, Final, NamedTuple, Protocol

from numpy.typing import NDArray

from spacecraft_gnc.drawing.envelope import strided
from spacecraft_gnc.drawing.traces import packed
from spacecraft_gnc.types import Array

POINTS: Final = 600
"""States that a run steps through at the most where each moves a whole scene."""


class Words(NamedTuple):
    """What the page says of a view."""

    link: str
    """In the list of its parts."""
    heading: str
    label: str
    """What the picture shows, for who cannot see it."""
    note: str
    """How to read it; ``{diamonds}`` stands for what the reference is called."""


class View(NamedTuple):
    """A 3-D view of the page."""

    data: dict[str, Any]
    """For ``drawView(data)`` of its script."""
    frames: str
    """Which states it steps through."""
    words: Words


class Moving(Protocol):
    """What moves in a view."""

    @property
    def name(self) -> str:
        """Of the run."""

    @property
    def n_steps(self) -> int:
        """Control steps."""


@dataclass(frozen=True, slots=True)
class Readout:
    """A line of the readout."""

    label: str
    """With unit."""
    values: Array
    """(n + 1, k)."""
    notes: Sequence[str] = ()
    """(n + 1,) words beside them."""
    is_count: bool = False
    """Whether they are whole numbers; else four significant digits are shown."""


def readout_data(
    lines: Sequence[Readout], n_states: int, chosen: NDArray[Any]
) -> Iterator[dict[str, Any]]:
    """Yield the lines of the readout at the chosen ones of so many states."""
    for line in lines:
        values = line.values.reshape(n_states, -1)
        yield {
            "label": line.label, "values": packed(values[chosen]), "width": values.shape[1],
            **({"fixed": 0} if line.is_count else {"significant": 4}),
            "notes": [line.notes[i] for i in chosen] if line.notes else [],
        }  # fmt: skip


def script(name: str) -> str:
    """Return the code of the view NAME.js, with what every view needs before it."""
    folder = resources.files(__package__)
    return "\n".join((folder / file).read_text(encoding="utf-8") for file in ("view.js", name))


def frames_note(motions: Sequence[Moving], points: int) -> str:
    """Return which states the slider steps through."""
    strides = {
        motion.name: int(strided(motion.n_steps + 1, points)[1])
        for motion in motions
        if motion.n_steps >= points
    }
    if not strides:
        return "The slider steps through every recorded state."
    listed = ", ".join(f"every {stride}th state of {name}" for name, stride in strides.items())
    return f"Long run: the slider steps through {listed}."
