"""What a reproduction is asked for."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from spacecraft_gnc.studies.flights import Progress, quiet


@dataclass(frozen=True, kw_only=True)
class Options:
    """What of a paper is flown.

    Attributes
    ----------
    baselines : bool
        Whether to run the slow baseline solvers as well, where the paper has some.
    only : str or None
        Part of the paper; None: all of it.
    folder : Path or None
        Where the paper's campaigns are, or are flown; None: none is flown.
    runs : int or None
        Of each campaign; None: as many as its file says; 0: none is flown.
    progress : callable
        Called with what is done, how much of it, and of how much.
    """

    baselines: bool = True
    only: str | None = None
    folder: Path | None = None
    runs: int | None = None
    progress: Progress = quiet
