"""YAML text to a node tree and to parameter values, by the rules of ROS 2."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import yaml

from spacecraft_gnc.parameters.parameter import Value
from spacecraft_gnc.parameters.problems import InvalidScenario, Problem
from spacecraft_gnc.parameters.yaml_scalar import Scalar, parse_plain

_PLAIN: Final = "plain"
_QUOTED: Final = "quoted"
_QUOTES: Final = ("'", '"')  # ROS 2 reads a block (| or >) like a value without quotes
_MAXIMUM_SIZE: Final = 4 << 20  # bytes; a scenario has a few kilobytes


class _Loader(yaml.SafeLoader):
    """Composes nodes only; tells plain scalars from quoted and tagged ones; refuses aliases."""

    def resolve(self, kind: Any, value: Any, implicit: Any) -> Any:
        if kind is yaml.ScalarNode:
            return _PLAIN if implicit[0] else _QUOTED
        return super().resolve(kind, value, implicit)  # type: ignore[no-untyped-call]

    def process_directives(self) -> Any:
        value = super().process_directives()  # type: ignore[no-untyped-call]
        if self.yaml_version not in (None, (1, 1)):
            mark = self.peek_token().start_mark  # type: ignore[no-untyped-call]
            raise yaml.MarkedYAMLError(problem="ROS 2 reads YAML 1.1", problem_mark=mark)
        return value

    def compose_node(self, parent: Any, index: Any) -> Any:
        if self.check_event(yaml.AliasEvent):
            mark = self.peek_event().start_mark  # type: ignore[no-untyped-call]
            raise yaml.MarkedYAMLError(problem="ROS 2 reads no aliases", problem_mark=mark)
        return super().compose_node(parent, index)


def compose(text: str) -> yaml.Node | None:
    """Return the root node of one YAML document; None for an empty one."""
    root: yaml.Node | None = yaml.compose(text, Loader=_Loader)
    return root


def compose_file(path: Path) -> yaml.Node | None:
    """Return the root node of a YAML file; None for an empty file.

    Raises
    ------
    InvalidScenario
        If the file cannot be read, or is no YAML; with the line where that is known.
    """
    return compose_text(text_of(path), path)


def compose_text(text: str, source: Path) -> yaml.Node | None:
    """Return, likewise, the root node of a text that stands in ``source``."""
    try:
        return compose(text)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = mark.line + 1 if mark else None
        problem = unreadable(source, f"bad YAML ({error.problem})", "mend this line", line)
    except yaml.YAMLError as error:
        line = text[: getattr(error, "position", 0)].count("\n") + 1
        problem = unreadable(source, "bad YAML (a forbidden character)", "remove it", line)
    except RecursionError:
        problem = unreadable(source, "bad YAML (nested too deeply)", "flatten it")
    raise InvalidScenario([problem])


def unreadable(path: Path, value: str, remedy: str, line: int | None = None) -> Problem:
    """Return the problem of a file that is no parameter file at all."""
    return Problem(str(path), line, "", value, "a readable ROS 2 parameter file", remedy)


def convert(node: yaml.Node) -> Value:
    """Return the value of a scalar or of a flat list.

    Raises
    ------
    ValueError
        If ROS 2 has no such value; the message is "requirement; remedy".
    """
    if isinstance(node, yaml.ScalarNode):
        return _scalar(node)
    if not isinstance(node, yaml.SequenceNode):
        raise ValueError("a value; remove the mapping")
    if not all(isinstance(item, yaml.ScalarNode) for item in node.value):
        raise ValueError("a flat list; write matrices row by row in one list")
    return [_scalar(item) for item in node.value]


def items(
    node: yaml.MappingNode, file: str, where: str, problems: list[Problem]
) -> Iterator[tuple[str, yaml.Node]]:
    """Yield the entries of a mapping; add a problem for each key that is no word, or repeated."""
    lines: dict[str, int] = {}
    for key_node, value in node.value:
        line = key_node.start_mark.line + 1
        if not isinstance(key_node, yaml.ScalarNode) or not key_node.value:
            what = "a key that is no word"
            problems.append(Problem(file, line, where, what, "words", "rename it"))
            continue
        key = str(key_node.value)
        if key in lines:
            what = f"the key a second time (first on line {lines[key]})"
            need, remedy = "each key once", "delete one of the two"
            problems.append(Problem(file, line, joined(where, key), what, need, remedy))
        else:
            lines[key] = line
            yield key, value


def joined(prefix: str, key: str) -> str:
    """Return a dotted name; either part may be empty."""
    return f"{prefix}.{key}" if prefix and key else prefix or key


def raw(node: yaml.Node) -> str:
    """Return what stands in the file, in words."""
    if isinstance(node, yaml.ScalarNode):
        return repr(node.value) if node.value else "nothing"
    return "a nested list" if isinstance(node, yaml.SequenceNode) else "a mapping"


def written(node: yaml.Node) -> str | list[str]:
    """Return the text of a scalar, or of each element of a flat list."""
    if isinstance(node, yaml.SequenceNode):
        return [str(item.value) for item in node.value]
    return str(node.value)


def _scalar(node: yaml.ScalarNode) -> Scalar:
    if node.tag == _QUOTED and node.style in _QUOTES:
        return str(node.value)
    if node.tag not in (_PLAIN, _QUOTED):
        raise ValueError(f"a value without a YAML tag; remove the tag {node.tag!r}")
    if not node.value:
        raise ValueError("a value; write one, or remove the key")
    return parse_plain(node.value)


def text_of(path: Path) -> str:
    """Return the text of a file; raise InvalidScenario if it cannot be read, or is far too long."""
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        raise InvalidScenario([unreadable(path, "no such file", "check the path")]) from None
    except IsADirectoryError:
        raise InvalidScenario([unreadable(path, "a directory", "name a file in it")]) from None
    except OSError as error:
        reason = error.strerror or str(error)
        raise InvalidScenario([unreadable(path, reason, "check the file")]) from None
    if len(data) > _MAXIMUM_SIZE:
        problem = unreadable(path, f"{len(data)} bytes", "name a scenario file")
        raise InvalidScenario([problem])
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        problem = unreadable(path, "bytes that are no UTF-8 text", "save it as UTF-8", line)
        raise InvalidScenario([problem]) from None
