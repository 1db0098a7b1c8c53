"""Options of one distribution as they stand in a variations file, with their lines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final

import yaml

from spacecraft_gnc.parameters.parameter import Kind, ParameterSpec, Value
from spacecraft_gnc.parameters.problems import Problem, shown, suggestion
from spacecraft_gnc.parameters.values import Refusal, admissible
from spacecraft_gnc.parameters.yaml_node import convert, items, joined, raw, written

_NUMBER: Final = ParameterSpec(kind=Kind.DOUBLE, default=0.0, description="")


class Options:
    """Reads options one by one and collects what is wrong with them.

    What is refused is reported, and a NaN or an empty list returned in its place: whoever made
    something of it throws it away (`is_valid`).
    """

    def __init__(
        self, node: yaml.MappingNode, file: str, where: str, problems: list[Problem]
    ) -> None:
        self.file = file
        self.where = where
        self.problems = problems
        self._line = node.start_mark.line + 1
        self._before = len(problems)
        self._nodes = dict(items(node, file, where, problems))
        self._known: dict[str, None] = {}
        """In the order in which they were asked for."""

    @property
    def is_valid(self) -> bool:
        """Whether nothing was wrong so far."""
        return len(self.problems) == self._before

    def has(self, name: str) -> bool:
        """Tell whether an option is given."""
        self._known[name] = None
        return name in self._nodes

    def node(self, name: str, requirement: str) -> yaml.Node | None:
        """Return an option as it stands there; None where it is missing, which is reported."""
        if not self.has(name):
            self.complain(name, "nothing", requirement, "add it")
            return None
        return self._nodes[name]

    def value(self, name: str, spec: ParameterSpec) -> Any:
        """Return an option that a spec describes; its default unless it is required."""
        if not self.has(name) and not spec.required:
            return spec.default
        node = self.node(name, spec.requirement)
        value = math.nan if node is None else self.converted(name, node, spec)
        return math.nan if value is None else value

    def converted(self, name: str, node: yaml.Node, spec: ParameterSpec) -> Value | None:
        """Return what a node holds, in the type of a spec; None where that is refused."""
        value = self.plain(name, node)
        if value is None:
            return None
        try:
            return admissible(spec, value, coerce=True, written=written(node))
        except Refusal as refusal:
            line = node.start_mark.line + 1
            self._add(line, name, refusal.received, refusal.requirement, refusal.remedy)
            return None

    def plain(self, name: str, node: yaml.Node) -> Value | None:
        """Return what a node holds, unchecked; None where that is no value at all."""
        try:
            return convert(node)
        except ValueError as error:
            requirement, _, remedy = str(error).partition("; ")
            self._add(node.start_mark.line + 1, name, raw(node), requirement, remedy)
            return None

    def sequence(self, name: str, requirement: str) -> list[yaml.Node]:
        """Return the items of a list that must not be empty."""
        node = self.node(name, requirement)
        if node is None:
            return []
        if not isinstance(node, yaml.SequenceNode) or not node.value:
            received = "[]" if isinstance(node, yaml.SequenceNode) else raw(node)
            self.complain(name, received, requirement, "write a list of them")
            return []
        return list(node.value)

    def numbers(self, name: str, count: int | None, default: float = math.nan) -> list[float]:
        """Return a number for each of ``count`` components, of which None is a scalar."""
        need = "a number" if count is None else f"a number, or a list of {count}"
        unknown = [math.nan] * (count or 1)
        if not self.has(name) and not math.isnan(default):
            return [default] * len(unknown)
        node = self.node(name, need)
        if node is None:
            return unknown
        if count is None or not isinstance(node, yaml.SequenceNode):
            value = self.converted(name, node, _NUMBER)
            return unknown if value is None else [float(value)] * len(unknown)  # type: ignore[arg-type]
        if len(node.value) != count:
            self.complain(name, f"{len(node.value)} numbers", need, f"write {count}")
            return unknown
        spec = ParameterSpec(kind=Kind.DOUBLE_ARRAY, default=[], description="", shape=(count,))
        found = self.converted(name, node, spec)
        return unknown if found is None else list(found)  # type: ignore[arg-type]

    def length(self, names: Sequence[str]) -> int | None:
        """Return the length of the first of these options that is a list."""
        for name in names:
            node = self._nodes.get(name)
            if isinstance(node, yaml.SequenceNode):
                return len(node.value)
        return None

    def check_rest(self, of: str) -> None:
        """Report the options that nobody asked for."""
        for name in self._nodes:
            if name not in self._known:
                known = list(self._known)
                need = f"one of {', '.join(known)}" + (f" of {of}" if of else "")
                self.complain(name, "an unknown key", need, suggestion(name, known))

    def complain(self, name: str, received: str, requirement: str, remedy: str) -> None:
        """Report a problem, at the line of an option where it is given."""
        node = self._nodes.get(name)
        line = self._line if node is None else node.start_mark.line + 1
        self._add(line, name, received, requirement, remedy)

    def shown(self, name: str) -> str:
        """Return an option as it stands there, in words."""
        node = self._nodes.get(name)
        if node is None:
            return "nothing"
        try:
            return shown(convert(node))
        except ValueError:
            return raw(node)

    def _add(self, line: int, name: str, received: str, requirement: str, remedy: str) -> None:
        key = joined(self.where, name)
        self.problems.append(Problem(self.file, line, key, received, requirement, remedy))
