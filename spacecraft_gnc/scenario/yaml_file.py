"""A ROS 2 parameter file, read without ROS: every value with the line it stands on.

The reader follows ``rcl_yaml_param_parser`` and refuses more: duplicate keys (of which ROS 2
silently takes the last), YAML tags, and nodes it does not know.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import yaml

from spacecraft_gnc.scenario.parameter import Value
from spacecraft_gnc.scenario.problems import InvalidScenario, Problem, suggestion
from spacecraft_gnc.scenario.yaml_node import compose, compose_file, convert, raw, unreadable

PARAMETERS_KEY = "ros__parameters"
WILDCARD = "/**"
_EXAMPLE = "copy an example from config/"


class Entry(NamedTuple):
    """A value and where it comes from."""

    value: Value | None
    """None: refused when the file was read, and reported there."""
    file: str
    line: int | None = None
    """None: laid over the file by ``--set``, or in memory from the start."""
    coerce: bool = False
    """An integer may stand for a double: true for ``--set``, false for a file handed to ROS 2."""


Given = dict[str, dict[str, Entry]]
"""Section -> dotted parameter name -> entry."""


def read(path: Path, known: Sequence[str]) -> tuple[Given, list[Problem]]:
    """Read a parameter file with the sections ``known``; return what was found and what is wrong.

    Raises
    ------
    InvalidScenario
        If the file cannot be read as a mapping of nodes at all.
    """
    reader = _Reader(str(path), known)
    root = compose_file(path)
    if not isinstance(root, yaml.MappingNode):
        what = "an empty file" if root is None else "no mapping of nodes"
        raise InvalidScenario([unreadable(path, what, _EXAMPLE)])
    reader.sections(root, "")
    return reader.given, reader.problems


def parse_value(text: str) -> Value | dict[str, Value]:
    """Return the value of one YAML text, such as that of ``--set``; a mapping comes out flat.

    Raises
    ------
    ValueError
        If ROS 2 has no such value; the message is "requirement; remedy".
    """
    try:
        root = compose(text)
    except (yaml.YAMLError, RecursionError):
        raise ValueError("one YAML value; quote it") from None
    if root is None:
        raise ValueError("a value; write '' for an empty string")
    if not isinstance(root, yaml.MappingNode):
        return convert(root)
    reader = _Reader("--set", ())
    values = reader.parameters(root, "", "")
    if reader.problems:
        raise ValueError(f"{reader.problems[0].requirement}; {reader.problems[0].remedy}")
    return {name: entry.value for name, entry in values.items() if entry.value is not None}


@dataclass(slots=True)
class _Reader:
    """Walks the node tree of one file, and collects what it finds."""

    file: str
    known: Sequence[str]
    given: Given = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)

    def sections(self, node: yaml.MappingNode, namespace: str) -> None:
        """Read node sections, which may be nested in namespaces."""
        for name, value in self._items(node, namespace):
            path = f"{namespace}/{name}".replace("//", "/") if namespace else name
            base = path.rsplit("/", 1)[-1]
            section = WILDCARD if base == "**" else base
            if section not in (*self.known, WILDCARD):
                if isinstance(value, yaml.MappingNode) and _holds_nodes(value):
                    self.sections(value, path)
                else:
                    known = f"one of {', '.join(self.known)} or {WILDCARD}"
                    remedy = suggestion(base, self.known)
                    self._complain(value, path, "an unknown node", known, remedy)
            elif section in self.given:
                what = f"a second section for {section}"
                self._complain(value, path, what, "one section for a node", "merge the two")
            else:
                self.given[section] = self._section(value, path, section)

    def parameters(self, node: yaml.MappingNode, section: str, prefix: str) -> dict[str, Entry]:
        """Return the parameters of a mapping by dotted name."""
        found: dict[str, Entry] = {}
        for key, value in self._items(node, _joined(section, prefix)):
            name = _joined(prefix, key)
            if isinstance(value, yaml.MappingNode):
                new = self.parameters(value, section, name)
            else:
                new = self._value(value, section, name)
            for repeated in found.keys() & new.keys():
                what = "the key a second time, dotted and nested"
                where = _joined(section, repeated)
                self._complain(value, where, what, "each key once", "delete one of the two")
            found |= new
        return found

    def _section(self, node: yaml.Node, path: str, section: str) -> dict[str, Entry]:
        found: dict[str, Entry] = {}
        keys = list(self._items(node, path)) if isinstance(node, yaml.MappingNode) else []
        if PARAMETERS_KEY not in (key for key, _ in keys):
            remedy = f"write '{PARAMETERS_KEY}:' beneath '{path}:' and indent the parameters"
            what = f"no {PARAMETERS_KEY}"
            self._complain(node, path, what, f"{PARAMETERS_KEY} beneath the node's name", remedy)
            return found
        for key, value in keys:
            if key != PARAMETERS_KEY:
                what = f"a key beside {PARAMETERS_KEY}"
                need = f"all parameters beneath {PARAMETERS_KEY}"
                self._complain(value, f"{path}.{key}", what, need, "indent it further")
            elif isinstance(value, yaml.MappingNode):
                found = self.parameters(value, section, "")
            elif raw(value) != "nothing":
                need = f"'name: value' lines beneath {PARAMETERS_KEY}"
                self._complain(value, path, raw(value), need, "check the indentation")
        return found

    def _value(self, node: yaml.Node, section: str, name: str) -> dict[str, Entry]:
        try:
            value = convert(node)
        except ValueError as error:
            requirement, _, remedy = str(error).partition("; ")
            self._complain(node, _joined(section, name), raw(node), requirement, remedy)
            return {name: Entry(None, self.file, node.start_mark.line + 1)}
        return {name: Entry(value, self.file, node.start_mark.line + 1)}

    def _items(self, node: yaml.MappingNode, where: str) -> Iterator[tuple[str, yaml.Node]]:
        """Yield the entries of a mapping; complain of what ROS 2 would drop or refuse."""
        lines: dict[str, int] = {}
        for key_node, value in node.value:
            if not isinstance(key_node, yaml.ScalarNode) or not key_node.value:
                self._complain(key_node, where, "a key that is no word", "words", "rename it")
                continue
            key = str(key_node.value)
            name = _joined(where, key)
            if key in lines:
                what = f"the key a second time (first on line {lines[key]})"
                self._complain(key_node, name, what, "each key once", "delete one of the two")
            else:
                lines[key] = key_node.start_mark.line + 1
                yield key, value

    def _complain(
        self, node: yaml.Node, key: str, value: str, requirement: str, remedy: str
    ) -> None:
        line = node.start_mark.line + 1
        self.problems.append(Problem(self.file, line, key, value, requirement, remedy))


def _holds_nodes(node: yaml.MappingNode) -> bool:
    """Tell whether a mapping is a namespace rather than a node."""
    names = [key.value for key, _ in node.value]
    mappings = all(isinstance(value, yaml.MappingNode) for _, value in node.value)
    return bool(names) and mappings and PARAMETERS_KEY not in names


def _joined(prefix: str, key: str) -> str:
    return f"{prefix}.{key}" if prefix and key else prefix or key
