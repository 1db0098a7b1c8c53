"""Verdict of the audit, as a report shows it."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from spacecraft_gnc.analysis.reader import is_npz
from spacecraft_gnc.errors import GncError
from spacecraft_gnc.scenario.fingerprint import fingerprint

if TYPE_CHECKING:
    from pathlib import Path

    from spacecraft_gnc.analysis.audit import Audit
    from spacecraft_gnc.audit.vehicle import Watch


class Verdict(NamedTuple):
    """Outcome of an audit."""

    passed: bool | None
    """None: not audited."""
    text: str
    checks: tuple[tuple[str, str, str, str, str], ...] = ()
    """Name, steps, largest deviation, tolerance, and verdict with its note, of each check."""


def audit_verdict(
    path: Path,
    *,
    namespace: str | None = None,
    allow_unfinished: bool = False,
    progress: Watch | None = None,
) -> Verdict:
    """Audit a recording.

    A file of ``gnc simulate`` holds neither plans nor commands to recompute, and is not audited;
    nor is a bag that the audit refuses, for instance because it holds no scenario.
    """
    if is_npz(path):
        return Verdict(None, "not audited: a .npz file holds no plans; record a bag")
    from spacecraft_gnc.analysis.audit import audit_bag  # loads the kernels

    try:
        audit = audit_bag(
            path, namespace=namespace, allow_unfinished=allow_unfinished, progress=progress
        )
    except GncError as error:
        return Verdict(None, f"not audited: {error}")
    return Verdict(audit.passed, _sentence(audit), tuple(_lines(audit)))


def _sentence(audit: Audit) -> str:
    if audit.first is None:
        made = sum(check.steps > 0 for check in audit.checks)
        return (
            f"{audit.steps} control steps: all {made} checks that apply passed; "
            f"{audit.counts.text}; by the scenario in the bag, sha256 {fingerprint(audit.scenario)}"
        )
    check, difference = audit.first
    failed = sum(check.first is not None for check in audit.checks)
    return (
        f"the first difference is at step {difference.step}, {difference.field} ({check.name}); "
        f"{failed} of {len(audit.checks)} checks failed"
    )


def _lines(audit: Audit) -> list[tuple[str, str, str, str, str]]:
    lines = []
    for check in audit.checks:
        where = "" if check.first is None else f"step {check.first.step}: {check.first.field}"
        remark = where or check.note
        verdict = f"{check.verdict}: {remark}" if remark else check.verdict
        lines.append(
            (check.name, str(check.steps or "-"), check.worst_text, check.tolerance, verdict)
        )
    return lines
