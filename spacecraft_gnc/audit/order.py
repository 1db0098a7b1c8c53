"""Check that each step was recorded once and carries its time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.audit.channels import is_expected
from spacecraft_gnc.audit.evidence import Evidence
from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.signals.signal import Signal
from spacecraft_gnc.types import Array

_EACH = "each step once"
_NS = 1_000_000_000


def audit_order(evidence: Evidence, ledger: Ledger, held: NDArray[np.int64], stopped: bool) -> None:
    """Check the steps and the time stamps of every topic that has a message a step.

    Steps ``held`` went on without a command; a flight that ``stopped`` may be shorter than planned.
    """
    for topic in evidence.topics.every_step:
        audit_each_step(evidence, ledger, topic, held)
    _whole_flight(evidence, ledger, stopped)
    for topic in evidence.topics.every_step:
        audit_stamps(evidence, ledger, topic)


def audit_stamps(evidence: Evidence, ledger: Ledger, topic: Signal) -> None:
    """Check that the messages of a topic carry the times of their steps."""
    columns = evidence.columns[topic]
    if columns.steps.size:
        expected = stamps_of(columns.steps, evidence.scenario.period)
        where = f"{topic}.header.stamp"
        ledger.compare("time stamps", columns.steps, {where: columns.stamps}, {where: expected})


def stamps_of(steps: NDArray[np.int64], period: float) -> Array:
    """Return the stamps (m,) [s] of steps, in whole nanoseconds as the nodes count them."""
    seconds, nanoseconds = np.divmod(steps * round(period * _NS), _NS)
    return np.asarray(seconds + 1e-9 * nanoseconds)


def audit_each_step(
    evidence: Evidence, ledger: Ledger, topic: Signal, held: NDArray[np.int64]
) -> None:
    """Check that a topic has a message of each step, but of those ``held``."""
    columns, name = evidence.columns[topic], f"steps of {topic}"
    last = evidence.n if topic in evidence.topics.leading else evidence.n - 1
    if not columns.steps.size and not is_expected(evidence, topic):
        ledger.skip(name, "the scenario has it not recorded")
        return
    required = np.arange(last + 1)
    there = np.isin(required, columns.steps, assume_unique=True)
    if topic not in evidence.topics.leading:
        unanswered = int((~there & np.isin(required, held)).sum())
        there |= np.isin(required, held)
        if unanswered:
            ledger.check(name, _EACH, f"{unanswered} steps without one, counted by the plant")
    ledger.require(name, _EACH, required, f"{topic} (missing)", there)
    for step in columns.conflicts:
        ledger.fail(name, _EACH, step, f"{topic} (two different messages)")
    if columns.repeats:
        ledger.check(name, _EACH, f"{columns.repeats} sent again with the same bytes")


def _whole_flight(evidence: Evidence, ledger: Ledger, stopped: bool) -> None:
    name, planned = "length of the flight", evidence.scenario.n_steps
    line = ledger.check(name, f"{planned} steps")
    saved = f"{evidence.n} of {planned} steps were saved"
    if evidence.recovered:
        ledger.skip(name, f"the bag was cut off and recovered: {saved}")
    elif stopped:
        ledger.skip(name, f"--unfinished: {saved}")
    elif evidence.n == planned:
        line.count("the last step", planned)
    else:
        ledger.fail(name, f"{planned} steps", min(evidence.n, planned), "the last step")
