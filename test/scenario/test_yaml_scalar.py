"""Scalars are read exactly as a ROS 2 node reads them."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from spacecraft_gnc.parameters.yaml_file import parse_value
from spacecraft_gnc.parameters.yaml_scalar import emit, parse_plain
from spacecraft_gnc.scenario import read_sections

# text as it stands in a file -> what rclpy 7.1.6 (Jazzy) makes of it
READ_BY_ROS: dict[str, Any] = {
    "1": 1,
    "-7": -7,
    "+3": 3,
    "010": 8,
    "08": 8.0,
    "0x10": 16,
    "99999999999999999999": 1e20,
    "0777777777777777777777777": 777777777777777777777777.0,
    "0xffffffffffffffffff": float(0xFFFFFFFFFFFFFFFFFF),
    "9" * 400: "9" * 400,
    "9" * 5000: "9" * 5000,
    "0" * 100 + "17": 15,
    "0x" + "f" * 300: "0x" + "f" * 300,
    "0x1p3": 8.0,
    "0x.8": 0.5,
    "0x0p9999": 0.0,
    "0x1p-1074": 5e-324,
    "0x1p-1080": "0x1p-1080",
    "150.0": 150.0,
    "1.": 1.0,
    ".5": 0.5,
    "+3.5": 3.5,
    "1e10": 1e10,
    "1.0e10": 1e10,
    "1E-3": 1e-3,
    "1e999": "1e999",
    "1e-400": "1e-400",
    "0e0": 0.0,
    "1_000": "1_000",
    "1:30": "1:30",
    "2020-01-01": "2020-01-01",
    "y": True,
    "Yes": True,
    "ON": True,
    "true": True,
    "n": False,
    "no": False,
    "Off": False,
    "FALSE": False,
    "tRue": "tRue",
    "null": "null",
    "~": "~",
    "word": "word",
    ".inf": math.inf,
    "inf": math.inf,
    "-Infinity": -math.inf,
    ".infinity": ".infinity",
    ".iNf": ".iNf",
    ">-\n     5": 5,
    "|\n     5\n": "5\n",
}


@pytest.mark.parametrize("text", READ_BY_ROS)
def test_scalar_without_quotes(text: str) -> None:
    value = parse_value(text)
    assert value == READ_BY_ROS[text]
    assert type(value) is type(READ_BY_ROS[text])


@pytest.mark.parametrize("text", [".nan", "nan", "NaN", ".NaN", "-nan"])
def test_not_a_number(text: str) -> None:
    value = parse_plain(text)
    assert isinstance(value, float)
    assert math.isnan(value)


VALUES = st.one_of(
    st.booleans(),
    st.integers(-(2**63), 2**63 - 1),
    st.floats(allow_nan=False, allow_infinity=False, allow_subnormal=False),
    st.text(st.characters(min_codepoint=32, max_codepoint=126)),
    st.sampled_from(["yes", "n", "null", "~", "1e3", "0x1", "", ".inf", "- a", "#", "a: b"]),
)


@given(VALUES)
def test_what_is_written_is_read_again(value: Any) -> None:
    text = emit(value)
    read = json.loads(text) if text.startswith('"') else parse_plain(text)
    assert read == value
    assert type(read) is type(value)


@given(VALUES)
def test_other_readers_agree(value: Any) -> None:
    read = yaml.safe_load(f"a: {emit(value)}")["a"]
    assert read == value
    assert type(read) is type(value)


PRINT_OVERRIDES = """
import json, sys, rclpy
from rclpy.node import Node
try:
    rclpy.init(args=sys.argv)
    node = Node("plant", start_parameter_services=False)
    found = {name: p.value for name, p in node._parameter_overrides.items()}
    print(json.dumps(found, default=list))
finally:
    rclpy.try_shutdown()
"""


def test_a_live_node_reads_the_same(tmp_path: Path) -> None:
    pytest.importorskip("rclpy")
    path = tmp_path / "plant.yaml"
    lines = [f"    p{number}: {text}" for number, text in enumerate(READ_BY_ROS)]
    lines += ['    quoted: "150"', "    nested: {a: {b: [1.0, 2e0]}}", "    dotted.name: x"]
    lines += ["    flags: [true, no]", "    counts: [1, 0x2]", '    words: [a, "1"]']
    path.write_text("plant:\n  ros__parameters:\n" + "\n".join(lines) + "\n")
    result = subprocess.run(
        [sys.executable, "-c", PRINT_OVERRIDES, "--ros-args", "--params-file", str(path)],
        env={**os.environ, "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "ROS_DOMAIN_ID": "97"},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    assert read_sections(path)["plant"] == json.loads(result.stdout)
