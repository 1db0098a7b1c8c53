"""Expressions of a criterion: syntax tree of Python's grammar to a function of the metrics."""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from numbers import Real
from typing import Any, Final, TypeAlias

from spacecraft_gnc.campaign.signs import Directions, flipped, merged, scaled
from spacecraft_gnc.parameters.problems import shown
from spacecraft_gnc.parameters.values import Refusal

Result: TypeAlias = bool | float | None
"""True or false, a number, or unknown."""
LONGEST: Final = 4000
"""Characters of an expression."""
_DEEPEST: Final = 100  # levels of a tree
_REQUIREMENT: Final = (
    "comparisons of metrics and numbers, joined by and, or, not, such as 'final_error_deg < 0.1'"
)
_WORDS: Final = {"true": True, "false": False}
_ARITHMETIC: Final[Mapping[type[ast.operator], Callable[[float, float], float]]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}
_COMPARISONS: Final[Mapping[type[ast.cmpop], Callable[[Any, Any], bool]]] = {
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
}
_EQUALITIES: Final = (ast.Eq, ast.NotEq)
_LESS: Final = (ast.Lt, ast.LtE)


@dataclass(frozen=True, slots=True)
class Expression:
    """A part of a criterion."""

    value: Callable[[Mapping[str, Any]], Result]
    directions: Directions
    is_number: bool
    is_truth: bool
    """Both for a metric, of which only a flight tells what it is: it has to be compared."""
    constant: float | None = None
    """Value of a number in which no metric stands."""


