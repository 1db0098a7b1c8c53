"""The interface package: its constants are the core's, and every field says what it is."""

from __future__ import annotations

import re
from enum import IntEnum
from pathlib import Path

import pytest

from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.ocp import Status

DEFINITIONS = Path(__file__).parents[2] / "msg_defs"
INTERFACES = sorted(p.relative_to(DEFINITIONS) for p in DEFINITIONS.glob("*/*.*"))
NO_UNIT = {"bool", "bool[]", "bool[6]", "string", "std_msgs/Header"}


def declarations(path: Path) -> list[str]:
    lines = (DEFINITIONS / path).read_text(encoding="utf-8").splitlines()
    return [line for line in lines if line and not line.startswith(("#", "---"))]


@pytest.mark.parametrize(("message", "enum"), [("TorqueCommand", Source), ("SolverStatus", Status)])
def test_constants_are_those_of_the_core(message: str, enum: type[IntEnum]) -> None:
    found = [
        re.match(r"uint8 (\w+)=(\d+)", line) for line in declarations(Path(f"msg/{message}.msg"))
    ]
    constants = {match[1]: int(match[2]) for match in found if match}
    constants.pop("NO_SOLVE", None)  # of a step without a solve, which the core says by None
    assert constants == {member.name: member.value for member in enum}


@pytest.mark.parametrize("path", INTERFACES, ids=lambda path: path.stem)
def test_every_field_has_a_comment_with_its_unit(path: Path) -> None:
    for line in declarations(path):
        field, _, comment = line.partition("#")
        assert comment.strip(), line
        if "=" not in field and field.split()[0] not in NO_UNIT:
            assert re.search(r"\[[^]]+\]|in that constraint's unit", comment), line


@pytest.mark.parametrize("path", INTERFACES, ids=lambda path: path.stem)
def test_every_definition_is_built(path: Path) -> None:
    assert f'"{path}"' in (DEFINITIONS / "CMakeLists.txt").read_text(encoding="utf-8")
