"""Formulas of defaults that follow from other values."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from spacecraft_gnc.parameters.parameter import Value


class Missing(Exception):
    """A value that a formula needs was refused."""


class Formula(NamedTuple):
    """The default of one parameter."""

    section: str
    name: str
    """Dotted name."""
    value: Callable[[], Value]
    """Raises `Missing` where a value that it needs was refused."""
