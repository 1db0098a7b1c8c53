"""Campaigns of a paper: flown in their folder, gone on with where they stopped, read as arrays."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from spacecraft_gnc.campaign.cluster import connected
from spacecraft_gnc.campaign.driver import fly_missing, keep_flights, kept_before, require_metrics
from spacecraft_gnc.campaign.engine import Engine
from spacecraft_gnc.campaign.results import Campaign
from spacecraft_gnc.campaign.spec import Spec, runs_of
from spacecraft_gnc.campaign.summary import summarize
from spacecraft_gnc.campaign.variations import load_variations
from spacecraft_gnc.campaign.writer import exclusive
from spacecraft_gnc.scenario import load
from spacecraft_gnc.studies.flights import Progress
from spacecraft_gnc.types import Array

_KEPT_FAILED = 100  # as of `gnc campaign`


def flown_campaign(
    scenario: str, variations: str, folder: Path, runs: int | None, progress: Progress
) -> Campaign:
    """Return a complete campaign that comes with the package, flown on all cores where need be.

    Parameters
    ----------
    scenario, variations : str
        Names of what `gnc campaign SCENARIO VARIATIONS` flies, with seed 0.
    folder : Path
        Of the campaign: new, or one that goes on.
    runs : int or None
        None: as many as the variations say.
    progress : callable

    Raises
    ------
    GncError
        If the folder holds something else, or nothing can be flown.
    """
    base = load(scenario)
    varied = load_variations(variations, base)
    spec = Spec.of(base, varied, 0, runs_of(varied, runs))
    if not Campaign.exists(folder):
        require_metrics(spec)
    campaign = Campaign.create(folder, spec)
    with exclusive(campaign):
        if not (campaign.is_complete and kept_before(campaign, 0, _KEPT_FAILED)):
            _complete(campaign, progress)
    return campaign


def _complete(campaign: Campaign, progress: Progress) -> None:
    name = campaign.folder.name
    with connected() as client:
        engine = Engine(client)
        fly_missing(campaign, engine, lambda done, total, _: progress(name, done, total))
        keeping = keep_flights(
            campaign, engine, 0, _KEPT_FAILED, lambda done, total: progress(name, done, total)
        )
    campaign.write_summary(summarize(campaign, keeping))


def column(campaign: Campaign, name: str) -> Array:
    """Return a column of the rows as doubles, (n,) or for vectors (n, k); NaN: no value."""
    values: list[Any] = campaign.table([name])[name].to_pylist()
    return np.array([np.nan if value is None else value for value in values], dtype=np.float64)
