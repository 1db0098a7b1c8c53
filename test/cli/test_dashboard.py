"""The terminal dashboard: what a frame and a line show."""

from __future__ import annotations

import math
from dataclasses import replace
from io import StringIO

import numpy as np
import pytest
from live.watching import Wall, recorded
from rich.console import Console

from spacecraft_gnc.analysis.live.picture import Phase, Picture, Setup, Timing
from spacecraft_gnc.cli._dashboard import line, render

SETUP = replace(recorded(Wall()).setup, live=True, governor="attitude")
VALUES = {
    "attitude": np.eye(3),
    "reference": np.eye(3),
    "target": np.eye(3),
    "error_deg": 0.0,
    "target_error_deg": 0.0,
    "momentum": np.array([1e-3, 0.0, -2e-3]),
    "torque": np.array([0.005, 0.0, -0.01]),
    "external_torque": None,
    "source": "optimal",
    "margins_deg": {"star": 70.0},
    "solve": {
        "status": "converged",
        "iterations": 3,
        "residual": 1e-13,
        "curvature": 0.8,
        "solve_time": 4e-5,
    },
    "decision": {
        "alpha": 0.5,
        "margin": 0.1,
        "constraint": "torque limit",
        "admissible": True,
    },
}
PICTURE = Picture(
    phase=Phase.FLYING,
    step=10,
    time=4.0,
    values=VALUES,
    timing=Timing(speed=2.0, latency=1e-3, slack=0.2, missed=4),
    rates={"attitude_state": 2.5, "target_attitude": 0.0},
)


def with_values(**changed) -> Picture:
    return replace(PICTURE, values={**VALUES, **changed})


def rows_of(text: str) -> list[str]:
    """Return the lines of a frame without its borders, with single spaces."""
    return [" ".join(row.strip("│ ").split()) for row in text.splitlines()]


def shown(picture: Picture, *, colors: bool = False) -> str:
    out = StringIO()
    system = "truecolor" if colors else None
    console = Console(file=out, width=100, force_terminal=colors, color_system=system)
    console.print(render(picture, SETUP))
    return out.getvalue()


def test_a_frame_shows_what_matters() -> None:
    text = shown(PICTURE)
    rows = rows_of(text)
    for words in (
        "error to target 0°",
        "margin to star 70°",
        "torque from optimal",
        "solver converged",
        "iterations 3",
        "residual 1.00e-13",
        "solve time 40 µs",
        "least curvature 0.8",
        "limited by torque limit",
        "times real time 2",
        "deadlines missed 4",
        "rates [Hz] attitude_state 2.5",
    ):
        assert words in rows
    assert "step 10 of 375" in text
    assert "of 0.01 N m" in text
    assert "target_attitude" not in text  # nothing comes there
    assert "nan" not in text


def test_without_parameters_no_limit_is_known() -> None:
    out = StringIO()
    unknown = Setup.without_scenario("x", live=True)
    Console(file=out, width=100).print(render(PICTURE, unknown))
    assert " N m, no limit known" in out.getvalue()


def test_bars_end_at_the_limit() -> None:
    rows = {
        name: row
        for row in shown(PICTURE).splitlines()
        for name in "xyz"
        if f"torque {name}" in row
    }
    assert [rows[name].count("█") for name in "xyz"] == [8, 0, 15]
    assert rows["x"].index("█") > rows["x"].index("│", 2)  # positive: to the right of zero
    assert rows["z"].index("█") < rows["x"].index("█")


def test_no_colors_where_nobody_sees_them() -> None:
    assert "\x1b[" not in shown(PICTURE)
    assert "\x1b[" in shown(PICTURE, colors=True)


def test_a_fallback_stands_out() -> None:
    assert "\x1b[33mzero" in shown(with_values(source="zero"), colors=True)


@pytest.mark.parametrize("missing", ["attitude", "reference", "torque", "solve", "decision"])
def test_what_has_not_come_leaves_no_hole(missing: str) -> None:
    for bare in (with_values(**{missing: None}), replace(PICTURE, timing=None)):
        assert "flying" in shown(bare)
        assert line(bare, SETUP).startswith("flying, step 10, t = 4.0 s")


def test_numbers_that_are_not_known_are_not_shown_as_nan() -> None:
    solve = dict.fromkeys(VALUES["solve"], math.nan) | {"status": "no solve", "iterations": 0}
    unknown = replace(
        with_values(solve=solve, error_deg=math.nan, target_error_deg=math.nan), timing=Timing()
    )
    assert "nan" not in shown(unknown)
    assert "nan" not in line(unknown, SETUP)


def test_a_line_is_one_line() -> None:
    text = line(PICTURE, SETUP)
    assert "\n" not in text
    assert "0 deg off the reference" in text
    assert "(optimal)" in text
    assert "alpha 0.5" in text
    assert "4 deadlines missed" in text
