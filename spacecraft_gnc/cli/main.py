"""``gnc``: finds the command, runs it, and turns what a user can mend into ``error:`` lines.

A command is imported when it is called, so that ``gnc --help`` is quick and a command that needs
ROS or numba costs the others nothing.
"""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Sequence
from typing import Annotated, Any, Final, NamedTuple

import typer

from spacecraft_gnc import SILENT_COMPILER, __version__
from spacecraft_gnc.cli._common import print_error
from spacecraft_gnc.cli._completion import told_completion
from spacecraft_gnc.cli._help import CONTEXT, App, Command, Group, UsageError
from spacecraft_gnc.cli._output import OutputFailed, PipeClosed, checked_streams
from spacecraft_gnc.errors import GncError
from spacecraft_gnc.extras import explained_imports


class _Command(NamedTuple):
    """A function, or a `typer.Typer` of sub-commands, that is imported when it is called."""

    target: str
    """``module:attribute``"""
    summary: str
    """Line in the list of commands; here, so that ``gnc --help`` imports no command."""


_PACKAGE: Final = "spacecraft_gnc.cli"
COMMANDS: Final = {
    "launch": _Command(
        f"{_PACKAGE}.launch:launch", "Fly a scenario as a ROS 2 graph and record it."
    ),
    "simulate": _Command(f"{_PACKAGE}.simulate:simulate", "Fly a scenario without ROS."),
    "check": _Command(
        f"{_PACKAGE}.check:check", "Check a scenario file; list every problem at once."
    ),
    "plan": _Command(
        f"{_PACKAGE}.plan:plan", "Plan the optimal transfer of a scenario, within its bounds."
    ),
    "campaign": _Command(
        f"{_PACKAGE}.campaign:campaign", "Fly a scenario many times, varied; count what succeeds."
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
        f"{_PACKAGE}.audit:audit", "Integrate a bag again, certify its plans, repeat its failures."
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
        f"{_PACKAGE}.warmup:warmup", "Compile every kernel ahead, so that no flight waits for it."
    ),
}


class _LazyGroup(Group):
    """A group that imports a command when it is called, or when its own words are completed."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse the words before the command."""
        with told_completion(list(args)):
            return list(super().parse_args(ctx, args))

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names in the order of the help text."""
        return list(COMMANDS)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return the command called ``cmd_name`` with its summary alone, or None."""
        command = COMMANDS.get(cmd_name)
        return None if command is None else Command(cmd_name, help=command.summary)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Import the command that is called; name the nearest where there is none of that name."""
        name = args[0]
        if name in COMMANDS:
            return name, _load(name, COMMANDS[name]), args[1:]
        if not ctx.resilient_parsing:
            from difflib import get_close_matches

            nearest = get_close_matches(name, COMMANDS, n=1)
            remedy = f"did you mean {nearest[0]!r}?" if nearest else f"use {', '.join(COMMANDS)}"
            ctx.fail(f"no such command {name!r}; {remedy}")
        return None, None, args[1:]


app = App(cls=_LazyGroup, no_args_is_help=True, add_completion=True, context_settings=CONTEXT)


def main(argv: Sequence[str] | None = None) -> None:
    """Run ``gnc`` with ``argv`` (default: the process's own) and exit.

    Raises
    ------
    SystemExit
        With 0 (done), 1 (the run or the check failed) or 2 (the input was refused); 130 after
        Ctrl-C and 141 where whoever read the output has gone, as a shell reports the signals.
    """
    try:
        with checked_streams():
            sys.exit(_run(argv))
    except OutputFailed as error:
        if not isinstance(error, PipeClosed):
            print_error(error)
        sys.exit(error.exit_code)


def _run(argv: Sequence[str] | None) -> int:
    """Run ``gnc``, print what the user can mend, and return the exit code."""
    arguments = sys.argv[1:] if argv is None else list(argv)
    if arguments[:1] == ["warmup"] or {"-q", "--quiet"} & set(arguments):
        os.environ[SILENT_COMPILER] = "1"  # for the nodes as well
    try:
        with explained_imports():
            return int(app(args=arguments, prog_name="gnc", standalone_mode=False) or 0)
    except OutputFailed:
        raise
    except GncError as error:
        print_error(error)
        return error.exit_code
    except UsageError as error:
        _print_usage_error(error)
        return 2
    except typer.Abort:
        return 130


def _print_usage_error(error: Any) -> None:
    """Print what the option parser refuses as every refusal is printed."""
    if type(error).__name__ == "NoArgsIsHelpError":
        error.show()
        return
    path = "gnc" if error.ctx is None else error.ctx.command_path
    problem = " ".join(error.format_message().split()).rstrip(".")
    received: list[Any] = getattr(error.__cause__, "errors", list)()  # of pydantic, typer's reader
    if received and error.param is not None:
        hint, _, need = problem.removeprefix("Invalid value for ").partition(": ")
        need = need.removeprefix("Input should be ").partition(", unable to")[0]
        need = need.partition(" is not ")[2] or need
        problem = f"{hint}: received {received[0]['input']!r}; required {need}"
    end = " See" if problem.endswith("?") else "; see"
    print_error(f"{path}: {problem[0].lower()}{problem[1:]}{end} {path} --help")


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
        function, target = target, App()
        target.command(name)(function)
    found = typer.main.get_command(target)
    found.name = name
    return found


if __name__ == "__main__":
    main()
