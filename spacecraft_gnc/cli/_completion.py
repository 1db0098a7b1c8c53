"""Shell completion, installed by typer, with errors reported like any other refusal."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Final

from spacecraft_gnc.errors import ParameterError

_OPTIONS: Final = ("--install-completion", "--show-completion")
_SHELLS: Final = ("bash", "zsh", "fish", "powershell", "pwsh")


@contextmanager
def told_completion(args: Sequence[str]) -> Iterator[None]:
    """Explain why completion cannot be installed or shown; do nothing for other arguments.

    Raises
    ------
    ParameterError
        There is none for the shell, or a file of the user's cannot be written.
    """
    option = args[0] if args else ""
    if option not in _OPTIONS:
        yield
        return
    _require_known_shell(option)
    try:
        yield
    except OSError as error:
        raise ParameterError(
            f"{option}: received {error.filename!r} ({error.strerror}); required a file that can "
            "be written; copy what --show-completion prints instead"
        ) from error


def _require_known_shell(option: str) -> None:
    from shellingham import ShellDetectionFailure, detect_shell

    try:
        shell = detect_shell()[0]
    except ShellDetectionFailure:
        shell = "that nobody knows"
    if shell not in _SHELLS:
        raise ParameterError(
            f"{option}: received a call from the shell {shell}; required bash, zsh, fish or "
            "PowerShell; call it from one of them"
        )
