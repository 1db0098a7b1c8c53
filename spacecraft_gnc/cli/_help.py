"""Help texts and usage lines."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import typer
from typer.core import TyperCommand, TyperGroup

HELP_OPTIONS: Final = ("-h", "--help")
_WIDEST: Final = 100  # columns of a help text on a wide terminal
_UNCUT: Final = 1000  # letters of a summary

CONTEXT: Final[dict[str, Any]] = {
    "help_option_names": list(HELP_OPTIONS),
    "max_content_width": _WIDEST,
}
"""Settings of the outermost context, which those of the commands inherit."""

UsageError: Final[Any] = typer.BadParameter.__base__
"""What the option parser raises; typer has no public name for it."""


class Command(TyperCommand):
    """A command whose help names arguments as its usage line does."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse ``args``; a refusal knows the command."""
        try:
            return list(super().parse_args(ctx, args))
        except UsageError as error:
            error.ctx = error.ctx or ctx
            raise

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        """Return the words after the command's name, e.g. ``[OPTIONS] SCENARIO.yaml``."""
        return ["[OPTIONS]", *(_argument(p) for p in self.get_params(ctx) if _is_argument(p))]

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write the arguments and the options."""
        sections: dict[str, list[tuple[str, str]]] = {"Arguments": [], "Options": []}
        for param in self.get_params(ctx):
            record = param.get_help_record(ctx)
            if record is not None and _is_argument(param):
                sections["Arguments"].append((_argument(param), record[1]))
            elif record is not None:
                sections["Options"].append(record)
        for title, rows in sections.items():
            if rows:
                with formatter.section(title):
                    formatter.write_dl(rows)


class Group(TyperGroup):
    """A group of commands that lists their summaries in full."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the list of commands."""
        commands = [(name, self.get_command(ctx, name)) for name in self.list_commands(ctx)]
        rows = [(n, c.get_short_help_str(_UNCUT)) for n, c in commands if c and not c.hidden]
        with formatter.section("Commands"):
            formatter.write_dl(rows)


class App(typer.Typer):
    """A plain `typer.Typer`: no markup, errors left to ``main``, help texts from here."""

    def __init__(self, cls: type[Group] = Group, **settings: Any) -> None:
        plain = {"rich_markup_mode": None, "pretty_exceptions_enable": False}
        super().__init__(cls=cls, **{"add_completion": False, **plain, **settings})

    def command(self, name: str | None = None, **settings: Any) -> Callable[[Any], Any]:
        """Return a decorator that adds a command."""
        return super().command(name, **{"cls": Command, **settings})


def _is_argument(param: Any) -> bool:
    return bool(param.param_type_name == "argument")


def _argument(param: Any) -> str:
    """Return an argument as a usage line shows it."""
    name = f"{param.metavar or param.name.upper()}{'...' if param.nargs != 1 else ''}"
    return name if param.required else f"[{name}]"
