"""``gnc``: finds the command, runs it, and turns what a user can mend into ``error:`` lines.

A command is imported when it is called, so that ``gnc --help`` is quick and a command that needs
ROS or numba costs the others nothing.
"""

from __future__ import annotations

import importlib
import sys
from collections.abc import Sequence
from typing import Annotated, Any, Final, NamedTuple

import typer
from typer.core import TyperGroup

from spacecraft_gnc import __version__
from spacecraft_gnc.cli._common import print_error
from spacecraft_gnc.errors import GncError
from spacecraft_gnc.extras import explained_imports


class _Command(NamedTuple):
    """A function, or a `typer.Typer` of sub-commands, that is imported when it is called."""

    target: str
    """``module:attribute``"""
    summary: str
    """Line in the list of commands; here, so that ``gnc --help`` imports no command."""
    hidden: bool = False


_PACKAGE: Final = "spacecraft_gnc.cli"
COMMANDS: Final = {
    "launch": _Command(
        f"{_PACKAGE}.launch:launch", "Fly a scenario as a ROS 2 graph and record it."
    ),
    "simulate": _Command(f"{_PACKAGE}.simulate:simulate", "Fly a scenario without ROS."),
    "check": _Command(
        f"{_PACKAGE}.check:check", "Check a scenario file; list every problem at once."
    ),
    "report": _Command(
        f"{_PACKAGE}.report:report", "Write one HTML page about a flight, or several side by side."
    ),
    "export": _Command(f"{_PACKAGE}.export:export", "Write a bag as CSV, Parquet, NPZ or MAT."),
    "plot": _Command(f"{_PACKAGE}.plot:plot", "Draw the figures of a flight."),
    "replay": _Command(
        f"{_PACKAGE}.replay:replay",
        "Play a bag into a live graph, or solve its steps again with another controller.",
    ),
    "inspect": _Command(
        f"{_PACKAGE}.inspect:inspect", "Look into a running graph: topics, rates, parameters."
    ),
    "view": _Command(
        f"{_PACKAGE}.view:view", "Watch a flight in the browser: a running graph, or a bag."
    ),
    "audit": _Command(
        f"{_PACKAGE}.audit:audit", "Integrate a bag again and certify every command afresh."
    ),
    "slew": _Command(f"{_PACKAGE}.slew:slew", "Command a slew of a running graph and follow it."),
    "recover": _Command(
        f"{_PACKAGE}.recover:recover", "Rebuild a readable bag from one that was cut off."
    ),
    "bench": _Command(f"{_PACKAGE}.bench:bench", "Measure how fast this machine flies."),
    "reproduce": _Command(
        f"{_PACKAGE}.reproduce:reproduce", "Run a paper's cases; print ours beside the paper's."
    ),
    "warmup": _Command(
        f"{_PACKAGE}.warmup:warmup", "Compile every kernel into the cache.", hidden=True
    ),
}
_PLAIN: Final[dict[str, Any]] = {
    "add_completion": False,
    "rich_markup_mode": None,
    "pretty_exceptions_enable": False,
}


class _LazyGroup(TyperGroup):
    """A group that imports a command when it is asked for."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names in the order of the help text."""
        return list(COMMANDS)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return the command called ``cmd_name``, or None."""
        command = COMMANDS.get(cmd_name)
        return None if command is None else _load(cmd_name, command)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the list of commands."""
        with formatter.section("Commands"):
            formatter.write_dl([(n, c.summary) for n, c in COMMANDS.items() if not c.hidden])

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Name the nearest command where there is none of that name."""
        if args[0] not in COMMANDS:
            from difflib import get_close_matches

            visible = [name for name, command in COMMANDS.items() if not command.hidden]
            nearest = get_close_matches(args[0], visible, n=1)
            remedy = f"did you mean {nearest[0]!r}?" if nearest else f"use {', '.join(visible)}"
            ctx.fail(f"No such command {args[0]!r}; {remedy}")
        return super().resolve_command(ctx, args)


app = typer.Typer(cls=_LazyGroup, no_args_is_help=True, **_PLAIN)


def main(argv: Sequence[str] | None = None) -> None:
    """Run ``gnc`` with ``argv`` (default: the process's own) and exit.

    Raises
    ------
    SystemExit
        With 0 (done), 1 (the run or the check failed) or 2 (the input was refused).
    """
    try:
        with explained_imports():
            app(args=None if argv is None else list(argv), prog_name="gnc")
    except GncError as error:
        print_error(error)
        sys.exit(error.exit_code)


def _print_version(wanted: bool) -> None:
    if wanted:
        print(f"spacecraft_gnc {__version__}")
        raise typer.Exit


@app.callback()
def _gnc(
    _version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Print the version."
        ),
    ] = False,
) -> None:
    """Fly, check and look at spacecraft attitude control scenarios."""


def _load(name: str, command: _Command) -> Any:
    module, _, attribute = command.target.partition(":")
    target = getattr(importlib.import_module(module), attribute)
    if not isinstance(target, typer.Typer):
        function, target = target, typer.Typer(**_PLAIN)
        target.command(name, hidden=command.hidden)(function)
    found = typer.main.get_command(target)
    found.name = name
    return found


if __name__ == "__main__":
    main()
