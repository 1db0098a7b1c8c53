"""Every public function and constructor of the core refuses what is no such argument, by its name.

A table lists them with arguments that they take, and the kind of each. Every argument is then
replaced, one at a time, by everything that is not of its kind; a `GncError` of one line has to name
the argument and say what is required. Numbers of NumPy, lists and views are taken like plain ones.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from spacecraft_gnc import lie, scenario
from spacecraft_gnc.arguments import shown
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.errors import GncError
from spacecraft_gnc.governors import PassThroughGovernor
from spacecraft_gnc.governors.attitude import AttitudeGovernor
from spacecraft_gnc.governors.controller_loop import ControllerLoopPredictor
from spacecraft_gnc.governors.feedback import AttitudeFeedback
from spacecraft_gnc.governors.feedback_loop import FeedbackPredictor
from spacecraft_gnc.governors.reference_set import ReferenceSet
from spacecraft_gnc.governors.route import RoutePlanner
from spacecraft_gnc.governors.search import GeodesicSearch
from spacecraft_gnc.loop import ClosedLoop, State
from spacecraft_gnc.ocp import (
    AttitudeOcp,
    FsolveSolver,
    NeighboringExtremal,
    NeighboringOptions,
    PenaltyContinuation,
    PointingZone,
    ShootingOptions,
    ShootingSolver,
    SlsqpSolver,
    StateContinuation,
    TerminalSetOcp,
    TerminalSetSolver,
    Weights,
    fly_nominal,
    linearize,
)
from spacecraft_gnc.vehicles.rigid_body.controllers.feedback.controller import FeedbackController
from spacecraft_gnc.vehicles.rigid_body.controllers.solvers import (
    ShootingController,
    SolverController,
)
from spacecraft_gnc.vehicles.rigid_body.flight import RigidBodyFlight
from spacecraft_gnc.vehicles.rigid_body.plant import RigidBodyPlant

INERTIA = np.diag([1.0, 0.8, 0.7])  # [kg m^2]
R = lie.exp(np.array([0.2, -0.1, 0.3]))
PI = np.array([0.01, 0.0, -0.02])  # [N m s]
OCP = AttitudeOcp(INERTIA, 0.4, 4)
SOLVER = ShootingSolver(OCP)
BODY = RigidBody(INERTIA, 0.4)
TERMINAL = TerminalSetOcp(INERTIA, 0.4, 4, terminal_set="false")
FEEDBACK = AttitudeFeedback(0.01, 0.1, INERTIA)
REFERENCES = ReferenceSet()
PREDICTOR = FeedbackPredictor(FEEDBACK, 0.4, 1, REFERENCES)
PLANT = RigidBodyPlant(BODY, R, PI, 3)
CONTROLLER = ShootingController(SOLVER)
GOVERNOR = PassThroughGovernor(np.eye(3))
ZONE = {"body_axis": [1.0, 0.0, 0.0], "inertial_axis": [0.0, 0.0, 1.0]}
CASE1 = Path(__file__).parents[1] / "config" / "gupta2015_case1.yaml"
SCENARIO = scenario.load(CASE1)
NOMINAL = fly_nominal(SOLVER, R, PI, 2)


class Nothing:
    """An object that is nothing in particular, with a long repr of several lines."""

    def __repr__(self) -> str:
        return "a thing\n" * 100


NO_NUMBER = (True, np.True_, "1.0", b"1", 1j, None, Nothing(), {}, [1.0], np.ones(2), math.nan)
NO_ARRAY = (True, "abc", b"abc", None, Nothing(), {"a": 1}, [[1.0], [1.0, 2.0]], np.ones(2), 1j)


def texts(shape: tuple[int, ...]) -> Iterator[Any]:
    """Yield arrays of the right shape that hold no numbers."""
    ones = np.ones(shape)
    yield from (ones.astype(bool), ones.astype(str), ones.astype(complex), ones.astype(object))
    yield ones.astype(bool).tolist()


BAD: dict[str, Callable[[], list[Any]]] = {
    "positive": lambda: [*NO_NUMBER, 0.0, -1.0, math.inf, 10**400, np.array("1")],
    "limit": lambda: [*NO_NUMBER, -1.0, math.inf, 10**400],
    "share": lambda: [*NO_NUMBER, 0.0, 2.0, -0.5],
    "count": lambda: [*NO_NUMBER, 0, -1, 1.5, 1.0, np.array(1.5)],
    "size": lambda: [*NO_NUMBER, -1, 1.5, np.array(1.5)],
    "word": lambda: ["nothing of the kind", 1, None, True, [], np.array(["a", "b"]), Nothing()],
    "object": lambda: ["text", 1.0, None, True, np.eye(3), Nothing(), []],
    "path": lambda: [1.0, None, True, [], Nothing(), "a\0b"],
    "axis": lambda: [*NO_ARRAY, 1.0, np.ones(4), np.zeros(3), [math.nan, 0, 0], *texts((3,))],
    "vector": lambda: [*NO_ARRAY, 1.0, np.ones((3, 1)), np.ones(4), [1, 2], *texts((3,))],
    "finite": lambda: [*BAD["vector"](), [math.nan, 0.0, 0.0], [0.0, math.inf, 0.0]],
    "quaternion": lambda: [*NO_ARRAY, np.ones(3), np.zeros(4), [math.nan] * 4, *texts((4,))],
    "square": lambda: [*NO_ARRAY, 1.0, np.ones(9), np.eye(2), np.eye(3)[None], *texts((3, 3))],
    "matrix": lambda: [*NO_ARRAY, np.eye(2), np.full((3, 3), math.nan), *texts((3, 3))],
    "rotation": lambda: [*BAD["matrix"](), -np.eye(3), 1.1 * np.eye(3), np.ones((3, 3))],
    "stack": lambda: [*NO_ARRAY, 1.0, np.ones(9), np.ones((4, 9)), *texts((2, 3, 3))],
    "rows": lambda: [*NO_ARRAY, 1.0, np.ones((4, 2)), np.ones((2, 2, 3)), *texts((2, 3))],
    "multipliers": lambda: [*(x for x in NO_ARRAY if x is not None), 1.0, np.ones(6),
                            np.ones((3, 6)), *texts((4, 6))],
    "zones": lambda: ["text", 1.0, None, True, [1.0], Nothing(), [None]],
    "overrides": lambda: [1.0, None, "plant.duration=1.0", [1.0], Nothing()],
    "sections": lambda: [1.0, None, "text", [], {"plant": 1.0}, {"plant": None}, Nothing()],
}  # fmt: skip


class Case(NamedTuple):
    """One callable, arguments that it takes, and the kind of each; a '?' takes None as well."""

    call: Callable[..., Any]
    good: dict[str, Any]
    kinds: dict[str, str]


STATE = {"attitude": R, "momentum": PI, "reference": np.eye(3)}
STATE_KINDS = {"attitude": "rotation", "momentum": "finite", "reference": "rotation?"}
SOLVE = {**STATE, "warm_start": np.zeros((4, 6))}
SOLVE_KINDS = {**STATE_KINDS, "warm_start": "multipliers?"}
CASES = {
    "lie.hat": Case(lie.hat, {"vector": PI}, {"vector": "vector"}),
    "lie.vee": Case(lie.vee, {"matrix": R}, {"matrix": "square"}),
    "lie.exp": Case(lie.exp, {"rotation_vector": PI}, {"rotation_vector": "finite"}),
    "lie.log": Case(lie.log, {"rotation": R}, {"rotation": "square"}),
    "lie.angle_between": Case(
        lie.angle_between, {"first": R, "second": R}, {"first": "square", "second": "square"}
    ),
    "lie.angles_between": Case(
        lie.angles_between,
        {"first": np.stack([R, R]), "second": R},
        {"first": "stack", "second": "stack"},
    ),
    "lie.to_quaternion_xyzw": Case(
        lie.to_quaternion_xyzw, {"rotation": R}, {"rotation": "square"}
    ),
    "lie.from_quaternion_xyzw": Case(
        lie.from_quaternion_xyzw,
        {"quaternion": np.array([0.0, 0.6, 0.0, 0.8])},
        {"quaternion": "quaternion"},
    ),
    "lie.is_rotation": Case(
        lie.is_rotation, {"matrix": R, "tolerance": 1e-6}, {"tolerance": "limit"}
    ),
    "lie.orthonormalize": Case(lie.orthonormalize, {"matrix": R}, {"matrix": "square"}),
    "RigidBody": Case(
        RigidBody,
        {"inertia": INERTIA, "time_step": 0.4},
        {"inertia": "matrix", "time_step": "positive"},
    ),
    "RigidBody.step": Case(
        BODY.step,
        {"attitude": R, "momentum": PI, "torque": PI, "n_steps": 2},
        {"attitude": "square", "momentum": "vector", "torque": "vector", "n_steps": "count"},
    ),
    "RigidBody.simulate": Case(
        BODY.simulate,
        {"attitude": R, "momentum": PI, "torques": np.zeros((3, 3)), "n_steps": 3},
        {"attitude": "rotation", "momentum": "finite", "torques": "rows", "n_steps": "count?"},
    ),
    "RigidBody.is_solvable": Case(BODY.is_solvable, {"momentum": PI}, {"momentum": "vector"}),
    "RigidBody.largest_time_step": Case(
        BODY.largest_time_step, {"momentum": PI}, {"momentum": "finite"}
    ),
    "RigidBody.angular_velocity": Case(
        BODY.angular_velocity, {"momentum": PI}, {"momentum": "vector"}
    ),
    "RigidBody.kinetic_energy": Case(BODY.kinetic_energy, {"momentum": PI}, {"momentum": "vector"}),
    "Weights": Case(
        Weights,
        dict.fromkeys(Weights.__slots__, 0.01),
        dict.fromkeys(Weights.__slots__, "matrix"),
    ),
    "PointingZone": Case(
        PointingZone,
        {"kind": "exclusion", **ZONE, "half_angle": 0.5, "penalty": 2.0},
        {
            "kind": "word",
            "body_axis": "axis",
            "inertial_axis": "axis",
            "half_angle": "positive",
            "penalty": "positive",
        },
    ),
    "PointingZone.margin": Case(
        PointingZone("exclusion", **ZONE, half_angle=0.5, penalty=2.0).margin,
        {"attitudes": np.stack([R, R])},
        {"attitudes": "stack"},
    ),
    "AttitudeOcp": Case(
        AttitudeOcp,
        {
            "inertia": INERTIA,
            "time_step": 0.4,
            "horizon": 4,
            "weights": Weights(),
            "max_torque": 0.25,
            "torque_penalty": 1e10,
            "zones": (),
            "actuators": np.eye(3),
        },
        {
            "inertia": "matrix",
            "time_step": "positive",
            "horizon": "count",
            "weights": "object",
            "max_torque": "limit",
            "torque_penalty": "positive",
            "zones": "zones",
            "actuators": "square?",
        },
    ),
    "AttitudeOcp.cost": Case(
        OCP.cost,
        {"controls": np.zeros((4, 3)), **STATE},
        {"controls": "rows", **STATE_KINDS},
    ),
    "AttitudeOcp.rollout": Case(
        OCP.rollout,
        {"controls": np.zeros((4, 3)), "attitude": R, "momentum": PI},
        {"controls": "rows", "attitude": "rotation", "momentum": "finite"},
    ),
    "AttitudeOcp.realizable": Case(OCP.realizable, {"torque": PI}, {"torque": "vector"}),
    "ShootingOptions": Case(
        ShootingOptions,
        {
            "residual_tolerance": 1e-10,
            "max_iterations": 9,
            "formulation": "auto",
            "step_rule": "full",
            "damping": 0.5,
        },
        {
            "residual_tolerance": "positive",
            "max_iterations": "count",
            "formulation": "word",
            "step_rule": "word",
            "damping": "share",
        },
    ),
    "ShootingSolver": Case(
        ShootingSolver,
        {"ocp": OCP, "variant": "exact", "options": ShootingOptions()},
        {"ocp": "object", "variant": "word", "options": "object?"},
    ),
    "ShootingSolver.solve": Case(SOLVER.solve, SOLVE, SOLVE_KINDS),
    "ShootingSolver.solve_batch": Case(
        SOLVER.solve_batch,
        {"attitudes": np.stack([R, R]), "momenta": np.stack([PI, PI]), "reference": np.eye(3)},
        {"attitudes": "stack", "momenta": "rows", "reference": "rotation?"},
    ),
    "NeighboringOptions": Case(
        NeighboringOptions,
        {"tolerance": 1e-3, "max_age": 5},
        {"tolerance": "positive", "max_age": "count"},
    ),
    "NeighboringExtremal": Case(
        NeighboringExtremal,
        {"ocp": OCP, "neighboring": NeighboringOptions(), "options": ShootingOptions()},
        {"ocp": "object", "neighboring": "object?", "options": "object?"},
    ),
    "NeighboringExtremal.solve": Case(NeighboringExtremal(OCP).solve, SOLVE, SOLVE_KINDS),
    "SlsqpSolver": Case(
        SlsqpSolver,
        {"ocp": OCP, "tolerance": 1e-9, "max_iterations": 9},
        {"ocp": "object", "tolerance": "positive", "max_iterations": "count"},
    ),
    "SlsqpSolver.solve": Case(SlsqpSolver(OCP, 1e-6, 3).solve, SOLVE, SOLVE_KINDS),
    "FsolveSolver": Case(
        FsolveSolver, {"ocp": OCP, "tolerance": 1e-9}, {"ocp": "object", "tolerance": "positive"}
    ),
    "FsolveSolver.solve": Case(FsolveSolver(OCP).solve, SOLVE, SOLVE_KINDS),
    "PenaltyContinuation": Case(
        PenaltyContinuation,
        {"ocp": OCP, "options": ShootingOptions()},
        {"ocp": "object", "options": "object?"},
    ),
    "PenaltyContinuation.solve": Case(PenaltyContinuation(OCP).solve, STATE, STATE_KINDS),
    "StateContinuation": Case(
        StateContinuation,
        {"ocp": OCP, "options": ShootingOptions()},
        {"ocp": "object", "options": "object?"},
    ),
    "StateContinuation.solve": Case(StateContinuation(OCP).solve, STATE, STATE_KINDS),
    "linearize": Case(linearize, {"solution": SOLVER.solve(R, PI)}, {"solution": "object"}),
    "fly_nominal": Case(
        fly_nominal,
        {"solver": SOLVER, "attitude": R, "momentum": PI, "n_steps": 2, "reference": np.eye(3)},
        {"solver": "object", "n_steps": "count", **STATE_KINDS},
    ),
    "NominalRun.torque": Case(
        NOMINAL.torque,
        {"step": 1, "attitude": R, "momentum": PI},
        {"step": "size", "attitude": "square", "momentum": "vector"},
    ),
    "TerminalSetOcp": Case(
        TerminalSetOcp,
        {
            "inertia": INERTIA,
            "time_step": 0.4,
            "horizon": 4,
            "stage_rate": 1.0,
            "stage_cost_scale": 0.125,
            "max_torque": 0.25,
            "terminal_set": "false",
            "zones": (),
        },
        {
            "inertia": "matrix",
            "time_step": "positive",
            "horizon": "count",
            "stage_rate": "matrix",
            "stage_cost_scale": "share",
            "max_torque": "limit",
            "terminal_set": "word",
            "zones": "zones",
        },
    ),
    "TerminalSetOcp.with_horizon": Case(
        TERMINAL.with_horizon, {"horizon": 3}, {"horizon": "count"}
    ),
    "TerminalSetOcp.weighted": Case(
        TERMINAL.weighted, {"multiplier": 1.0}, {"multiplier": "limit"}
    ),
    "TerminalSetSolver": Case(
        TerminalSetSolver,
        {"ocp": TERMINAL, "options": ShootingOptions()},
        {"ocp": "object", "options": "object?"},
    ),
    "TerminalSetSolver.solve": Case(TerminalSetSolver(TERMINAL).solve, SOLVE, SOLVE_KINDS),
    "AttitudeFeedback": Case(
        AttitudeFeedback,
        {"attitude_gain": 0.01, "momentum_gain": 0.1, "inertia": INERTIA, "max_torque": 0.5},
        {
            "attitude_gain": "matrix",
            "momentum_gain": "matrix",
            "inertia": "matrix",
            "max_torque": "limit",
        },
    ),
    "AttitudeFeedback.critically_damped": Case(
        AttitudeFeedback.critically_damped,
        {"inertia": INERTIA, "period": 0.5, "max_torque": 0.5},
        {"inertia": "matrix", "period": "positive", "max_torque": "limit"},
    ),
    "AttitudeFeedback.torque": Case(
        lambda reference: FEEDBACK.torque(State(0, R, PI), reference),
        {"reference": R},
        {"reference": "square"},
    ),
    "ReferenceSet": Case(
        ReferenceSet,
        {"zones": (), "steady_margin": 0.125, "names": ()},
        {"zones": "zones", "steady_margin": "positive"},
    ),
    "ReferenceSet.margin": Case(REFERENCES.margin, {"attitude": R}, {"attitude": "square"}),
    "ReferenceSet.margins": Case(
        REFERENCES.margins, {"attitudes": np.stack([R, R])}, {"attitudes": "stack"}
    ),
    "FeedbackPredictor": Case(
        FeedbackPredictor,
        {
            "feedback": FEEDBACK,
            "time_step": 0.4,
            "substeps": 1,
            "reference_set": REFERENCES,
            "max_torque": 0.0,
            "max_momentum": 0.0,
            "level": 0.0,
            "horizon": 5,
        },
        {
            "feedback": "object",
            "time_step": "positive",
            "substeps": "count",
            "reference_set": "object",
            "max_torque": "limit",
            "max_momentum": "limit",
            "level": "limit",
            "horizon": "size",
        },
    ),
    "GeodesicSearch": Case(
        GeodesicSearch,
        {
            "predictor": PREDICTOR,
            "reference_set": REFERENCES,
            "alpha_tolerance": 0.125,
            "cut_point_shift": 0.125,
        },
        {
            "predictor": "object",
            "reference_set": "object",
            "alpha_tolerance": "share",
            "cut_point_shift": "share",
        },
    ),
    "RoutePlanner": Case(
        RoutePlanner,
        {"reference_set": REFERENCES, "clearance": 0.125},
        {"reference_set": "object", "clearance": "positive"},
    ),
    "AttitudeGovernor": Case(
        AttitudeGovernor,
        {
            "predictor": PREDICTOR,
            "reference_set": REFERENCES,
            "target": R,
            "planner": RoutePlanner(REFERENCES, 0.125),
            "initial_reference": R,
        },
        {
            "predictor": "object",
            "reference_set": "object",
            "target": "rotation",
            "planner": "object?",
            "initial_reference": "rotation?",
        },
    ),
    "PassThroughGovernor": Case(PassThroughGovernor, {"target": R}, {"target": "rotation"}),
    "ControllerLoopPredictor": Case(
        ControllerLoopPredictor,
        {
            "controller": ShootingController(ShootingSolver(OCP)),
            "body": BODY,
            "substeps": 1,
            "reference_set": REFERENCES,
            "target": np.eye(3),
            "max_torque": 0.0,
            "max_momentum": 0.0,
            "horizon": 5,
        },
        {
            "controller": "object",
            "body": "object",
            "substeps": "count",
            "reference_set": "object",
            "target": "rotation",
            "max_torque": "limit",
            "max_momentum": "limit",
            "horizon": "size",
        },
    ),
    "RigidBodyPlant": Case(
        RigidBodyPlant,
        {"body": BODY, "attitude": R, "momentum": PI, "n_steps": 3, "substeps": 1},
        {
            "body": "object",
            "attitude": "rotation",
            "momentum": "finite",
            "n_steps": "count",
            "substeps": "count",
        },
    ),
    "RigidBodyPlant.step": Case(PLANT.step, {"torque": PI}, {"torque": "vector"}),
    "ClosedLoop": Case(
        ClosedLoop,
        {"plant": PLANT, "controller": CONTROLLER, "governor": GOVERNOR},
        {"plant": "object", "controller": "object", "governor": "object"},
    ),
    "SolverController": Case(SolverController, {"solver": SOLVER}, {"solver": "object"}),
    "FeedbackController": Case(
        FeedbackController,
        {"feedback": FEEDBACK, "period": 0.5},
        {"feedback": "object", "period": "positive"},
    ),
    "RigidBodyFlight.load": Case(RigidBodyFlight.load, {"path": None}, {"path": "path"}),
    "scenario.load": Case(
        scenario.load, {"path": CASE1, "overrides": ()}, {"path": "path", "overrides": "overrides"}
    ),
    "scenario.read_sections": Case(scenario.read_sections, {"path": CASE1}, {"path": "path"}),
    "scenario.from_sections": Case(
        scenario.from_sections, {"sections": {}}, {"sections": "sections"}
    ),
    "scenario.revise": Case(
        scenario.revise,
        {"scenario": SCENARIO, "overrides": ()},
        {"scenario": "object", "overrides": "overrides"},
    ),
}  # fmt: skip
PAIRS = [(name, argument) for name, case in CASES.items() for argument in case.kinds]
OTHER_NAMES = {("FeedbackPredictor", "level"): "lyapunov_level"}


def refusal(call: Callable[[], Any]) -> str | None:
    """Return what a `GncError` says; None if the call goes well."""
    try:
        call()
    except GncError as error:
        return str(error)
    return None


@pytest.mark.parametrize(("name", "argument"), PAIRS)
def test_what_is_no_such_argument_is_refused_by_its_name(name: str, argument: str) -> None:
    case = CASES[name]
    kind = case.kinds[argument]
    for value in BAD[kind.rstrip("?")]():
        if value is None and kind.endswith("?"):
            continue
        text = refusal(lambda value=value: case.call(**{**case.good, argument: value}))
        assert text is not None, f"{name}: {argument}={shown(value)} was taken"
        assert "\n" not in text, text
        known = OTHER_NAMES.get((name, argument), argument)
        of_sections = argument == "sections" and text.startswith("plant: ")
        assert of_sections or known in text.partition(": received")[0], text
        assert "required" in text


SAME: dict[str, Callable[[Any], list[Any]]] = {
    "positive": lambda x: [np.float64(x), np.array(x), Fraction(x)],
    "scalar": lambda x: [np.float64(x), np.array(x)],
    "count": lambda n: [np.int64(n), np.int32(n), np.uint8(n), np.array(n)],
    "array": lambda a: [a.tolist(), a.copy(order="F"), np.asarray(a, dtype=">f8"),
                        np.repeat(a, 2, axis=0)[::2]],
}  # fmt: skip
SAME["limit"] = SAME["share"] = SAME["positive"]
SAME["size"] = SAME["count"]
ARRAYS = ("axis", "vector", "finite", "quaternion", "square", "matrix", "rotation", "stack", "rows",
          "multipliers")  # fmt: skip


@pytest.mark.parametrize(("name", "argument"), PAIRS)
def test_what_is_the_same_number_is_taken(name: str, argument: str) -> None:
    case = CASES[name]
    kind, value = case.kinds[argument].rstrip("?"), case.good[argument]
    if kind in ARRAYS and isinstance(value, np.ndarray):
        kind = "array"
    elif kind in ARRAYS and isinstance(value, float):
        kind = "scalar"
    for same in SAME.get(kind, lambda _: [])(value):
        case.call(**{**case.good, argument: same})


def test_single_precision_is_a_number() -> None:
    ocp = AttitudeOcp(INERTIA.astype(np.float32), np.float32(0.4), np.int16(4))
    assert ocp.time_step == pytest.approx(0.4, rel=1e-7)
    assert type(ocp.time_step) is float
    assert type(ocp.horizon) is int
    single = ShootingSolver(OCP).solve(np.eye(3, dtype=np.float32), PI.astype(np.float32))
    double = ShootingSolver(OCP).solve(np.eye(3), PI)
    assert np.allclose(single.torques, double.torques, rtol=1e-6, atol=0.0)


def test_a_matrix_that_is_none_is_no_rotation() -> None:
    for value in BAD["rotation"]():
        assert not lie.is_rotation(value)


def test_what_is_not_known_stays_unknown() -> None:
    unknown = np.full((3, 3), math.nan)
    assert math.isnan(lie.angle_between(unknown, R))
    assert np.isnan(lie.angles_between(np.stack([unknown, R]), R)).tolist() == [True, False]
    assert np.isnan(lie.to_quaternion_xyzw(unknown)).all()
    with pytest.raises(GncError, match="rotation: received"):
        lie.log(unknown)
