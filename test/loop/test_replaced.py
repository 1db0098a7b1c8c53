"""Controllers and governors that are replaced in flight go on to the last bit."""

from __future__ import annotations

import itertools
import os
import random
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from spacecraft_gnc import lie
from spacecraft_gnc.loop.memory_file import Inputs, MemoryFile
from spacecraft_gnc.loop.past import Past
from spacecraft_gnc.scenario import Scenario, load

CONFIG = Path(__file__).resolve().parents[2] / "config"
NE = "nmpc_controller.method=neighboring_extremal"


class Case(NamedTuple):
    """A scenario, and how much of it is flown."""

    scenario: str
    overrides: tuple[str, ...] = ()
    n_steps: int = 120
    target: Any = None
    """Taken in the middle; its transpose after three quarters."""
    is_costly: bool = False
    """Whether its cores take so long to build that two of each, in turn, have to do."""


CASES = {
    "shooting": Case("gupta2015_case1"),
    "shooting, zones": Case("gupta2015_case2", n_steps=90),
    "shooting, chord": Case("gupta2015_case1", ("nmpc_controller.step_rule=chord",)),
    "shooting, estimated": Case("bagherzadeh2023_estimated_du"),
    "shooting, falls back": Case(
        "gupta2015_case2", ("nmpc_controller.max_iterations=4", "nmpc_controller.continuation=none")
    ),
    "chord, continuation": Case(
        "gupta2015_case2",
        ("nmpc_controller.step_rule=chord", "nmpc_controller.max_iterations=6"),
        60,
    ),
    "neighboring extremals": Case("gupta2015_case1", (NE,), 120),
    "neighboring extremals, zones": Case("gupta2015_case2", (NE,)),
    "neighboring extremals, moving": Case("turning_reference", (NE,)),
    "nominal run": Case("bagherzadeh2023_ne"),
    "nominal run, exact steps": Case("bagherzadeh2023_ne_exact10"),
    "slsqp": Case("gupta2015_case1", ("nmpc_controller.method=slsqp",), 12),
    "fsolve": Case("gupta2015_case1", ("nmpc_controller.method=fsolve",), 25),
    "terminal set": Case("kalabic2014_nmpc", n_steps=60),
    "terminal set, flip": Case("kalabic2014_flip_minus", n_steps=60),
    "feedback": Case("sun_moon_pd"),
    "planned": Case("phogat_figure4_disturbed", n_steps=250),
    "planned again": Case("phogat_replanned", n_steps=200),
    "planned governor": Case(
        "phogat_replanned",
        ("nmpc_controller.method=shooting", "reference_governor.governor=planned"),
        120,
        lie.exp(np.array([0.2, 0.3, -0.1])),
    ),
    "moving reference": Case("turning_reference", target=lie.exp(np.array([0.2, 0.3, -0.1]))),
    "stored trajectory": Case("stored_trajectory"),
    "governor": Case(
        "kalabic2014_governor", n_steps=200, target=lie.exp(np.array([0.5, 0.0, 0.0]))
    ),
    "governed shooting": Case("governed_nmpc", n_steps=30),
    "governed, way round": Case("sun_moon", n_steps=40),
    "wheels, feedback": Case("three_wheel_slew", n_steps=60),
    "wheels, shooting": Case("three_wheel_slew", ("nmpc_controller.method=shooting",), 60),
    "two wheels": Case("afrl_two_wheel", n_steps=60),
    "wheel lost": Case("afrl_wheel_loss", n_steps=60),
    "wheel lost, rest elsewhere": Case(
        "afrl_wheel_loss", ("plant.initial_total_momentum=[-0.02, 0.016, 0.012]",), 32
    ),
    "wheel of four lost": Case("afrl_wheel_loss_pyramid", n_steps=60),
    "docking": Case("afrl_docking_noise", n_steps=60, is_costly=True),
    "docking, not governed": Case("afrl_docking_ungoverned", n_steps=60, is_costly=True),
    "thruster lost": Case("afrl_docking_thruster_failed", n_steps=90, is_costly=True),
    "formation": Case("afrl_formation", n_steps=80, is_costly=True),
    "formation, deadlock": Case("afrl_formation_deadlock", n_steps=200, is_costly=True),
    "formation, loss": Case("afrl_formation_loss", n_steps=100, is_costly=True),
    "formation, not governed": Case("afrl_formation_ungoverned", n_steps=60),
}


class Told:
    """Values that inputs stand for, by their number: nodes have their messages."""

    def __init__(self) -> None:
        self.values: list[tuple[Any, ...]] = []

    def inputs(self, *values: Any) -> Inputs:
        self.values.append(values)
        return (len(self.values) - 1).to_bytes(8, "little"), b""

    def again(self, answer: Callable[..., Any]) -> Callable[[Inputs], Any]:
        return lambda inputs: answer(*self.values[int.from_bytes(inputs[0], "little")])


class Hosted:
    """A core as a node hosts it: with a past, which another process may take up."""

    def __init__(self, core: Any, descriptor: int, told: Told, answer: str) -> None:
        core.warm_up()
        core.reset()
        self.core = core
        self._told = told
        self._answer = getattr(core, answer)
        self.tales: list[str] = []
        self.past = Past(core, MemoryFile(descriptor), told.again(self._answer), self._tell)
        self.past.begin()

    def _tell(self, text: str, is_warning: bool) -> None:
        assert not is_warning, text
        self.tales.append(text)

    def take_target(self, target: Any) -> None:
        self.core.set_target(target)
        self.past.take_target(target)

    def answer(self, step: int, *values: Any) -> Any:
        return self.past.answer(step, self._told.inputs(*values), lambda: self._answer(*values))


