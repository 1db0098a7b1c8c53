"""Rules for the numbers in a field, and the checks of incoming messages that follow from them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, Final, NamedTuple

from spacecraft_gnc.types import ROTATION_TOLERANCE

Check = Callable[[str, Any], str | None]
"""Takes a field's name and its number or numbers; returns why they are refused, or None."""


class Rule(NamedTuple):
    """Which numbers a field may hold."""

    nan: bool = False
    """Whether NaN is allowed (not known, or nothing to tell)."""
    infinite: bool = False
    """Whether infinity is allowed (no limit)."""
    rotation: bool = False
    """Whether the 9 numbers are a rotation matrix, row-major."""
    most: int | None = None
    """Largest value of an enumeration that starts at 0."""
    when: tuple[str, int] | None = None
    """The rule holds only in messages whose field of this name has this value."""


FINITE: Final = Rule()
ANY: Final = Rule(nan=True, infinite=True)
INFINITE: Final = Rule(infinite=True)
ROTATION: Final = Rule(rotation=True)


def check_of(rule: Rule, is_float: bool) -> Check | None:
    """Return the check that a rule asks for; None where any number passes."""
    if rule.rotation:
        return reject_rotation
    if rule.most is not None:
        return _reject_above(rule.most)
    if not is_float or (rule.nan and rule.infinite):
        return None
    return reject_nan if rule.infinite else reject_infinite


def reject_rotation(name: str, r: Sequence[float]) -> str | None:
    """Return why the 9 numbers ``r`` (row-major) are no rotation; None if they are one."""
    a, b, c, d, e, f, g, h, i = r
    xx, yy, zz = a * a + d * d + g * g, b * b + e * e + h * h, c * c + f * f + i * i
    xy, xz, yz = a * b + d * e + g * h, a * c + d * f + g * i, b * c + e * f + h * i
    square = (xx - 1.0) ** 2 + (yy - 1.0) ** 2 + (zz - 1.0) ** 2
    square += 2.0 * (xy * xy + xz * xz + yz * yz)
    if not math.isfinite(square):
        return f"{name} holds NaN or infinity; required 9 finite numbers"
    if square > ROTATION_TOLERANCE**2:
        return (
            f"{name} has |R^T R - I| = {math.sqrt(square):.3g}; required a rotation "
            f"(at most {ROTATION_TOLERANCE:g})"
        )
    if a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) < 0.0:
        return f"{name} has determinant -1; required a rotation (determinant 1)"
    return None


def reject_infinite(name: str, x: float | Sequence[float]) -> str | None:
    """Return why a number or numbers are refused; None if all are finite."""
    if isinstance(x, float):
        return None if math.isfinite(x) else f"{name} is {x}; required a finite number"
    if all(map(math.isfinite, x)):
        return None
    return f"{name} holds NaN or infinity ({list(x)}); required {len(x)} finite numbers"


def reject_nan(name: str, x: float | Sequence[float]) -> str | None:
    """Return why a number or numbers are refused; None if none is NaN."""
    numbers = (x,) if isinstance(x, float) else x
    if not any(map(math.isnan, numbers)):
        return None
    return f"{name} holds NaN ({x}); required numbers"


def reject_step(step: int, last_step: int) -> str | None:
    """Return why ``step`` is refused after ``last_step``; None if it is not older."""
    if step < last_step:
        return f"step {step} is older than step {last_step}, seen before; required a newer one"
    return None


def _reject_above(most: int) -> Check:
    def reject(name: str, x: int) -> str | None:
        return None if 0 <= x <= most else f"{name} is {x}; required 0 to {most}"

    return reject
