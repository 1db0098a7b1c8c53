"""Runs and pages for the tests of the report."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from analysis.flights import case1
from recording.bags import flight_messages, record

from spacecraft_gnc.analysis.report import read_run, report_html
from spacecraft_gnc.drawing.page import write_page

NASTY = "</script><b>&amp;\"'{{plotly}}"
"""In a name and in a scenario it must be shown as it is."""
SCENARIO = f"""\
# {NASTY}
plant:
  ros__parameters:
    inertia: [1.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8]
    time_step: 0.4
nmpc_controller:
  ros__parameters:
    max_torque: 0.01
    zone_names: [star, station]
    zones:
      star:
        {{body_axis: [1.0, 0.0, 0.0], inertial_axis: [0.0, 1.0, 0.0], half_angle_deg: 5.0}}
      station:
        kind: inclusion
        body_axis: [0.6, 0.0, 0.8]
        inertial_axis: [0.0, 0.0, 1.0]
        half_angle_deg: 80.0
"""


def flight(n=20):
    """Return the first ``n`` control steps of Case I, its torque from several sources."""
    whole = case1()
    names = ["time", *(name for name, column in whole.columns() if not column.at_end)]
    rows = {name: getattr(whole, name)[:n] for name in names}
    return replace(
        whole,
        **{**rows, "source": np.minimum(np.arange(n) // 4, 4)},
        final_attitude=whole.attitude[n],
        final_momentum=whole.momentum[n],
    )


def bag(folder, n=20, scenario=SCENARIO, lost=()):
    """Record a flight, without the messages of some (topic, step)."""
    items = [item for item in flight_messages(flight(n)) if item[:2] not in lost]
    return record(folder, items, scenario=scenario)


def page(target, paths, names, title=""):
    """Write the report of recordings to ``target`` and return it."""
    runs = [read_run(path, name) for path, name in zip(paths, names, strict=True)]
    write_page(report_html(runs, title), target)
    return target
