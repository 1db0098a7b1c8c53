"""Files of plans: what is read is what was written, and a bad one is refused in one line."""

import math
import os
import zipfile

import numpy as np
import pytest
from transfer_cases import BODY, figure_4, paper_transfer

from spacecraft_gnc.analysis.plan_file import vehicle_in
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.ocp.transfer import TransferSolver
from spacecraft_gnc.vehicles.rigid_body.planner.file import difference, load_plan, save_plan


@pytest.fixture(scope="module")
def plan():
    return TransferSolver().solve(figure_4())


@pytest.fixture
def stored(plan, tmp_path):
    return save_plan(tmp_path / "plan.npz", plan, "plant: {}", "# none")


def rewritten(path, **changes):
    """The same file with other members."""
    with np.load(path) as members:
        arrays = {name: members[name] for name in members.files} | changes
    np.savez_compressed(path, **{name: a for name, a in arrays.items() if a is not None})
    return path


def test_plan_that_is_read_is_the_one_that_was_written(plan, stored):
    found, scenario, defaults = load_plan(stored)
    assert (scenario, defaults) == ("plant: {}", "# none")
    for name in (
        "torque", "momentum", "attitude", "co_momentum", "zeta", "torque_multipliers",
        "momentum_multipliers", "active_torque", "active_momentum",
    ):  # fmt: skip
        assert np.array_equal(getattr(found, name), getattr(plan, name)), name
    for name in ("status", "cost", "residuals", "min_curvature", "iterations", "tried", "reason"):
        assert getattr(found, name) == getattr(plan, name), name
    assert found.active == plan.active
    assert difference(found.problem, plan.problem) == ""
    assert math.isnan(found.solve_time)


def test_promised_arrays_have_the_promised_shapes(stored):
    with np.load(stored) as members:
        shapes = {
            name: members[name].shape
            for name in ("torque", "momentum", "attitude", "co_momentum", "multipliers")
        }
    assert shapes == {
        "torque": (190, 3), "momentum": (191, 3), "attitude": (191, 3, 3),
        "co_momentum": (190, 3), "multipliers": (191, 6),
    }  # fmt: skip


def test_file_does_not_depend_on_how_long_the_solve_took(stored, tmp_path):
    again = save_plan(
        tmp_path / "again.npz", TransferSolver().solve(figure_4()), "plant: {}", "# none"
    )
    assert again.read_bytes() == stored.read_bytes()


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"plan_of": None}, "received a file that is no plan of gnc plan;"),
        ({"zeta": None}, "received a plan without zeta;"),
        ({"plan_of": np.array("two_wheel")}, "of vehicle two_wheel, not rigid_body"),
        ({"momentum": np.zeros((190, 3))}, "momentum of shape (190, 3), or not finite"),
        ({"torque": np.full((190, 3), math.nan)}, "torque of shape (190, 3), or not finite"),
        ({"inertia": -np.eye(3)}, "inertia"),
        ({"goal": 2.0 * np.eye(3)}, "goal: received"),
        ({"tried": np.array("{")}, "Expecting"),
        ({"status": np.array(77)}, "77 is not a valid Status"),
    ],
)
def test_what_is_no_plan_is_refused_in_one_line(stored, changes, reason):
    with pytest.raises(RecordingError) as refused:
        load_plan(rewritten(stored, **changes))
    text = str(refused.value)
    assert text.startswith(f"{stored}: received a ")
    assert reason in text
    assert text.endswith("; required a .npz file written by `gnc plan --out`; plan again")
    assert "\n" not in text


def test_missing_and_torn_files_are_refused(stored, tmp_path):
    with pytest.raises(RecordingError, match=f"read as a plan \\({os.strerror(2)}\\)"):
        load_plan(tmp_path / "none.npz")
    stored.write_bytes(stored.read_bytes()[:2000])
    with pytest.raises(RecordingError, match="cannot be read as a plan"):
        load_plan(stored)


@pytest.mark.parametrize("name", ["torque", "co_momentum", "zeta", "multipliers", "limits"])
def test_numbers_that_are_no_optimal_plan_are_refused(stored, name):
    with np.load(stored) as members:
        changed = 0.999 * members[name]
    with pytest.raises(RecordingError, match="received a plan that violates its conditions by"):
        load_plan(rewritten(stored, **{name: changed}))


def test_file_that_cannot_be_written_is_refused(plan, tmp_path):
    with pytest.raises(RecordingError, match="cannot be written"):
        save_plan(tmp_path / "none" / "plan.npz", plan)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        (
            {"body": RigidBody(np.diag([800.0, 1200.0, 1001.0]), 0.1)},
            "inertia diag(800, 1200, 1000) kg m^2, not diag(800, 1200, 1001)",
        ),
        ({"body": RigidBody(BODY.inertia, 0.2)}, "control period 0.1 s, not 0.2"),
        ({"n_steps": 200}, "duration 19 s, not 20"),
        ({"torque": (-20.0, math.inf)}, "torque bounds [[-20, -20, -20], [20, 20, 20]] N m, not"),
        ({"momentum": None}, "momentum bounds"),
        ({"start_momentum": np.zeros(3)}, "initial momentum [30, -10, 10] N m s, not [0, 0, 0]"),
    ],
)
def test_difference_to_another_transfer_is_told(changes, told):
    assert difference(figure_4(), figure_4(**changes)).startswith(told)


def test_difference_of_attitudes_is_an_angle():
    other = paper_transfer(80.0, (1.0, 1.0, 1.0), 19.0)
    told = difference(paper_transfer(90.0, (1.0, 1.0, 1.0), 19.0), other)
    assert told == "another target, 10 deg off"


def test_damage_anywhere_is_refused_in_one_line(stored):
    whole, random = stored.read_bytes(), np.random.default_rng(16)
    for i in range(150):
        damaged = bytearray(whole)
        place = random.integers(len(damaged)) if i % 3 else -random.integers(2000) - 1
        damaged[place] ^= 1 << random.integers(8)
        stored.write_bytes(damaged[: random.integers(len(damaged))] if i % 10 == 0 else damaged)
        text = ""
        try:
            load_plan(stored)  # a bit may decide nothing
        except RecordingError as error:
            text = str(error)
        assert "\n" not in text


@pytest.mark.parametrize("text", ["{'descr': ((", "{'shape': (9999999999999, 3)", "\x00"])
def test_damaged_header_of_an_array_is_refused(stored, text):
    with zipfile.ZipFile(stored) as members:
        arrays = {name: members.read(name) for name in members.namelist()}
    header = arrays["torque.npy"]
    arrays["torque.npy"] = header[:10] + text.encode() + header[10 + len(text) :]
    with zipfile.ZipFile(stored, "w") as members:
        for name, data in arrays.items():
            members.writestr(name, data)
    with pytest.raises(RecordingError, match="cannot be read as a plan"):
        load_plan(stored)
    assert vehicle_in(stored) == "rigid_body"
