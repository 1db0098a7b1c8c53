"""Summary of a campaign: how many runs ended how, and what they cost."""

from __future__ import annotations

from typing import Any

import numpy as np

from spacecraft_gnc.campaign.driver import Keeping
from spacecraft_gnc.campaign.flyer import PASSED, STATUSES, WALL_TIME
from spacecraft_gnc.campaign.results import Campaign


def summarize(campaign: Campaign, keeping: Keeping | None = None) -> dict[str, Any]:
    """Return the summary of a campaign, ready for JSON.

    Returns
    -------
    dict
        ``runs`` (asked for), ``done``, the number of each status, ``success_rate`` (passed of
        those done; None of none), ``wall_flights`` (sum of the wall times of the runs [s]),
        ``flights_per_core_second``, ``size`` of the rows [bytes], ``kept`` (runs whose flights are
        kept), ``failed_not_kept`` and ``mismatches``, the latter of a complete campaign only;
        ``seed``, ``identity`` and what it was flown with.
    """
    counts, seconds, spec = campaign.counts(), _wall_seconds(campaign), campaign.spec
    done = counts.total()
    return {
        "runs": spec.runs,
        "done": done,
        **{status: counts[status] for status in STATUSES},
        "success_rate": counts[PASSED] / done if done else None,
        "wall_flights": seconds,
        "flights_per_core_second": done / seconds if seconds else None,
        "size": sum(part.path.stat().st_size for part in campaign.parts),
        **({} if keeping is None else _kept(keeping)),
        "seed": spec.seed,
        "identity": spec.identity,
        "package_version": spec.package_version,
        "lock_sha256": spec.lock_sha256,
        "libraries": spec.libraries,
    }


def _kept(keeping: Keeping) -> dict[str, Any]:
    return {
        "kept": list(keeping.runs),
        "failed_not_kept": keeping.left_out,
        "mismatches": list(keeping.mismatches),
    }


def _wall_seconds(campaign: Campaign) -> float:
    tables = campaign.tables([WALL_TIME]) if campaign.done else ()
    return float(sum(np.nansum(table[WALL_TIME].to_numpy()) for table in tables))
