"""An audit certifies plans of two wheels and of torques, and names what was changed in them."""

from __future__ import annotations

import numpy as np
import pytest
from flown_bags import messages_of
from recording.bags import CODEC
from two_wheels import two_wheels
from wheel_bags import fly, rewrite

from spacecraft_gnc import lie
from spacecraft_gnc.analysis.audit import audit_bag
from spacecraft_gnc.vehicles.two_wheel.audit.certificates import Planned
from spacecraft_gnc.vehicles.two_wheel.audit.wheel_problem import WheelProblem, angles_of
from spacecraft_gnc.vehicles.two_wheel.euler import from_euler_321, to_euler_321
from spacecraft_gnc.vehicles.two_wheel.signals import SOLVER_STATUS

PERIOD = 10_000_000_000  # [ns]
STEP = 9
SHORT = {"duration": 200.0, "initial_euler_321": [0.6, 0.5, -0.8]}
FREE = {"max_wheel_speed": 0.0, "max_wheel_acceleration": 0.0}
OF_TWO = {
    "plan starts at the state", "planned speeds = sums of accelerations", "plan ends at rest",
    "plan within the limits", "planned attitudes = own integration", "cost of the plan",
    "angle off the end", "plan ends where it has to", "first-order conditions",
    "curvature of the plan", "plan is a minimum", "end of the plan = reference", "command = plan",
}  # fmt: skip
OF_TORQUES = {
    "torque plan = own integration", "cost of the torque plan",
    "first-order conditions of the torque plan",
}  # fmt: skip


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    return fly(tmp_path_factory.mktemp("flown"), two_wheels(plant=SHORT))[0]


@pytest.fixture(scope="module")
def messages(bag):
    return messages_of(bag)


def _audited(bag, messages, folder, change):
    """Return the audit of the bag with the solve of one step changed."""

    def changed(data):
        message = CODEC.store.deserialize_cdr(data, SOLVER_STATUS.type)
        change(message)
        return bytes(CODEC.store.serialize_cdr(message, SOLVER_STATUS.type))

    told = (f"/{SOLVER_STATUS}", STEP * PERIOD)
    again = [(t, s, changed(data) if (t, s) == told else data) for t, s, data in messages]
    return audit_bag(rewrite(bag, folder / "bag", again))


@pytest.mark.parametrize(
    ("controller", "limits"),
    [({}, {}), ({"terminal": "soft"}, {}), ({"prediction_model": "simplified"}, {}),
     ({"prediction_model": "euler_321"}, {}), ({}, FREE)],
    ids=["shaped", "soft", "simplified", "euler_321", "no limits"],
)  # fmt: skip
def test_every_plan_that_flies_is_certified(tmp_path, controller, limits):
    sections = two_wheels(plant={**SHORT, **limits}, nmpc_controller=controller)
    audit = audit_bag(fly(tmp_path, sections)[0])
    assert audit.passed, audit.first
    steps = {check.name: check.steps for check in audit.checks}
    assert all(steps[name] > 0 for name in OF_TWO)
    assert steps["first-order conditions"] == 20


