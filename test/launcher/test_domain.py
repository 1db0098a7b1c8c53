"""Domains of this machine: claimed, refused, found."""

from __future__ import annotations

import socket
from pathlib import Path

import pytest

from spacecraft_gnc.errors import LaunchError
from spacecraft_gnc.launcher import domain


@pytest.fixture(autouse=True)
def _own_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))


def test_a_domain_belongs_to_one_graph() -> None:
    lock = domain.claim_given(7, {"scenario": "a.yaml"})
    with pytest.raises(domain.DomainTaken, match=r"received 7.*a\.yaml.*required"):
        domain.claim_given(7, {"scenario": "b.yaml"})
    lock.release()
    lock.release()
    domain.claim_given(7, {}).release()


def test_a_lone_plant_keeps_graphs_away() -> None:
    plant = domain.claim(domain.CLOCK, 7, {"plant": "/plant"})
    with pytest.raises(domain.DomainTaken, match="/plant") as caught:
        domain.claim_given(7, {})
    assert caught.value.exit_code == 2
    plant.release()
    domain.claim_given(7, {}).release()


def test_running_graphs_are_found() -> None:
    locks = [domain.claim_given(d, {"scenario": f"{d}.yaml"}) for d in (3, 12)]
    assert [g.domain_id for g in domain.running_graphs()] == [12, 3]  # by file name
    assert {g.about["scenario"] for g in domain.running_graphs()} == {"3.yaml", "12.yaml"}
    for lock in locks:
        lock.release()
    assert list(domain.running_graphs()) == []


def test_free_domains_differ_and_avoid_other_programs() -> None:
    first = domain.claim_free({})
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        for candidate in range(first.domain_id + 1, 102):
            try:
                other.bind(("", 7400 + 250 * candidate + 10))
            except OSError:  # a graph of somebody else's
                continue
            break
        second = domain.claim_free({})
    assert second.domain_id not in (first.domain_id, candidate)
    first.release()
    second.release()


def test_no_domain_left(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(domain, "_FREE_DOMAINS", range(5, 6))
    lock = domain.claim_given(5, {})
    with pytest.raises(LaunchError, match="every domain from 5 to 5"):
        domain.claim_free({})
    lock.release()
