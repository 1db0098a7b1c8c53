"""The corners and the middle of what benchmarks/defaults.py sweeps."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

SWEEP = runpy.run_path(str(Path(__file__).parents[2] / "benchmarks" / "defaults.py"))


@pytest.mark.parametrize("body", SWEEP["BODIES"])
@pytest.mark.parametrize(("moment", "torque"), SWEEP["CORNERS"])
def test_a_turn_settles_with_defaults_only(body: str, moment: float, torque: float) -> None:
    turn = SWEEP["turn"](body, moment, torque)
    assert turn.holds, turn
    assert turn.settled < 1.0
    assert turn.settled == pytest.approx(turn.predicted, abs=0.05)
