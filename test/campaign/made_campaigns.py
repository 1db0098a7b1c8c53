"""Campaigns whose rows are made up, for the tests of the report."""

from __future__ import annotations

import numpy as np
import pyarrow as pa

from spacecraft_gnc.campaign.results import Campaign, Part
from spacecraft_gnc.campaign.spec import Spec
from spacecraft_gnc.campaign.tables import write_table
from spacecraft_gnc.campaign.variations import load_variations
from spacecraft_gnc.scenario import load

NASTY = "</script><b>&amp;\"'{{plotly}}$x$"
"""In a name, in a reason and in a path it must be shown as it is."""
VARIATIONS = f"""\
# {NASTY}
vary:
  plant.initial_rotation_vector: {{distribution: rotation}}
  plant.inertia: {{distribution: inertia, factor: 0.1, axes_deg: 5.0}}
  nmpc_controller.horizon: {{distribution: choice, values: [5, 8]}}
  nmpc_controller.method: {{distribution: choice, values: [shooting, neighboring_extremal]}}
pass: final_error_deg < 0.1 and "settle_time_0.1deg" < 100
"""
REFUSED, RAISED = 7, 11  # every so many runs


def made(folder, runs=400, *, done=None, metrics=4, variations=VARIATIONS, seed=3):
    """Return a campaign of so many runs, of which the first ``done`` have rows."""
    path = folder.parent / "variations.yaml"
    path.write_text(variations, encoding="utf-8")
    scenario = load("gupta2015_case1")
    spec = Spec.of(scenario, load_variations(path, scenario), seed, runs)
    campaign = Campaign.create(folder, spec)
    done = runs if done is None else done
    if done:
        write_table(rows(done, metrics), Part.of(campaign.results, range(done)).path)
    return Campaign.open(folder)


def rows(n, metrics=4):
    """Return a table as a campaign has it; attitudes far off settle late."""
    random = np.random.default_rng(8)
    axis = random.normal(size=(n, 3))
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    angle = random.uniform(0.0, np.pi, n)
    turned = np.linalg.qr(random.normal(size=(n, 3, 3)))[0]
    moments = random.uniform(0.8, 1.2, (n, 3))
    inertia = np.einsum("nij,nj,nkj->nik", turned, moments, turned)
    error = 10.0 ** random.normal(-3.0, 1.5, n)
    settled = 40.0 + 25.0 * angle
    run = np.arange(n)
    refused, raised = run % REFUSED == 5, run % RAISED == 9
    ended = ~(refused | raised)
    settles = ended & (error < 1.0)
    passed = settles & (error < 0.1) & (settled < 100.0)
    reason = np.where(refused, [f"zone {NASTY}: received {k}.5; required less" for k in run], None)
    reason = np.where(raised & ~refused, "ZeroDivisionError: division by zero", reason)
    status = np.select([refused, raised, passed], ["refused", "error", "passed"], "failed")
    table = {
        "run": run,
        "status": status,
        "passed": passed,
        "reason": pa.array(reason, pa.string()),
        "plant.initial_rotation_vector": pa.array(list(axis * angle[:, None])),
        "plant.inertia": pa.array(list((0.5 * (inertia + inertia.swapaxes(1, 2))).reshape(n, 9))),
        "nmpc_controller.horizon": random.choice([5, 8], n),
        "nmpc_controller.method": random.choice(["shooting", "neighboring_extremal"], n),
        "scenario_hash": [f"{k:064x}" for k in run],
        "steps": pa.array(np.full(n, 375), mask=~ended),
        "final_error_deg": pa.array(error, mask=~ended),
        "settle_time_0.1deg": pa.array(settled, mask=~settles),
        "error_to": pa.array(np.where(run % 2, "target", "reference"), mask=~ended),
        "limits_exceeded": [f"zone sun by {k}.5 deg" if k < 100 else None for k in run],
        "min_zone_margin_deg": pa.nulls(n, pa.float64()),
    }
    for k in range(metrics):
        values = random.lognormal(0.0, 0.3 * (k % 12), n)
        table[f"zone_margin_deg.{NASTY}{k}"] = pa.array(values, mask=~ended)
    return pa.table({**table, "wall_time": pa.array(random.gamma(9.0, 0.001, n), mask=~ended)})
