"""Problems of a scenario: one `Problem` per line, all in one exception."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

from spacecraft_gnc.errors import GncError, ScenarioError

_LONGEST_VALUE = 100  # characters of a value that a line shows
_LONGEST_LIST = 8  # words that a remedy enumerates


@dataclass(frozen=True, slots=True, order=True)
class Problem:
    """One reason why a scenario is refused, with the way out."""

    file: str
    """File (or ``--set``) that the value comes from."""
    line: int | None
    """Line in the file, counted from 1, where known."""
    key: str
    """Dotted name ``node.parameter``; empty where the whole file is meant."""
    value: str
    """What was received, in words or as YAML."""
    requirement: str
    """What is required instead."""
    remedy: str
    """What to do."""

    def __str__(self) -> str:
        place = self.file if self.line is None else f"{self.file}:{self.line}"
        subject = f"{place}: {self.key}" if self.key else place
        line = f"{subject}: received {self.value}; required {self.requirement}; {self.remedy}"
        # one line, and nothing a terminal would obey, whatever stands in the file
        return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in line)

    def as_dict(self) -> dict[str, Any]:
        """Return the fields as a JSON-able mapping."""
        return {name: getattr(self, name) for name in self.__slots__}


class InvalidScenario(ScenarioError):
    """A scenario is refused; ``problems`` holds every reason at once."""

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems: tuple[Problem, ...] = tuple(problems)
        super().__init__("\n".join(str(problem) for problem in self.problems))


def problem_of(error: GncError, file: str, section: str, known: Sequence[str]) -> Problem | None:
    """Return the problem that a core complains of; None where its message has another form.

    Parameters
    ----------
    error
        Its message is "what: received VALUE; required X; remedy".
    file
        Of the scenario.
    section
        That the core was built from.
    known
        Names of that section's parameters.
    """
    what, _, rest = str(error).removeprefix(f"{section}.").partition(": received ")
    value, _, rest = rest.partition("; required ")
    requirement, _, remedy = rest.partition("; ")
    if not (value and requirement and remedy):
        return None
    key = f"{section}.{what}" if what in known else f"{section} ({what})"
    return Problem(file, None, key, value, requirement, remedy)


def shown(value: Any) -> str:
    """Return ``value`` as YAML on one line, shortened where it is long."""
    return shortened(_yaml(value))


def shortened(text: str) -> str:
    """Return a text, cut where it is long, with its length."""
    if len(text) <= _LONGEST_VALUE:
        return text
    return f"{text[:_LONGEST_VALUE]}... ({len(text)} characters)"


def suggestion(name: str, known: Sequence[str]) -> str:
    """Return a remedy that names the known word nearest to ``name``."""
    nearest = get_close_matches(name, known, n=1, cutoff=0.5)
    if nearest:
        return f"did you mean {nearest[0]!r}?"
    listed = 0 < len(known) <= _LONGEST_LIST
    return f"use one of {', '.join(known)}" if listed else "remove it"


def _yaml(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return repr(value)
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_yaml(item) for item in value) + "]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {_yaml(item)}" for key, item in value.items()) + "}"
    return str(value)
