"""An audit follows deadlocks, the passages out of them, and the loss of a craft."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from flown_bags import messages_of
from formation_bags import ORBIT, PARKED, fly, rewrite, sections
from recording.bags import CODEC

from spacecraft_gnc.analysis.audit import audit_bag
from spacecraft_gnc.recording.bag import open_bag
from spacecraft_gnc.recording.columns import read_columns
from spacecraft_gnc.scenario import from_sections
from spacecraft_gnc.signals.message import period_ns
from spacecraft_gnc.vehicles.formation.decision import Answer
from spacecraft_gnc.vehicles.formation.signals import GOVERNOR_STATUS, REFERENCE

pytestmark = pytest.mark.long

_PASSAGE = "passage: begins at a deadlock, nearer with each formation"
_GOES_ON = "passage: goes on until the formation is attained"
_NEAREST = "passage: no admissible candidate is nearer, or costs less"
_LEFT = "passage: transitions left = a search of all parked formations"
_LONGEST = "shifts: no candidate keeps the limits longer"
LOST = {"spacecraft_lost": "sc2", "spacecraft_lost_at": ORBIT / 20}


class Told(NamedTuple):
    """What a bag tells of the governor."""

    bag: Path
    status: np.ndarray
    left: np.ndarray
    shifts: np.ndarray
    deadlocked: np.ndarray

    @classmethod
    def of(cls, bag):
        with open_bag(bag) as opened:
            columns = read_columns(opened, (GOVERNOR_STATUS, REFERENCE))
        fields = columns[GOVERNOR_STATUS].fields
        left, deadlocked = fields["passages_left"], fields["deadlocked"]
        return cls(bag, fields["status"], left, columns[REFERENCE].fields["shift"], deadlocked)


@pytest.fixture(scope="module")
def parked(tmp_path_factory):
    return Told.of(fly(tmp_path_factory.mktemp("parked"), PARKED))


@pytest.fixture(scope="module")
def lost(tmp_path_factory):
    return Told.of(fly(tmp_path_factory.mktemp("lost"), sections(plant=LOST)))


def forged(told, folder, flown, changes):
    """Write a bag again with other values of the governor's fields, by step; return the audit."""
    period = period_ns(from_sections(flown).period)
    messages = []
    for topic, stamp, data in messages_of(told.bag):
        step, made = stamp // period, data
        if topic == f"/{GOVERNOR_STATUS}" and step in changes:
            message = CODEC.store.deserialize_cdr(data, GOVERNOR_STATUS.type)
            for name, value in changes[step].items():
                setattr(message, name, value)
            made = bytes(CODEC.store.serialize_cdr(message, GOVERNOR_STATUS.type))
        messages.append((topic, stamp, made))
    return audit_bag(rewrite(told.bag, folder / "bag", messages, flown))


def first_of_each(audit):
    """Return the first step of each check that failed."""
    return {check.name: check.first.step for check in audit.checks if check.first}


def test_a_passage_leads_out_of_a_deadlock(parked):
    audit = audit_bag(parked.bag)
    assert audit.passed, audit.first
    assert audit.exceeded == ()
    steps = {check.name: check.steps for check in audit.checks}
    passing = np.flatnonzero(parked.status == Answer.PASSAGE)
    assert passing[0] == np.flatnonzero(parked.deadlocked)[0] + 1
    assert steps[_PASSAGE] == steps[_GOES_ON] == steps[_NEAREST] == passing.size
    assert steps[_LEFT] == np.count_nonzero(parked.deadlocked)
    assert parked.left.max() >= 2
    assert parked.left[-1] == 0


def test_a_forged_passage_is_named(parked, tmp_path):
    """Each change is found at its own step, by the check that it concerns."""
    turn = 1 + int(np.flatnonzero(np.diff(parked.left) < 0)[0])  # where it is nearer
    first = int(np.flatnonzero(parked.deadlocked)[0])
    changes = {
        first: {"deadlocked": False, "passages_left": 0},
        turn: {"passages_left": int(parked.left[turn]) + 1},
        turn + 3: {"waypoint": np.array([1, 2, 3], dtype=np.uint32)},
        turn + 5: {"status": int(Answer.OPTIMAL)},
    }
    found = first_of_each(forged(parked, tmp_path, PARKED, changes))
    assert found["deadlocked: parked in another formation"] == first
    assert found[_PASSAGE] == first + 1  # it begins without a deadlock
    assert found[_LEFT] == turn
    assert found["passage: waypoint = the shifts"] == turn + 3
    assert found[_GOES_ON] == turn + 5
    assert found["shifts: no admissible candidate costs less"] == turn + 5


