"""Page of a campaign: headline, diagrams, and tables of the runs that failed."""

from __future__ import annotations

import html
from collections.abc import Iterator
from typing import TYPE_CHECKING

from spacecraft_gnc.campaign.report import charts, tables
from spacecraft_gnc.campaign.report.data import Data, read_data
from spacecraft_gnc.drawing.page import chart_sections, filled_page

if TYPE_CHECKING:
    from spacecraft_gnc.campaign.results import Campaign


def report_html(campaign: Campaign, title: str = "", data: Data | None = None) -> str:
    """Return the report of a campaign as a page.

    The page holds counts and quantiles, never the rows: below 10 MB for any number of runs.

    Parameters
    ----------
    campaign
        With at least one row.
    title
        Heading; default: the name of its folder.
    data
        As `read_data` read it, if it is at hand.

    Raises
    ------
    RecordingError
        If there is no row yet.
    """
    data = read_data(campaign) if data is None else data
    parameters = charts.ranked(data)
    metrics = list(charts.distribution_charts(data))
    rates = list(charts.rate_charts(parameters, data))
    parts = {
        "kind": "Campaign report",
        "title": html.escape(title or campaign.folder.resolve().name),
        "warnings": tables.warnings(list(_warnings(campaign, data))),
        "headline": tables.headline(campaign, data),
        "facts": tables.facts(campaign),
        "metrics": chart_sections(metrics),
        "quantiles": tables.quantiles(data),
        "rates": chart_sections(rates),
        "pairs": "" if len(parameters) < 2 else tables.pair_section("rates"),
        "density": tables.pair_section("density") if parameters and metrics else "",
        "failures": tables.failures(campaign, data),
        "worst": tables.worst(campaign, data),
        "texts": tables.files(campaign),
    }
    pairs = []
    if len(parameters) > 1:
        pairs.append(charts.rate_pairs(parameters, data))
    if parameters and metrics:
        pairs.append(charts.density_pairs(parameters, data))
    shown = {"charts": [chart.data() for chart in (*metrics, *rates)], "pairs": pairs}
    return filled_page(__package__, "campaign", parts, shown)


def _warnings(campaign: Campaign, data: Data) -> Iterator[str]:
    """Yield what a reader should know before trusting the page."""
    spec = campaign.spec
    if data.runs < spec.runs:
        yield (
            f"{data.runs:,} of {spec.runs:,} runs are done: the same gnc campaign command "
            "goes on with the rest"
        )
    unflown = data.runs - data.flown
    if unflown:
        yield (
            f"{unflown:,} of {data.runs:,} runs refused or ended by an error count as not passed; "
            f"of those flown to their end, {tables.rate_text(data.successes, data.flown)}"
        )
    if spec.variations.sampling != "random":
        yield (
            "the intervals are exact for independent runs; those of a design of sampling "
            f"{spec.variations.sampling} are not independent"
        )
    if len(data.metrics) > charts.MOST_CHARTS:
        yield f"of {len(data.metrics)} metrics the first {charts.MOST_CHARTS} are drawn"
    if len(data.parameters) > charts.MOST_PARAMETERS:
        yield (
            f"of {len(data.parameters)} parameters and components, those {charts.MOST_PARAMETERS} "
            "are drawn that explain most of the success"
        )
