"""The report as one HTML file that needs nothing else."""

from __future__ import annotations

import html
import json
from collections.abc import Iterable, Sequence
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import Any, Final

from spacecraft_gnc import __version__
from spacecraft_gnc.analysis.report import tables
from spacecraft_gnc.analysis.report.runs import Run
from spacecraft_gnc.analysis.vehicle import common_part
from spacecraft_gnc.drawing.chart import Chart
from spacecraft_gnc.drawing.envelope import budget, per_interval
from spacecraft_gnc.drawing.vehicle import VehicleReport
from spacecraft_gnc.drawing.whole_file import whole_file

# Nothing may be fetched, whatever a script in the page may ask for. plotly.js compiles the code of
# its 3-D scenes when it runs.
_POLICY: Final = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval'; style-src 'unsafe-inline'; "
    "img-src data: blob:; form-action 'none'; base-uri 'none'"
)


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
    vehicle: VehicleReport = common_part("report", [run.scenario for run in runs])
    charts = list(vehicle.charts(runs, points))
    view, note = vehicle.scene(runs, points)
    heading = html.escape(title or ", ".join(run.name for run in runs))
    data = {"charts": [chart.data() for chart in charts], "view": view}
    parts = {
        "title": heading,
        "several": "several" if len(runs) > 1 else "",
        "version": html.escape(__version__),
        "policy": _POLICY,
        "style": _resource("report.css"),
        "warnings": tables.warnings(runs),
        "thinned": _thinned(runs, points),
        "summary": tables.summary(runs, vehicle.rows),
        "verdicts": tables.verdicts(runs),
        "run_options": _options(run.name for run in runs),
        "frames_note": html.escape(note),
        "charts": "".join(_chart(chart) for chart in paired(charts)),
        "scenarios": tables.scenarios(runs),
        "recordings": tables.recordings(runs),
        "data": _embedded(data),
        "plotly": _plotly(),
        "script": "\n".join([_resource("report.js"), vehicle.scene_script()]),
    }
    return _filled(_resource("report.html"), parts)


def write_report(text: str, target: Path) -> None:
    """Write a page, whole or not at all.

    Raises
    ------
    RecordingError
        If the file cannot be written.
    """
    with whole_file(target) as file:
        file.write_text(text, encoding="utf-8")


def _filled(page: str, parts: dict[str, str]) -> str:
    """Put the parts into their places: what a part holds is never looked at again."""
    pieces = page.split("{{")
    done = [pieces[0]]
    for piece in pieces[1:]:
        name, _, rest = piece.partition("}}")
        done += [parts[name], rest]
    return "".join(done)


def paired(charts: Sequence[Chart]) -> list[Chart]:
    """Return the charts so that both columns end alike above each wide one, and at the end.

    Where they would not, one more chart becomes wide: the last one that helps.
    """
    done: list[Chart] = []
    group: list[Chart] = []
    for chart in charts:
        group.append(chart)
        if chart.wide:
            done += _balanced(group)
            group = []
    return done + _balanced(group)


def _balanced(group: list[Chart]) -> list[Chart]:
    wider = (
        [*group[:i], replace(group[i], wide=True), *group[i + 1 :]]
        for i in reversed(range(len(group)))
    )
    return min((group, *wider), key=_blank)


def _blank(charts: Sequence[Chart]) -> int:
    """Return how much is left blank, in heights of a chart, where each goes to the shorter side."""
    left, right, blank = 0, 0, 0
    for chart in charts:
        height = 2 if chart.tall else 1
        if chart.wide:
            blank += abs(left - right)
            left = right = max(left, right) + height
        elif left <= right:
            left += height
        else:
            right += height
    return blank + abs(left - right)


def _chart(chart: Chart) -> str:
    name, controls = chart.name, ""
    if chart.scale:
        controls = (
            f'<label class=control><input type=checkbox data-scale="{name}" checked> '
            "logarithmic</label>"
        )
    if chart.variants:
        options = "".join(
            f'<option value="{i}">{html.escape(variant.label)}</option>'
            for i, variant in enumerate(chart.variants)
        )
        select = f'<select data-variants="{name}">{options}</select>'
        controls = f"<label class=control>shown as {select}</label>"
    note = chart.note or (chart.variants[0].note if chart.variants else "")
    shape = " wide" if chart.wide else ""
    return (
        f'<section class="chart{shape}" aria-labeledby="h-{name}"><div class=head>'
        f'<h3 id="h-{name}">{html.escape(chart.title)}</h3>{controls}</div>'
        f'<div id="{name}" class=plot role=img aria-label="{html.escape(chart.title)}"></div>'
        f'<p class=note id="n-{name}">{html.escape(note)}</p></section>'
    )


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


def _embedded(data: dict[str, Any]) -> str:
    """Return JSON that no HTML parser takes for markup."""
    text = json.dumps(data, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _plotly() -> str:
    from plotly.offline import get_plotlyjs

    return str(get_plotlyjs()).replace("</script", "<\\/script")


def _resource(name: str) -> str:
    return resources.files(__package__).joinpath(name).read_text(encoding="utf-8")
