"""Tables of the report: metrics side by side, warnings, provenance of each recording."""

from __future__ import annotations

import html
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Final

from spacecraft_gnc.analysis.report.runs import Run
from spacecraft_gnc.drawing.table import Row

_CHECK_HEADS: Final = ("Check", "Steps", "Worst", "Tolerance", "Verdict")
_BADGES: Final = {True: "passed", False: "failed", None: "unknown"}


def summary(runs: Sequence[Run], rows: Sequence[Row]) -> str:
    """Return the table of metrics, one column for each run; later ones with the difference."""
    head = "".join(f'<th scope="col">{_text(run.name)}</th>' for run in runs)
    lines = [f'<thead><tr><th scope="col">Metric</th>{head}</tr></thead><tbody>']
    if not runs[0].info.is_plan:
        lines += [_line("Flown by", [_method(run) for run in runs])]
        lines += [_line("Audit", [_badge(run) for run in runs])]
    for row in rows:
        if row.is_shown(runs):
            unit = f" <span class=unit>[{row.unit}]</span>" if row.unit else ""
            lines.append(_line(f"{_text(row.label)}{unit}", _cells(row, runs)))
    return f'<table class="summary">{"".join(lines)}</tbody></table>'


def warnings(runs: Sequence[Run]) -> str:
    """Return the box of everything that a reader should know first; empty if there is nothing."""
    items = [
        f"<li><b>{_text(run.name)}</b>: {_text(line)}</li>"
        for run in runs
        for line in run.warnings()
    ]
    if not items:
        return ""
    return f'<div class="warnings" role="note"><h2>Warnings</h2><ul>{"".join(items)}</ul></div>'


def verdicts(runs: Sequence[Run]) -> str:
    """Return the audit of each run; its table is folded up."""
    return "".join(_audit(run) for run in runs)


def _audit(run: Run) -> str:
    text = f"{_badge(run)} {_text(run.name)}: <span class=unit>{_text(run.verdict.text)}</span>"
    if not run.verdict.checks:
        return f"<p>{text}</p>"
    heads = "".join(f"<th scope=col>{name}</th>" for name in _CHECK_HEADS)
    rows = "".join(
        f"<tr>{''.join(f'<td>{_text(cell)}</td>' for cell in line)}</tr>"
        for line in run.verdict.checks
    )
    table = f"<table><thead><tr>{heads}</tr></thead><tbody>{rows}</tbody></table>"
    return f"<details><summary>{text}</summary><div class=scroll>{table}</div></details>"


def scenarios(runs: Sequence[Run]) -> str:
    """Return the scenario of each run, folded up."""
    return "".join(
        f"<details><summary>{_text(run.name)}</summary>"
        f"<pre tabindex=0>{_text(_scenario_text(run))}</pre></details>"
        for run in runs
    )


def recordings(runs: Sequence[Run]) -> str:
    """Return host, versions and losses of each recording, folded up."""
    return "".join(
        f"<details><summary>{_text(run.name)}</summary>{''.join(_records(run))}</details>"
        for run in runs
    )


def _records(run: Run) -> Iterator[str]:
    yield _mapping("source", {"path": str(run.info.path)})
    for name, record in run.info.metadata.items():
        if name != "rosbag2":  # a copy of metadata.yaml
            yield _mapping(name, record)


def _mapping(title: str, values: Mapping[str, str]) -> str:
    rows = "".join(
        f"<tr><th scope=row>{_text(k)}</th><td>{_text(v)}</td></tr>" for k, v in values.items()
    )
    return f"<h4>{_text(title)}</h4><table class=record><tbody>{rows}</tbody></table>"


def _scenario_text(run: Run) -> str:
    if run.info.scenario_text:
        return run.info.scenario_text
    return run.scenario.to_yaml() if run.scenario is not None else "not recorded"


def _line(title: str, cells: Sequence[str]) -> str:
    return f"<tr><th scope=row>{title}</th>{''.join(f'<td>{cell}</td>' for cell in cells)}</tr>"


def _cells(row: Row, runs: Sequence[Run]) -> list[str]:
    cells = []
    for i, run in enumerate(runs):
        told = row.difference(run, runs[0]) if i else ""
        beside = f' <span class="difference">({told})</span>' if told else ""
        cells.append(f"{_text(row.value(run))}{beside}")
    return cells


def _method(run: Run) -> str:
    if run.scenario is None:
        return "unknown"
    controller, governor = run.scenario.controller, run.scenario.governor.governor
    parts = [controller.method]
    parts += [f"N = {controller.horizon}"] if "horizon" in run.scenario.method.reads else []
    parts += [f"governor {governor}"] if governor != "none" else []
    return _text(", ".join(parts))


def _badge(run: Run) -> str:
    word = {True: "passed", False: "failed", None: "not audited"}[run.verdict.passed]
    return f'<span class="badge {_BADGES[run.verdict.passed]}">{word}</span>'


_text: Callable[[str], str] = html.escape
