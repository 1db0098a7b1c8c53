"""Validation of one value against its `ParameterSpec`."""

from __future__ import annotations

import dataclasses
import math
import re
from typing import Any, Final, TypeAlias

import numpy as np

from spacecraft_gnc.errors import GncError
from spacecraft_gnc.parameters.parameter import Kind, MatrixRule, ParameterSpec, Value
from spacecraft_gnc.parameters.problems import shortened, shown, suggestion
from spacecraft_gnc.parameters.yaml_scalar import emit, parse_plain
from spacecraft_gnc.types import as_inertia, as_semidefinite, as_symmetric

_ELEMENT: Final = {
    Kind.BOOL_ARRAY: Kind.BOOL,
    Kind.INTEGER_ARRAY: Kind.INTEGER,
    Kind.DOUBLE_ARRAY: Kind.DOUBLE,
    Kind.STRING_ARRAY: Kind.STRING,
}
_TYPES: Final = {Kind.BOOL: bool, Kind.INTEGER: int, Kind.DOUBLE: float, Kind.STRING: str}
_MATRIX_CHECKS: Final = {
    MatrixRule.INERTIA: as_inertia,
    MatrixRule.SEMIDEFINITE: as_semidefinite,
    MatrixRule.DEFINITE: as_symmetric,  # and its eigenvalues in `_check_vector`
}
_TYPE_NAMES: Final = {bool: "a boolean", int: "an integer", float: "a number", str: "a string"}


_DIGITS: Final = re.compile(r"[-+]?[0-9][-+.0-9eE]*")
Written: TypeAlias = str | list[str] | None
"""A value, or each of a list, as it stands in a file; None where that is not known."""


class Refusal(ValueError):
    """A value that its spec does not admit."""

    def __init__(self, received: str, requirement: str, remedy: str) -> None:
        super().__init__(received, requirement, remedy)
        self.received = received
        self.requirement = requirement
        self.remedy = remedy


def plain(value: Any) -> Any:
    """Return tuples, NumPy arrays and ``array.array`` as lists, NumPy scalars as Python's."""
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    if isinstance(value, list | tuple) or hasattr(value, "tolist"):
        return [plain(item) for item in value]
    return value


def admissible(spec: ParameterSpec, value: Value, coerce: bool, written: Written = None) -> Value:
    """Return ``value`` in the ROS 2 type of ``spec``.

    Parameters
    ----------
    spec : ParameterSpec
        What is admitted.
    value : Value
        As read from YAML, or from ROS 2.
    coerce : bool
        Whether an integer may stand for a double.
    written : str or list of str, optional
        The value, or each of a list, as it stands in the file.

    Raises
    ------
    Refusal
        If the type, the size or the value is not admitted.
    """
    typed = _of_type(spec, value, coerce, written)
    items = typed if isinstance(typed, list) else [typed]
    _check_finite(spec, value, items)
    _check_size(spec, typed)
    _check_words(spec, items)
    if not isinstance(typed, list) or spec.matrix is MatrixRule.NONE:
        _check_range(spec, items)
    elif any(map(spec.is_too_high, map(abs, items))):  # its rule decides on signs and zeros
        _check_range(dataclasses.replace(spec, minimum=None, above=None), [*map(abs, items)])
    if isinstance(typed, list) and typed:
        _check_vector(spec, typed)
    return typed


def _of_type(spec: ParameterSpec, value: Value, coerce: bool, written: Written) -> Value:
    kind = spec.kind
    if isinstance(value, bool) and kind is Kind.STRING and emit(value) in spec.choices:
        value = emit(value)  # YAML and ROS 2 read the words true and false as booleans
    if kind is Kind.DYNAMIC:
        kind = Kind.DOUBLE_ARRAY if isinstance(value, list) else Kind.DOUBLE
    if kind in _ELEMENT:
        if not isinstance(value, list):
            remedy = f"write [{emit(value)}]" if spec.length == -1 else "write a list"
            raise Refusal(_received(value, written), spec.requirement, remedy)
        items = [_element(_ELEMENT[kind], item, coerce) for item in value]
    elif isinstance(value, list):
        raise Refusal(_received(value, written), spec.requirement, "write one value")
    else:
        items = [_element(kind, value, coerce)]
    if any(item is None for item in items):
        remedy = _type_remedy(spec, kind, value, written)
        raise Refusal(_received(value, written), spec.requirement, remedy)
    return items if kind in _ELEMENT else items[0]


def _element(kind: Kind, value: Any, coerce: bool) -> Any:
    """Return a scalar of the type of ``kind``; None where it is of another type."""
    if coerce and kind is Kind.DOUBLE and type(value) is int:
        return float(value)
    return value if type(value) is _TYPES[kind] else None


