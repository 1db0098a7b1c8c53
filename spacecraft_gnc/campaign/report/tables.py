"""Tables of a campaign's page: headline, quantiles, failures, worst runs."""

from __future__ import annotations

import html
import math
import shlex
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Final

from spacecraft_gnc.campaign import statistics as stats
from spacecraft_gnc.campaign.report.data import Column, Data
from spacecraft_gnc.campaign.report.failures import MOST_GROUPS, Group, Worst
from spacecraft_gnc.drawing.table import NOTHING, rounded

if TYPE_CHECKING:
    from spacecraft_gnc.campaign.results import Campaign

_BADGES: Final = {"passed": "passed", "failed": "failed"}
_DIGITS: Final = 6
_PAIRS: Final = {
    "rates": (
        "Success rate over two parameters",
        f"White: no run. The colors span the rates of the cells of at least {stats.ENOUGH} runs.",
    ),
    "density": ("Runs by parameter and metric", "White: no run. The colors are logarithmic."),
}
_text: Callable[[str], str] = html.escape


def rerun_command(campaign: Campaign, run: int) -> str:
    """Return the command that flies a run again in the graph."""
    return f"gnc campaign rerun {shlex.quote(str(campaign.folder))} --run {run} --launch"


def percent(share: float, width: float) -> str:
    """Return a share in percent, with the digits that an interval of this width leaves."""
    places = 2 if width <= 0.0 else min(max(1 - math.floor(math.log10(100.0 * width)), 0), 6)
    return f"{100.0 * share:.{places}f} %"


def rate_text(successes: int, runs: int) -> str:
    """Return a success rate with its interval in words."""
    if not runs:
        return "none passed"
    low, high = stats.clopper_pearson(successes, runs)
    rate, *bounds = (percent(each, high - low) for each in (successes / runs, low, high))
    return f"{rate} passed ({100.0 * stats.CONFIDENCE:g} % interval {' to '.join(bounds)})"


def headline(campaign: Campaign, data: Data) -> str:
    """Return success rate, interval and counts."""
    low, high = stats.clopper_pearson(data.successes, data.runs)
    rate, *bounds = (percent(each, high - low) for each in (data.successes / data.runs, low, high))
    counts = " ".join(
        f'<span class="badge {_BADGES.get(status, "unknown")}">{count:,} {_text(status)}</span>'
        for status, count in data.statuses.items()
    )
    return (
        f"<p class=rate>{rate}</p>"
        f"<p>of {data.runs:,} runs passed, {100.0 * stats.CONFIDENCE:g} % confidence interval "
        f"<b>{' to '.join(bounds)}</b> (Clopper-Pearson)</p>"
        f"<p>{counts}</p>"
        f"<p>A run passes if <code>{_text(campaign.spec.variations.criterion.text)}</code></p>"
    )


def facts(campaign: Campaign) -> str:
    """Return what the campaign is, and what flew it."""
    spec = campaign.spec
    rows = {
        "Folder": str(campaign.folder),
        "Scenario": spec.scenario_path,
        "Variations": spec.variations_path,
        "Sampling": f"{spec.variations.sampling}, {spec.runs:,} runs",
        "Seed": str(spec.seed),
        "Flown by": f"spacecraft_gnc {spec.package_version}, {spec.libraries}",
        "Lock file, SHA-256": spec.lock_sha256 or "unknown",
        "Identity, SHA-256": spec.identity,
    }
    return _records(rows.items(), "record")


def warnings(lines: Sequence[str]) -> str:
    """Return the box of what a reader should know first; empty if there is nothing."""
    if not lines:
        return ""
    items = "".join(f"<li>{_text(line)}</li>" for line in lines)
    return f'<div class="warnings" role="note"><h2>Before you read on</h2><ul>{items}</ul></div>'


def quantiles(data: Data) -> str:
    """Return the quantiles of all columns, and what no diagram shows, folded up."""
    heads = ["", *(f"{100.0 * level:g} %" for level in stats.LEVELS), "no value"]
    heads[1], heads[-2] = "least", "greatest"
    columns = [each for each in (*data.metrics, *data.parameters) if each.quantiles is not None]
    rows = ([_text(each.name), *_numbers(each)] for each in columns)
    parts = [_folded("Quantiles of metrics and parameters", _table(heads, rows))]
    if data.words:
        lines = [
            (name, "; ".join(f"{text}: {count}" for text, count in counts.items()))
            for name, counts in data.words.items()
        ]
        parts.append(_folded("Metrics in words, and in how many runs", _records(lines, "record")))
    if data.undrawn:
        table = _records(data.undrawn.items(), "record")
        parts.append(_folded("The same in all runs, or without a diagram", table))
    return "".join(parts)


