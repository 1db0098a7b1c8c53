"""A ROS 2 parameter file, read without ROS: every value with the line it stands on.

The reader follows ``rcl_yaml_param_parser`` and refuses more: duplicate keys (of which ROS 2
silently takes the last), YAML tags, and nodes it does not know.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, NamedTuple, TypeGuard

import yaml

from spacecraft_gnc.parameters.parameter import Value
from spacecraft_gnc.parameters.problems import InvalidScenario, Problem, suggestion
from spacecraft_gnc.parameters.yaml_node import (
    compose,
    compose_file,
    compose_text,
    convert,
    items,
    joined,
    raw,
    unreadable,
    written,
)

PARAMETERS_KEY: Final = "ros__parameters"
_EXAMPLE: Final = "copy an example from config/"
_WILDCARDS: Final = ("*", "**")
_NODE_NAME: Final = re.compile(r"(/(\*\*?|[A-Za-z_][A-Za-z0-9_]*))+")
_LONGEST_NAME: Final = 245  # characters; the same limit as that of rmw


class Entry(NamedTuple):
    """A value and where it comes from."""

    value: Value | None
    """None: refused when the file was read, and reported there."""
    file: str
    line: int | None = None
    """None: laid over the file by ``--set``, or in memory from the start."""
    coerce: bool = False
    """An integer may stand for a double: true for ``--set``, false for a file handed to ROS 2."""
    written: str | list[str] | None = None
    """The value, or each of a list, as it stands there; None where that is not known."""


Sections = dict[str, dict[str, Entry]]
"""Pattern of full node names (``/**``, ``/plant``) -> dotted parameter name -> entry, in the order
in which ROS 2 lays the patterns over each other."""
Given = dict[str, dict[str, Entry]]
"""Role of a node (``plant``) -> dotted parameter name -> entry."""


def read(
    path: Path, known: Sequence[str], text: str | None = None
) -> tuple[Sections, list[Problem]]:
    """Read a parameter file of the nodes ``known``; return what was found and what is wrong.

    Of a ``text`` at hand, ``path`` only tells where it stands.

    Raises
    ------
    InvalidScenario
        If the file cannot be read as a mapping of nodes at all.
    """
    reader = _Reader(str(path), known)
    root = compose_file(path) if text is None else compose_text(text, path)
    if not isinstance(root, yaml.MappingNode):
        what = "an empty file" if root is None else "no mapping of nodes"
        raise InvalidScenario([unreadable(path, what, _EXAMPLE)])
    reader.sections(root, "")
    return reader.found, reader.problems


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
    found: Sections = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)

    def sections(self, node: yaml.MappingNode, namespace: str) -> None:
        """Read node sections, which may be nested in namespaces."""
        for name, value in self._items(node, namespace):
            path = f"{namespace.removesuffix('/')}/{name}" if namespace else name
            base = path.rpartition("/")[2]
            if base not in self.known and _holds_nodes(value):
                self.sections(value, path)
            elif base in (*self.known, *_WILDCARDS):
                self._add_section(value, path, base)
            else:
                need = f"one of {', '.join(self.known)} or a wildcard such as /**"
                self._complain(value, path, "an unknown node", need, suggestion(base, self.known))

    def _add_section(self, value: yaml.Node, path: str, base: str) -> None:
        pattern = path if path.startswith("/") else f"/{path}"
        if pattern in self.found:
            what = f"a second section for {path}"
            self._complain(value, path, what, "one section for a node", "merge the two")
        elif not _NODE_NAME.fullmatch(pattern) or len(pattern) > _LONGEST_NAME:
            need = "words of letters, digits and _, or *, or **, with one / between two"
            self._complain(value, path, "no name of a node", need, "rename it")
        else:
            self.found[pattern] = self._section(value, path, base if base in self.known else path)

    def parameters(self, node: yaml.MappingNode, section: str, prefix: str) -> dict[str, Entry]:
        """Return the parameters of a mapping by dotted name."""
        found: dict[str, Entry] = {}
        for key, value in self._items(node, joined(section, prefix)):
            name = joined(prefix, key)
            if isinstance(value, yaml.MappingNode) and not value.value:
                need = "a value (ROS 2 stumbles over an empty mapping)"
                remedy = "write one, or remove the key"
                self._complain(value, joined(section, name), "{}", need, remedy)
                continue
            if isinstance(value, yaml.MappingNode):
                new = self.parameters(value, section, name)
            else:
                new = self._value(value, section, name)
            for repeated in found.keys() & new.keys():
                what = "the key a second time, dotted and nested"
                where = joined(section, repeated)
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
            else:
                need = f"'name: value' lines beneath {PARAMETERS_KEY}"
                remedy = "check the indentation, or remove the section"
                self._complain(value, path, raw(value), need, remedy)
        return found

    def _value(self, node: yaml.Node, section: str, name: str) -> dict[str, Entry]:
        try:
            value = convert(node)
        except ValueError as error:
            requirement, _, remedy = str(error).partition("; ")
            self._complain(node, joined(section, name), raw(node), requirement, remedy)
            return {name: Entry(None, self.file, node.start_mark.line + 1)}
        return {name: Entry(value, self.file, node.start_mark.line + 1, written=written(node))}

    def _items(self, node: yaml.MappingNode, where: str) -> Iterator[tuple[str, yaml.Node]]:
        return items(node, self.file, where, self.problems)

    def _complain(
        self, node: yaml.Node, key: str, value: str, requirement: str, remedy: str
    ) -> None:
        line = node.start_mark.line + 1
        self.problems.append(Problem(self.file, line, key, value, requirement, remedy))


def _holds_nodes(node: yaml.Node) -> TypeGuard[yaml.MappingNode]:
    """Tell whether a node of the file is a namespace rather than a node of ROS 2."""
    if not isinstance(node, yaml.MappingNode):
        return False
    names = [key.value for key, _ in node.value]
    mappings = all(isinstance(value, yaml.MappingNode) for _, value in node.value)
    return bool(names) and mappings and PARAMETERS_KEY not in names