def _type_remedy(spec: ParameterSpec, kind: Kind, value: Value, written: Written) -> str:
    """Return what to write instead: the same value in the right type where there is one."""
    scalar = _ELEMENT.get(kind, kind)
    items = value if isinstance(value, list) else [value]
    texts = written if isinstance(written, list) else [written] * len(items)
    fixed = [_in_type(scalar, item, text) for item, text in zip(items, texts, strict=True)]
    if any(item is None for item in fixed):
        if any(isinstance(item, str) and _DIGITS.fullmatch(item) for item in items):
            return "write a number that double precision holds"
        return f"write {spec.type_text}, without quotes"
    if scalar in (Kind.INTEGER, Kind.DOUBLE) and any(
        spec.is_too_low(item) or spec.is_too_high(item) for item in fixed
    ):
        return f"write {spec.requirement}"
    return f"write {emit(fixed if isinstance(value, list) else fixed[0])}"


def _in_type(kind: Kind, value: Any, text: str | None) -> Any:
    """Return ``value``, written as ``text``, as a scalar of ``kind``; None: it reads as none."""
    if kind is Kind.STRING:
        return value if isinstance(value, str) else text or emit(value)
    number = parse_plain(value) if isinstance(value, str) else value
    if kind is Kind.DOUBLE and type(number) in (int, float):
        return float(number)
    if kind is Kind.INTEGER and type(number) in (int, float) and float(number).is_integer():
        return int(number)
    return number if kind is Kind.BOOL and type(number) is bool else None


def _check_finite(spec: ParameterSpec, value: Value, items: list[Any]) -> None:
    refused, word = (math.isnan, "NaN") if spec.infinite else (_is_infinite, "NaN and infinity")
    if any(isinstance(item, float) and refused(item) for item in items):
        need = "no NaN" if spec.infinite else "finite"
        raise Refusal(shown(value), f"{spec.requirement}, {need}", f"replace {word}")


def _is_infinite(number: float) -> bool:
    return not math.isfinite(number)


def _check_size(spec: ParameterSpec, value: Value) -> None:
    if not isinstance(value, list) or (spec.may_be_empty and not value):
        return
    if spec.length not in (-1, len(value)):
        raise Refusal(
            f"{len(value)} numbers: {shown(value)}",
            spec.requirement,
            f"write exactly {spec.length}",
        )
    if len(value) % spec.rows:
        raise Refusal(
            f"{len(value)} numbers: {shown(value)}",
            spec.requirement,
            f"write {spec.rows} rows of equal length, one after the other"
            if spec.shape[0] > 0
            else f"write {spec.rows} numbers for each row",
        )
    if not value:
        raise Refusal("[]", f"{spec.requirement}, at least one", "add one")


def _check_words(spec: ParameterSpec, items: list[Any]) -> None:
    if not spec.choices and not spec.unique:
        return
    for index, item in enumerate(items):
        word = item.rpartition("/")[2] if spec.paths else item
        if spec.choices and word not in spec.choices:
            requirement = f"one of {spec.listed_choices}"
            raise Refusal(shown(item), requirement, suggestion(item, spec.choices))
        if spec.unique and item in items[:index]:
            raise Refusal(shown(items), "each element once", f"remove the second {item!r}")


def _check_range(spec: ParameterSpec, items: list[Any]) -> None:
    lowest, highest = spec.lowest, spec.highest
    for item in items:
        too_low = lowest is not None and item < lowest
        if too_low or (highest is not None and item > highest):
            remedy = "raise it" if too_low else "lower it"
            raise Refusal(shown(item), spec.requirement, f"{remedy} ({spec.range_text})")


def _check_vector(spec: ParameterSpec, value: list[Any]) -> None:
    if spec.nonzero and math.sqrt(sum(item * item for item in value)) < 1e-12:
        raise Refusal(
            shown(value), "a direction of non-zero length", "give the axis, such as [1.0, 0.0, 0.0]"
        )
    if spec.matrix is MatrixRule.NONE:
        return
    check = _MATRIX_CHECKS[spec.matrix]
    try:
        with np.errstate(over="ignore"):  # numbers near 1e308 fail the check, not the arithmetic
            matrix = check("value", value)
    except GncError as error:
        raise _from_core(value, error) from None
    if spec.matrix is MatrixRule.DEFINITE:
        smallest = float(np.linalg.eigvalsh(matrix)[0])
        if smallest <= 0.0:
            received = f"{shown(value)} (smallest eigenvalue {smallest:.6g})"
            remedy = "make every eigenvalue positive"
            raise Refusal(received, spec.matrix.value, remedy)


def _from_core(value: Value, error: GncError) -> Refusal:
    """Translate ``name: received A; required B; C`` of the core's own checks."""
    received, _, rest = str(error).partition(": received ")[2].partition("; required ")
    requirement, _, remedy = rest.rpartition("; ")
    if not requirement:
        return Refusal(shown(value), str(error), "change it")
    return Refusal(f"{shown(value)} ({received})", requirement, remedy)


def _received(value: Value, written: Written) -> str:
    if isinstance(value, list):
        return shown(value)
    is_word = isinstance(value, str)
    text = shortened(written) if isinstance(written, str) and not is_word else shown(value)
    return f"{text} ({_TYPE_NAMES.get(type(value), 'no value')})"