def test_a_deadlock_that_is_not_resolved_stays_one(tmp_path):
    """Of twenty places there is no way out that keeps every constraint."""
    flown = sections(
        plant={
            "initial_phase": [6.0, 13.0, 0.0],
            "initial_along_track_offset": [0.0, 0.0, 0.0],
            "initial_amplitude": [1.0, 1.0, 1.0],
        }
    )
    told = Told.of(fly(tmp_path, flown))
    assert told.deadlocked.tolist() == [0] * 5 + [1] * 4
    assert told.left.tolist() == [0] * 5 + [-1] * 4
    audit = audit_bag(told.bag)
    assert audit.passed, audit.first
    found = first_of_each(forged(told, tmp_path / "forged", flown, {6: {"passages_left": 2}}))
    assert found == {_GOES_ON: 7, _LEFT: 6}


def test_shifts_after_a_loss_keep_the_limits_longest(lost):
    longest = np.flatnonzero(lost.status == Answer.LONGEST_KEPT)
    assert longest.size
    audit = audit_bag(lost.bag)
    assert audit.passed, audit.first
    steps = {check.name: check.steps for check in audit.checks}
    assert steps[_LONGEST] == longest.size
    assert steps["answer where no candidate is admissible"] == longest.size
    assert steps["no craft concluded lost that answers"] > 0


def test_held_shifts_are_proven_without_an_alternative(tmp_path):
    """A craft whose commands do not come leaves the prediction, until no shifts are admissible."""
    told = Told.of(fly(tmp_path, late=[(k, 1) for k in range(5)]))
    held = np.flatnonzero(told.status == Answer.HELD)
    assert held.tolist() == [5, 6, 7]
    audit = audit_bag(told.bag)
    assert audit.passed, audit.first
    steps = {check.name: check.steps for check in audit.checks}
    assert steps["shifts held: no candidate is admissible"] == 3
    assert steps["shifts held = the last ones"] == 3
    changes = {6: {"status": int(Answer.OPTIMAL)}, 8: {"status": int(Answer.HELD)}}
    found = first_of_each(forged(told, tmp_path / "forged", sections(), changes))
    assert found["shifts: admissible, all constraints predicted"] == 6
    assert found["shifts held: no candidate is admissible"] == 8


@pytest.mark.parametrize(
    "changes",
    [
        {
            "plant": {
                "spacecraft": ["alpha", "bravo"],
                "initial_phase": [18.0, 8.4],
                "initial_along_track_offset": [6103.0, 8325.0],
                "initial_amplitude": [1.53, 1.705],
            },
            "reference_governor": {"phase": [0, 10], "horizon": 40},
        },
        {
            "plant": {
                "spacecraft": ["sc1", "sc2", "sc3", "sc4"],
                "initial_phase": [2.0, 6.8, 12.0, 16.8],
                "initial_along_track_offset": [0.0, 500.0, 1000.0, 1500.0],
                "initial_amplitude": [1.4, 1.5, 1.6, 1.7],
                "duration": 3.5 * ORBIT / 20,
            },
            "reference_governor": {"phase": [0, 5, 10, 15], "horizon": 40},
        },
    ],
    ids=["two", "four"],
)
def test_any_number_of_craft_is_audited(tmp_path, changes):
    audit = audit_bag(fly(tmp_path, sections(**changes)))
    assert audit.passed, audit.first


def test_other_shifts_after_a_loss_are_named(lost, tmp_path):
    """Shifts that keep the limits longest exceed one by more, and are neither optimal nor held."""
    longest = int(np.flatnonzero(lost.status == Answer.LONGEST_KEPT)[0])
    changes = {
        longest: {"status": int(Answer.LEAST_VIOLATING)},
        longest + 1: {"status": int(Answer.OPTIMAL)},
        longest + 2: {"status": int(Answer.HELD)},
    }
    found = first_of_each(forged(lost, tmp_path, sections(plant=LOST), changes))
    assert found["shifts: no candidate exceeds a limit by less"] == longest
    assert found["answer where no candidate is admissible"] == longest
    assert found["shifts: admissible, all constraints predicted"] == longest + 1
