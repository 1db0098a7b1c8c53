"""Disturbances as a sum of parts, found by name, built from the parameters of the plant."""

from __future__ import annotations

import dataclasses
from importlib import metadata

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import rotations, vectors

from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.parameters.parameter import specs_of, typed
from spacecraft_gnc.parameters.problems import problem_of
from spacecraft_gnc.plant.disturbances.constant import ConstantTorque
from spacecraft_gnc.plant.disturbances.gravity_gradient import GravityGradient
from spacecraft_gnc.plant.disturbances.noise import NoiseTorque
from spacecraft_gnc.plant.disturbances.parameters import DisturbanceParameters
from spacecraft_gnc.plant.disturbances.push import Push
from spacecraft_gnc.plant.disturbances.registry import build, names, refusals
from spacecraft_gnc.plant.disturbances.torques import Disturbances, Motion

INERTIA = np.diag([1.0, 0.8, 0.6])
HERE = __name__
STILL = Motion(0, 0.0, np.eye(3), np.zeros(3))


def parameters(plugin=None, **values):
    specs = dict(specs_of(DisturbanceParameters))
    given = {name: typed(specs[name], value) for name, value in values.items()}
    return DisturbanceParameters(**given, plugin=plugin or {})


class Damping:
    """A part of another package: a torque against the body rate."""

    def __init__(self, coefficient):
        self.coefficient = coefficient

    @classmethod
    def from_parameters(cls, parameters, inertia):
        assert (inertia == INERTIA).all()
        if parameters.plugin["coefficient"] < 0.0:
            raise ParameterError("plugin.coefficient: received < 0; required >= 0; raise it")
        return cls(parameters.plugin["coefficient"])

    def torque(self, motion):
        return -self.coefficient * motion.angular_velocity


class WithoutTorque:
    @classmethod
    def from_parameters(cls, _parameters, _inertia):
        return cls()


class Failing:
    @classmethod
    def from_parameters(cls, _parameters, _inertia):
        raise ZeroDivisionError("by\nzero")


@pytest.fixture
def plugins(monkeypatch):
    """Entry points of a package that is not there, one good and the others broken."""
    targets = {
        "damping": f"{HERE}:Damping",
        "without_torque": f"{HERE}:WithoutTorque",
        "without_factory": f"{HERE}:STILL",
        "failing": f"{HERE}:Failing",
        "no_module": "no_such_module_here:Damping",
        "no_class": f"{HERE}:NoSuchClass",
        "constant": f"{HERE}:Damping",
    }
    installed = metadata.entry_points

    def entry_points(**selection):
        group = selection.get("group")
        if group != "spacecraft_gnc.disturbances":
            return installed(**selection)
        return [metadata.EntryPoint(name, target, group) for name, target in targets.items()]

    monkeypatch.setattr(metadata, "entry_points", entry_points)


@given(rotations(), vectors(), st.integers(0, 10**6), st.floats(0.0, 1e6))
def test_the_sum_is_that_of_its_parts_and_the_mean_that_of_its_instants(R, omega, step, time):
    parts = {
        "constant": ConstantTorque([1e-4, -2e-4, 3e-5]),
        "gravity_gradient": GravityGradient(INERTIA, 1e-2),
        "noise": NoiseTorque([1e-3, 0.0, 1e-5], 5, 6),
    }
    motion = Motion(step, time, R, omega)
    later = Motion(step, time + 0.1, R.T, -omega)
    both, first, second = Disturbances(parts), parts.values(), parts.values()
    expected = sum(part.torque(motion) for part in first)
    assert both.torque(motion) == pytest.approx(expected, rel=1e-15)
    expected = 0.5 * (expected + sum(part.torque(later) for part in second))
    assert both.torque(motion, later) == pytest.approx(expected, abs=1e-17)
    assert (both.torque(motion, motion) == both.torque(motion)).all()


def test_no_parts_are_none():
    assert not Disturbances()
    assert not build(parameters(), INERTIA)
    assert len(build(parameters(disturbances=["constant"], constant_torque=[1.0, 0, 0]), INERTIA))


def test_noise_depends_on_the_step_alone_and_has_the_deviations_asked_for():
    deviation = np.array([1e-3, 0.0, 2e-5])
    part = NoiseTorque(deviation, seed=3, run=4)
    drawn = np.array([part.torque(Motion(k, 0.0, np.eye(3), np.zeros(3))) for k in range(5000)])
    again = part.torque(Motion(4321, 99.0, -np.eye(3), np.ones(3)))
    assert (again == drawn[4321]).all()
    assert (drawn[:, 1] == 0.0).all()
    assert drawn.std(axis=0) == pytest.approx(deviation, rel=0.05)
    for other in (NoiseTorque(deviation, 3, 5), NoiseTorque(deviation, 4, 4)):
        assert (other.torque(STILL) != part.torque(STILL))[[0, 2]].all()


