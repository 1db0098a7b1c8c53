"""Distributions of a variations file by their names."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

import yaml

from spacecraft_gnc.campaign.distributions.components import (
    read_log_uniform,
    read_normal,
    read_uniform,
)
from spacecraft_gnc.campaign.distributions.directions import read_direction, read_rotation
from spacecraft_gnc.campaign.distributions.discrete import read_choice, read_constant
from spacecraft_gnc.campaign.distributions.distribution import Distribution, Target
from spacecraft_gnc.campaign.distributions.inertia import read_inertia
from spacecraft_gnc.campaign.distributions.options import Options
from spacecraft_gnc.parameters.parameter import Kind, ParameterSpec
from spacecraft_gnc.parameters.problems import Problem
from spacecraft_gnc.parameters.values import Refusal, admissible

_KEY: Final = "distribution"


def read_distribution(
    node: yaml.MappingNode, target: Target, file: str, problems: list[Problem]
) -> Distribution | None:
    """Return the distribution that stands at a node.

    Parameters
    ----------
    node
        Mapping of its options.
    target
        The parameter that it is for.
    file
        That it stands in.
    problems
        Takes each reason why it is refused, also that a value of it may lie outside the range of
        the parameter.

    Returns
    -------
    Distribution or None
        None where it is refused.
    """
    options = Options(node, file, target.name, problems)
    kind = options.value(_KEY, _KIND)
    if kind not in READERS:  # refused
        return None
    distribution = READERS[kind](options, target)
    options.check_rest(str(kind))
    if options.is_valid:
        _check_extremes(options, str(kind), distribution, target)
    return distribution if options.is_valid else None


def _check_extremes(
    options: Options, kind: str, distribution: Distribution, target: Target
) -> None:
    for value in distribution.extremes():
        try:
            admissible(target.spec, value, coerce=True)
        except Refusal as refusal:
            received = f"{refusal.received} as a value that {kind} may take"
            remedy = _REMEDIES.get(kind, "narrow it")
            options.complain("", received, refusal.requirement, remedy)
            return


def _read_direction(options: Options, target: Target) -> Distribution:
    return read_direction(options, target, read_distribution)


READERS: Final[Mapping[str, Callable[[Options, Target], Distribution]]] = {
    "constant": read_constant,
    "choice": read_choice,
    "uniform": read_uniform,
    "normal": read_normal,
    "log_uniform": read_log_uniform,
    "direction": _read_direction,
    "rotation": read_rotation,
    "inertia": read_inertia,
}
"""Name -> what reads its options."""
_KIND: Final = ParameterSpec(
    kind=Kind.STRING, default="", description="", required=True, choices=tuple(READERS)
)
_REMEDIES: Final = {"normal": "cut it off by from: and to:, or narrow it"}
