"""Tables of the report: metrics side by side, warnings, what is known of each recording."""

from __future__ import annotations

import html
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Final, NamedTuple

from spacecraft_gnc.analysis.report.runs import Run


class _Row(NamedTuple):
    """A metric: how to call it, its unit, and what it means where there is none."""

    label: str
    key: str
    unit: str = ""
    digits: int = 5
    factor: float = 1.0
    absent: Callable[[Run], str] = lambda _: _NOTHING


_NOTHING: Final = "-"  # it does not apply


def _unknown(_: Run) -> str:
    return "unknown"


def _never_settled(run: Run) -> str:
    return "never" if run.metrics["final_error_deg"] is not None else "unknown"


def _never_allowed(run: Run) -> str:
    return "never" if run.metrics["error_to"] == "target" else _NOTHING


def _unpriced(run: Run) -> str:
    return _NOTHING if run.metrics["neighboring_share"] is None else "unknown"


def _of_scenario(text: str) -> Callable[[Run], str]:
    """Return what says ``text`` where the scenario is known, and is without it."""
    return lambda run: "unknown" if run.scenario is None else text


_ROWS: Final = (
    _Row("Control steps", "steps"),
    _Row("Control period", "period", "s"),
    _Row("Duration", "duration", "s", 8),
    _Row("Error at the end", "final_error_deg", "deg", absent=_unknown),
    _Row("Error below 5° for good from", "settle_time_5deg", "s", absent=_never_settled),
    _Row("Error below 1° for good from", "settle_time_1deg", "s", absent=_never_settled),
    _Row("Error below 0.1° for good from", "settle_time_0.1deg", "s", absent=_never_settled),
    _Row("Momentum at the end", "final_momentum", "N m s", absent=_unknown),
    _Row("Whole way allowed from", "alpha_one_time", "s", absent=_never_allowed),
    _Row("Last reference to the target", "final_reference_error_deg", "deg"),
    _Row("Steps without an admissible reference", "inadmissible_steps"),
    _Row("Least governor margin", "min_governor_margin"),
    _Row("Largest torque", "max_torque", "N m", 8, absent=_unknown),
    _Row("Torque limit", "torque_limit", "N m", 8, absent=_of_scenario("none")),
    _Row("Steps on the limit", "saturated_steps", absent=_of_scenario(_NOTHING)),
    _Row("Sum of stage costs", "cost", "", 8, absent=_of_scenario(_NOTHING)),
    _Row("Least zone margin", "min_zone_margin_deg", "deg", absent=_of_scenario(_NOTHING)),
    _Row("Iterations a solve, median", "iterations_median"),
    _Row("Iterations a solve, most", "iterations_max"),
    _Row("Solve time, median", "solve_time_median", "µs", 4, 1e6),
    _Row("Solve time, 99 %", "solve_time_p99", "µs", 4, 1e6),
    _Row("Solve time, longest", "solve_time_max", "µs", 4, 1e6),
    _Row("Deadlines missed", "missed_deadlines"),
    _Row("Solves not converged", "unconverged_steps"),
    _Row("Steps at a standstill", "stalled_steps"),
    _Row("Steps escaping from a standstill", "escaping_steps"),
    _Row("Steps on a fallback torque", "fallback_steps"),
    _Row("Steps answered by neighbouring extremals", "neighboring_share", "%", 4, 100.0),
    _Row("Largest error of those", "neighboring_error", "N m", absent=_unpriced),
    _Row("Incomplete steps", "missing_steps"),
)
_EXPONENT_FROM: Final = 1e12
_LARGEST_SHARE: Final = 2.0  # of the first run: what is farther off is told as a factor
_LEAST_FACTOR: Final = 0.01  # likewise
_CHECK_HEADS: Final = ("Check", "Steps", "Worst", "Tolerance", "Verdict")
_BADGES: Final = {True: "passed", False: "failed", None: "unknown"}


def summary(runs: Sequence[Run]) -> str:
    """Return the table of metrics, one column for each run; later ones with the difference."""
    head = "".join(f'<th scope="col">{_text(run.name)}</th>' for run in runs)
    lines = [f'<thead><tr><th scope="col">Metric</th>{head}</tr></thead><tbody>']
    lines += [_line("Flown by", [_method(run) for run in runs])]
    lines += [_line("Audit", [_badge(run) for run in runs])]
    lines += [_line("Error is the angle to the", [run.metrics["error_to"] for run in runs])]
    for row in _ROWS:
        if any(_value(row, run) != _NOTHING for run in runs):
            unit = f" <span class=unit>[{row.unit}]</span>" if row.unit else ""
            lines.append(_line(f"{_text(row.label)}{unit}", _cells(row, runs)))
    lines.append(_line("Torque from", [_sources(run) for run in runs]))
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


def _cells(row: _Row, runs: Sequence[Run]) -> list[str]:
    first = runs[0].metrics[row.key]
    return [
        _value(row, run) + (_difference(row, run.metrics[row.key], first) if i else "")
        for i, run in enumerate(runs)
    ]


def _value(row: _Row, run: Run) -> str:
    value = run.metrics[row.key]
    return row.absent(run) if value is None else _rounded(row.factor * value, row.digits)


def _rounded(value: float, digits: int, sign: str = "") -> str:
    """Return a number with so many digits, and every one before the point: counts are exact."""
    if 10.0**digits - 0.5 <= abs(value) < _EXPONENT_FROM:
        return f"{value:{sign}.0f}"
    return f"{value:{sign}.{digits}g}"


def _difference(row: _Row, value: float | None, first: float | None) -> str:
    """Return the difference to the first run, and its share or factor where that says something."""
    if value is None or first is None:
        return ""
    text = "same" if value == first else _rounded(row.factor * (value - first), 3, "+")
    if value != first and first:
        share, factor = (value - first) / abs(first), value / first
        if factor > 0.0 and not _LEAST_FACTOR <= factor <= 1.0 + _LARGEST_SHARE:
            text += f", {_rounded(factor, 3)} times"
        elif abs(share) <= _LARGEST_SHARE:
            text += f", {_rounded(100.0 * share, 3, '+')} %"
    return f' <span class="difference">({text})</span>'


def _method(run: Run) -> str:
    if run.scenario is None:
        return "unknown"
    controller, governor = run.scenario.controller, run.scenario.governor.governor
    parts = [controller.method]
    parts += [f"N = {controller.horizon}"] if "horizon" in run.scenario.traits.reads else []
    parts += [f"governor {governor}"] if governor != "none" else []
    return _text(", ".join(parts))


def _badge(run: Run) -> str:
    word = {True: "passed", False: "failed", None: "not audited"}[run.verdict.passed]
    return f'<span class="badge {_BADGES[run.verdict.passed]}">{word}</span>'


def _sources(run: Run) -> str:
    names = (f"{name.lower().replace('_', ' ')} {n}" for name, n in run.metrics["sources"].items())
    return _text(", ".join(names))


_text: Callable[[str], str] = html.escape