def test_parts_are_built_from_the_parameters_of_the_plant():
    built = build(
        parameters(
            disturbances=["noise", "gravity_gradient", "constant"],
            constant_torque=[1.0, 2.0, 3.0],
            orbit_rate=0.01,
            orbit_normal=[0.0, 2.0, 0.0],
            orbit_position=[0.0, 0.0, -1.0],
            noise_torque=[0.1, 0.2, 0.3],
            seed=8,
            run=9,
        ),
        INERTIA,
    ).parts
    assert list(built) == ["noise", "gravity_gradient", "constant"]
    assert built["constant"].value.tolist() == [1.0, 2.0, 3.0]
    gradient = built["gravity_gradient"]
    assert (gradient.inertia == INERTIA).all()
    assert gradient.orbit_rate == 0.01
    assert gradient.orbit_normal.tolist() == [0.0, 1.0, 0.0]
    assert gradient.position(0.0).tolist() == [0.0, 0.0, -1.0]
    noise = built["noise"]
    assert (noise.deviation.tolist(), noise.seed, noise.run) == ([0.1, 0.2, 0.3], 8, 9)


@pytest.mark.usefixtures("plugins")
def test_another_package_adds_its_own_part():
    assert "damping" in names()
    listed = ["damping", "constant"]
    section = parameters({"coefficient": 2.0}, disturbances=listed, constant_torque=[1.0, 0, 0])
    built = build(section, INERTIA)
    motion = Motion(0, 0.0, np.eye(3), np.array([0.1, 0.2, 0.3]))
    assert built.torque(motion) == pytest.approx([0.8, -0.4, -0.6])
    assert type(built.parts["constant"]) is ConstantTorque  # a built-in one wins


REFUSED = [
    (["constant"], "constant_torque", "received nothing; required 3 numbers"),
    (["gravity_gradient"], "orbit_rate", "received 0.0 rad/s; required a positive rate"),
    (["noise"], "noise_torque", "received nothing; required 3 standard deviations"),
    (["push"], "push_torque", "received nothing; required 3 numbers"),
    (["dampin"], "disturbances", "received 'dampin'; required one of constant, .*'damping'?"),
    (["damping"], "plugin.coefficient", "received < 0"),
    (["failing"], "disturbances", "'failing', .*fails with ZeroDivisionError: by zero; .*mend"),
    (["no_module"], "disturbances", "'no_module', .*ModuleNotFoundError.*mend"),
    (["no_class"], "disturbances", "'no_class', .*AttributeError.*mend"),
    (["without_factory"], "disturbances", "'without_factory', .*from_parameters.*mend"),
    (["without_torque"], "disturbances", "'without_torque', .*without a method torque.*mend"),
]


@pytest.mark.usefixtures("plugins")
@pytest.mark.parametrize(("listed", "name", "words"), REFUSED)
def test_a_part_that_cannot_be_built_is_refused_in_one_line(listed, name, words):
    section = parameters({"coefficient": -1.0}, disturbances=listed)
    with pytest.raises(ParameterError, match=f"^{name}: .*{words}") as caught:
        build(section, INERTIA)
    assert "\n" not in str(caught.value)
    known = [f.name for f in dataclasses.fields(DisturbanceParameters)]
    problem = problem_of(caught.value, "file", "plant", known)
    assert problem is not None
    assert problem.remedy


@pytest.mark.usefixtures("plugins")
def test_every_refusal_is_told_at_once():
    listed = ["noise", "constant", "damping", "unknown"]
    found = refusals(
        parameters({"coefficient": 1.0}, disturbances=listed, constant_torque=[1.0, 0, 0]), INERTIA
    )
    assert [str(error).partition(":")[0] for error in found] == ["noise_torque", "disturbances"]


@pytest.mark.parametrize(
    ("returned", "words"),
    [
        ([1.0, 2.0], r"received \[1.0, 2.0\] from 'own' at step 7"),
        ([1.0, np.nan, 0.0], r"received \[1.0, nan, 0.0\] from 'own' at step 7"),
        (None, "required a finite body torque"),
        ("three", "ValueError"),
    ],
)
def test_a_part_that_returns_no_torque_is_refused_in_flight(returned, words):
    class Own:
        def torque(self, motion):
            return returned

    with pytest.raises(ParameterError, match=words):
        Disturbances({"own": Own()}).torque(STILL._replace(step=7))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: ConstantTorque([1.0, np.inf, 0.0]), "constant_torque: .*finite"),
        (lambda: ConstantTorque([1.0, 0.0]), "constant_torque: .*shape"),
        (lambda: NoiseTorque([1.0, -1.0, 0.0]), "noise_torque: .*>= 0"),
        (lambda: NoiseTorque([1.0, np.nan, 0.0]), "noise_torque: .*finite"),
        (lambda: NoiseTorque([1.0, 1.0, 1.0], seed=-1), "seed: received -1"),
        (lambda: NoiseTorque([1.0, 1.0, 1.0], run=2**63), "run: received"),
        (lambda: Push([1.0, 0.0], 1.0, 1.0), "push_torque: .*shape"),
        (lambda: Push([1.0, 0.0, 0.0], -1.0, 1.0), "push_time: received -1"),
        (lambda: Push([1.0, 0.0, 0.0], 1.0, 0.0), "push_duration: received 0"),
    ],
)
def test_numbers_that_are_none_are_refused(make, words):
    with pytest.raises(ValueError, match=words):
        make()