def test_plans_of_torques_are_certified(tmp_path):
    three = {
        **SHORT, "wheel_axes": [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        "wheel_inertias": [0.043] * 3,
    }  # fmt: skip
    sections = two_wheels(plant=three, nmpc_controller={"method": "shooting"})
    audit = audit_bag(fly(tmp_path, sections)[0])
    assert audit.passed, audit.first
    steps = {check.name: check.steps for check in audit.checks}
    assert all(steps[name] == 20 for name in OF_TORQUES)


def _array(name, index, change):
    def changed(message):
        values = np.array(getattr(message, name))
        values[index] = change(values[index])
        setattr(message, name, values)

    return changed


def _number(name, change):
    return lambda message: setattr(message, name, change(getattr(message, name)))


CHANGES = {
    "an acceleration": (_array("predicted_accelerations", 11, lambda x: x + 1e-8),
                        {"planned speeds = sums of accelerations"}),
    "the first acceleration": (_array("predicted_accelerations", 0, lambda x: x - 1e-9),
                               {"command = plan"}),
    "a speed": (_array("predicted_speeds", 7, lambda x: x + 1e-6),
                {"planned speeds = sums of accelerations"}),
    "the last speed": (_array("predicted_speeds", -1, lambda x: x + 1e-6), {"plan ends at rest"}),
    "an attitude": (_array("predicted_attitudes", 100, lambda x: x + 1e-4),
                    {"planned attitudes = own integration"}),
    "the start": (_array("predicted_attitudes", 1, lambda x: x + 1e-9),
                  {"plan starts at the state"}),
    "the cost": (_number("cost", lambda x: x * (1.0 + 1e-6)), {"cost of the plan"}),
    "the angle": (_number("terminal_violation", lambda x: x + 1e-6), {"angle off the end"}),
    "the curvature": (_number("min_curvature", lambda x: -x), {"plan is a minimum"}),
}  # fmt: skip


@pytest.mark.parametrize(("change", "names"), CHANGES.values(), ids=CHANGES)
def test_what_was_changed_in_a_plan_is_named(bag, messages, tmp_path, change, names):
    audit = _audited(bag, messages, tmp_path, change)
    failed = {check.name for check in audit.checks if check.first}
    assert names <= failed
    assert all(check.first.step == STEP for check in audit.checks if check.first)


def test_a_plan_that_is_not_optimal_is_no_minimum(bag, messages, tmp_path):
    """A small detour of one wheel, which nearly keeps the end."""

    def detour(message):
        u = np.array(message.predicted_accelerations).reshape(-1, 2)
        u[20:23, 0] += np.array([0.05, -0.1, 0.05])
        message.predicted_accelerations = u.ravel()

    checks = {c.name: c for c in _audited(bag, messages, tmp_path, detour).checks}
    assert checks["first-order conditions"].first.step == STEP


@pytest.mark.parametrize("without", [(), (f"/{SOLVER_STATUS}",)], ids=["messages", "channel"])
def test_solves_that_are_left_out_are_missed(bag, messages, tmp_path, without):
    left = [message for message in messages if message[0] != f"/{SOLVER_STATUS}"]
    audit = audit_bag(rewrite(bag, tmp_path / "bag", left, without))
    missed = "topics of the graph" if without else f"steps of {SOLVER_STATUS}"
    assert {check.name for check in audit.checks if check.first is not None} == {missed}
    notes = {check.name: check.note for check in audit.checks}
    assert notes["plans told"] == "wheel_solver_status was not recorded"


@pytest.mark.parametrize("model", ["simplified", "euler_321", "so3"])
def test_the_derivatives_of_the_audit_are_those_of_its_cost(model):
    rng = np.random.default_rng(3)
    rates = np.array([[-1e-4, 0.0], [0.0, -3.55e-5], [0.0, 0.0]])
    problem = WheelProblem(
        np.eye(3), rates, 10.0, np.array([1.0, 2.0, 3.0]), 1e-6, 1e-3, 1e2, 100.0, 5.0
    )
    first, u = lie.exp(np.array([0.4, -0.3, 0.2])), rng.uniform(-4.0, 4.0, (6, 2))
    drift = 1e-3 * rng.normal(size=(7, 3))
    plan = Planned(problem, model, True, first, drift, np.array([10.0, -20.0]), u)

    def cost(flat):
        v = flat.reshape(1, 6, 2)
        speeds = problem.speeds(plan.start, v)
        return problem.cost(problem.errors(model, first, drift, speeds), speeds, v, True)[0]

    gradient, end = plan.derivatives(u)
    steps = 1e-3 * np.eye(12)
    central = [(cost(u.ravel() + s) - cost(u.ravel() - s)) / 2e-3 for s in steps]
    np.testing.assert_allclose(gradient, central, rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose(end, np.tile(10.0 * np.eye(2), 6), rtol=1e-12)


def test_angles_of_quaternions_are_the_3_2_1_angles():
    angles = np.array([0.5, -1.2, 2.5])
    x, y, z, w = lie.to_quaternion_xyzw(from_euler_321(angles))
    np.testing.assert_allclose(angles_of(np.array([w, x, y, z])), angles, atol=1e-14)
    np.testing.assert_allclose(to_euler_321(from_euler_321(angles)), angles, atol=1e-14)
