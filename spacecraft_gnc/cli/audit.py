"""``gnc audit``: integrate a bag again, certify its plans, repeat its failures."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from spacecraft_gnc.cli._common import (
    JsonOption,
    NamespaceOption,
    QuietOption,
    RunFailed,
    StrictOption,
    exceeded_text,
    print_json,
    require_within_limits,
)
from spacecraft_gnc.cli._progress import show_progress
from spacecraft_gnc.errors import ParameterError

if TYPE_CHECKING:
    from spacecraft_gnc.analysis.audit import Audit
    from spacecraft_gnc.audit.ledger import Check
    from spacecraft_gnc.scenario import Scenario
    from spacecraft_gnc.scenario.fingerprint import ValueDifference

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
    scenario: Annotated[
        Path | None,
        typer.Option(
            "--scenario",
            metavar="FILE",
            readable=False,
            help="Hold the scenario in the bag against this one; 1 where a value differs that "
            "decides the flight.",
        ),
    ] = None,
    strict: StrictOption = False,
    namespace: NamespaceOption = None,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Integrate a flight again, certify its plans, repeat its failures; 1 where it differs."""
    if tolerance is not None and not 0.0 <= tolerance < math.inf:
        raise ParameterError(
            f"--tolerance: received {tolerance!r}; required a number >= 0; give for example 1e-12"
        )
    from spacecraft_gnc.analysis.audit import audit_bag
    from spacecraft_gnc.audit.limits import as_dicts
    from spacecraft_gnc.scenario.fingerprint import differences

    intended = None if scenario is None else _intended(scenario, namespace)
    with show_progress("auditing", silent=quiet) as update:
        found = audit_bag(
            bag,
            tolerance=tolerance,
            namespace=namespace,
            allow_unfinished=unfinished,
            progress=lambda what: partial(update, what=what),
        )
    differing = () if intended is None else differences(found.scenario, intended)
    exceeded = as_dicts(found.exceeded)
    if not quiet:
        for remark in found.remarks:
            print(f"note: {remark}", file=sys.stderr)
        if exceeded:
            print(f"warning: {bag}: {exceeded_text(exceeded)}", file=sys.stderr)
    if as_json:
        print_json(_as_dict(found, scenario, differing))
    elif not quiet:
        _print(found)
        _print_scenario(found, scenario, differing)
    _require_passed(bag, found)
    if differing:
        count = "1 value differs" if len(differing) == 1 else f"{len(differing)} values differ"
        raise RunFailed(
            f"{bag}: holds another scenario than {scenario}: {differing[0].name} is "
            f"{differing[0].first}; required {differing[0].second}; {count}"
        )
    require_within_limits(bag, exceeded, strict)


def _intended(path: Path, namespace: str | None) -> Scenario:
    """Return the scenario of a file, read as the nodes do: it may be one that was cut short."""
    from spacecraft_gnc.scenario import from_sections, read_sections
    from spacecraft_gnc.scenario.shipped import find

    file = find(path)
    return from_sections(read_sections(file, namespace), str(file))


def _require_passed(bag: Path, found: Audit) -> None:
    if found.first is None:
        return
    check, difference = found.first
    told = f"; {check.note}" if check.note else ""
    raise RunFailed(
        f"{bag}: the first difference is at step {difference.step}, {difference.field} "
        f"({check.name}{told}); required {check.tolerance}; {_count(found)} failed"
    )


def _as_dict(
    found: Audit, scenario: Path | None, differing: Sequence[ValueDifference]
) -> dict[str, Any]:
    """Return the audit with what the scenario in the bag was held against."""
    values = found.as_dict()
    if scenario is None:
        return values
    listed = [difference._asdict() for difference in differing]
    values["passed"] = found.passed and not differing
    return values | {"held_against": str(scenario), "scenario_differences": listed}


def _print_scenario(
    found: Audit, scenario: Path | None, differing: Sequence[ValueDifference]
) -> None:
    from spacecraft_gnc.scenario.fingerprint import fingerprint

    print(f"  {found.counts.text}")
    rests = f"  by the scenario in the bag, sha256 {fingerprint(found.scenario)}"
    if scenario is None:
        print(f"{rests}; hold it against yours with --scenario FILE")
        return
    print(f"{rests}, {'which differs from' if differing else 'equal to'} {scenario}")
    for name, recorded, given in differing:
        print(f"    {name}: {recorded} in the bag, {given} in the file")


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
    where = f"first at step {check.first.step}: {check.first.field}"
    return f"{where}: {check.note}" if check.note else where
