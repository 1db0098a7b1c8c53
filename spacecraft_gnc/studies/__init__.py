"""Reproduction of the papers' cases: our figures beside the printed ones.

One module for each paper with a function ``run(options) -> Report``, named in `PAPERS`; for a paper
with parts, one more for each part, ``PAPER_PART``, with the same function.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterable
from difflib import get_close_matches
from typing import Final

from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.studies.options import Options
from spacecraft_gnc.studies.report import Report

PAPERS: Final = {
    "gupta2015": "spacecraft_gnc.studies.gupta2015",
    "bagherzadeh2023": "spacecraft_gnc.studies.bagherzadeh2023",
    "kalabic2014": "spacecraft_gnc.studies.kalabic2014",
    "afrl2016": "spacecraft_gnc.studies.afrl2016",
    "phogat": "spacecraft_gnc.studies.phogat",
}
"""Name for the command line and module, in the order in which all of them are run."""
PARTS: Final = {"afrl2016": ("two_wheel", "docking", "formation")}
"""Parts of the papers that treat several spacecraft, in the order in which they are run."""


def require_paper(name: str) -> None:
    """Refuse a name that no paper has.

    Raises
    ------
    ParameterError
        If there is none.
    """
    if name not in PAPERS:
        raise ParameterError(
            f"paper: received {name!r}; required one of {', '.join(PAPERS)}; "
            f"{_nearest(name, PAPERS) or 'choose one, or none for all'}"
        )


def require_part(name: str | None, part: str) -> None:
    """Refuse a part that a paper does not have.

    Raises
    ------
    ParameterError
        If no paper is named, or it has no such part.
    """
    if name is None:
        raise ParameterError(
            f"--only: received {part!r} without a paper; required one with parts "
            f"({', '.join(PARTS)}) before it; name it"
        )
    parts = PARTS.get(name)
    if parts is None:
        raise ParameterError(
            f"--only: received {part!r} of {name}, which has no parts; required a paper with parts "
            f"({', '.join(PARTS)}); leave --only out"
        )
    if part not in parts:
        raise ParameterError(
            f"--only: received {part!r}; required a part of {name}: {', '.join(parts)}; "
            f"{_nearest(part, parts) or 'choose one, or leave --only out for all'}"
        )


def reproduce(name: str, options: Options | None = None) -> Report:
    """Fly the cases of a paper.

    Parameters
    ----------
    name : str
        Of `PAPERS`.
    options : Options, optional
        What of it.

    Raises
    ------
    ParameterError
        If there is no such paper, or it has no such part.
    """
    options = options or Options()
    require_paper(name)
    if options.only is not None:
        require_part(name, options.only)
    report: Report = importlib.import_module(PAPERS[name]).run(options)
    return report


def _nearest(name: str, known: Iterable[str]) -> str:
    nearest = get_close_matches(name, list(known), n=1)
    return f"did you mean {nearest[0]}?" if nearest else ""
