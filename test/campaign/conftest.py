"""Fixtures of the tests of campaigns."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from short_campaign import SHORT, VARIATIONS

from spacecraft_gnc.campaign.spec import Spec
from spacecraft_gnc.campaign.variations import load_variations
from spacecraft_gnc.scenario import load

MakeSpec = Callable[..., Spec]


@pytest.fixture
def make_spec(tmp_path: Path) -> MakeSpec:
    """Return what makes the campaign, with another text, seed or number of runs if asked."""

    def make(text: str = VARIATIONS, seed: int = 7, runs: int = 12, **overrides: object) -> Spec:
        path = tmp_path / "variations.yaml"
        path.write_text(text)
        scenario = load("gupta2015_case1", {**SHORT, **overrides})
        return Spec.of(scenario, load_variations(path, scenario), seed, runs)

    return make


@pytest.fixture
def spec(make_spec: MakeSpec) -> Spec:
    return make_spec()
