"""Options, JSON output and tables shared by the commands."""

from __future__ import annotations

import json
import math
import os
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import typer

from spacecraft_gnc.errors import GncError, RecordingError

if TYPE_CHECKING:
    from spacecraft_gnc.analysis.run_info import RunInfo
    from spacecraft_gnc.scenario import Fleet, Scenario

ScenarioArgument = Annotated[
    Path,  # not checked by typer, so that every refusal of a file reads alike
    typer.Argument(
        metavar="SCENARIO.yaml",
        readable=False,
        help="Scenario: a ROS 2 parameter file, or the name of a shipped one (gupta2015_case1).",
    ),
]
SetOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="NODE.PARAMETER=VALUE",
        help="Replace a value of the scenario; VALUE is YAML. May be given several times. Of "
        "several agents, /sc1/NODE.PARAMETER means one, NODE.PARAMETER all.",
    ),
]
SpacecraftOption = Annotated[
    str | None,
    typer.Option(
        "--namespace",
        metavar="NAME",
        help="Of the spacecraft, where the file names several; a craft's means its flight.",
    ),
]
NamespaceOption = Annotated[
    str | None,
    typer.Option(
        "--namespace",
        metavar="NAME",
        help="Of the spacecraft, where the bag holds several; a craft's means its flight.",
    ),
]
JsonOption = Annotated[
    bool, typer.Option("--json", help="Print one JSON object on stdout and nothing else.")
]
UnfinishedOption = Annotated[
    bool, typer.Option("--unfinished", help="Read what was saved of a bag that was cut off.")
]
StrictOption = Annotated[
    bool,
    typer.Option(
        "--strict",
        help="End with 1 where a torque, momentum or zone limit was exceeded by more than 0.1 %.",
    ),
]
QuietOption = Annotated[bool, typer.Option("--quiet", "-q", help="Print errors only.")]


class RunFailed(GncError):
    """A run that was accepted did not end well."""

    exit_code: ClassVar[int] = 1


def require_within_limits(
    source: object, exceeded: Iterable[Mapping[str, Any]], strict: bool
) -> None:
    """Refuse, where that is asked for, a flight that exceeded a limit (`analysis.limits`).

    Raises
    ------
    RunFailed
        With every limit that was exceeded.
    """
    found = list(exceeded)
    if strict and found:
        raise RunFailed(f"{source}: {exceeded_text(found)}; --strict requires every limit kept")


def exceeded_text(exceeded: Iterable[Mapping[str, Any]]) -> str:
    """Return limits that were exceeded, and by what factor, in one line."""
    return f"limits exceeded: {'; '.join(each['text'] for each in exceeded)}"


def given_scenario(path: Path | None, namespace: str | None = None) -> Scenario | None:
    """Return the scenario of ``--scenario``, of one agent if it has several; None: not given."""
    if path is None:
        return None
    from spacecraft_gnc.scenario import load, load_fleet

    fleet = load_fleet(path)
    return fleet.leading if "" in fleet.agents else load(path, namespace=namespace)


def known_scenario(info: RunInfo, given: Scenario | None) -> Scenario | None:
    """Return the scenario that a run holds, else the one that was given."""
    tell_unused(info, given)
    return info.scenario or given


def tell_unused(info: RunInfo, given: Scenario | None) -> None:
    """Tell of a scenario that was given though the run holds what flew."""
    if given is not None and info.scenario is not None:
        print(f"note: {info.path}: holds what flew; --scenario is not used", file=sys.stderr)


def require_folder(out: Path | None) -> None:
    """Refuse a folder that could not be made or written in, before anything is computed.

    Raises
    ------
    RecordingError
        If it, or what it would be made in, is a file or not writable.
    """
    if out is None:
        return
    there = next(path for path in (out.absolute(), *out.absolute().parents) if path.exists())
    if not there.is_dir():
        problem = "a file" if there == out.absolute() else f"in {there}, which is a file"
    elif not os.access(there, os.W_OK | os.X_OK):
        problem = "which may not be written"
    else:
        return
    raise RecordingError(
        f"--out: received {str(out)!r}, {problem}; required a folder that can be written; choose "
        "another one"
    )


def require_writable(out: Path, suffix: str, option: str = "--out") -> None:
    """Refuse an output file that could not be written, before anything is computed.

    Raises
    ------
    RecordingError
        If the name does not end in ``suffix``, or its folder is missing or not writable.
    """
    folder = out.parent
    if out.suffix != suffix:
        name = Path(out.name or "flight").with_suffix(suffix)
        problem, remedy = f"no {suffix} file", f"name it {name}"
    elif out.is_dir():
        problem, remedy = "a directory", "name a file in it"
    elif not folder.is_dir():
        problem, remedy = "in a folder that does not exist", f"create it: mkdir -p {folder}"
    elif not os.access(folder, os.W_OK | os.X_OK):
        problem, remedy = "in a folder that is not writable", "choose another folder"
    else:
        return
    raise RecordingError(
        f"{option}: received {str(out)!r}, {problem}; required a {suffix} file in a writable "
        f"folder; {remedy}"
    )


def print_json(values: Mapping[str, Any]) -> None:
    """Print one JSON object; NaN and infinity, which JSON lacks, become null."""
    sys.stdout.write(json.dumps(json_able(values), indent=2, allow_nan=False) + "\n")


def json_able(value: Any) -> Any:
    """Return ``value`` with arrays as lists, NumPy scalars as Python's, non-finite ones as None."""
    if hasattr(value, "tolist"):  # NumPy arrays and scalars, without importing NumPy
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(key): json_able(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [json_able(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return str(value) if isinstance(value, Path) else value


def print_table(rows: Iterable[tuple[str, str]]) -> None:
    """Print labels and texts in two aligned columns."""
    table = list(rows)
    width = max((len(label) for label, _ in table), default=0)
    for label, text in table:
        print(f"  {label:<{width}}  {text}")


def tell_warnings(scenario: Scenario | Fleet, further: Iterable[str] = ()) -> None:
    """Print on stderr what to know before a scenario flies."""
    for text in (*scenario.warnings, *further):
        print(f"warning: {text}", file=sys.stderr)


def print_error(error: Exception | str) -> None:
    """Print one ``error:`` line on stderr for each line of the message."""
    for line in str(error).splitlines():
        print(f"error: {line}", file=sys.stderr)
