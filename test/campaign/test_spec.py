"""Identity of a campaign: what it depends on, and what two campaigns differ in."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest
from short_campaign import VARIATIONS

from spacecraft_gnc.campaign.spec import Spec, require_installed, runs_of
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.scenario.fingerprint import fingerprint


def test_it_survives_the_way_to_a_worker_and_into_a_file(spec) -> None:
    spec.design.points(0, 2)  # what is derived does not travel
    sent = pickle.loads(pickle.dumps(spec))
    read = Spec.from_dict({**spec.to_dict(), "written_by": "somebody"})
    assert sent == read == spec
    assert set(vars(sent)) == set(spec.to_dict())
    assert sent.identity == read.identity == spec.identity
    assert fingerprint(sent.scenario) == fingerprint(spec.scenario)
    np.testing.assert_array_equal(sent.design.points(3, 4), spec.design.points(3, 4))


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"seed": 8}, "seed 8 instead of 7"),
        ({"runs": 13}, "runs 13 instead of 12"),
        ({"text": VARIATIONS.replace("40.0", "41.0")}, "other variations"),
        ({"plant.time_step": 0.2}, "plant.time_step 0.2 instead of 0.4"),
    ],
    ids=lambda change: str(next(iter(change))) if isinstance(change, dict) else "",
)
def test_what_differs_is_named(change, told: str, spec, make_spec) -> None:
    other = make_spec(**change)
    assert other.identity != spec.identity
    assert spec.differences(other) == (told,)


def test_another_version_is_another_campaign(spec) -> None:
    other = replace(spec, package_version="9.9.9", lock_sha256="")
    assert other.identity != spec.identity
    (version, lock) = spec.differences(other)
    assert version == f"package_version 9.9.9 instead of {spec.package_version}"
    assert lock.startswith("lock_sha256 unknown instead of ")
    require_installed(spec, "worker")
    with pytest.raises(ParameterError, match=r"^worker: received package_version 0\.1\.0, lock_sh"):
        require_installed(other, "worker")


def test_paths_are_no_part_of_it(spec) -> None:
    moved = replace(spec, variations_path="elsewhere.yaml", scenario_path="elsewhere too.yaml")
    assert moved.identity == spec.identity
    assert spec.differences(moved) == ()


def test_the_number_of_runs_is_given_or_of_the_file(spec, make_spec) -> None:
    assert runs_of(spec.variations, None) == 12
    assert runs_of(spec.variations, 3) == 3
    with pytest.raises(ParameterError, match="--runs: received 0; required a whole number"):
        runs_of(spec.variations, 0)
    silent = make_spec(VARIATIONS.replace("runs: 12", ""))
    with pytest.raises(ParameterError, match="--runs: received nothing"):
        runs_of(silent.variations, None)
