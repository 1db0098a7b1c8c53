"""A variations file, read and checked against the scenario that it varies."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final

import yaml

from spacecraft_gnc.campaign.criterion import KEY, Criterion
from spacecraft_gnc.campaign.distributions.distribution import Distribution
from spacecraft_gnc.campaign.distributions.options import Options
from spacecraft_gnc.campaign.distributions.read import read_distribution
from spacecraft_gnc.campaign.sampling import GRID, MOST_RUNS, RANDOM, SAMPLINGS
from spacecraft_gnc.campaign.targets import target_of
from spacecraft_gnc.parameters.parameter import Kind, ParameterSpec
from spacecraft_gnc.parameters.problems import InvalidScenario, Problem
from spacecraft_gnc.parameters.yaml_node import compose_text, items, raw, text_of
from spacecraft_gnc.scenario import Scenario
from spacecraft_gnc.scenario.shipped import shipped_file

_A_FILE: Final = "a readable variations file"
_VARY: Final = "vary"
_EXAMPLE: Final = "{distribution: uniform, from: 0.0, to: 1.0}"
_SAMPLING: Final = ParameterSpec(
    kind=Kind.STRING, default=RANDOM, description="", choices=SAMPLINGS
)
_RUNS: Final = ParameterSpec(
    kind=Kind.INTEGER, default=0, description="", minimum=1, maximum=MOST_RUNS
)
_WORST: Final = ParameterSpec(kind=Kind.INTEGER, default=3, description="", minimum=0, maximum=1000)


def read_variations(path: str, scenario: Scenario, text: str | None) -> dict[str, Any]:
    """Return the fields of `Variations`.

    Raises
    ------
    InvalidScenario
        As `load_variations`.
    """
    file = _found(path) if text is None else path
    text, root = _composed(Path(file), text)
    problems: list[Problem] = []
    options = Options(root, file, "", problems)
    sampling = options.value("sampling", _SAMPLING)
    runs = options.value("runs", _RUNS) or None
    worst = options.value("worst", _WORST)
    varied = _varied(options, scenario)
    criterion = _criterion(options)
    if sampling == GRID:
        _check_grid(options, varied, runs)
    options.check_rest("")
    if problems:
        raise InvalidScenario(sorted(problems, key=lambda problem: problem.line or 0))
    return {
        "path": file,
        "text": text,
        "sampling": sampling,
        "runs": runs,
        "worst": worst,
        "criterion": criterion,
        "names": tuple(varied),
        "distributions": tuple(varied.values()),
    }


def _found(path: str) -> str:
    """Return the file meant by a path, or by the name of one of ``config/campaigns``."""
    if Path(path).is_file() or len(Path(path).parts) != 1:
        return path
    shipped = shipped_file(f"campaigns/{path.removesuffix('.yaml')}.yaml")
    return path if shipped is None else str(shipped)


def _composed(path: Path, text: str | None) -> tuple[str, yaml.MappingNode]:
    try:
        text = text_of(path) if text is None else text
        root = compose_text(text, path)
    except InvalidScenario as error:
        raise InvalidScenario(
            dataclasses.replace(problem, requirement=_A_FILE) for problem in error.problems
        ) from None
    if not isinstance(root, yaml.MappingNode):
        what = "an empty file" if root is None else raw(root)
        remedy = "copy an example from config/campaigns/"
        raise InvalidScenario([Problem(str(path), None, "", what, _A_FILE, remedy)])
    return text, root


def _varied(options: Options, scenario: Scenario) -> dict[str, Distribution | None]:
    """Return the distribution of each parameter; None where it is refused."""
    if not options.has(_VARY):
        return {}
    node = options.node(_VARY, "")
    if not isinstance(node, yaml.MappingNode):
        need = f"lines 'NODE.PARAMETER: {_EXAMPLE}'"
        options.complain(_VARY, "nothing" if node is None else raw(node), need, "indent them")
        return {}
    nodes = dict(items(node, options.file, _VARY, options.problems))
    return {name: _distribution(options, scenario, name, nodes) for name in nodes}


def _distribution(
    options: Options, scenario: Scenario, name: str, nodes: Mapping[str, yaml.Node]
) -> Distribution | None:
    node = nodes[name]
    place = options.file, node.start_mark.line + 1
    target = target_of(scenario, name, place, options.problems, nodes)
    if not isinstance(node, yaml.MappingNode):
        is_value = isinstance(node, yaml.ScalarNode) and node.value
        constant = f"{{distribution: constant, value: {node.value}}}"
        remedy = f"write {constant if is_value else _EXAMPLE}"
        options.problems.append(Problem(*place, name, raw(node), "a distribution", remedy))
        return None
    if target is None:
        return None
    return read_distribution(node, target, options.file, options.problems)


def _criterion(options: Options) -> Criterion | None:
    need = "what counts as success, such as 'final_error_deg < 0.1'"
    node = options.node(KEY, need)
    if node is None:
        return None
    if not isinstance(node, yaml.ScalarNode):
        options.complain(KEY, raw(node), need, "write one expression")
        return None
    try:
        return Criterion.parse(str(node.value), options.file, node.start_mark.line + 1)
    except InvalidScenario as error:
        options.problems.extend(error.problems)
        return None


def _check_grid(
    options: Options, varied: Mapping[str, Distribution | None], runs: int | None
) -> None:
    if not varied and options.is_valid:
        options.complain(_VARY, "an empty grid", "a parameter to vary", "add one")
    for name in _continua(varied):
        need = "choice or constant, of which a grid takes each value"
        remedy = "list values, or set another sampling"
        options.complain(_VARY, f"a continuum for {name}", need, remedy)
    if not options.is_valid:
        return
    cells = math.prod(distribution.size or 0 for distribution in varied.values() if distribution)
    if cells > MOST_RUNS:
        need = f"at most {MOST_RUNS:.0e} cells"
        options.complain(_VARY, f"a grid of {cells:.3g} cells", need, "list fewer values")
    elif runs is not None and runs > cells:
        options.complain("runs", str(runs), f"at most the {cells} cells of the grid", "remove it")


def _continua(varied: Mapping[str, Distribution | None]) -> Iterator[str]:
    for name, distribution in varied.items():
        if distribution is not None and distribution.size is None:
            yield name
