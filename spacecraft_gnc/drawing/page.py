"""Pages of charts: one self-contained HTML file each."""

from __future__ import annotations

import html
import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import Any, Final

from spacecraft_gnc import __version__
from spacecraft_gnc.drawing.chart import Chart
from spacecraft_gnc.drawing.whole_file import whole_file

# Nothing may be fetched, whatever a script in the page may ask for. plotly.js compiles the code of
# its 3-D scenes when it runs.
_POLICY: Final = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval'; style-src 'unsafe-inline'; "
    "img-src data: blob:; form-action 'none'; base-uri 'none'"
)


def filled_page(
    package: str, name: str, parts: Mapping[str, str], data: Mapping[str, Any], script: str = ""
) -> str:
    """Return a page: a body with its parts, its data, the library of charts and the scripts.

    Parameters
    ----------
    package
        That holds the body NAME.html, and NAME.css and NAME.js, which are added to those of every
        page of charts.
    name
        Of these files.
    parts
        HTML of the places of the body, which are named ``{{like_this}}``; also ``title`` and
        ``kind``, the heading and what is below it.
    data
        ``charts`` (`Chart.data` of each), and what the page's own script needs.
    script
        Further code.
    """
    common = {
        "version": html.escape(__version__),
        "policy": _POLICY,
        "style": _resource(__package__, "page.css") + _resource(package, f"{name}.css"),
        "data": _embedded(data),
        "plotly": _plotly(),
        "script": "\n".join(
            [_resource(__package__, "page.js"), _resource(package, f"{name}.js"), script]
        ),
    }
    body = _filled(_resource(package, f"{name}.html"), parts)
    return _filled(_resource(__package__, "page.html"), {**parts, **common, "body": body})


def write_page(text: str, target: Path) -> None:
    """Write a page, whole or not at all.

    Raises
    ------
    RecordingError
        If the file cannot be written.
    """
    with whole_file(target) as file:
        file.write_text(text, encoding="utf-8")


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


def chart_sections(charts: Sequence[Chart]) -> str:
    """Return the HTML of the charts' places, headings, controls and notes, paired up."""
    return "".join(_section(chart) for chart in paired(charts))


def _section(chart: Chart) -> str:
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
        f'<section class="chart{shape}" aria-labelledby="h-{name}"><div class=head>'
        f'<h3 id="h-{name}">{html.escape(chart.title)}</h3>{controls}</div>'
        f'<div id="{name}" class=plot role=img aria-label="{html.escape(chart.title)}"></div>'
        f'<p class=note id="n-{name}">{html.escape(note)}</p></section>'
    )


def _filled(page: str, parts: Mapping[str, str]) -> str:
    """Put the parts into their places: what a part holds is never looked at again."""
    pieces = page.split("{{")
    done = [pieces[0]]
    for piece in pieces[1:]:
        name, _, rest = piece.partition("}}")
        done += [parts[name], rest]
    return "".join(done)


def _embedded(data: Mapping[str, Any]) -> str:
    """Return JSON that no HTML parser takes for markup."""
    text = json.dumps(data, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _plotly() -> str:
    from plotly.offline import get_plotlyjs

    return str(get_plotlyjs()).replace("</script", "<\\/script")


def _resource(package: str, name: str) -> str:
    return resources.files(package).joinpath(name).read_text(encoding="utf-8")
