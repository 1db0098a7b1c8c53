"""The report as one HTML file that needs nothing else."""

from __future__ import annotations

import html
from collections.abc import Iterable, Sequence
from typing import Final

from spacecraft_gnc.analysis.plans import report_part
from spacecraft_gnc.analysis.report import tables
from spacecraft_gnc.analysis.report.runs import Run
from spacecraft_gnc.drawing.envelope import budget, per_interval
from spacecraft_gnc.drawing.page import chart_sections, filled_page

_FLIGHT_WORDS: Final = {
    "diamonds": "the reference",
    "audit_link": "Audit",
    "audit_heading": "Audit: integrated and certified again",
    "scenario_heading": "Scenario as flown",
    "recording_link": "Recording",
    "recording_heading": "Recording: host, versions, losses",
}
_PLAN_WORDS: Final = {
    "diamonds": "the goal",
    "audit_link": "Conditions",
    "audit_heading": "Conditions of the optimum",
    "scenario_heading": "Scenario as planned",
    "recording_link": "File",
    "recording_heading": "File",
}


def report_html(runs: Sequence[Run], title: str = "") -> str:
    """Return the report of one or several runs as a page.

    Parameters
    ----------
    runs
        At least one; each later one is compared with the first.
    title
        Heading; default: the names of the runs.
    """
    points = budget(len(runs))
    vehicle = report_part(runs)
    planned = runs[0].info.is_plan
    charts = list(vehicle.charts(runs, points))
    view = vehicle.scene(runs, points)
    words = _PLAN_WORDS if planned else _FLIGHT_WORDS
    parts = {
        "kind": "Plan" if planned else "Flight report",
        "title": html.escape(title or ", ".join(run.name for run in runs)),
        "several": "several" if len(runs) > 1 else "",
        "warnings": tables.warnings(runs),
        "thinned": _thinned(runs, points),
        "summary": tables.summary(runs, vehicle.rows),
        "verdicts": tables.verdicts(runs),
        "run_options": _options(run.name for run in runs),
        "view_link": html.escape(view.words.link),
        "view_heading": html.escape(view.words.heading),
        "view_label": html.escape(view.words.label),
        "view_note": html.escape(view.words.note.format_map(words)),
        "frames_note": html.escape(view.frames),
        "charts": chart_sections(charts),
        "scenarios": tables.scenarios(runs),
        "recordings": tables.recordings(runs),
    }
    parts |= words
    data = {"charts": [chart.data() for chart in charts], "view": view.data}
    return filled_page(__package__, "report", parts, data, vehicle.scene_script())


def _thinned(runs: Sequence[Run], points: int) -> str:
    """Return the note that long runs are drawn as envelopes; empty where every sample is drawn."""
    widths = {run.name: per_interval(run.trajectory.n_steps + 1, points) for run in runs}
    long = [f"{name} ({width} steps an interval)" for name, width in widths.items() if width > 1]
    if not long:
        return ""
    return (
        '<p class="thinned" role="note">Long runs are drawn as the least and the greatest value of '
        f"each interval, so that no extreme is lost: {html.escape(', '.join(long))}. The summary "
        "is of every step; <code>gnc export</code> gives every sample.</p>"
    )


def _options(names: Iterable[str]) -> str:
    return "".join(
        f'<option value="{i}">{html.escape(name)}</option>' for i, name in enumerate(names)
    )
