"""Fingerprint of a scenario, and the values in which two scenarios differ.

It is made of every value that decides the flight, defaults included, so that a file, the same file
with its defaults written out and what a bag holds of either have one fingerprint. Defaults that
change nothing (`ParameterSpec.is_neutral`) are left out, and so is where files are.
"""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from spacecraft_gnc.parameters.parameter import Kind, ParameterSpec, Value, typed
from spacecraft_gnc.parameters.yaml_scalar import emit

if TYPE_CHECKING:
    from spacecraft_gnc.scenario.scenario import Scenario

FLOWN: Final = ("plant", "nmpc_controller", "reference_governor")
"""Sections that decide what is flown; the others say what is started and recorded."""
_SET_BY_LAUNCHER: Final = ("autostart", "peers")
_DIGITS: Final = 12
_NOTHING: Final = "-"


class ValueDifference(NamedTuple):
    """A value that two scenarios do not share."""

    name: str
    """``section.parameter``"""
    first: str
    second: str
    """As YAML; ``-`` where a scenario has no such parameter."""

    def __str__(self) -> str:
        """Return the difference in one line."""
        return f"{self.name}: {self.first} / {self.second}"


def flown_values(scenario: Scenario) -> dict[str, str]:
    """Return every value that decides the flight, as YAML, by ``section.parameter``, sorted.

    Those that formulas give for what was not given are among them.
    """
    schema = scenario.schema
    described = (
        (f"{section}.{name}", value, schema.spec_of(section, name, value))
        for section in sorted(FLOWN)
        for name, value in sorted(scenario.values.get(section, {}).items())
        if name not in _SET_BY_LAUNCHER
    )
    return {
        name: _emitted(scenario, spec, value)
        for name, value, spec in described
        if not _says_nothing(spec, value)
    }


def _says_nothing(spec: ParameterSpec | None, value: Value) -> bool:
    """Tell whether a value is a path, or a default that was the flight's before it existed."""
    if spec is None:
        return False
    return spec.is_file or (spec.is_neutral and value == spec.default)


def _emitted(scenario: Scenario, spec: ParameterSpec | None, value: Value) -> str:
    """Return a value as YAML, in one form: that of a parameter left open, s for the matrix s I."""
    if spec is not None and spec.otherwise and value == spec.default:
        other, _, key = spec.otherwise.partition(".")
        value = scenario.values[other][key]
    if spec is not None and spec.kind is Kind.DYNAMIC and isinstance(value, list):
        matrix = typed(spec, value)
        isotropic = np.array_equal(matrix, matrix[0, 0] * np.eye(len(matrix)))
        return emit((matrix[0, 0] if isotropic else matrix.ravel()).tolist())
    return emit(value)


def fingerprint(scenario: Scenario) -> str:
    """Return the first 12 hexadecimal digits of the SHA-256 of `flown_values`, a line each."""
    text = "".join(f"{name}: {value}\n" for name, value in flown_values(scenario).items())
    return hashlib.sha256(text.encode()).hexdigest()[:_DIGITS]


def differences(first: Scenario, second: Scenario) -> tuple[ValueDifference, ...]:
    """Return the values that decide the flight and differ, in the order of their names."""
    ours, theirs = flown_values(first), flown_values(second)
    return tuple(
        ValueDifference(name, ours.get(name, _NOTHING), theirs.get(name, _NOTHING))
        for name in sorted(ours.keys() | theirs.keys())
        if ours.get(name) != theirs.get(name)
    )
