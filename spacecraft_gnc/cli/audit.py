"""``gnc audit``: integrate a bag again, and certify every command afresh."""

from __future__ import annotations

import math
import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from spacecraft_gnc.cli._common import (
    JsonOption,
    NamespaceOption,
    QuietOption,
    RunFailed,
    print_json,
)
from spacecraft_gnc.cli._progress import show_progress
from spacecraft_gnc.errors import ParameterError

if TYPE_CHECKING:
    from spacecraft_gnc.analysis.audit.ledger import Check
    from spacecraft_gnc.analysis.audit.run import Audit

_HEADINGS = ("check", "steps", "worst", "tolerance", "verdict")
_RIGHT = (1, 2)  # columns of numbers


def audit(
    bag: Annotated[Path, typer.Argument(metavar="BAG", help="Bag folder or .mcap file.")],
    tolerance: Annotated[
        float | None,
        typer.Option(
            "--tolerance",
            metavar="X",
            help="Let the motion differ by this share of each field's largest magnitude, as "
            "between machines with other libraries.  [default: not in a bit]",
        ),
    ] = None,
    unfinished: Annotated[
        bool,
        typer.Option(
            "--unfinished",
            help="Audit what was saved of a bag that was cut off or a flight that was stopped.",
        ),
    ] = False,
    namespace: NamespaceOption = None,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Integrate a recorded flight again and certify every command afresh; 1 where it differs."""
    if tolerance is not None and not 0.0 <= tolerance < math.inf:
        raise ParameterError(
            f"--tolerance: received {tolerance!r}; required a number >= 0; give for example 1e-12"
        )
    from spacecraft_gnc.analysis.audit.run import audit_bag

    with show_progress("auditing", silent=quiet) as update:
        found = audit_bag(
            bag,
            tolerance=tolerance,
            namespace=namespace,
            allow_unfinished=unfinished,
            progress=lambda what: partial(update, what=what),
        )
    if not quiet:
        for remark in found.remarks:
            print(f"note: {remark}", file=sys.stderr)
    if as_json:
        print_json(found.as_dict())
    elif not quiet:
        _print(found)
    if found.first is not None:
        check, difference = found.first
        raise RunFailed(
            f"{bag}: the first difference is at step {difference.step}, {difference.field} "
            f"({check.name}); required {check.tolerance}; {_count(found)} failed"
        )


def _count(found: Audit) -> str:
    failed = sum(check.first is not None for check in found.checks)
    return f"{failed} of {len(found.checks)} checks"


def _print(found: Audit) -> None:
    rows = [_HEADINGS, *(_row(check) for check in found.checks)]
    widths = [max(len(row[i]) for row in rows) for i in range(len(_HEADINGS))]
    for row, remark in zip(rows, ["", *map(_remark, found.checks)], strict=True):
        cells = [
            cell.rjust(width) if i in _RIGHT else cell.ljust(width)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        print(f"  {'  '.join([*cells, remark])}".rstrip())
    if found.passed:
        print(f"{found.path}: {found.steps} control steps, every check that applies passed")


def _row(check: Check) -> tuple[str, ...]:
    if not check.steps:
        return check.name, "-", "-", "-", check.verdict
    return check.name, str(check.steps), check.worst_text, check.tolerance, check.verdict


def _remark(check: Check) -> str:
    if check.first is None:
        return check.note
    return f"first at step {check.first.step}: {check.first.field}"
