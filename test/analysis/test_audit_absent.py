"""The audit of a bag that lacks all messages of a topic names it, and goes on with the others."""

from __future__ import annotations

from pathlib import Path

import pytest
from flown_bags import fly, messages_of, rewrite

from spacecraft_gnc.analysis.audit import audit_bag


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return fly(tmp_path_factory.mktemp("flown"))


@pytest.mark.parametrize(
    "topic",
    ["attitude_reference", "governor_status", "torque_command", "solver_status"],
)
def test_a_topic_without_messages(topic: str, bag: Path, tmp_path: Path) -> None:
    kept = [item for item in messages_of(bag) if item[0] != f"/{topic}"]
    found = audit_bag(rewrite(bag, tmp_path / "bag", kept))
    assert found.first is not None
    check, difference = found.first
    assert (check.name, difference.step) == (f"steps of {topic}", 0)
    assert difference.field == f"{topic} (missing)"
    # what does not need the topic is audited as before, and passes
    others = {each.name: each.first for each in found.checks if each.name != check.name}
    assert others["integrator, from each state"] is None
    assert others["integrator, from the start"] is None
    assert others["energy and momentum told"] is None
    by_name = {each.name: each for each in found.checks}
    assert by_name["integrator, from each state"].steps == 12


def test_a_flight_without_what_was_applied(bag: Path, tmp_path: Path) -> None:
    """The commands are taken as applied, and the flight follows from them."""
    kept = [item for item in messages_of(bag) if item[0] != "/plant_invariants"]
    found = audit_bag(rewrite(bag, tmp_path / "bag", kept))
    failed = [each.name for each in found.checks if each.first is not None]
    assert failed == ["steps of plant_invariants"]
    by_name = {each.name: each for each in found.checks}
    assert by_name["integrator, from the start"].steps == 13
