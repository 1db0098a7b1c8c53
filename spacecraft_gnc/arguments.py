"""Checks of single arguments: numbers, counts, words, objects and paths.

Every error names the argument, the value, the requirement and the remedy. Arrays are checked
by `spacecraft_gnc.arrays` and `spacecraft_gnc.types`.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable
from numbers import Real
from typing import Any, TypeVar

import numpy as np

from spacecraft_gnc.errors import ParameterError

T = TypeVar("T")
_MOST = 2**31 - 1  # of a count that has no other bound
_LONGEST = 100  # letters of a value that a message shows


def shown(value: object) -> str:
    """Return ``value`` as one short line for a message."""
    text = " ".join(repr(value).split())
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."


def as_real(
    name: str, value: object, holds: Callable[[float], bool], need: str, remedy: str
) -> float:
    """Return a finite real number as a float; NumPy scalars and 0-d arrays are accepted.

    Raises
    ------
    ParameterError
        If it is not a number, such as a bool or a text, or does not satisfy ``holds``.
    """
    value = _unwrapped(value)
    number = math.nan
    if isinstance(value, Real) and not isinstance(value, bool):
        try:
            number = float(value)
        except OverflowError:  # a whole number or a fraction beyond every float
            number = math.inf
    if not (math.isfinite(number) and holds(number)):
        raise ParameterError(f"{name}: received {shown(value)}; required {need}; {remedy}")
    return number


def _unwrapped(value: object) -> object:
    """Return the number in a 0-d array; anything else unchanged."""
    return value[()] if isinstance(value, np.ndarray) and value.ndim == 0 else value


def require_positive(name: str, value: object) -> float:
    """Return ``value`` as a float; raise ParameterError if it is not positive and finite."""
    need = "a positive finite number"
    return as_real(name, value, lambda x: x > 0.0, need, "give for example 1.0")


def as_limit(name: str, value: object) -> float:
    """Return a limit as a float; raise ParameterError if it is not a number >= 0."""
    return as_real(name, value, lambda x: x >= 0.0, "a number >= 0", "give 0 for no limit")


def as_count(name: str, value: object, least: int = 1, remedy: str = "", most: int = _MOST) -> int:
    """Return an integer as an int; raise ParameterError if it is not one, or out of bounds."""
    value = _unwrapped(value)
    is_whole = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
    if is_whole and least <= value <= most:  # type: ignore[operator]
        return int(value)  # type: ignore[call-overload, no-any-return]
    bounds = f"at least {least}" if most == _MOST else f"{least} to {most}"
    raise ParameterError(
        f"{name}: received {shown(value)}; required a whole number, {bounds}; "
        f"{remedy or f'give {max(least, 1)}'}"
    )


def as_tuple(name: str, values: object, of: str) -> tuple[Any, ...]:
    """Return a sequence as a tuple; raise ParameterError if it is not one, or a text."""
    if isinstance(values, Iterable) and not isinstance(values, (str, bytes)):
        return tuple(values)
    raise ParameterError(
        f"{name}: received {shown(values)}; required a sequence of {of}; give () for none"
    )


def require_word(name: str, word: object, words: tuple[str, ...]) -> None:
    """Raise ParameterError if ``word`` is not one of ``words``."""
    if not (isinstance(word, str) and word in words):
        raise ParameterError(
            f"{name}: received {shown(word)}; required one of {', '.join(words)}; choose one"
        )


def require_kind(name: str, value: T, kind: type[Any]) -> T:
    """Return ``value``; raise ParameterError if it is not an instance of a class."""
    if isinstance(value, kind):
        return value
    raise ParameterError(
        f"{name}: received {shown(value)}; required an object of {kind.__name__}; construct one "
        f"of {kind.__module__}"
    )


def require_members(name: str, value: T, members: tuple[str, ...], kind: str) -> T:
    """Return ``value``; raise ParameterError if it lacks members of a protocol."""
    missing = [member for member in members if not hasattr(value, member)]
    if missing:
        raise ParameterError(
            f"{name}: received {shown(value)}, without {', '.join(missing)}; required a {kind}; "
            "construct one, or see spacecraft_gnc.loop.protocols"
        )
    return value


def require_path(name: str, value: object) -> str:
    """Return the text of a path; raise ParameterError if it is not a file path."""
    if isinstance(value, (str, os.PathLike)):
        text = os.fsdecode(value)
        if "\0" not in text:
            return text
    raise ParameterError(
        f"{name}: received {shown(value)}; required the path of a file; give a str or a Path"
    )
