"""What is let in: checks of numbers that come from outside, cheap enough for every message.

Each function returns the reason for a refusal, or None. They take plain floats, as messages are
unpacked, and touch no array.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from spacecraft_gnc.types import ROTATION_TOLERANCE


def reject_rotation(name: str, r: Sequence[float]) -> str | None:
    """Reason why the 9 numbers ``r`` (row-major) are no rotation; None if they are one."""
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


def reject_vector(name: str, x: Sequence[float]) -> str | None:
    """Reason why the 3 numbers ``x`` are refused; None if they are finite."""
    if math.isfinite(x[0]) and math.isfinite(x[1]) and math.isfinite(x[2]):
        return None
    return f"{name} holds NaN or infinity ({list(x)}); required 3 finite numbers"


def reject_step(step: int, last_step: int) -> str | None:
    """Reason why ``step`` is refused after ``last_step``; None if it is not older."""
    if step < last_step:
        return f"step {step} is older than step {last_step}, seen before; required a newer one"
    return None


def reject_state(
    step: int, attitude: Sequence[float], momentum: Sequence[float], last_step: int
) -> str | None:
    """Reason why a state (step, 9 numbers row-major, 3 numbers) is refused, or None."""
    return (
        reject_step(step, last_step)
        or reject_rotation("attitude", attitude)
        or reject_vector("angular_momentum", momentum)
    )


def reject_reference(step: int, attitude: Sequence[float], last_step: int) -> str | None:
    """Reason why a reference (step, 9 numbers row-major) is refused, or None."""
    return reject_step(step, last_step) or reject_rotation("attitude", attitude)
