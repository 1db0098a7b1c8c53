"""The random problems: drawn the same again, the same in all units, and every fault is found."""

from __future__ import annotations

import copy
import importlib
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "benchmarks" / "random_problems"
PEERS = ROOT / ".venv-peers" / "bin" / "python"


@pytest.fixture(scope="module")
def draw() -> Any:
    return _module("draw")


@pytest.fixture(scope="module")
def judge() -> Any:
    return _module("judge")


def _module(name: str) -> ModuleType:
    sys.path.insert(0, str(FOLDER))
    try:
        return importlib.import_module(name)
    finally:
        sys.path.remove(str(FOLDER))


def test_a_seed_draws_the_same_problem_again(draw: Any) -> None:
    first, again = draw.draw(7), draw.draw(7)
    assert first.plain() == again.plain()
    assert draw.Drawn.of(first.plain()).plain() == first.plain()
    assert first.plain() != draw.draw(8).plain()


def test_the_problems_are_what_they_are_meant_to_be(draw: Any) -> None:
    drawn = [draw.draw(seed) for seed in range(300)]
    inertias = [p.units[0] for p in drawn]
    limits = [p.limit * p.units[0] / p.units[1] ** 2 for p in drawn if p.limit > 0.0]
    assert min(inertias) < 1e-5 and max(inertias) > 1e7  # noqa: PT018
    assert min(limits) < 1e-5 and max(limits) > 1e2  # noqa: PT018
    assert 1e-6 <= min(limits) <= max(limits) <= 1e3
    assert min(p.horizon for p in drawn) == 1
    assert 55 <= max(p.horizon for p in drawn) <= 60
    assert {len(p.zones) for p in drawn} == {0, 1, 2, 3, 4}
    assert {p.actuators.shape[1] for p in drawn} == {2, 3, 4}
    assert sum(p.other_units is not None for p in drawn) == 150


def test_the_cost_of_the_same_controls_is_the_same_in_all_units(draw: Any) -> None:
    rng = np.random.default_rng(1)
    for seed in range(1, 60, 2):
        problem = draw.draw(seed)
        controls = rng.normal(size=(problem.horizon, problem.actuators.shape[1]))
        controls *= problem.control_scale
        costs = []
        for mass, time, unit in ((1.0, 1.0, 1.0), problem.units, problem.other_units):
            ocp, state = draw.in_units(problem, (mass, time, unit))
            if not all(ocp.body.is_solvable(x) for x in [state[1]]):
                break
            try:
                costs.append(ocp.cost(controls * mass / time**2, *state) / unit)
            except ValueError:  # the controls turn the body too far in a step
                break
        assert np.allclose(costs, costs[:1], rtol=1e-10, atol=0.0)


GOOD = {
    "horizon": 3, "status": "CONVERGED", "cold": "CONVERGED", "way": "cold", "iterations": 4,
    "cost": 2.0, "unlike": 1e-15, "other": {"cold": "CONVERGED", "iterations": 4, "exact": True},
    "check": {"correction": 1e-12, "positive": True, "cost": 2.0, "moved": 1.0},
    "ipopt": {"solved": True, "cost": 2.0, "moved": 1.0},
}  # fmt: skip


@pytest.mark.parametrize(
    ("change", "kind"),
    [
        ({}, None),
        ({"check": {"correction": 2e-8}}, "false"),
        ({"check": {"correction": float("nan")}}, "false"),
        ({"check": {"positive": False}}, "false"),
        ({"check": {"fault": "the body turns too far in one step"}}, "false"),
        ({"exception": "Traceback\nZeroDivisionError"}, "exceptions"),
        ({"cost": 2.0 + 1e-8}, "cost"),
        ({"ipopt": {"cost": 2.0 - 2e-6}}, "worse"),
        ({"ipopt": {"cost": 2.0 + 2e-6}}, "better"),
        ({"status": "SADDLE"}, "missed"),
        ({"unlike": 1e-7}, "unlike"),
        ({"other": {"iterations": 5}}, "unlike"),
        ({"other": {"iterations": 5, "exact": False}}, None),
        ({"other": {"cold": "SADDLE", "exact": False}}, "unlike"),
    ],
)
def test_each_fault_is_found(judge: Any, change: dict[str, Any], kind: str | None) -> None:
    account: dict[str, Any] = copy.deepcopy(GOOD)
    for name, value in change.items():
        account[name] = account[name] | value if isinstance(value, dict) else value
    parts = {name: account.pop(name) | {"seed": 5} for name in ("check", "ipopt")}
    verdict = judge.judge({5: account}, [parts["check"]], [parts["ipopt"]])
    kinds = ("false", "exceptions", "cost", "worse", "better", "missed", "unlike")
    assert [name for name in kinds if getattr(verdict, name)] == ([kind] if kind else [])
    assert verdict.faults == (kind not in (None, "better"))
    told = judge.report(verdict, 1.0)
    assert (f"{kind}: {{'seed': 5" in told) == (kind not in (None, "better"))


def test_the_command_judges_or_says_what_is_missing(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, str(FOLDER / "run.py"), "--count", "4", "--keep", str(tmp_path)],
        capture_output=True,
        text=True,
        timeout=240,
        check=False,
    )
    if PEERS.exists():
        assert "| problems | 4, ours in " in done.stdout, done.stderr
        assert "| solved by IPOPT | 4 of 4 |" in done.stdout
    else:
        assert done.stderr == ".venv-peers is absent: make bench installs it\n"
