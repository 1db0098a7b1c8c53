"""A shortened form of ``benchmarks/fuzz_bags.py``: no reader of bags fails on damage."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from flown_bags import fly
from recording.mutations import Bases, mutate

RUN = Path(__file__).resolve().parents[2] / "benchmarks" / "fuzz_bags.py"


def test_damaged_bags_are_read_or_refused() -> None:
    """In a process of its own, whose memory is limited."""
    done = subprocess.run(
        [sys.executable, str(RUN), "--count", "90"],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "90 damaged bags of 15 kinds" in done.stdout
    assert ": 0 failures" in done.stdout


@pytest.fixture(scope="module")
def bases(tmp_path_factory: pytest.TempPathFactory) -> Bases:
    folder = tmp_path_factory.mktemp("bases")
    return Bases.of(fly(folder), folder)


def test_the_same_seed_does_the_same_damage(bases: Bases, tmp_path: Path) -> None:
    for seed in range(40):
        kind, path = mutate(bases, seed, tmp_path / f"{seed}")
        again, other = mutate(bases, seed, tmp_path / f"{seed} again")
        assert kind == again
        files = [next(p.rglob("*.mcap")) if p.is_dir() else p for p in (path, other)]
        assert files[0].read_bytes() == files[1].read_bytes()
