"""Attributes imported on first use, so that unused modules are never loaded."""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from operator import attrgetter
from typing import Any


@dataclass(frozen=True, slots=True)
class Lazy:
    """An attribute of a module, imported when it is first needed.

    Attributes
    ----------
    target : str
        ``"module:name"``; the name may be dotted, as ``"package.module:Class.from_scenario"``.
    """

    target: str

    def load(self) -> Any:
        """Import the module and return the attribute."""
        module, _, name = self.target.partition(":")
        return attrgetter(name)(importlib.import_module(module))
