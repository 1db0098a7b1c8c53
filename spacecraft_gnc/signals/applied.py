"""Signals that hold the control which acted over a step, beside its command."""

from __future__ import annotations

from typing import NamedTuple

from spacecraft_gnc.signals.signal import Signal


class Applied(NamedTuple):
    """Where a vehicle's messages hold the control that acted, and the command of the same step.

    The plant tells of a step in the message of the next one.
    """

    told: Signal
    control: str
    source: str
    """Fields of ``told``."""
    command: Signal
    commanded: str
    """Its field; its source is in the field ``source``."""
