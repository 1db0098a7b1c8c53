"""Domains of this machine: claimed, refused, found."""

from __future__ import annotations

import socket
import subprocess
import sys
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


LOOK = """
import sys, tempfile
tempfile.tempdir = sys.argv[1]
from spacecraft_gnc.launcher import domain
print(sum(len(list(domain.running_graphs())) for _ in range(500)))
"""


def test_who_only_looks_is_seen_by_nobody_and_keeps_nobody_away(tmp_path: Path) -> None:
    for domain_id in range(1, 21):
        domain.claim_given(domain_id, {}).release()  # leaves its files
    command = [sys.executable, "-c", LOOK, str(tmp_path)]
    looking = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(3)]
    assert [process.communicate()[0].strip() for process in looking] == ["0", "0", "0"]

    lock = domain.claim_given(7, {"scenario": "a.yaml"})
    looking = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(2)]
    while any(process.poll() is None for process in looking):
        domain.claim_given(3, {}).release()  # is refused nowhere
        assert [graph.domain_id for graph in domain.running_graphs()] == [7]
    for process in looking:
        process.communicate()
    lock.release()


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
