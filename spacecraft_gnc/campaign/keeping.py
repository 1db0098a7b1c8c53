"""Runs whose whole flights are kept: failed ones, the worst of each metric, the first ones."""

from __future__ import annotations

from typing import Any

import numpy as np

from spacecraft_gnc.campaign.flyer import FAILED, PASSED
from spacecraft_gnc.campaign.results import Campaign


def kept_runs(campaign: Campaign, first: int, most_failed: int) -> tuple[list[int], int]:
    """Return the runs to keep, ascending, and how many failed runs are not among them.

    Parameters
    ----------
    campaign
        A complete one.
    first
        Number of first runs to keep.
    most_failed
        Number of failed runs to keep at most, the first ones.
    """
    flown, failed = flown_and_failed(campaign)
    chosen = {*failed[:most_failed], *flown[flown < first]}
    for name in campaign.spec.variations.criterion.worse:
        chosen.update(worst_runs(campaign, name))
    return sorted(map(int, chosen)), len(set(failed) - chosen)


def worst_runs(campaign: Campaign, name: str) -> list[int]:
    """Return the runs to keep as the worst in a metric of the criterion, the worst one first."""
    return [run for run, _ in worst_values(campaign, name, campaign.spec.variations.worst)]


def worst_values(campaign: Campaign, name: str, count: int) -> list[tuple[int, float]]:
    """Return the worst runs in a metric of the criterion and their values, the worst one first.

    Of equal ones the first is the worse; runs without a number are none of them.
    """
    from spacecraft_gnc.campaign.columns import numbers

    if name not in campaign.schema.names:
        return []
    sign = campaign.spec.variations.criterion.worse[name]
    worst: list[tuple[float, int]] = []
    for table in campaign.tables(["run", name]):
        values = numbers(table[name])
        if values is None or values.ndim != 1:
            return []
        known = ~np.isnan(values)
        runs, goodness = table["run"].to_numpy()[known], -sign * values[known]
        order = np.lexsort((runs, goodness))[:count]
        worst += zip(goodness[order].tolist(), runs[order].tolist(), strict=True)
        worst = sorted(worst)[:count]
    return [(run, -sign * good) for good, run in worst]


def flown_and_failed(campaign: Campaign) -> tuple[Any, Any]:
    """Return the runs that were flown and those that failed, ascending."""
    flown, failed = [np.zeros(0, int)], [np.zeros(0, int)]
    for table in campaign.tables(["run", "status"]):
        runs, status = table["run"].to_numpy(), np.array(table["status"].to_pylist())
        flown.append(runs[np.isin(status, (PASSED, FAILED))])
        failed.append(runs[status == FAILED])
    return np.concatenate(flown), np.concatenate(failed)
