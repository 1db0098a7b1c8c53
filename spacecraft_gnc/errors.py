"""Errors a user can cause.

Every message names the item, the value received, the requirement and the remedy. The command line
prints the message without a traceback and ends with ``exit_code``.
"""

from __future__ import annotations

from typing import ClassVar


class GncError(Exception):
    """Base of every error that a user can cause and correct."""

    exit_code: ClassVar[int] = 2
    """Process exit code: 2 the input was refused, 1 the run or the check failed."""


class ShapeError(GncError, ValueError):
    """An array does not have the required shape or type."""


class ParameterError(GncError, ValueError):
    """A value lies outside its admissible set."""


class ScenarioError(GncError):
    """A scenario file cannot be flown; the message has one line for each problem."""


class RecordingError(GncError):
    """A bag cannot be written or read."""


class LaunchError(GncError):
    """A graph could not be started, or ended abnormally."""

    exit_code: ClassVar[int] = 1
