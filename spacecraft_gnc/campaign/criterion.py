"""Criterion of success: an expression in metrics, such as ``final_error_deg < 0.1``.

It is parsed by Python's grammar and then read node by node: what is not listed here (attributes,
calls, names of Python, ...) is refused, and nothing is ever evaluated by Python itself.
"""

from __future__ import annotations

import warnings
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

from spacecraft_gnc.campaign.expression import Expression, read_expression
from spacecraft_gnc.parameters.problems import InvalidScenario, Problem, suggestion
from spacecraft_gnc.parameters.values import Refusal

KEY = "pass"


@dataclass(frozen=True, eq=False)
class Criterion:
    """What counts as success; build it with `Criterion.parse`.

    Attributes
    ----------
    text : str
        The expression.
    names : frozenset of str
        Metrics that it reads; those of a nested one with a dot, ``zone_margin_deg.sun``.
    worse : mapping
        Metric -> 1 where a larger one is worse, as for ``x < c``, -1 where a smaller one is. Those
        for which neither is true, as for ``0 < x < c`` or ``x == c``, are absent.
    file, line
        Where it stands, for messages.
    """

    text: str
    names: frozenset[str]
    worse: Mapping[str, int]
    file: str
    line: int | None
    _expression: Expression

    @classmethod
    def parse(cls, text: str, file: str = "criterion", line: int | None = None) -> Criterion:
        """Read an expression.

        Parameters
        ----------
        text : str
            Comparisons of metrics and numbers, chained or not (``< <= > >= == !=``), joined by
            ``and``, ``or``, ``not`` and parentheses; ``+ - * /`` in them; ``true`` and ``false``.
            A metric whose name is no identifier stands in quotes, ``"settle_time_0.1deg"``.
        file, line
            Where it stands, for messages.

        Raises
        ------
        InvalidScenario
            If it is anything else, or names no metric.
        """
        try:
            with warnings.catch_warnings():  # Python's, of constants compared and the like
                warnings.simplefilter("ignore")
                expression = read_expression(text)
        except Refusal as refusal:
            reason = refusal.received, refusal.requirement, refusal.remedy
            raise InvalidScenario([Problem(file, line, KEY, *reason)]) from None
        names = frozenset(expression.directions)
        worse = {name: sign for name, sign in expression.directions.items() if sign}
        return cls(text, names, worse, file, line, expression)

    def holds(self, row: Mapping[str, Any]) -> bool:
        """Tell whether a flight with these metrics is a success.

        The logic has three values: a comparison with a metric that has no value (None, NaN, a text,
        absent) is unknown, ``not`` leaves it so, ``false and`` and ``true or`` decide all the same.
        Only what is true passes.
        """
        return self._expression.value(row) is True

    def check(self, known: Collection[str]) -> None:
        """Check that every metric is one of the flights'.

        Raises
        ------
        InvalidScenario
            With each that is not, and the nearest that is.
        """
        problems = [
            Problem(
                self.file,
                self.line,
                KEY,
                repr(name),
                "a metric of the scenario's flights",
                suggestion(name, sorted(known)),
            )
            for name in sorted(self.names)
            if name not in known
        ]
        if problems:
            raise InvalidScenario(problems)
