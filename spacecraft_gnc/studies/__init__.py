"""Reproduction of the papers' cases: our figures beside the printed ones.

One module for each paper with a function ``run(baselines, progress) -> Report``, named in `PAPERS`.
"""

from __future__ import annotations

import importlib
from difflib import get_close_matches
from typing import Final

from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.studies.flights import Progress, quiet
from spacecraft_gnc.studies.report import Report

PAPERS: Final = {
    "gupta2015": "spacecraft_gnc.studies.gupta2015",
    "bagherzadeh2023": "spacecraft_gnc.studies.bagherzadeh2023",
    "kalabic2014": "spacecraft_gnc.studies.kalabic2014",
}
"""Name for the command line and module, in the order in which all of them are run."""


def require_paper(name: str) -> None:
    """Refuse a name that no paper has.

    Raises
    ------
    ParameterError
        If there is none.
    """
    if name not in PAPERS:
        nearest = get_close_matches(name, PAPERS, n=1)
        remedy = f"did you mean {nearest[0]}?" if nearest else "choose one, or none for all"
        raise ParameterError(
            f"paper: received {name!r}; required one of {', '.join(PAPERS)}; {remedy}"
        )


def reproduce(name: str, *, baselines: bool = True, progress: Progress = quiet) -> Report:
    """Fly the cases of a paper.

    Parameters
    ----------
    name : str
        Of `PAPERS`.
    baselines : bool, optional
        Whether to fly the slow baseline solvers as well, where the paper has some.
    progress : callable, optional

    Raises
    ------
    ParameterError
        If there is no such paper.
    """
    require_paper(name)
    report: Report = importlib.import_module(PAPERS[name]).run(baselines, progress)
    return report
