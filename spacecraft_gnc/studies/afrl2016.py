"""Kolmanovsky et al. 2016 (AFRL report), part by part: one module ``afrl2016_PART`` for each."""

from __future__ import annotations

import importlib
from typing import Final

from spacecraft_gnc.studies import PARTS
from spacecraft_gnc.studies.options import Options
from spacecraft_gnc.studies.report import Report

NAME: Final = "afrl2016"
TITLE: Final = (
    "Kolmanovsky (AFRL 2016): enhanced constrained predictive control for autonomous vehicles, "
    "sections 3 and 4"
)


def run(options: Options) -> Report:
    """Run the part that is wanted, or all; return one report of them."""
    wanted = PARTS[NAME] if options.only is None else (options.only,)
    reports = [
        importlib.import_module(f"{__package__}.{NAME}_{part}").run(options) for part in wanted
    ]
    return Report(
        NAME,
        TITLE,
        [table for report in reports for table in report.tables],
        [check for report in reports for check in report.checks],
        {part: report.values for part, report in zip(wanted, reports, strict=True)},
        tuple(reports),
    )
