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
    """Integrate a flight again, certify its plans, repeat its failures; 1 where it differs.

    Of a bag of several spacecraft each one is audited, unless --namespace names one.
    """
    if tolerance is not None and not 0.0 <= tolerance < math.inf:
        raise ParameterError(
            f"--tolerance: received {tolerance!r}; required a number >= 0; give for example 1e-12"
        )
    from spacecraft_gnc.analysis.agents import agents
    from spacecraft_gnc.analysis.audit import audit_bag
    from spacecraft_gnc.analysis.plan_file import refuse_plan

    refuse_plan(bag)
    names = agents(bag, namespace, allow_unfinished=unfinished)
    intended = [None if scenario is None else _intended(scenario, name) for name in names]
    with show_progress("auditing", silent=quiet) as update:
        results = [
            _Result(
                name,
                audit_bag(
                    bag,
                    tolerance=tolerance,
                    namespace=name,
                    allow_unfinished=unfinished,
                    progress=lambda what: partial(update, what=what),
                ),
                wanted,
                scenario,
            )
            for name, wanted in zip(names, intended, strict=True)
        ]
    if not quiet:
        for result in results:
            result.warn(f"{bag}: {result.agent}" if len(results) > 1 else f"{bag}")
    if as_json:
        print_json(_as_dict(bag, results))
    elif not quiet:
        for result in results:
            if len(results) > 1:
                print(f"{result.agent}:")
            result.print()
    for result in results:
        result.require(f"{bag}: {result.agent}" if len(results) > 1 else f"{bag}", strict)


def _as_dict(bag: Path, results: list[_Result]) -> dict[str, Any]:
    """Return the audit of a spacecraft, or of several by their names."""
    if len(results) == 1:
        return results[0].as_dict()
    told = {str(result.agent): result.as_dict() for result in results}
    passed = all(values["passed"] for values in told.values())
    return {"bag": str(bag), "passed": passed, "agents": told}


class _Result:
    """The audit of one spacecraft, and what the scenario in the bag was held against."""

    def __init__(
        self, agent: str | None, found: Audit, intended: Scenario | None, file: Path | None
    ) -> None:
        from spacecraft_gnc.audit.limits import as_dicts
        from spacecraft_gnc.scenario.fingerprint import differences

        self.agent, self.found, self._file = agent, found, file
        self.differing = () if intended is None else differences(found.scenario, intended)
        self._exceeded = as_dicts(found.exceeded)

    def warn(self, where: str) -> None:
        """Print what to know beside the verdict."""
        for remark in self.found.remarks:
            print(f"note: {remark}", file=sys.stderr)
        if self._exceeded:
            print(f"warning: {where}: {exceeded_text(self._exceeded)}", file=sys.stderr)

    def print(self) -> None:
        """Print the table, and what it rests on."""
        _print(self.found)
        _print_scenario(self.found, self._file, self.differing)

    def as_dict(self) -> dict[str, Any]:
        """Return the audit with what the scenario in the bag was held against."""
        values = self.found.as_dict()
        if self._file is None:
            return values
        listed = [difference._asdict() for difference in self.differing]
        values["passed"] = self.found.passed and not self.differing
        return values | {"held_against": str(self._file), "scenario_differences": listed}

    def require(self, where: str, strict: bool) -> None:
        """End with 1 where the audit failed, or the scenario is another one."""
        _require_passed(where, self.found)
        if self.differing:
            n = len(self.differing)
            count = "1 value differs" if n == 1 else f"{n} values differ"
            first = self.differing[0]
            raise RunFailed(
                f"{where}: holds another scenario than {self._file}: {first.name} is "
                f"{first.first}; required {first.second}; {count}"
            )
        require_within_limits(where, self._exceeded, strict)


def _intended(path: Path, namespace: str | None) -> Scenario:
    """Return the scenario of a file, read as the nodes do: it may be one that was cut short."""
    from spacecraft_gnc.scenario import from_sections, read_sections
    from spacecraft_gnc.scenario.shipped import find

    file = find(path)
    return from_sections(read_sections(file, namespace), str(file))


def _require_passed(where: str, found: Audit) -> None:
    if found.first is None:
        return
    check, difference = found.first
    told = f"; {check.note}" if check.note else ""
    raise RunFailed(
        f"{where}: the first difference is at step {difference.step}, {difference.field} "
        f"({check.name}{told}); required {check.tolerance}; {_count(found)} failed"
    )


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