@pytest.fixture
def descriptors() -> Iterator[tuple[int, int]]:
    files = os.memfd_create("controller"), os.memfd_create("governor")
    yield files
    for file in files:
        os.close(file)


def numbers(value: Any) -> bytes:
    """Return the bits of a reference, without wall times."""
    if isinstance(value, tuple):
        return b"".join(map(numbers, value))
    return np.asarray(value).tobytes()


def fly(
    scenario: Scenario,
    case: Case,
    hosts: Callable[[int, str], Any],
    *,
    twice: frozenset[int] = frozenset(),
) -> list[tuple[bytes, bytes]]:
    """Return control and reference of every step; steps in ``twice`` are answered twice."""
    plant = scenario.build_plant()
    plant.warm_up()
    plant.reset()
    state, flown = plant.state, []
    for k in range(case.n_steps):
        if case.target is not None and k == case.n_steps // 2:  # dies with it untold
            hosts(-1, "decide").take_target(case.target)
        governor = hosts(k, "decide")
        if case.target is not None and k == 3 * case.n_steps // 4:  # has not gone on yet
            governor.take_target(case.target.T)
        decision = governor.answer(k, state)
        command = hosts(k, "command").answer(k, state, decision.reference)
        if k in twice:  # the process ends between answer and message
            decision = hosts(k, "decide").answer(k, state)
            command = hosts(k, "command").answer(k, state, decision.reference)
        flown.append((numbers(command.control), numbers(tuple(decision.reference))))
        state = plant.step(command.control)
    return flown


SOME = ("shooting", "nominal run", "governor", "planned governor", "wheels, shooting", "formation")
"""Cases that CI flies."""


@pytest.mark.parametrize(
    "name",
    [name if name in SOME else pytest.param(name, marks=pytest.mark.long) for name in CASES],
)
def test_cores_that_are_replaced_fly_on_to_the_last_bit(
    name: str, descriptors: tuple[int, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    """At some steps the process ends after the answer, so that another one answers again."""
    monkeypatch.setattr("spacecraft_gnc.loop.past._EVERY", 4)
    case = CASES[name]
    scenario = load(CONFIG / f"{case.scenario}.yaml", case.overrides)
    files = dict(zip(("command", "decide"), descriptors, strict=True))
    build = {"command": scenario.build_controller, "decide": scenario.build_governor}
    if case.is_costly:
        two = {answer: itertools.cycle((make(), make())) for answer, make in build.items()}
        build = {answer: partial(next, cores) for answer, cores in two.items()}
    draw = random.Random(name)
    targets = {case.n_steps // 2, 3 * case.n_steps // 4}
    replaced = frozenset({*draw.sample(range(1, case.n_steps - 4), 2), *targets})

    def fly_with(deaths: frozenset[int]) -> tuple[list[tuple[bytes, bytes]], int]:
        for file in files.values():
            os.ftruncate(file, 0)
        told, hosted, dead = Told(), {}, itertools.count()

        def host(k: int, answer: str) -> Hosted:
            at = k in deaths
            if answer not in hosted or at:
                if at:
                    next(dead)
                hosted[answer] = Hosted(build[answer](), files[answer], told, answer)
            return hosted[answer]

        return fly(scenario, case, host, twice=deaths), next(dead)

    whole, _ = fly_with(frozenset())
    broken, deaths = fly_with(replaced)
    assert deaths >= 4 * len(replaced)
    for k, (ours, theirs) in enumerate(zip(broken, whole, strict=True)):
        assert ours == theirs, (name, k, sorted(replaced))


@pytest.mark.parametrize(
    "name",
    ["shooting", "neighboring extremals", "planned again", "governor", "wheel lost", "formation"],
)
def test_steps_that_nobody_answered_are_passed_over(
    name: str, descriptors: tuple[int, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    """As in free run, where the others do not wait for a restart."""
    monkeypatch.setattr("spacecraft_gnc.loop.past._EVERY", 4)
    case = CASES[name]
    scenario = load(CONFIG / f"{case.scenario}.yaml", case.overrides)
    told, plant = Told(), scenario.build_plant()
    plant.warm_up()
    plant.reset()
    state = plant.state
    builds = (scenario.build_controller, scenario.build_governor)

    def hosts() -> list[Hosted]:
        named = zip(builds, descriptors, ("command", "decide"), strict=True)
        return [Hosted(build(), file, told, answer) for build, file, answer in named]

    controller, governor = hosts()
    for k in range(30):
        if k == 18:
            controller, governor = hosts()
        if 14 <= k < 18:
            state = plant.step(plant.idle_control)
            continue
        reference = governor.answer(k, state).reference
        command = controller.answer(k, state, reference)
        assert np.isfinite(command.control).all()
        state = plant.step(command.control)
    assert controller.past.is_taken_up
    assert governor.past.is_taken_up


def test_without_its_past_a_core_flies_other_last_bits(descriptors: tuple[int, int]) -> None:
    """Of the test above: it can fail."""
    case = Case("gupta2015_case1", n_steps=40)
    scenario = load(CONFIG / f"{case.scenario}.yaml")
    build = {"command": scenario.build_controller, "decide": scenario.build_governor}

    def fly_with(death: int) -> list[tuple[bytes, bytes]]:
        told, hosted = Told(), {}

        def host(k: int, answer: str) -> Hosted:
            if answer not in hosted or k == death:
                os.ftruncate(descriptors[0], 0)
                hosted[answer] = Hosted(build[answer](), descriptors[0], told, answer)
            return hosted[answer]

        return fly(scenario, case, host)

    assert fly_with(-1) != fly_with(20)
