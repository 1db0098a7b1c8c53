"""What the commands share: options, JSON, tables."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar

import typer

from spacecraft_gnc.errors import GncError

ScenarioArgument = Annotated[
    Path,  # not checked by typer, so that every refusal of a file reads alike
    typer.Argument(
        metavar="SCENARIO.yaml", readable=False, help="Scenario: a ROS 2 parameter file."
    ),
]
SetOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="NODE.PARAMETER=VALUE",
        help="Replace a value of the scenario; VALUE is YAML. May be given several times.",
    ),
]
JsonOption = Annotated[
    bool, typer.Option("--json", help="Print one JSON object on stdout and nothing else.")
]
QuietOption = Annotated[bool, typer.Option("--quiet", "-q", help="Print errors only.")]


class RunFailed(GncError):
    """A run that was accepted did not end well."""

    exit_code: ClassVar[int] = 1


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


def print_error(error: Exception | str) -> None:
    """Print one ``error:`` line on stderr for each line of the message."""
    for line in str(error).splitlines():
        print(f"error: {line}", file=sys.stderr)
