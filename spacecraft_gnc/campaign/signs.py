"""Directions in which an expression changes with each metric."""

from __future__ import annotations

from typing import TypeAlias

Directions: TypeAlias = dict[str, int]
"""Metric -> 1 where a larger one makes the expression smaller (or false), -1 where it makes it
larger (or true), 0 where neither holds throughout."""


def merged(*parts: Directions) -> Directions:
    """Return the directions of what rises with each part."""
    merged: Directions = {}
    for part in parts:
        for name, sign in part.items():
            merged[name] = sign if merged.get(name, sign) == sign else 0
    return merged


def flipped(directions: Directions) -> Directions:
    """Return the directions of what falls where the expression rises."""
    return {name: -sign for name, sign in directions.items()}


def scaled(directions: Directions, factor: float | None) -> Directions:
    """Return the directions of a product with a constant; None: with no constant."""
    if factor is None or factor == 0.0:
        return dict.fromkeys(directions, 0)
    return dict(directions) if factor > 0.0 else flipped(directions)