def read_expression(text: str) -> Expression:
    """Return the meaning of a criterion.

    Raises
    ------
    Refusal
        If it is not what `Criterion.parse` takes.
    """
    if len(text) > LONGEST:
        received = f"{len(text)} characters"
        raise Refusal(received, f"at most {LONGEST}", "simplify the expression")
    if "#" in text:  # Python would skip the rest, which may stand on another line
        raise Refusal(shown(text), _REQUIREMENT, "remove the '#'")
    try:
        tree = ast.parse(" ".join(text.split()), mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise Refusal(shown(text), _REQUIREMENT, "mend the expression") from None
    expression = _read(tree.body, 1)
    if expression.is_number:
        remedy = "compare it, such as '... < 0.1' or '... == true'"
        raise Refusal(f"{shown(text)}, without a comparison", _REQUIREMENT, remedy)
    if not expression.directions:
        raise Refusal(f"{shown(text)}, no metric in it", _REQUIREMENT, "name a metric")
    return expression


def _read(node: ast.expr, depth: int) -> Expression:
    if depth > _DEEPEST:
        received = f"more than {_DEEPEST} levels of parentheses and signs"
        raise Refusal(received, _REQUIREMENT, "simplify the expression")
    reader = _READERS.get(type(node))
    if reader is None:
        raise _refusal(node, _REMEDIES.get(type(node), "remove it"))
    return reader(node, depth + 1)


def _refusal(node: ast.AST, remedy: str) -> Refusal:
    return Refusal(shown(_source(node)), _REQUIREMENT, remedy)


def _source(node: ast.AST) -> str:
    try:
        return " ".join(ast.unparse(node).split())
    except (RecursionError, ValueError):
        return "..."


# Leaves.


def _read_name(node: ast.Name, _depth: int) -> Expression:
    if node.id in _WORDS:
        truth = _WORDS[node.id]
        return Expression(lambda _: truth, {}, is_number=False, is_truth=True)
    return _metric(node.id)


def _read_constant(node: ast.Constant, _depth: int) -> Expression:
    value = node.value
    if isinstance(value, str) and value.strip():
        return _metric(value)
    if isinstance(value, bool) or not isinstance(value, int | float):
        remedy = f"write {str(value).lower()}" if isinstance(value, bool) else "write a number"
        raise _refusal(node, remedy)
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise _refusal(node, "write a number that double precision holds")
    return _number(number)


def _number(number: float) -> Expression:
    return Expression(lambda _: number, {}, is_number=True, is_truth=False, constant=number)


def _metric(name: str) -> Expression:
    return Expression(lambda row: _known(row.get(name)), {name: -1}, is_number=True, is_truth=True)


def _known(value: Any) -> Result:
    """Return a metric as a truth value or a number; None where it has no value."""
    if hasattr(value, "item") and getattr(value, "ndim", None) == 0:
        value = value.item()
    if isinstance(value, bool):
        return value
    if not isinstance(value, Real) or math.isnan(value):
        return None
    return float(value)


# Numbers.


def _read_sign(node: ast.UnaryOp, depth: int) -> Expression:
    if isinstance(node.op, ast.Not):
        inner = _truth(node.operand, depth)
        return Expression(
            lambda row: _negation(inner.value(row)), flipped(inner.directions), False, True
        )
    if not isinstance(node.op, ast.USub | ast.UAdd):
        raise _refusal(node, "remove it")
    inner = _numeric(node.operand, depth)
    if isinstance(node.op, ast.UAdd):
        return Expression(inner.value, inner.directions, True, False, inner.constant)
    return _combined(operator.sub, _number(0.0), inner, flipped(inner.directions))


def _read_arithmetic(node: ast.BinOp, depth: int) -> Expression:
    combine = _ARITHMETIC.get(type(node.op))
    if combine is None:
        raise _refusal(node, "use + - * / only")
    left, right = _numeric(node.left, depth), _numeric(node.right, depth)
    if isinstance(node.op, ast.Add):
        directions = merged(left.directions, right.directions)
    elif isinstance(node.op, ast.Sub):
        directions = merged(left.directions, flipped(right.directions))
    elif isinstance(node.op, ast.Mult):
        directions = merged(
            scaled(left.directions, right.constant), scaled(right.directions, left.constant)
        )
    else:
        unsure = dict.fromkeys(right.directions, 0)
        directions = merged(scaled(left.directions, right.constant), unsure)
    return _combined(combine, left, right, directions)


def _combined(
    combine: Callable[[float, float], float],
    left: Expression,
    right: Expression,
    directions: Directions,
) -> Expression:
    def value(row: Mapping[str, Any]) -> Result:
        first, second = left.value(row), right.value(row)
        if type(first) is not float or type(second) is not float:
            return None
        try:
            return combine(first, second)
        except ZeroDivisionError:
            return None

    constant = value({}) if not (left.directions or right.directions) else None
    known = constant if type(constant) is float else None
    return Expression(value, directions, is_number=True, is_truth=False, constant=known)


def _numeric(node: ast.expr, depth: int) -> Expression:
    expression = _read(node, depth)
    if not expression.is_number:
        raise _refusal(node, "write a number or a metric there")
    return expression


# Truth values.


def _truth(node: ast.expr, depth: int) -> Expression:
    expression = _read(node, depth)
    if expression.is_number:
        raise _refusal(node, "compare it, such as '... < 0.1' or '... == true'")
    return expression


def _read_logic(node: ast.BoolOp, depth: int) -> Expression:
    parts = [_truth(part, depth) for part in node.values]
    decisive = isinstance(node.op, ast.Or)

    def value(row: Mapping[str, Any]) -> Result:
        return _joined([part.value(row) for part in parts], decisive)

    return Expression(value, merged(*(part.directions for part in parts)), False, True)


def _joined(results: list[Result], decisive: bool) -> bool | None:
    """Return Kleene's ``or`` (``decisive`` true) or ``and`` (false); a number is unknown."""
    if any(result is decisive for result in results):
        return decisive
    return (not decisive) if all(type(result) is bool for result in results) else None


def _negation(result: Result) -> bool | None:
    return not result if type(result) is bool else None


def _read_comparison(node: ast.Compare, depth: int) -> Expression:
    operands = [_read(operand, depth) for operand in (node.left, *node.comparators)]
    pairs = list(zip(operands, node.ops, operands[1:], strict=False))
    for left, op, right in pairs:
        if type(op) not in _COMPARISONS:
            raise _refusal(node, "use < <= > >= == != only")
        has_truth = not (left.is_number and right.is_number)
        if has_truth and not (left.is_truth and right.is_truth and isinstance(op, _EQUALITIES)):
            raise _refusal(node, "compare numbers with numbers")

    def value(row: Mapping[str, Any]) -> Result:
        results = [operand.value(row) for operand in operands]
        triples = zip(results, node.ops, results[1:], strict=False)
        return _joined([_compared(*triple) for triple in triples], False)

    directions = merged(*(_of_comparison(*pair) for pair in pairs))
    return Expression(value, directions, is_number=False, is_truth=True)


def _compared(left: Result, op: ast.cmpop, right: Result) -> bool | None:
    is_equality = isinstance(op, _EQUALITIES)
    if type(left) is not type(right) or (type(left) is bool and not is_equality):
        return None
    if left is None or math.isnan(left) or math.isnan(right or 0.0):
        return None
    return _COMPARISONS[type(op)](left, right)


def _of_comparison(left: Expression, op: ast.cmpop, right: Expression) -> Directions:
    if isinstance(op, _EQUALITIES):
        return dict.fromkeys((*left.directions, *right.directions), 0)
    lesser, greater = (left, right) if isinstance(op, _LESS) else (right, left)
    return merged(flipped(lesser.directions), greater.directions)


_READERS: Final[Mapping[type[ast.expr], Callable[[Any, int], Expression]]] = {
    ast.Name: _read_name,
    ast.Constant: _read_constant,
    ast.UnaryOp: _read_sign,
    ast.BinOp: _read_arithmetic,
    ast.BoolOp: _read_logic,
    ast.Compare: _read_comparison,
}
_REMEDIES: Final[Mapping[type[ast.expr], str]] = {
    ast.Attribute: "write a metric with a dot in quotes",
    ast.Call: "use metrics and numbers only: there are no functions",
    ast.IfExp: "use and, or, not",
}