def _numbers(column: Column) -> Iterator[str]:
    if column.quantiles is not None:
        yield from (rounded(float(value), _DIGITS) for value in column.quantiles)
    yield f"{column.missing:,}" if column.missing else NOTHING


def failures(campaign: Campaign, data: Data) -> str:
    """Return the runs that did not pass, by reason."""
    if not data.groups:
        return "<p>None: every run passed.</p>"
    heads = ("Outcome", "Reason", "Runs", "Share", "First runs", "Flies the first one again")
    rows = (_failure(campaign, data, group) for group in data.groups)
    note = (
        "Reasons that differ in numbers only are counted together; the text is that of the first "
        "run."
    )
    if len(data.groups) == MOST_GROUPS:
        note += f" The {MOST_GROUPS} largest groups are listed."
    return f"<p class=note>{note}</p>{_table(heads, rows)}"


def _failure(campaign: Campaign, data: Data, group: Group) -> list[str]:
    more = ", ..." if group.size > len(group.first_runs) else ""
    return [
        _badge(group.status),
        f"<span class=reason>{_text(group.reason)}</span>",
        f"{group.size:,}",
        f"<span class=short>{100.0 * group.size / data.runs:.3g} %</span>",
        f"<span class=short>{', '.join(map(str, group.first_runs))}{more}</span>",
        _command(campaign, group.first_runs[0]),
    ]


def worst(campaign: Campaign, data: Data) -> str:
    """Return the worst runs of each metric of the criterion."""
    if not data.worst:
        return "<p>The criterion compares no metric with a limit.</p>"
    return "".join(_worst(campaign, each) for each in data.worst)


def _worst(campaign: Campaign, found: Worst) -> str:
    which = "Largest" if found.is_largest else "Smallest"
    rows = (
        [
            str(each.run),
            rounded(each.value, _DIGITS),
            _badge(each.status),
            "kept" if campaign.flight_of(each.run).is_file() else NOTHING,
            _command(campaign, each.run),
        ]
        for each in found.runs
    )
    missing = ""
    if found.missing:
        missing = f"<p class=note>{found.missing:,} flown runs have no value and did not pass.</p>"
    table = _table(("Run", "Value", "Outcome", "Flight", "Flies it again"), rows)
    return f"<div class=worst><h3>{which} {_text(found.metric)}</h3>{missing}{table}</div>"


def files(campaign: Campaign) -> str:
    """Return the variations and the scenario, folded up."""
    spec = campaign.spec
    shown = {"Variations": spec.variations_text, "Scenario": spec.scenario_text}
    return "".join(
        _folded(name, f"<pre tabindex=0>{_text(text)}</pre>") for name, text in shown.items()
    )


def pair_section(name: str) -> str:
    """Return the place of a diagram of pairs and its controls."""
    title, note = _PAIRS[name]
    which = ""
    if name == "density":
        options = "".join(f"<option>{each}</option>" for each in ("all", "passed", "not passed"))
        which = _control(name, "which", "runs", options)
    controls = f"{_control(name, 'x', 'across')}{_control(name, 'y', 'up')}{which}"
    return (
        f'<section class="chart pair" aria-labelledby="h-{name}"><h3 id="h-{name}">{title}'
        f'</h3><div class=controls>{controls}</div><div id="{name}" class=plot role=img '
        f'aria-label="{title}"></div><p class=note id="n-{name}">{note}</p></section>'
    )


def _control(name: str, part: str, text: str, options: str = "") -> str:
    return (
        f'<label class=control>{text} <select data-pair="{name}" data-part="{part}">{options}'
        "</select></label>"
    )


def _badge(status: str) -> str:
    return f'<span class="badge {_BADGES.get(status, "unknown")}">{_text(status)}</span>'


def _command(campaign: Campaign, run: int) -> str:
    return f"<code class=command>{_text(rerun_command(campaign, run))}</code>"


def _folded(title: str, content: str) -> str:
    return f"<details><summary>{title}</summary><div class=scroll>{content}</div></details>"


def _table(heads: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """Return a table; heads and cells are HTML."""
    head = "".join(f"<th scope=col>{each}</th>" for each in heads)
    body = "".join(f"<tr>{''.join(f'<td>{cell}</td>' for cell in row)}</tr>" for row in rows)
    return (
        f"<div class=scroll><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
        "</div>"
    )


def _records(pairs: Iterable[tuple[str, str]], kind: str) -> str:
    rows = "".join(f"<tr><th scope=row>{_text(k)}</th><td>{_text(v)}</td></tr>" for k, v in pairs)
    return f"<table class={kind}><tbody>{rows}</tbody></table>"
