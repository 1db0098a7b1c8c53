"""A change of one bit, of a key or of a check's name is found, and the line says where."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pinned import flights, records, store

from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.vehicles.rigid_body.plant import RigidBodyPlant

CASE_1 = "gupta2015_case1"
OTHER = {"processor": "another"}


def pinned(kind: str) -> dict[str, Any]:
    return store.load(CASE_1)[kind]


def differences(array: Any, changed: Any, name: str = "torque", *, exact: bool = True) -> list[str]:
    pair = records.of_array(array), records.of_array(changed)
    return list(records.array_differences(name, *pair, exact=exact))


def changed_in(row: int, by: float, n: int = 375) -> tuple[Any, Any]:
    array = np.sin(np.arange(3.0 * n)).reshape(n, 3)
    changed = array.copy()
    changed[row, 1] += by
    return array, changed


def test_a_scenario_equals_itself() -> None:
    for kind in ("simulated", "recorded"):
        assert flights.differences(CASE_1, pinned(kind), pinned(kind)) == []


def test_one_bit_is_found_with_its_rows() -> None:
    array, changed = changed_in(57, 1e-16)
    assert differences(array, changed) == ["torque: differs first in rows 54 to 59 of 375"]
    array, changed = changed_in(9, 1e-16, 60)
    assert differences(array, changed) == ["torque: differs first in row 9 of 60"]


def test_negative_zero_is_another_number() -> None:
    assert differences([0.0, 1.0], [-0.0, 1.0]) == ["torque: differs first in row 0 of 2"]


def test_another_machine_may_round_otherwise() -> None:
    array, changed = changed_in(374, 1e-12)
    assert differences(array, changed, exact=False) == []
    (line,) = differences(*changed_in(0, 1e-3), exact=False)
    assert line.startswith("torque: sum ")
    assert differences([1, 2], [1, 3], exact=False) == ["torque: differs first in row 1 of 2"]
    assert differences([1, 2], [1, 3], "iterations", exact=False) == []
    assert differences([0.0], [1e-14], "/solver_status residual", exact=False) == []
    assert differences([0.0, 3e-16], [4e-16, -2e-16], "orthogonality_error", exact=False) == []
    assert differences([0.0, 1.0], [np.nan, 1.0], exact=False) == [
        "torque: 1 finite numbers; pinned 2"
    ]


def test_shape_and_type_are_pinned() -> None:
    assert differences([1.0], [1.0, 2.0]) == ["torque: shape [2]; pinned [1]"]
    assert differences([1], [1.0], exact=False) == ["torque: dtype <f8; pinned <i8"]


def test_a_renamed_check_is_found_on_any_machine() -> None:
    found = copy.deepcopy(pinned("recorded"))
    audit = found["json"]["audit"]
    found["json"]["audit"] = {k.replace("[integrator", "[motion"): v for k, v in audit.items()}
    found["machine"] = OTHER
    lines = flights.differences(CASE_1, pinned("recorded"), found)
    renamed = [key for key in audit if "[integrator" in key]
    assert len(lines) == 2 * len(renamed) > 0
    assert f"{CASE_1}: gnc audit --json: {renamed[0]}: missing" in lines


def test_values_of_commands_are_compared_on_the_same_machine_only() -> None:
    found = copy.deepcopy(pinned("simulated"))
    found["json"]["simulate"]["iterations_max"] = 4
    assert flights.differences(CASE_1, pinned("simulated"), found) == [
        f"{CASE_1}: gnc simulate --json: iterations_max: 4; pinned 3"
    ]
    found["machine"] = OTHER
    assert flights.differences(CASE_1, pinned("simulated"), found) == []


@pytest.mark.parametrize("name", sorted(flights.BY_SETS))
def test_a_flight_decided_by_rounding_is_compared_in_the_large_elsewhere(name: str) -> None:
    stored = store.load(name)
    for kind in ("simulated", "recorded"):
        assert flights.differences(name, stored[kind], stored[kind] | {"machine": OTHER}) == []


def test_a_bag_that_is_another_in_the_large_is_found() -> None:
    name = "afrl_docking_thruster_failed"
    stored = store.load(name)["recorded"]
    found = copy.deepcopy(stored) | {"machine": OTHER}
    found["json"]["audit"]["passed"] = False
    found["json"]["launch"]["phase"] = "docking"
    fields = found["topics"]["/wrench_command"]["fields"]
    fields["wrench.force.x"] |= {"largest": 1.2}
    fields["wrench.force.y"] |= {"sum": 0.0}  # rounding may change it
    del found["topics"]["/deputy_pose"]["fields"]["pose.position.x"]
    assert flights.differences(name, stored, found) == [
        f"{name}: gnc launch --json: phase 'docking'; pinned 'holding'",
        f"{name}: gnc audit --json: passed False; pinned True",
        f"{name}: /deputy_pose pose.position.x: missing",
        f"{name}: /wrench_command wrench.force.x: another by 0.2; allowed 0.1",
    ]


def test_a_new_field_leaves_the_others_pinned() -> None:
    found = copy.deepcopy(pinned("recorded"))
    topic = found["topics"]["/plant_invariants"]
    topic["fields"]["sun_torque.x"] = records.of_array(np.zeros(376))
    topic["payloads"] = "another"
    assert flights.differences(CASE_1, pinned("recorded"), found) == [
        f"{CASE_1}: /plant_invariants sun_torque.x: not pinned"
    ]
    del topic["fields"]["sun_torque.x"]
    assert flights.differences(CASE_1, pinned("recorded"), found) == [
        f"{CASE_1}: /plant_invariants: payloads differ though no field does: their layout"
    ]


def test_a_plant_that_moves_otherwise_is_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One bit of the momentum after the first step: all that follows is another flight."""
    step, changed = RigidBody.step, False

    def other(self: Any, *args: Any, **options: Any) -> Any:
        nonlocal changed
        attitude, momentum = step(self, *args, **options)
        if not changed and momentum.any():  # not the rest of the warm-up
            changed = True
            momentum = momentum + np.spacing(momentum)
        return attitude, momentum

    monkeypatch.setattr(RigidBody, "step", other)
    monkeypatch.setattr(RigidBodyPlant, "stretch", None)  # which takes the kernel itself
    found = flights.simulated(CASE_1, tmp_path)
    lines = flights.differences(CASE_1, pinned("simulated") | {"machine": found["machine"]}, found)
    assert f"{CASE_1}: momentum: differs first in rows 0 to 5 of 375" in lines
    assert not any(": reference" in line for line in lines)
